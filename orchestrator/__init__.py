"""Systems, scenarios, the master, and what becomes of a run: records, metrics, pictures, the command."""
