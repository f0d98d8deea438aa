"""The paper's vehicle (Table 1, and RESOLUTIONS 6), and what vehicles are tested with."""

from __future__ import annotations

from hypothesis import strategies as st

from components.interfaces.buses import Actuation, VehicleState
from components.interfaces.sockets import PlantInputs

M, I_Z, L_F, L_R, C, R_W, MU, G = 2000.0, 1300.0, 1.2, 1.05, 12000.0, 0.3, 0.5, 9.81

steering = st.floats(-0.78, 0.78)


def states(v_y: float, r: float) -> st.SearchStrategy[VehicleState]:
    """States of a vehicle that drives forward, with at most this lateral speed and yaw rate to either side."""
    return st.builds(
        VehicleState,
        x=st.floats(-100, 100),
        y=st.floats(-10, 10),
        psi=st.floats(-3, 3),
        v_x=st.floats(1, 40),
        v_y=st.floats(-v_y, v_y),
        r=st.floats(-r, r),
    )


def driven(delta_f: float = 0.0, T_r: float = 0.0) -> PlantInputs:
    """The inputs of a plant."""
    return PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r))
