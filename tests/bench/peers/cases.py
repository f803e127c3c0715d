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
    low: float  # The domain is the square [low, high]^2.
    high: float
    metric: Callable[[np.ndarray], np.ndarray]


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


def by_name(name, nodes):
    if name == "A":
        return gaussian(nodes)
    if name == "B":
        return diagonal(nodes)
    if name == "C":
        return _front("C", 100, 0.5, 0.55669468 * nodes)
    if name == "C1000":
        return _front("C1000", 1000, 0.15, 0.4626196 * nodes)
    raise SystemExit(f"there is no case {name!r}; there are A, B, C and C1000")
