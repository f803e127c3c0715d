#!/usr/bin/python3
"""Cases E, F and G step by step, by Pliant and Debian's bamg and ffbamg, in one run.

    moving.py WORKLOADS [--case E] [--nodes 10000] [--steps 5]

WORKLOADS is the program of that name in tests/bench.

    E       a front moves by 1/50 of the domain a step
    F       the size is halved in a disc of 0.1 % of the area; its tensors are sent
    G-hole  a round hole in a layer moves by half its diameter
    G-flap  a flap in a layer turns by 10 degrees

In E and F a peer begins with Pliant's mesh and has two passes a step, each with its last mesh as
background. In G, where the boundary moves, it begins each step with the geometry and has three.
Times are CPU seconds of a step by its own timer, which leaves out files. A vertex is untouched if a
vertex of the new mesh has its bits; the bytes of a diff are those of new vertices (20), triangles
(16) and ids of removed ones (4), over those of the whole mesh.
"""

import argparse
import dataclasses
import json
import pathlib
import shutil
import statistics
import tempfile
from typing import Callable

import cases
import compare
import judge
import medit

START = 0.25
STEP = 0.02
SHIFT = 0.1
TURN = 10


@dataclasses.dataclass(frozen=True)
class Scene:
    """What moves, and how everybody follows it."""
    case_at: Callable[[int, int], cases.Case]  # After so many steps, for so many nodes.
    start: list[str]  # Arguments of workloads for the mesh at the beginning...
    ours: dict[str, list[str]]  # ...and for its updates.
    passes: int  # Of a peer in a step.


SCENES = {
    "E": Scene(lambda step, nodes: cases.front_at(START + step * STEP, nodes),
               ["--case", "E", "--front", str(START)],
               {"pliant": ["--update", "front"],
                "pliant, tensors sent": ["--update", "front", "--metric", "tensors"],
                "pliant, displacement sent": ["--update", "front", "--displace"]}, 2),
    "F": Scene(lambda step, nodes: cases.disc(nodes, step % 2 == 1), ["--case", "F"],
               {"pliant": ["--update", "tensors"]}, 2),
    "G-hole": Scene(lambda step, nodes: cases.hole_at(SHIFT * min(step % 6, 6 - step % 6), nodes),
                    ["--case", "G-hole"], {"pliant": ["--update", "body", "--follow", "100"]}, 3),
    "G-flap": Scene(lambda step, nodes: cases.flap_at(TURN * step, nodes), ["--case", "G-flap"],
                    {"pliant": ["--update", "body", "--follow", "100"]}, 3),
}


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


def write_geometry(path, case):
    """The boundary of a case, for bamg to begin with."""
    square = [(case.low, case.low), (case.high, case.low), (case.high, case.high),
              (case.low, case.high)]
    loops = [square] if case.hole is None else [square, case.hole.tolist()]
    with open(path, "w", encoding="ascii") as file:
        file.write(f"MeshVersionFormatted 0\nDimension 2\nVertices {sum(map(len, loops))}\n")
        file.writelines(f"{x:.17g} {y:.17g} 1\n" for loop in loops for x, y in loop)
        file.write(f"Edges {sum(map(len, loops))}\n")
        first = 1
        for tag, loop in enumerate(loops, 1):
            file.writelines(f"{first + i} {first + (i + 1) % len(loop)} {tag}\n"
                            for i in range(len(loop)))
            first += len(loop)
        file.write("SubDomain 1\n2 1 1 1\nEnd\n")  # What lies left of the first edge.


def begin_anew(program, folder, case, nodes):
    """A uniform mesh of a case's domain, whose boundary is another one than it was."""
    write_geometry(folder / "geometry.mesh", case)
    compare.run([program, "-v", "0", "-g", "geometry.mesh", "-nbv", str(int(4 * nodes + 10000)),
                 "-hmax", f"{nodes**-0.5:.3g}", "-o", "adapted.mesh"], folder)
    return medit.read(folder / "adapted.mesh")


