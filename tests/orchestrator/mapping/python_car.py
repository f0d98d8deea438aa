"""A plant as somebody with pythonfmu would write it: flat names, no units, no dependencies."""

from math import cos, sin

from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class PythonCar(Fmi2Slave):
    """The single-track model of the paper, in plain Python."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.delta_f = self.T_r = 0.0
        self.x = self.y = self.psi = self.v_y = self.r = 0.0
        self.v_x = 10.0
        for name in ("delta_f", "T_r"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("x", "y", "psi", "v_x", "v_y", "r"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def slope(self, x):
        _, _, psi, v_x, v_y, r = x
        front = -12000 * ((v_y + 1.2 * r) / v_x - self.delta_f)
        rear = -12000 * (v_y - 1.05 * r) / v_x
        return (
            v_x * cos(psi) - v_y * sin(psi),
            v_x * sin(psi) + v_y * cos(psi),
            r,
            r * v_y - 2 / 2000 * (front * sin(self.delta_f) - self.T_r / 0.3),
            -r * v_x + 2 / 2000 * (front * cos(self.delta_f) + rear),
            2 / 1300 * (1.2 * front - 1.05 * rear),
        )

    def do_step(self, current_time, step_size):
        x = (self.x, self.y, self.psi, self.v_x, self.v_y, self.r)
        h = step_size / 10
        for _ in range(10):
            a = self.slope(x)
            b = self.slope([p + h / 2 * q for p, q in zip(x, a, strict=True)])
            c = self.slope([p + h / 2 * q for p, q in zip(x, b, strict=True)])
            d = self.slope([p + h * q for p, q in zip(x, c, strict=True)])
            x = [p + h / 6 * (i + 2 * j + 2 * k + n) for p, i, j, k, n in zip(x, a, b, c, d, strict=True)]
        self.x, self.y, self.psi, self.v_x, self.v_y, self.r = x
        return True
