"""The paper's vehicle (Table 1, and RESOLUTIONS 6), and what drives a vehicle."""

from __future__ import annotations

from components.interfaces.buses import Actuation
from components.interfaces.sockets import PlantInputs

M, I_Z, L_F, L_R, C, R_W, MU, G = 2000.0, 1300.0, 1.2, 1.05, 12000.0, 0.3, 0.5, 9.81


def driven(delta_f: float = 0.0, T_r: float = 0.0) -> PlantInputs:
    """The inputs of a plant."""
    return PlantInputs(actuation=Actuation(delta_f=delta_f, T_r=T_r))
