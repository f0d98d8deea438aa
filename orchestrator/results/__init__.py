"""Results: the run folder, its summary, its signals as parquet, and the metrics."""
