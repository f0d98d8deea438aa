"""A block becomes an FMU."""
