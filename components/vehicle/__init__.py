"""Blocks of the plant socket."""
