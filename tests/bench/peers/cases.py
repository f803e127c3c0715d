"""The cases of the peer benchmark: domain, and metric as a function of arrays of points.

Written from the formulas alone, so that a mistake in the C++ of the same cases shows as bad
quality. A metric is an array (n, 3) of m11, m12, m22; an ideal unit mesh has about `nodes`
vertices.
"""

import dataclasses
from typing import Callable

import numpy as np


@dataclasses.dataclass(frozen=True)
class Case:
    name: str
    low: float  # The domain is the square [low, high]^2...
    high: float
    metric: Callable[[np.ndarray], np.ndarray]
    hole: np.ndarray | None = None  # ...without this polygon: (n, 2), counter-clockwise.


def _from_axes(normal, across, along):
    """Eigenvalue `across` along the unit normal, `along` across it."""
    nx, ny = normal
    excess = across - along
    return np.stack([along + excess * nx * nx, excess * nx * ny, along + excess * ny * ny], axis=1)


def gaussian(nodes):
    def metric(points):
        x, y = points.T
        r2 = x * x + y * y
        f = np.exp(-r2 / 2)
        r = np.sqrt(r2)
        safe = np.where(r > 1e-12, r, 1)
        normal = np.where(r > 1e-12, x / safe, 1), np.where(r > 1e-12, y / safe, 0)
        radial = np.maximum(0.01, f * np.abs(r2 - 1))
        return 0.134436791 * nodes * _from_axes(normal, radial, np.maximum(0.01, f))
    return Case("A", -3, 3, metric)


def diagonal(nodes):
    def metric(points):
        x, y = points.T
        h = 0.01 + 0.25 * np.abs(x - y) / np.sqrt(2)
        return 9.1736630e-4 * nodes * _from_axes((1 + 0 * x, 0 * x), h**-2, h**-2)
    return Case("B", 0, 1, metric)


def _front(name, aspect, slope, scale):
    def metric(points):
        x, y = points.T
        t = y - 0.5
        g = np.sqrt(0.25 + slope**2 * t * t)
        gp = slope**2 * t / g
        w = np.sqrt(1 + gp * gp)
        distance = np.abs(x - g) / w
        peak = 1 + (aspect - 1) * np.exp(-((t / 0.35) ** 2))
        size = 1 / peak + (1 - 1 / peak) * (1 - np.exp(-distance / 0.07))
        return scale * _from_axes((1 / w, -gp / w), size**-2, 1 + 0 * x)
    return Case(name, 0, 1, metric)


def front_at(xc, nodes):
    """Case E: the front of C where it stands after some steps."""
    still = by_name("C", nodes)
    return Case("E", 0, 1, lambda points: still.metric(points - (xc - 0.5, 0)))


def disc(nodes, on):
    """Case F: uniform, with half the size in a disc of 0.1 % of the area while it is on."""
    def metric(points):
        x, y = points.T
        inside = on & (np.hypot(x - 0.5, y - 0.5) < np.sqrt(0.001 / np.pi))
        scale = nodes * np.sqrt(3) / 2 * np.where(inside, 4, 1)
        return np.stack([scale, 0 * x, scale], axis=1)
    return Case("F", 0, 1, metric)


def _layer(name, radii, center, turn, scale):
    """An ellipse in a layer: the size grows with the distance from it, up to four times smaller
    across than along. The turn is in degrees."""
    axis = np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    beside = np.array([-axis[1], axis[0]])

    def metric(points):
        arm = points - center
        u, v = arm @ axis, arm @ beside
        level = np.hypot(u / radii[0], v / radii[1])
        slope = np.stack([u / radii[0]**2, v / radii[1]**2], axis=1)
        steepness = np.maximum(1e-12, np.hypot(*slope.T))
        distance = np.maximum(0, level * (level - 1) / steepness)
        along = 0.02 + 0.15 * distance
        across = along / (1 + 3 * np.exp(-distance / 0.05))
        normal = (slope / steepness[:, None]) @ np.stack([axis, beside])
        return scale * _from_axes(normal.T, across**-2, along**-2)

    t = 2 * np.pi * np.arange(256) / 256
    hole = (center + radii[0] * np.cos(t)[:, None] * axis + radii[1] * np.sin(t)[:, None] * beside)
    return Case(name, 0, 1, metric, hole)


def hole_at(shift, nodes):
    """Case G: a round hole, moved to the right."""
    return _layer("G-hole", (0.1, 0.1), np.array([0.4 + shift, 0.5]), 0, 1.57111598e-3 * nodes)


def flap_at(turn, nodes):
    """Case G: a flap, turned by so many degrees."""
    return _layer("G-flap", (0.25, 0.05), np.array([0.4, 0.5]), turn, 1.01226050e-3 * nodes)


def by_name(name, nodes):
    if name == "A":
        return gaussian(nodes)
    if name == "B":
        return diagonal(nodes)
    if name == "C":
        return _front("C", 100, 0.5, 0.55669468 * nodes)
    if name == "C1000":
        return _front("C1000", 1000, 0.15, 0.4626196 * nodes)
    if name == "F":
        return disc(nodes, False)
    if name == "G-hole":
        return hole_at(0, nodes)
    if name == "G-flap":
        return flap_at(0, nodes)
    raise SystemExit(f"there is no case {name!r}; there are A, B, C, C1000, F, G-hole and G-flap")
