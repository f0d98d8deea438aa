"""Algorithms that solve the controllers' problems; what becomes C is written as symbols."""
