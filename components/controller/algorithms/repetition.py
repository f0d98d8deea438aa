"""An iteration that is repeated until it says that it is done, by a branch: in the generated C and in this process."""
# pyright: basic
# CasADi carries no types; everything that leaves this file is annotated.

from __future__ import annotations

import casadi as ca


def repeated(iterate: ca.Function, at_most: int) -> ca.Function:
    """A function that repeats another one until it is done.

    Each repetition is a call behind an `if`, so that what is not needed costs no time; the C of the iteration stands
    in the file once. The bound keeps the longest time, and all memory, known in advance.

    Args:
        iterate: ``iterate(*values, *data) -> (*values, done)``, where `done` is 0 while another repetition is needed.
        at_most: The bound on the repetitions.

    Returns:
        ``search(*values, *data) -> (*values)``.
    """
    arguments = iterate.mx_in()
    n = iterate.n_out() - 1
    values, data = arguments[:n], arguments[n:]
    keep = ca.Function("keep", arguments, [*values, ca.MX(1)])
    unless_done = ca.Function.if_else("unless_done", keep, iterate)
    done = ca.MX(0)
    for _ in range(at_most):
        *values, done = unless_done(done, *values, *data)
    return ca.Function("search", arguments, values)
