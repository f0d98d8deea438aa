"""Many variants of one scenario: what varies, how it is sampled, who runs it, and what it says."""
