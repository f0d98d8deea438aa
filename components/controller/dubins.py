"""The Dubins path of a lane change and the return: straight lines and arcs of the smallest radius, (4) of the paper.

One change turns by theta to one side, goes straight for the diagonal `l_d` and turns back. It moves across by

    w = 2 R (1 - cos theta) + l_d sin theta        and along by        2 R sin theta + l_d cos theta.

    P0 ---- P1 ~ P2 ~ P3=P4 ---- P5=P6 ~ P7 ---- P8 ~ P9 ---- P10 ~ P11 ---- P12 ---- P13 ---- P14
    lane     arc        diagonal        arc   adjacent lane   the mirror image       original lane

(P2 is the point of the first arc nearest to the obstacle's boundary.)
References: L. E. Dubins (1957); G. P. Bevan et al. (2008), the construction the paper follows.
"""

from __future__ import annotations

from dataclasses import dataclass

from components.interfaces.buses import Waypoints
from components.interfaces.maths import absolute, atan2, clip, cos, fmax, sin, sqrt, vector, where


def radius(v: float, mu: float, g: float) -> float:
    """Radius of the circle that uses the whole friction at speed `v`, ``R = v^2 / (mu g)`` (4)."""
    return v * v / (mu * g)  # (4)


@dataclass(frozen=True)
class LaneChange:
    """Shape of one change: across by `w` (to the left positive) with arcs of radius `R` and a diagonal `l_d`."""

    w: float
    R: float
    l_d: float

    @property
    def theta(self) -> float:
        """Angle of each arc, from ``2 R cos(theta) - l_d sin(theta) = 2 R - |w|``; exact for small ones too."""
        w = absolute(self.w)
        return 2 * atan2(w, self.l_d + sqrt(self.l_d * self.l_d + w * (4 * self.R - w)))

    @property
    def length(self) -> float:
        """How far along the road the change takes."""
        return 2 * self.R * sin(self.theta) + self.l_d * cos(self.theta)


@dataclass(frozen=True)
class Segment:
    """A line or an arc: start pose, curvature (positive to the left) and arc length."""

    x: float
    y: float
    psi: float
    kappa: float
    length: float
    straight: bool

    def point(self, s: float) -> tuple[float, float]:
        """The point at arc length `s` from the start."""
        if self.straight:
            return self.x + s * cos(self.psi), self.y + s * sin(self.psi)
        turned = self.psi + self.kappa * s
        return (
            self.x + (sin(turned) - sin(self.psi)) / self.kappa,
            self.y - (cos(turned) - cos(self.psi)) / self.kappa,
        )

    def heading(self, s: float) -> float:
        """Direction of travel at arc length `s` from the start."""
        return self.psi + self.kappa * s

    def project(self, x: float, y: float) -> float:
        """Arc length of the point of this segment nearest to (x, y)."""
        dx, dy = x - self.x, y - self.y
        if self.straight:
            return clip(dx * cos(self.psi) + dy * sin(self.psi), 0.0, self.length)
        # the angle at the centre of the circle, counted from the start of the arc
        forward = dx * cos(self.psi) + dy * sin(self.psi)
        left = dy * cos(self.psi) - dx * sin(self.psi)
        turned = atan2(self.kappa * forward, 1 - self.kappa * left)
        return clip(turned / self.kappa, 0.0, self.length)


