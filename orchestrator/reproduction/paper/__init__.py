"""The paper: its experiments, its claims, and what decides them."""
