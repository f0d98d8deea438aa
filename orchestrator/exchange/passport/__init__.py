"""The passport of an FMU: what it is and how it behaves, measured line by line in other processes."""
