"""The varied set: many variations of the scenarios, and what they say."""
