"""The recording beside the run; the only room that imports rerun."""
