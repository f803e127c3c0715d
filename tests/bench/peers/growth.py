#!/usr/bin/python3
"""Draws how the time of a first build grows with its nodes, Pliant's and the peers'.

    growth.py WORKLOADS SHEET OUTPUT [--nodes-max 4e6] [--seconds-max 60] [--paper]

WORKLOADS is the program of that name in tests/bench, SHEET is pliant_sheet. Case A at 1,000 nodes
and more, each size three times the last; all meshers take turns at a size. Times are those of
compare.py: CPU seconds of our whole way from polygon to mesh, and of a peer's last pass alone, by
its own timer. A mesher is not asked again once a build took more than --seconds-max. Writes
OUTPUT.png and OUTPUT.json, and prints the slopes log(time) / log(nodes).
"""

import argparse
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

import cases
import compare

OURS = {"Pliant": "nested", "Pliant, the paper's loop": "paper"}


def build_ours(workloads, variant, nodes):
    """(Nodes, CPU seconds) of one build, and the machine."""
    report = json.loads(subprocess.run(
        [workloads, "--case", "A", "--nodes", str(nodes), "--variant", variant, "--repeat", "1"],
        check=True, capture_output=True, text=True).stdout)
    return (report["result"]["nodes"], report["result"]["time"]["cpu_s"]), report["machine"]


def build_peer(adapt, nodes):
    seconds, _, _, mesh = compare.adapt_peer(adapt, cases.by_name("A", nodes), nodes)
    return len(mesh.points), seconds


def sizes(nodes_max):
    size = 1000.0
    while size < 1.0001 * nodes_max:
        yield size
        size *= 3
    if size / 3 < 0.9 * nodes_max:
        yield nodes_max


def slope(points):
    """Of the least-squares line through the points' logarithms."""
    xs, ys = zip(*((math.log(x), math.log(y)) for x, y in points))
    x_mean, y_mean = sum(xs) / len(xs), sum(ys) / len(ys)
    return (sum((x - x_mean) * (y - y_mean) for x, y in zip(xs, ys))
            / sum((x - x_mean) ** 2 for x in xs))


def grow(workloads, arguments):
    """A curve for each mesher, and the machine."""
    ours = [name for name, variant in OURS.items() if variant == "nested" or arguments.paper]
    peers = {name: adapt for name, (program, adapt) in compare.PEERS.items()
             if shutil.which(program)}
    curves = {name: [] for name in [*ours, *peers]}
    machine = {}
    for nodes in sizes(arguments.nodes_max):
        for name, curve in curves.items():
            if curve and curve[-1][1] > arguments.seconds_max:
                continue
            if name in peers:
                point = build_peer(peers[name], nodes)
            else:
                point, machine = build_ours(workloads, OURS[name], nodes)
            curve.append(point)
            print(f"{name}: {point[0]:,} nodes in {point[1]:.4g} s", flush=True)
    return curves, machine


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workloads", type=pathlib.Path)
    parser.add_argument("sheet", type=pathlib.Path)
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--nodes-max", type=float, default=4e6)
    parser.add_argument("--seconds-max", type=float, default=60)
    parser.add_argument("--paper", action="store_true", help="also the paper's loop, word for word")
    arguments = parser.parse_args()
    curves, machine = grow(arguments.workloads.resolve(), arguments)
    for name, curve in curves.items():
        if len(curve) > 1:
            print(f"{name}: slope {slope(curve):.2f}, of the last two {slope(curve[-2:]):.2f}")
    arguments.output.with_suffix(".json").write_text(
        json.dumps({"curves": curves, "machine": machine}, indent=1))
    chart = {"chart": {"title": "Time of a first build (case A)", "x_label": "nodes",
                       "y_label": "CPU seconds",
                       "series": [{"name": name, "points": curve}
                                  for name, curve in curves.items() if len(curve) > 1]}}
    with tempfile.TemporaryDirectory() as folder:
        description = pathlib.Path(folder, "chart.json")
        description.write_text(json.dumps(chart))
        subprocess.run([arguments.sheet, description, "-o", arguments.output.with_suffix(".png"),
                        "--dpi", "96"], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
