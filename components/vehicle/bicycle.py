"""The paper's vehicle: a single-track (bicycle) model with linear tyres."""

from __future__ import annotations

from typing import final

from components.interfaces.block import block
from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.sockets import PLANT
from components.vehicle.single_track import SingleTrack


@final
@block(PLANT)
class Bicycle(SingleTrack):
    """Single-track vehicle with linear tyres, equations (1)-(3) of the paper.

        x_dot = v_x cos(psi) - v_y sin(psi)        v_x_dot =  r v_y - 2/m (F_cf sin(delta_f) - T_r/R_w)
        y_dot = v_x sin(psi) + v_y cos(psi)        v_y_dot = -r v_x + 2/m (F_cf cos(delta_f) + F_cr)
        psi_dot = r                                  r_dot = 2/I_z (l_f F_cf - l_r F_cr)                    (1)

        F_cf = -C_alpha_f alpha_f                     F_cr = -C_alpha_r alpha_r                            (2)
        alpha_f = (v_y + l_f r)/v_x - delta_f      alpha_r = (v_y - l_r r)/v_x                             (3)

    Two tyres per axle, hence the factors 2; `psi_dot = r` is added (RESOLUTIONS 3).
    Leaves out load transfer, drag and the saturation of the tyre (`bicycle_saturated` has it): `tyre.mu_f` and
    `tyre.mu_r` are the shares of the friction limit that the linear tyre uses, and exceed 1 where a real tyre would
    slide.

    Reference point: centre of gravity. Feedthrough: `actuation` to `tyre` and `motion`, none to `state`.
    Equations (3) hold for v_x >= 1 m/s; below, and at rest, the wheels go over into rolling without slip.
    """

    def forces(self, x: VehicleState, u: Actuation) -> tuple[float, float]:
        """Lateral forces of one front and one rear tyre (2)."""
        alpha_f, alpha_r = self.slip(x, u)
        return -self.C_alpha_f * alpha_f, -self.C_alpha_r * alpha_r  # (2)
