"""Scenarios: from a readable file and a person's options to a checked system and its experiment."""
