"""Steering by a linear-quadratic regulator (LQR) on lateral and heading error, with curvature feedforward."""

from __future__ import annotations

from components.controller.algorithms import riccati
from components.controller.tracking import Deviation, Tracking
from components.interfaces.maths import Array, vector
from components.interfaces.quantity import quantity
from components.interfaces.record import record


@record
class Gain:
    """Feedback of the errors on the steering angle."""

    e: float = quantity("rad/m", "gain on the lateral error")
    e_dot: float = quantity("rad.s/m", "gain on the rate of the lateral error")
    psi_e: float = quantity("1", "gain on the heading error")
    psi_e_dot: float = quantity("s", "gain on the rate of the heading error")


@record
class LqrTracking(Tracking):
    """Feedback of the errors of the linear single-track model around a steady turn.

    At the speed v, with the axle stiffnesses C_f, C_r (two tyres each), the errors

        e''     = -(C_f + C_r)/(m v) e' + (C_f + C_r)/m psi_e + (l_r C_r - l_f C_f)/(m v) psi_e'     + C_f/m delta_f
        psi_e'' = (l_r C_r - l_f C_f)/(I_z v) e' - (l_r C_r - l_f C_f)/I_z psi_e
                  - (l_f^2 C_f + l_r^2 C_r)/(I_z v) psi_e'                                       + l_f C_f/I_z delta_f

    are regulated around the steady turn of the curvature kappa, in which e = 0,

        psi_e = -(l_r - l_f m v^2 / (L C_r)) kappa,     delta_f = (L + (m/L) (l_r/C_f - l_f/C_r) v^2) kappa.

    The gain belongs to `v_ref`; it is computed once, at the start. Reference: R. Rajamani, Vehicle Dynamics and
    Control (2012), 2.5 and 3.1-3.3.
    """

    m: float = quantity("kg", "mass of the modelled vehicle", min=1)
    I_z: float = quantity("kg.m2", "yaw inertia of the modelled vehicle", min=1)
    l_f: float = quantity("m", "distance from the centre of gravity to the front axle", min=0.1)
    l_r: float = quantity("m", "distance from the centre of gravity to the rear axle", min=0.1)
    C_alpha_f: float = quantity("N/rad", "cornering stiffness of one front tyre", min=1)
    C_alpha_r: float = quantity("N/rad", "cornering stiffness of one rear tyre", min=1)
    q_e: float = quantity("1/m2", "weight of the lateral error", min=1e-9)
    q_e_dot: float = quantity("s2/m2", "weight of the rate of the lateral error", min=0)
    q_psi: float = quantity("1/rad2", "weight of the heading error", min=0)
    q_psi_dot: float = quantity("s2/rad2", "weight of the rate of the heading error", min=0)
    q_delta: float = quantity("1/rad2", "weight of the steering angle", min=1e-9)

    def error_dynamics(self, v: float) -> tuple[list[Array], Array]:
        """Rows of A and column b, each of shape (4,), in x' = A x + b delta_f with x = (e, e', psi_e, psi_e')."""
        C_f, C_r = 2 * self.C_alpha_f, 2 * self.C_alpha_r
        stiffness, moment = C_f + C_r, self.l_r * C_r - self.l_f * C_f
        damping = self.l_f * self.l_f * C_f + self.l_r * self.l_r * C_r
        m, I_z = self.m, self.I_z
        rows = [
            vector([0.0, 1.0, 0.0, 0.0]),
            vector([0.0, -stiffness / (m * v), stiffness / m, moment / (m * v)]),
            vector([0.0, 0.0, 0.0, 1.0]),
            vector([0.0, moment / (I_z * v), -moment / I_z, -damping / (I_z * v)]),
        ]
        return rows, vector([0.0, C_f / m, 0.0, self.l_f * C_f / I_z])

    def gain(self) -> Gain:
        """The gain at the speed `v_ref`."""
        rows, b = self.error_dynamics(self.v_ref)
        q = vector([self.q_e, self.q_e_dot, self.q_psi, self.q_psi_dot])
        K = riccati.gain(rows, b, q, self.q_delta, self.T_s)
        return Gain(e=K[0], e_dot=K[1], psi_e=K[2], psi_e_dot=K[3])

    def steady_turn(self, kappa: float, v: float) -> tuple[float, float]:
        """A steady turn without lateral error.

        Args:
            kappa: The curvature [1/m], positive to the left.
            v: The speed [m/s].

        Returns:
            The heading error and the steering angle, both in rad.
        """
        C_f, C_r, L = 2 * self.C_alpha_f, 2 * self.C_alpha_r, self.l_f + self.l_r
        psi_e = -(self.l_r - self.l_f * self.m * v * v / (L * C_r)) * kappa
        delta_f = (L + self.m / L * (self.l_r / C_f - self.l_f / C_r) * v * v) * kappa
        return psi_e, delta_f

    def steering(self, K: Gain, at: Deviation, kappa: float, v: float) -> float:
        """The steering angle at a deviation from a path of the curvature `kappa`."""
        psi_e, delta_f = self.steady_turn(kappa, v)
        return delta_f - K.e * at.e - K.e_dot * at.e_dot - K.psi_e * (at.psi_e - psi_e) - K.psi_e_dot * at.psi_e_dot
