"""The metrics of the figures in [BossenHeckbert1996], as formulas and, for figure 15, as arrays.

The paper describes its metrics in words. These are the reconstructions that this project measures
itself by; tests/support/cases.cc has the same in C++. Each takes `count`, which scales the metric
so that an ideal mesh has about as many nodes: the integral of sqrt(det M) is count sqrt(3)/2.
"""

import numpy as np


def gaussian(count):
    """Figures 10 and 12: the Hessian of exp(-r^2/2) on [-3, 3]^2, absolute eigenvalues >= 0.01.

    The Hessian's eigenvalues are f (r^2 - 1) along the radius and -f across it. With n the radial
    direction, M = across I + (along - across) n n'; 1e-300 makes n n' zero at the origin, where
    both are equal.
    """
    r2 = "(x*x + y*y)"
    f = f"exp(-{r2}/2)"
    along = f"max(0.01, {f}*abs({r2} - 1))"
    across = f"max(0.01, {f})"
    stretch = f"({along} - {across})/({r2} + 1e-300)"
    scale = repr(0.134436791 * count)
    return [
        f"{scale}*({across} + {stretch}*x*x)",
        f"{scale}*{stretch}*x*y",
        f"{scale}*({across} + {stretch}*y*y)",
    ]


def diagonal(count):
    """Figure 11: the size on the unit square, small along its diagonal."""
    return f"{(9.1736630e-4 * count) ** -0.5!r}*(0.01 + 0.25*abs(x - y)/sqrt(2))"


def shock(count):
    """Figures 13 and 14: a hyperbolic front in the unit square, 100:1 at its middle.

    The front is x = g(y); the size across it grows with the distance from 1/A to 1, where the
    aspect ratio A falls from 100 in the middle to 1 at the ends of the front.
    """
    g = "sqrt(0.25 + 0.25*(y - 0.5)^2)"
    slope = f"(0.25*(y - 0.5)/{g})"
    stretch = f"(1 + {slope}^2)"
    aspect = "(1 + 99*exp(-(y - 0.5)^2/0.1225))"
    size = f"(1/{aspect} + (1 - 1/{aspect})*(1 - exp(-abs(x - {g})/sqrt{stretch}/0.07)))"
    across = f"1/{size}^2"
    scale = repr(0.55669468 * count)
    return [
        f"{scale}*({across} + {slope}^2)/{stretch}",
        f"{scale}*(1 - {across})*{slope}/{stretch}",
        f"{scale}*({across}*{slope}^2 + 1)/{stretch}",
    ]


# Makes the integral over the domain in data/letters.poly what the head of this file says.
_LETTERS_SCALE = 1.992406736691e-05


class Letters:
    """Figure 15: sizes grow with the distance to the given nodes; thin along a sine curve.

    No formula: this is what a solver sends, tensors at the nodes of the mesh that it has.
    """

    def __init__(self, given_points, count):
        self._given = np.asarray(given_points)
        self._scale = _LETTERS_SCALE * count
        self._low = self._given.min(axis=0)
        self._extent = self._given.max(axis=0) - self._low

    def tensors(self, points):
        """(n, 3) rows m11, m12, m22 at (n, 2) points."""
        width, height = self._extent
        size = 0.004 + 0.12 * self._distance(points)
        wave = 2 * np.pi * 1.5 / width
        phase = wave * (points[:, 0] - self._low[0])
        curve = self._low[1] + height / 2 + 0.25 * height * np.sin(phase)
        slope = 0.25 * height * wave * np.cos(phase)
        stretch = np.sqrt(1 + slope**2)
        aspect = 1 + 7 * np.exp(-np.abs(points[:, 1] - curve) / stretch / (0.08 * height))
        normal = np.stack([-slope, np.ones_like(slope)], axis=1) / stretch[:, None]
        along, across = size**-2, (aspect / size) ** 2
        nx, ny = normal.T
        tensors = np.stack(
            [across * nx**2 + along * ny**2, (across - along) * nx * ny,
             across * ny**2 + along * nx**2], axis=1)
        return self._scale * tensors

    def _distance(self, points):
        nearest = np.full(len(points), np.inf)
        for given in self._given:
            np.minimum(nearest, ((points - given) ** 2).sum(axis=1), out=nearest)
        return np.sqrt(nearest)
