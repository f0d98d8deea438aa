"""A description becomes a running unit."""
