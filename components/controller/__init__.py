"""Blocks of the controller socket, and what they are made of."""
