"""Blocks of the traffic socket."""
