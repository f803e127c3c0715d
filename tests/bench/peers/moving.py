#!/usr/bin/python3
"""Case E, a front that moves by 1/50 of the domain a step, by Pliant and Debian's bamg and ffbamg.

    moving.py WORKLOADS [--nodes 10000] [--steps 5]

WORKLOADS is the program of that name in tests/bench. A peer begins with Pliant's mesh and has two
passes a step, each with its last mesh as background; times are CPU seconds of a step by its own
timer, which leaves out files. A vertex is untouched if a vertex of the new mesh has its bits; the
bytes of a diff are those of new vertices (20), triangles (16) and ids of removed ones (4), over
those of the whole mesh.
"""

import argparse
import json
import pathlib
import shutil
import statistics
import tempfile

import cases
import compare
import judge
import medit

START = 0.25
STEP = 0.02
PASSES = 2


def keys_of(mesh):
    """What the bits of a mesh are known by: vertices, and triangles as sets of three vertices."""
    points = [point.tobytes() for point in mesh.points]
    triangles = {frozenset(points[corner] for corner in corners) for corners in mesh.triangles}
    return set(points), triangles


def difference(old, new):
    """(Share of the old vertices that are untouched, diff bytes over bytes of the new mesh.)"""
    old_points, old_triangles = keys_of(old)
    new_points, new_triangles = keys_of(new)
    kept = old_points & new_points
    stay = old_triangles & new_triangles
    diff = (20 * len(new_points - kept) + 4 * len(old_points - kept)
            + 16 * len(new_triangles - stay) + 4 * len(old_triangles - stay))
    return len(kept) / len(old_points), diff / (20 * len(new_points) + 16 * len(new_triangles))


def step_peer(adapt, mesh, case, nodes):
    seconds = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for _ in range(PASSES):
            compare.write_inputs(folder, mesh, case)
            seconds += adapt(folder, int(4 * nodes + 10000))[0]
            mesh = medit.read(folder / "adapted.mesh")
    return seconds, mesh


def follow(adapt, mesh, arguments):
    rows = []
    for step in range(1, arguments.steps + 1):
        case = cases.front_at(START + step * STEP, arguments.nodes)
        seconds, new = step_peer(adapt, mesh, case, arguments.nodes)
        untouched, share = difference(mesh, new)
        mesh = new
        rows.append({**judge.judge(mesh, case), "seconds": seconds, "untouched": untouched,
                     "bytes": share})
    mean = {key: statistics.mean(row[key] for row in rows)
            for key in ("nodes", "q_mean", "share_125", "untouched", "bytes")}
    return {**mean, "seconds": statistics.median(row["seconds"] for row in rows),
            "length_max": max(row["length_max"] for row in rows),
            "q_min": min(row["q_min"] for row in rows)}


def run_ours(workloads, arguments, more):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        compare.run([str(workloads), "--case", "E", "--nodes", str(arguments.nodes), "--front",
                     str(START), "--repeat", "1", "--json", "report.json", *more], folder)
        report = json.loads((folder / "report.json").read_text())["result"]
        mesh = medit.read(folder / "mesh.mesh") if "--mesh" in more else None
    return report, mesh


def row_of_ours(report):
    front = report["front"]
    return {"nodes": report["nodes_after"], "seconds": front["steps"]["total"]["cpu_s"],
            "build": front["builds"]["cpu_s"], "q_mean": front["q_mean_of_steps"],
            "q_min": front["q_min_of_steps"], "share_125": front["integrated_125_of_steps"],
            "length_max": front["longest_of_steps"],
            "untouched": front["untouched"]["untouched"],
            "bytes": front["untouched"]["diff_bytes_share"]}


def line(name, row):
    build = f"{row['seconds'] / row['build']:.2f}" if "build" in row else ""
    return (f"| {name} | {row['nodes']:,.0f} | {1e3 * row['seconds']:.3g} | {build} "
            f"| {row['share_125']:.1%} | {row['length_max']:.2f} | {row['q_mean']:.3f} "
            f"| {row['q_min']:.3f} | {row['untouched']:.1%} | {row['bytes']:.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workloads", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--nodes", type=int, default=10000)
    parser.add_argument("--steps", type=int, default=5)
    arguments = parser.parse_args()
    print("| mesher | nodes | ms a step | of a build | [.8,1.25] | longest | Q mean | Q min "
          "| untouched | diff bytes |")
    print("|---" * 10 + "|")
    _, mesh = run_ours(arguments.workloads, arguments, ["--mesh", "mesh.mesh"])
    steps = ["--update", "front", "--steps", str(arguments.steps)]
    for name, more in {"pliant": [], "pliant, displacement sent": ["--displace"]}.items():
        report, _ = run_ours(arguments.workloads, arguments, steps + more)
        print(line(name, row_of_ours(report)), flush=True)
    for name in ("bamg", "ffbamg"):
        program, adapt = compare.PEERS[name]
        if shutil.which(program):
            print(line(f"{name}, {PASSES} passes", follow(adapt, mesh, arguments)), flush=True)


if __name__ == "__main__":
    main()
