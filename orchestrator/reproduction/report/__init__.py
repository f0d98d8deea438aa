"""The report: figures, tables and text."""
