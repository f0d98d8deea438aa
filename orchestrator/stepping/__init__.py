"""Stepping: the schedule, the signal table, and the master that carries it out tick by tick."""