def step_peer(name, mesh, scene, case, nodes):
    program, adapt = compare.PEERS[name]
    seconds = 0
    with tempfile.TemporaryDirectory() as folder_name:
        folder = pathlib.Path(folder_name)
        if case.hole is not None:
            mesh = begin_anew(program, folder, case, nodes)
        for _ in range(scene.passes):
            compare.write_inputs(folder, mesh, case)
            seconds += adapt(folder, int(4 * nodes + 10000))[0]
            mesh = medit.read(folder / "adapted.mesh")
    return seconds, mesh


def follow(name, mesh, scene, arguments):
    rows = []
    for step in range(1, arguments.steps + 1):
        case = scene.case_at(step, arguments.nodes)
        seconds, new = step_peer(name, mesh, scene, case, arguments.nodes)
        untouched, share = difference(mesh, new)
        mesh = new
        rows.append({**judge.judge(mesh, case), "seconds": seconds, "untouched": untouched,
                     "bytes": share})
    mean = {key: statistics.mean(row[key] for row in rows)
            for key in ("nodes", "q_mean", "share_125", "untouched", "bytes")}
    return {**mean, "seconds": statistics.median(row["seconds"] for row in rows),
            "length_max": max(row["length_max"] for row in rows),
            "q_min": min(row["q_min"] for row in rows)}


def run_ours(arguments, scene, more):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        compare.run([str(arguments.workloads), *scene.start, "--nodes", str(arguments.nodes),
                     "--json", "report.json", *more], folder)
        report = json.loads((folder / "report.json").read_text())["result"]
        mesh = medit.read(folder / "mesh.mesh") if "--mesh" in more else None
    return report, mesh


def row_of_ours(report):
    row = {"nodes": report["nodes_after"], "build": report["build"]["cpu_s"]}
    if "tensors" in report:
        disc = report["tensors"]
        quality, kept, steps = disc["quality_on"], disc["untouched"], disc["on"]
        row.update(q_mean=quality["q_mean"], q_min=quality["q_min"],
                   share_125=quality["integrated_125"], length_max=quality["integrated"]["max"])
    else:
        moved = report["front"] if "front" in report else report["body"]
        kept, steps = moved["untouched"], moved["steps"]
        row["build"] = moved.get("builds", report["build"])["cpu_s"]
        row.update({key: moved[f"{name}_of_steps"]
                    for key, name in (("q_mean", "q_mean"), ("q_min", "q_min"),
                                      ("share_125", "integrated_125"), ("length_max", "longest"))})
    return {**row, "seconds": steps["total"]["cpu_s"], "untouched": kept["untouched"],
            "bytes": kept["diff_bytes_share"]}


def line(name, row):
    build = f"{row['seconds'] / row['build']:.2g}" if "build" in row else ""
    return (f"| {name} | {row['nodes']:,.0f} | {1e3 * row['seconds']:.3g} | {build} "
            f"| {row['share_125']:.1%} | {row['length_max']:.2f} | {row['q_mean']:.3f} "
            f"| {row['q_min']:.3f} | {row['untouched']:.1%} | {row['bytes']:.2g} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workloads", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--case", choices=SCENES, default="E")
    parser.add_argument("--nodes", type=int, default=10000)
    parser.add_argument("--steps", type=int, default=5)
    arguments = parser.parse_args()
    scene = SCENES[arguments.case]
    print("| mesher | nodes | ms a step | of a build | [.8,1.25] | longest | Q mean | Q min "
          "| untouched | diff bytes |")
    print("|---" * 10 + "|")
    _, mesh = run_ours(arguments, scene, ["--repeat", "1", "--mesh", "mesh.mesh"])
    often = ["--repeat", str(arguments.steps), "--steps", str(arguments.steps)]
    for name, more in scene.ours.items():
        report, _ = run_ours(arguments, scene, [*often, *more])
        print(line(name, row_of_ours(report)), flush=True)
    for name in ("bamg", "ffbamg"):
        if shutil.which(compare.PEERS[name][0]):
            row = follow(name, mesh, scene, arguments)
            print(line(f"{name}, {scene.passes} passes", row), flush=True)


if __name__ == "__main__":
    main()
