"""The optimal control problems that the predictive controllers solve, as text."""
