#!/usr/bin/env python3
"""A front sweeps through a square, as a solver would see it.

Each time step the "solver" looks at the nodes that it has, computes at each of them the tensor that
it wants there, and sends these tensors; the server lets the mesh follow and the diff says what
changed. Run it with the package on PYTHONPATH (see client/python/README.md):

    client/examples/moving_front.py --steps 10

Columns: nodes and triangles of the mesh; share of the triangles that the step wrote or removed;
milliseconds for the tensors, for the update as seen from here, and in the server's core; error of
linear interpolation of the front's profile at the triangles' centroids.
"""

import argparse
import time

import numpy as np

import pliant

WIDTH = 0.02
CENTRE = np.array([-0.2, -0.2])


def profile(points, radius):
    """What the solver computes: a circular front of width WIDTH around CENTRE."""
    return np.tanh((np.hypot(*(points - CENTRE).T) - radius) / WIDTH)


def wanted_tensors(points, radius, h_min, h_max):
    """(n, 3) tensors m11, m12, m22: across the front h_min growing to h_max, along it h_max."""
    offset = points - CENTRE
    distance = np.hypot(*offset.T)
    normal = offset / distance[:, None]
    # One element may be a fifth longer than the one before it.
    across = np.minimum(h_max, h_min + 0.2 * np.maximum(0, np.abs(distance - radius) - WIDTH))
    along = np.minimum(h_max, 8 * across)
    a, b = 1 / across**2, 1 / along**2
    nx, ny = normal.T
    return np.stack([a * nx**2 + b * ny**2, (a - b) * nx * ny, a * ny**2 + b * nx**2], axis=1)


def interpolation_error(mesh, radius):
    """Largest error of the mesh's linear interpolation of the profile, at centroids."""
    corners = mesh.points[mesh.triangles]
    nodal = profile(mesh.points, radius)[mesh.triangles].mean(axis=1)
    return np.abs(nodal - profile(corners.mean(axis=1), radius)).max()


def run(client, steps, h_min, h_max):
    """Moves the front `steps` times; prints a line each. Returns the last mesh."""
    square = pliant.Domain([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1], [1, 2], [2, 3], [3, 0]],
                           tags=[1, 2, 3, 4])
    print(f"{'step':>4} {'nodes':>7} {'triangles':>9} {'changed':>8} {'tensors ms':>10} "
          f"{'update ms':>9} {'core ms':>8} {'error':>7}")
    with client.create_session(domain=square, metric=pliant.metric.size(h_max)) as session:
        for step in range(steps + 1):
            radius = 0.6 + 0.02 * step
            # At first the mesh knows nothing of the front: it takes some rounds to find it.
            for _ in range(6 if step == 0 else 1):
                began = time.perf_counter()
                tensors = wanted_tensors(session.mesh.points, radius, h_min, h_max)
                sent = time.perf_counter()
                diff = session.update_metric(tensors)
                done = time.perf_counter()
            mesh = session.mesh
            changed = (len(diff.triangle_ids) + len(diff.removed_triangles)) / len(mesh.triangles)
            print(f"{step:4} {len(mesh.points):7} {len(mesh.triangles):9} {changed:8.1%} "
                  f"{(sent - began) * 1e3:10.1f} {(done - sent) * 1e3:9.1f} "
                  f"{diff.compute_us / 1e3:8.1f} {interpolation_error(mesh, radius):7.4f}",
                  flush=True)
        return mesh


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=20, help="time steps")
    parser.add_argument("--h-min", type=float, default=0.002, help="edge length across the front")
    parser.add_argument("--h-max", type=float, default=0.1, help="edge length far away")
    parser.add_argument("--address", help="of a server; default: starts a private one")
    arguments = parser.parse_args()
    address = arguments.address
    with pliant.connect(address) if address else pliant.start_local() as client:
        run(client, arguments.steps, arguments.h_min, arguments.h_max)


if __name__ == "__main__":
    main()
