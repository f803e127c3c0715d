#!/usr/bin/python3
"""Runs Pliant and the meshers that Debian has on the same cases, in turns, and prints a table.

    compare.py WORKLOADS [--cases A10000,B925,...] [--repeat 3] [--million] [--json FILE]

WORKLOADS is the program of that name in tests/bench. All meshes are judged by judge.py, against
the analytic metric. Times are CPU seconds of one thread, which other users of the machine disturb
least. A peer sees the metric only at the vertices of its background mesh, so it gets several
passes, each with its last mesh as background, the first with a structured one; a row counts the
last pass alone, by the peer's own timer, which leaves out files; ours is the whole way from polygon
to mesh, in memory. What the processes of all passes took, files included, stands beside it.
"""

import argparse
import json
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import cases
import judge
import medit

HERE = pathlib.Path(__file__).resolve().parent
# Passes after which more of them no longer help.
PASSES = {"A": 3, "B": 3, "C": 5, "C1000": 6}
DEFAULT = "A10000,A100000,B925,C8712,C1000:10000"


def run(command, folder):
    """CPU seconds, largest resident MiB and output of a process."""
    done = subprocess.run([sys.executable, "-S", "-E", HERE / "measure.py", "usage", *command],
                          cwd=folder, check=False, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, errors="replace")
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))} failed:\n{done.stdout[-2000:]}")
    seconds, memory = map(float, (folder / "usage").read_text().split())
    return seconds, memory, done.stdout


def write_inputs(folder, mesh, case):
    medit.write(folder / "mesh.mesh", mesh)
    metric = case.metric(mesh.points)
    np.savetxt(folder / "mesh.mtr", metric, fmt="%.17g", header=f"{len(metric)} 3", comments="")


def bamg(program):
    """The command line that Debian's bamg and FreeFem's ffbamg share."""
    def adapt(folder, limit):
        process, memory, text = run([program, "-v", "1", "-nbv", str(limit), "-b", "mesh.mesh",
                                     "-M", "mesh.mtr", "-o", "adapted.mesh"], folder)
        own = float(re.search(r"Cpu time for meshing +: *([\d.eE+-]+)s", text)[1])
        # Its timer counts hundredths; for the smallest meshes only the process tells anything.
        return own if own >= 0.02 else process, process, memory
    return adapt


def freefem(folder, limit):
    (folder / "limit").write_text(f"{limit}\n")
    process, memory, text = run(["FreeFem++", "-nw", "-v", "0", str(HERE / "adapt.edp")], folder)
    own = float(re.search(r"adaptmesh seconds ([\d.eE+-]+)", text)[1])
    return own, process, memory


PEERS = {"bamg": ("bamg", bamg("bamg")), "ffbamg": ("ffbamg", bamg("ffbamg")),
         "freefem": ("FreeFem++", freefem)}


def adapt_peer(adapt, case, nodes):
    """(Seconds of the last pass, of all processes, largest memory, last mesh)."""
    processes, memory = 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        # Coarser by a fifth, bamg ends with 20 % more nodes than wanted on case C.
        mesh = medit.square(case.low, case.high, 0.3 * nodes)
        for _ in range(PASSES[case.name]):
            write_inputs(folder, mesh, case)
            seconds, process, used = adapt(folder, int(4 * nodes + 10000))
            processes += process
            memory = max(memory, used)
            mesh = medit.read(folder / "adapted.mesh")
    return seconds, processes, memory, mesh


def adapt_ours(workloads, case, nodes):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        process, _, _ = run([str(workloads), "--case", case.name, "--nodes", str(nodes), "--repeat",
                             "1", "--mesh", "mesh.mesh", "--json", "report.json"], folder)
        report = json.loads((folder / "report.json").read_text())
        mesh = medit.read(folder / "mesh.mesh")
    return (report["result"]["time"]["cpu_s"], process, report["result"]["peak_rss_mib"], mesh,
            report["machine"])


def compare(workloads, name, nodes, repeat):
    """One row for each mesher, the turns interleaved; and the machine."""
    case = cases.by_name(name, nodes)
    meshers = {"pliant": None, **{peer: adapt for peer, (program, adapt) in PEERS.items()
                                  if shutil.which(program)}}
    runs = {mesher: [] for mesher in meshers}
    machine = {}
    for _ in range(repeat):
        for mesher, adapt in meshers.items():
            if adapt is None:
                *result, machine = adapt_ours(workloads, case, nodes)
            else:
                result = adapt_peer(adapt, case, nodes)
            runs[mesher].append(result)
    rows = []
    for mesher, results in runs.items():
        seconds, processes, memory, meshes = zip(*results)
        row = {"case": f"{name} {nodes:,.0f}", "mesher": mesher,
               "passes": 1 if meshers[mesher] is None else PASSES[name],
               "seconds": statistics.median(seconds),
               "process_seconds": statistics.median(processes), "rss_mib": max(memory),
               **judge.judge(meshes[-1], case)}
        row["nodes_per_s"] = row["nodes"] / row["seconds"]
        rows.append(row)
        row["ratio"] = rows[0]["nodes_per_s"] / row["nodes_per_s"]
    return rows, machine


COLUMNS = {
    "case": "case", "mesher": "mesher", "passes": "passes", "nodes": "nodes",
    "s, last pass": "seconds", "s, all processes": "process_seconds", "nodes/s": "nodes_per_s",
    "ours is faster by": "ratio", "[.8,1.25]": "share_125", "[.71,1.41]": "share_sqrt2",
    "longest": "length_max", "Q mean": "q_mean", "Q min": "q_min", "RSS MiB": "rss_mib",
    "valid": "valid"}
FORMATS = {"nodes": "{:,}", "seconds": "{:.3g}", "process_seconds": "{:.3g}",
           "nodes_per_s": "{:,.0f}", "ratio": "{:.1f}", "share_125": "{:.1%}",
           "share_sqrt2": "{:.1%}", "length_max": "{:.2f}", "q_mean": "{:.3f}",
           "q_min": "{:.3f}", "rss_mib": "{:.0f}"}
HEAD = f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}"


def line(row):
    cells = (FORMATS.get(key, "{}").format(row[key]) for key in COLUMNS.values())
    return f"| {' | '.join(cells)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workloads", type=pathlib.Path)
    parser.add_argument("--cases", default=DEFAULT, help=f"default: {DEFAULT}")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--million", action="store_true", help="also A at 1,000,000 nodes, once")
    parser.add_argument("--json", type=pathlib.Path)
    arguments = parser.parse_args()
    wanted = [(*re.fullmatch(r"(A|B|C1000(?=:)|C):?(\d+)", text).groups(), arguments.repeat)
              for text in arguments.cases.split(",")]
    if arguments.million:
        wanted.append(("A", "1000000", 1))
    print(HEAD, flush=True)
    rows = []
    for name, nodes, repeat in wanted:
        more, machine = compare(arguments.workloads.resolve(), name, float(nodes), repeat)
        print("\n".join(map(line, more)), flush=True)
        rows += more
    print("\n" + ", ".join(f"{key} {value}" for key, value in machine.items()))
    if arguments.json:
        arguments.json.write_text(json.dumps({"rows": rows, "machine": machine}, indent=1,
                                             default=lambda value: value.item()))
    return 0 if all(row["valid"] for row in rows if row["mesher"] == "pliant") else 1


if __name__ == "__main__":
    sys.exit(main())