@dataclass(frozen=True)
class Path:
    """The segments of the path, in order, and its waypoints."""

    segments: tuple[Segment, ...]
    waypoints: Waypoints

    def project(self, x: float, y: float) -> float:
        """Arc length of the point of the path nearest to (x, y)."""
        best, distance, travelled = 0.0, 1e12, 0.0
        for segment in self.segments:
            s = segment.project(x, y)
            p_x, p_y = segment.point(s)
            d = (p_x - x) * (p_x - x) + (p_y - y) * (p_y - y)
            nearer = d < distance
            best = where(nearer, travelled + s, best)
            distance = where(nearer, d, distance)
            travelled = travelled + segment.length
        return best

    def point(self, s: float) -> tuple[float, float]:
        """The point at arc length `s`; straight on before the start and after the end."""
        last = len(self.segments) - 1
        x, y = self.segments[0].point(s)
        travelled = self.segments[0].length
        for i, segment in enumerate(self.segments[1:], start=1):
            inside = s - travelled
            p_x, p_y = segment.point(inside if i == last else clip(inside, 0.0, segment.length))
            x, y = where(inside > 0, p_x, x), where(inside > 0, p_y, y)
            travelled = travelled + segment.length
        return x, y

    def direction(self, s: float) -> tuple[float, float]:
        """Heading and curvature (positive to the left) at arc length `s`; at a joint those of the segment before."""
        psi, kappa = self.segments[0].heading(s), self.segments[0].kappa
        travelled = self.segments[0].length
        for segment in self.segments[1:]:
            inside = s - travelled
            psi = where(inside > 0, segment.heading(clip(inside, 0.0, segment.length)), psi)
            kappa = where(inside > 0, segment.kappa, kappa)
            travelled = travelled + segment.length
        return psi, kappa


def double_lane_change(  # noqa: PLR0913 - what the construction needs
    shape: LaneChange, *, x_0: float, x_1: float, x_8: float, x_14: float, y_lane: float, corner: tuple[float, float]
) -> Path:
    """The path from P0 at `x_0` out at `x_1`, back at `x_8` and on to `x_14`, along the lane at `y_lane`.

    Args:
        shape: Either of the two changes; w = 0 gives the straight lane.
        x_0: Start of the path [m].
        x_1: Where the change out begins [m].
        x_8: Where the return begins [m].
        x_14: End of the path [m].
        y_lane: Centre of the lane that the path starts in [m].
        corner: The point [m] of the obstacle's boundary that P2 is nearest to.
    """
    side = where(shape.w < 0, -1.0, 1.0)
    theta, R = side * shape.theta, shape.R
    kappa = side / R
    l_arc = R * absolute(theta)
    x_7, x_11 = x_1 + shape.length, x_8 + shape.length
    drop = R * (1 - cos(theta)) * side  # across one arc
    run = R * sin(absolute(theta))  # along one arc
    y_far = y_lane + shape.w

    out = Segment(x_1, y_lane, 0.0, kappa, l_arc, straight=False)
    back = Segment(x_8, y_far, 0.0, -kappa, l_arc, straight=False)
    x_3, y_3 = x_1 + run, y_lane + drop
    x_5, y_5 = x_7 - run, y_far - drop
    x_9, y_9 = x_8 + run, y_far - drop
    x_10, y_10 = x_11 - run, y_lane + drop
    segments = (
        Segment(x_0, y_lane, 0.0, 0.0, fmax(x_1 - x_0, 0.0), straight=True),  # P0-P1
        out,  # P1-P3
        Segment(x_3, y_3, theta, 0.0, shape.l_d, straight=True),  # P4-P5
        Segment(x_5, y_5, theta, -kappa, l_arc, straight=False),  # P6-P7
        Segment(x_7, y_far, 0.0, 0.0, fmax(x_8 - x_7, 0.0), straight=True),  # P7-P8
        back,  # P8-P9
        Segment(x_9, y_9, -theta, 0.0, shape.l_d, straight=True),  # P9-P10
        Segment(x_10, y_10, -theta, kappa, l_arc, straight=False),  # P10-P11
        Segment(x_11, y_lane, 0.0, 0.0, fmax(x_14 - x_11, 0.0), straight=True),  # P11-P14
    )
    x_2, y_2 = out.point(out.project(*corner))
    rest = (x_14 - x_11) / 3
    return Path(
        segments,
        Waypoints(
            x=vector(
                [x_0, x_1, x_2, x_3, x_3, x_5, x_5, x_7, x_8, x_9, x_10, x_11, x_11 + rest, x_11 + 2 * rest, x_14]
            ),
            y=vector([y_lane, y_lane, y_2, y_3, y_3, y_5, y_5, y_far, y_far, y_9, y_10, *[y_lane] * 4]),
        ),
    )
