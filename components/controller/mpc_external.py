"""The paper's controller with the other two algorithms of its comparison; they run in this process, not as FMUs.

Shown in tests/closed_loop/test_mpc_external.py.
"""

from __future__ import annotations

from typing import ClassVar, final

from typing_extensions import override

from components.controller.algorithms import external_solvers
from components.controller.algorithms.bounded import Solution
from components.controller.mpc import IntegratedMpc
from components.controller.problems.ocp import OptimalControlProblem
from components.interfaces.block import block
from components.interfaces.maths import Array
from components.interfaces.quantity import quantity
from components.interfaces.sockets import CONTROLLER

_KKT_CONVERGED = 1e-3
"""These solvers stop by criteria of their own (cost change, scaled residual) and leave larger residuals than `mpc`."""


@final
@block(CONTROLLER)
class MpcSqp(IntegratedMpc):
    """The paper's controller (see `mpc`), solved by sequential quadratic programming (SLSQP of SciPy)."""

    native: ClassVar[bool] = False
    kkt_converged: ClassVar[float] = _KKT_CONVERGED

    tolerance: float = quantity("1", "change of the cost at which SLSQP stops", min=1e-16, max=1)

    @override
    def solve(self, problem: OptimalControlProblem, guess: Array) -> Solution:
        """A line-search SQP method with bounds."""
        search = external_solvers.sqp
        return external_solvers.minimise(search, problem, self.dimensions(), guess, tolerance=self.tolerance)


@final
@block(CONTROLLER)
class MpcInteriorPoint(IntegratedMpc):
    """The paper's controller (see `mpc`), solved by an interior-point method (IPOPT)."""

    native: ClassVar[bool] = False
    kkt_converged: ClassVar[float] = _KKT_CONVERGED

    tolerance: float = quantity("1", "residual at which IPOPT stops", min=1e-12, max=1)

    @override
    def solve(self, problem: OptimalControlProblem, guess: Array) -> Solution:
        """A barrier method with a quasi-Newton Hessian."""
        search = external_solvers.interior_point
        return external_solvers.minimise(search, problem, self.dimensions(), guess, tolerance=self.tolerance)
