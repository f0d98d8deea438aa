"""The recording of a run while it steps; only this package imports rerun."""
