#!/usr/bin/python3
"""Says how far first builds are from the limit, in the tables of README.md.

    limit.py LIMIT [--case A] [--nodes 10000,100000,1000000] [--valgrind]

LIMIT is the program of that name. Without hardware counters, instructions and cache misses come
from valgrind (--valgrind; a hundred times as slow), which counts one and simulates the other: a
first level of 48 KiB and a second of 1 MiB, without prefetching.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

RUNS = 3
LEVEL_HEAD = ("nodes", "visits/node", "ns/visit", "cycles/visit", "refinement, ns/new node")
PHASE_HEAD = ("nodes", "visits/node", "loop", "refinement", "commit", "all, ms", "nodes/s",
              "peak B/node", "after B/node")
COUNT_HEAD = ("nodes", "instructions/visit", "reads/visit", "writes/visit", "L1 misses/visit",
              "L2 misses/visit")


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def run(command):
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def total(report):
    levels = report["levels"]
    return (report["start_cpu_s"] + report["commit_cpu_s"] + sum(x["loop_cpu_s"] for x in levels)
            + sum(x.get("refine_cpu_s", 0) for x in levels))


def level_rows(report):
    new_nodes = 0
    refine_s = 0
    for level in report["levels"]:
        nanoseconds = 1e9 * level["loop_cpu_s"] / level["visits"]
        new_nodes = level["nodes"] - new_nodes
        yield (f"{level['nodes']:,}", f"{level['visits'] / level['nodes']:.2f}",
               f"{nanoseconds:.0f}", f"{nanoseconds * report['clock_ghz']:.0f}",
               f"{1e9 * refine_s / new_nodes:.0f}" if refine_s else "")
        new_nodes = level["nodes"]
        refine_s = level.get("refine_cpu_s", 0)


def phase_row(report):
    levels = report["levels"]
    nodes = levels[-1]["nodes"]
    seconds = total(report)
    share = [sum(x["loop_cpu_s"] for x in levels), sum(x.get("refine_cpu_s", 0) for x in levels),
             report["commit_cpu_s"]]
    return (f"{nodes:,}", f"{sum(x['visits'] for x in levels) / nodes:.2f}",
            *(f"{part / seconds:.0%}" for part in share), f"{1e3 * seconds:.1f}",
            f"{nodes / seconds:,.0f}", f"{report['peak_bytes_per_node']:.0f}",
            f"{report['bytes_per_node']:.0f}")


def count_row(command):
    """What valgrind counts inside the loop, for each visit."""
    with tempfile.TemporaryDirectory() as folder:
        output = pathlib.Path(folder) / "counts"
        report = run(["valgrind", "-q", "--tool=callgrind", f"--callgrind-out-file={output}",
                      "--cache-sim=yes", "--D1=49152,12,64", "--LL=1048576,16,64",
                      "--toggle-collect=pliant::PliantLoop::Run*", *command])
        lines = output.read_text().splitlines()
    events = next(line for line in lines if line.startswith("events:")).split()[1:]
    numbers = next(line for line in lines if line.startswith(("totals:", "summary:"))).split()[1:]
    counts = dict(zip(events, map(int, numbers)))
    levels = report["levels"]
    visits = sum(x["visits"] for x in levels)
    sums = (counts["Ir"], counts["Dr"], counts["Dw"], counts["D1mr"] + counts["D1mw"],
            counts["DLmr"] + counts["DLmw"])
    return (f"{levels[-1]['nodes']:,}", *(f"{x / visits:,.1f}" for x in sums))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("limit")
    parser.add_argument("--case", default="A")
    parser.add_argument("--nodes", default="10000,100000,1000000")
    parser.add_argument("--valgrind", action="store_true")
    arguments = parser.parse_args()
    commands = [[arguments.limit, "--case", arguments.case, "--nodes", nodes]
                for nodes in arguments.nodes.split(",")]
    reports = []
    for command in commands:
        runs = sorted((run(command) for _ in range(RUNS)), key=total)
        reports.append(runs[RUNS // 2])
    print(table(PHASE_HEAD, [phase_row(report) for report in reports]))
    print(f"\nClock: {statistics.median(x['clock_ghz'] for x in reports):.2f} GHz. "
          f"Levels of {reports[-1]['levels'][-1]['nodes']:,} nodes:\n")
    print(table(LEVEL_HEAD, level_rows(reports[-1])))
    if arguments.valgrind:
        print("\nInside the loop:\n")
        print(table(COUNT_HEAD, [count_row(command) for command in commands]))


if __name__ == "__main__":
    main()
