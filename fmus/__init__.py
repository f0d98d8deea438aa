"""A block becomes an FMU, an FMU becomes a unit."""
