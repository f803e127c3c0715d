#!/usr/bin/python3
"""Runs workloads one after the other and prints the tables of README.md.

    suite.py WORKLOADS [--builds] [--updates] [--large] [--poly FILE]

--builds and --updates choose (default: both); --large adds what takes minutes; --poly is the
outline of case D.
"""

import argparse
import json
import pathlib
import subprocess
import sys

BUILDS = [f"--case A --nodes {nodes} --variant {variant}"
          for nodes in (1000, 10000, 100000) for variant in ("nested", "cooled", "paper")]
BUILDS += [f"--case {case} --metric {metric}"
           for case in ("A --nodes 10000", "B --nodes 925", "C --nodes 8712", "C1000 --nodes 10000")
           for metric in ("analytic", "expression", "background")
           if (case, metric) != ("A --nodes 10000", "analytic")]
LARGE_BUILDS = [f"--case A --nodes 1000000 --variant {variant} --repeat 1"
                for variant in ("nested", "cooled")]
LETTERS = "--case D --nodes 5523"
POLY = pathlib.Path(__file__).parents[2] / "client/examples/figures/data/letters.poly"
UPDATES = [f"--case F --nodes {nodes} --update {update}" for nodes in (10000, 100000)
           for update in ("disc", "tensors")]
UPDATES += [f"--case A --nodes {nodes} --update bump --changed {changed}"
            for nodes in (10000, 100000) for changed in (100, 1000)]
UPDATES += [f"--case A --nodes {nodes} --update same" for nodes in (10000, 100000)]
UPDATES += ["--case E --nodes 10000 --front 0.2 --update front --steps 50 --repeat 1"]
LARGE_UPDATES = ["--case F --nodes 1000000 --update disc",
                 "--case F --nodes 1000000 --update tensors",
                 "--case A --nodes 1000000 --update bump --changed 1000",
                 "--case A --nodes 1000000 --update same"]

BUILD_HEAD = ("workloads", "nodes", "CPU s", "nodes/s", "visits/node", "[.8,1.25]", "[.71,1.41]",
              "longest", "Q mean", "Q min", "Q 1 %", "RSS MiB")
UPDATE_HEAD = ("workloads", "nodes", "build", "update", "staging", "loop", "commit",
               "nodes changed", "visits")


def table_line(cells):
    return f"| {' | '.join(cells)} |"


def run(workloads, command):
    done = subprocess.run([workloads, *command.split()], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def milliseconds(seconds):
    return f"{1000 * seconds:.3g}"


def build_row(command, result):
    quality = result["quality"]
    return (f"`{command}`", f"{result['nodes']:,}", f"{result['time']['cpu_s']:.3g}",
            f"{result['nodes_per_cpu_s']:,.0f}", f"{result['visits_per_node']:.1f}",
            f"{quality['integrated_125']:.1%}", f"{quality['integrated_sqrt2']:.1%}",
            f"{quality['integrated']['max']:.2f}", f"{quality['q_mean']:.3f}",
            f"{quality['q_min']:.3f}", f"{quality['q_percentile_1']:.3f}",
            f"{result['peak_rss_mib']:.0f}")


def update_rows(command, update, result):
    parts = result[update]
    for name, part in parts.items():
        if isinstance(part, dict) and "total" in part:
            yield (f"`{command}`: {name}", f"{result['nodes']:,}",
                   milliseconds(result["build"]["cpu_s"]), milliseconds(part["total"]["cpu_s"]),
                   milliseconds(part["stage_cpu_s"]), milliseconds(part["loop_cpu_s"]),
                   milliseconds(part["commit_cpu_s"]), f"{part['changed_nodes']:,.0f}",
                   f"{part['visits']:,.0f}")


def front_line(parts):
    return (f"Front, over all steps: Q mean {parts['q_mean_of_steps']:.4f}, "
            f"Q min {parts['q_min_of_steps']:.3f}, "
            f"[.8,1.25] {parts['integrated_125_of_steps']:.1%}.")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workloads")
    for option in ("--builds", "--updates", "--large"):
        parser.add_argument(option, action="store_true")
    parser.add_argument("--poly", default=POLY)
    arguments = parser.parse_args()
    both = arguments.builds == arguments.updates
    machine = {}
    if arguments.builds or both:
        print(table_line(BUILD_HEAD), "|---" * len(BUILD_HEAD) + "|", sep="\n", flush=True)
        for command in BUILDS + (LARGE_BUILDS if arguments.large else []):
            report = run(arguments.workloads, command)
            print(table_line(build_row(command, report["result"])), flush=True)
        report = run(arguments.workloads, f"{LETTERS} --poly {arguments.poly}")
        print(table_line(build_row(LETTERS, report["result"])), flush=True)
        machine = report["machine"]
    if arguments.updates or both:
        print("\nTimes in CPU ms.\n\n" + table_line(UPDATE_HEAD), "|---" * len(UPDATE_HEAD) + "|",
              sep="\n", flush=True)
        notes = []
        for command in UPDATES + (LARGE_UPDATES if arguments.large else []):
            report = run(arguments.workloads, command)
            if report["update"] == "front":
                notes.append(front_line(report["result"]["front"]))
            for row in update_rows(command, report["update"], report["result"]):
                print(table_line(row), flush=True)
        print("", *notes, sep="\n")
        machine = report["machine"]
    print("\n" + ", ".join(f"{key} {value}" for key, value in machine.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
