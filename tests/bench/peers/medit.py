"""Reads and writes Medit text meshes, just enough for the peers."""

import dataclasses

import numpy as np


@dataclasses.dataclass
class Mesh:
    points: np.ndarray  # (n, 2)
    triangles: np.ndarray  # (m, 3), from 0
    edges: np.ndarray  # (k, 2), from 0
    edge_tags: np.ndarray  # (k,)


def _section(lines, name, columns):
    """The rows of a section without their last column, and that column; empty if there is none.

    The name stands alone on its line, with the count on the next one or behind it.
    """
    for number, line in enumerate(lines):
        words = line.split()
        if words and words[0] == name:
            first = number + 1 if len(words) > 1 else number + 2
            count = int(words[1] if len(words) > 1 else lines[number + 1])
            rows = np.array(" ".join(lines[first:first + count]).split(), dtype=float)
            rows = rows.reshape(count, columns)
            return rows[:, :-1], rows[:, -1].astype(int)
    return np.empty((0, columns - 1)), np.empty(0, int)


def read(path):
    with open(path, encoding="ascii", errors="replace") as file:
        lines = file.read().splitlines()
    points, _ = _section(lines, "Vertices", 3)
    triangles, _ = _section(lines, "Triangles", 4)
    edges, tags = _section(lines, "Edges", 3)
    return Mesh(points, triangles.astype(int) - 1, edges.astype(int) - 1, tags)


def write(path, mesh):
    with open(path, "w", encoding="ascii") as file:
        file.write("MeshVersionFormatted 1\n\nDimension\n2\n")
        for name, rows, tags in (("Vertices", mesh.points, np.zeros(len(mesh.points), int)),
                                 ("Edges", mesh.edges + 1, mesh.edge_tags),
                                 ("Triangles", mesh.triangles + 1,
                                  np.ones(len(mesh.triangles), int))):
            file.write(f"\n{name}\n{len(rows)}\n")
            number = "%.17g" if rows.dtype == float else "%d"
            row = " ".join([number] * rows.shape[1]) + " %d\n"
            file.writelines(row % (*values, tag)
                            for values, tag in zip(rows.tolist(), tags.tolist()))
        file.write("\nEnd\n")


def square(low, high, count):
    """A structured mesh of a square with about `count` vertices, diagonals alternating."""
    n = max(2, round(count**0.5))
    line = np.linspace(low, high, n)
    points = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    j, i = (k.ravel() for k in np.meshgrid(range(n - 1), range(n - 1), indexing="ij"))
    a = j * n + i
    b, d, e = a + 1, a + n, a + n + 1
    odd = ((i + j) % 2 == 1)[:, None]
    first = np.where(odd, np.stack([a, b, d], 1), np.stack([a, b, e], 1))
    second = np.where(odd, np.stack([b, e, d], 1), np.stack([a, e, d], 1))
    k = np.arange(n - 1)
    sides = (np.stack([k, k + 1], 1), np.stack([(k + 1) * n - 1, (k + 2) * n - 1], 1),
             np.stack([n * n - 1 - k, n * n - 2 - k], 1), np.stack([(n - 1 - k) * n,
                                                                    (n - 2 - k) * n], 1))
    return Mesh(points, np.concatenate([first, second]), np.concatenate(sides),
                np.repeat([1, 2, 3, 4], n - 1))
