"""A single-track (bicycle) model whose tyres saturate at the friction limit."""

from __future__ import annotations

from typing import final

from components.interfaces.block import block
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.maths import tanh
from components.interfaces.sockets import PLANT
from components.vehicle.single_track import SingleTrack


@final
@block(PLANT)
class BicycleSaturated(SingleTrack):
    """Single-track vehicle with tyres that saturate at the friction limit, otherwise as `bicycle`.

    Equations (1) and (3) of the paper, and for each tyre, with its static load F_z, in place of (2)

        F_c = -mu F_z tanh(C_alpha alpha / (mu F_z))

    which has the slope of (2) at the origin and never exceeds mu F_z: `tyre.mu_f` stays below 1. `tyre.mu_r` also
    counts the driving force T_r / R_w, which leaves the lateral force as it is (no friction ellipse).
    Leaves out load transfer and drag.

    Reference point: centre of gravity. Feedthrough: `actuation` to `tyre` and `motion`, none to `state`.
    Equations (3) hold for v_x >= 1 m/s; below, and at rest, the wheels go over into rolling without slip.
    """

    def forces(self, x: VehicleState, u: Actuation) -> tuple[float, float]:
        """Lateral forces of one front and one rear tyre."""
        (alpha_f, alpha_r), (F_zf, F_zr) = self.slip(x, u), self.loads()
        F_cf = -self.mu * F_zf * tanh(self.C_alpha_f * alpha_f / (self.mu * F_zf))
        F_cr = -self.mu * F_zr * tanh(self.C_alpha_r * alpha_r / (self.mu * F_zr))
        return F_cf, F_cr
