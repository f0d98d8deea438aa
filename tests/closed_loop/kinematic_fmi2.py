"""The README's vehicle as an FMU of version 2.0, made by pythonfmu; `test_plants` builds it."""

from math import cos, sin, tan
from types import SimpleNamespace

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class KinematicFmi2(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.m, self.R_w, self.l_f, self.l_r = 2000.0, 0.3, 1.2, 1.05
        self.actuation = SimpleNamespace(delta_f=0.0, T_r=0.0)
        self.state = SimpleNamespace(x=0.0, y=0.0, psi=0.0, v_x=10.0, v_y=0.0, r=0.0)
        for bus, causality in (("actuation", Fmi2Causality.input), ("state", Fmi2Causality.output)):
            for name in vars(getattr(self, bus)):
                self.register_variable(Real(f"{bus}.{name}", causality=causality))
        for name in ("m", "R_w", "l_f", "l_r"):
            self.register_variable(Real(name, causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, t, h):
        s, a = self.state, self.actuation
        s.r = s.v_x * tan(a.delta_f) / (self.l_f + self.l_r)
        s.v_y = self.l_r * s.r
        s.x += h * (s.v_x * cos(s.psi + h * s.r / 2) - s.v_y * sin(s.psi + h * s.r / 2))
        s.y += h * (s.v_x * sin(s.psi + h * s.r / 2) + s.v_y * cos(s.psi + h * s.r / 2))
        s.psi += h * s.r
        s.v_x = max(0.0, s.v_x + h * 2 * a.T_r / self.R_w / self.m)
        return True
