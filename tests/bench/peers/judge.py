"""Judges a mesh against the analytic metric of a case; shares no code with the project's C++.

    judge.py CASE NODES MESH        one line of JSON
"""

import json
import sys

import numpy as np

import cases
import medit

# 5-point Gauss-Legendre on [0, 1].
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)
NODES, WEIGHTS = (NODES + 1) / 2, WEIGHTS / 2


def squared(metric, vector):
    x, y = vector.T
    return metric[:, 0] * x * x + 2 * metric[:, 1] * x * y + metric[:, 2] * y * y


def edges_of(triangles):
    """All edges once, the lower vertex first, and in how many triangles each one lies."""
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]],
                                    triangles[:, [2, 0]]]), axis=1).astype(np.int64)
    keys, counts = np.unique(sides[:, 0] << 32 | sides[:, 1], return_counts=True)
    return np.stack([keys >> 32, keys & 0xFFFFFFFF], axis=1), counts


def lengths(points, edges, metric):
    """Metric lengths, integrated along the edges."""
    start = points[edges[:, 0]]
    vector = points[edges[:, 1]] - start
    return sum(weight * np.sqrt(squared(metric(start + node * vector), vector))
               for node, weight in zip(NODES, WEIGHTS))


def areas(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    u, v = b - a, c - a
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def qualities(points, triangles, metric):
    """Q = 4 sqrt(3) A_M / sum l_M^2 with the mean of the metric at the corners."""
    mean = metric(points)[triangles].mean(axis=1)
    area = areas(points, triangles) * np.sqrt(mean[:, 0] * mean[:, 2] - mean[:, 1] ** 2)
    total = sum(squared(mean, points[triangles[:, (i + 1) % 3]] - points[triangles[:, i]])
                for i in range(3))
    return 4 * np.sqrt(3) * area / total


def domain_of(case):
    """Area and Euler's number of a case's domain."""
    area = (case.high - case.low) ** 2
    if case.hole is None:
        return area, 1
    x, y = case.hole.T
    return area - 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y), 0


def judge(mesh, case):
    area = areas(mesh.points, mesh.triangles)
    triangles = mesh.triangles if area.sum() > 0 else mesh.triangles[:, ::-1]
    area = np.abs(area.sum())
    edges, counts = edges_of(triangles)
    length = lengths(mesh.points, edges, case.metric)
    quality = qualities(mesh.points, triangles, case.metric)
    exact, euler = domain_of(case)
    # The domain without overlaps: all triangles positive, no edge in three, its Euler number and
    # its area.
    used = len(np.unique(triangles))
    valid = (areas(mesh.points, triangles).min() > 0 and counts.max() <= 2
             and used - len(edges) + len(triangles) == euler and abs(area / exact - 1) < 1e-9)
    return {"nodes": used, "triangles": len(triangles), "valid": bool(valid),
            "length_mean": length.mean(), "length_min": length.min(), "length_max": length.max(),
            "share_sqrt2": np.mean((length >= 0.5**0.5) & (length <= 2**0.5)),
            "share_125": np.mean((length >= 0.8) & (length <= 1.25)),
            "q_mean": quality.mean(), "q_min": quality.min()}


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    name, nodes, path = sys.argv[1:]
    print(json.dumps(judge(medit.read(path), cases.by_name(name, float(nodes)))))


if __name__ == "__main__":
    main()
