#!/usr/bin/env python3
"""Goal: server_bench runs, small, and says what its rows need. Timings decide nothing."""

import json
import subprocess
import sys


def run(*arguments):
    done = subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def check_percentiles(numbers):
    assert numbers["count"] > 0, numbers
    assert 0 < numbers["p50_ms"] <= numbers["p99_ms"] <= numbers["p999_ms"] <= numbers["max_ms"]


def main():
    fairness = run("fairness", "--nodes", "20000", "--updates", "20")
    check_percentiles(fairness["idle"])
    check_percentiles(fairness["beside"])
    assert fairness["large_nodes"] > 15000 and fairness["p99_ratio"] > 0
    sessions = run("sessions", "--count", "12", "--seconds", "2", "--threads", "3")
    check_percentiles(sessions["latency"])
    assert sessions["latency"]["count"] == 24
    assert sessions["rss_mib_last"] > 0
    overhead = run("overhead", "--nodes", "5000", "--updates", "5")  # There and back: six.
    for answers in ("waiting", "ahead"):
        check_percentiles(overhead[answers]["end_to_end"])
        assert overhead[answers]["end_to_end"]["count"] == 6
        assert overhead[answers]["ratio_median"] > 0
        assert overhead[answers]["cpu_ratio_median"] > 0
    assert 20 < overhead["changed"] < 200, overhead["changed"]
    larger = run("overhead", "--nodes", "5000", "--updates", "2", "--share", "0.1")
    assert larger["changed"] > 5 * overhead["changed"], larger["changed"]
    phases = run("stretches", "--nodes", "5000")["phases"]
    for phase in ("build", "formula", "tensors"):
        check_percentiles(phases[phase])
        assert 0 < phases[phase]["longest_unasked_ms"] <= phases[phase]["max_ms"]
        assert phases[phase + "_commit_ms"] > 0
    phases = run("cancels", "--nodes", "20000", "--updates", "5")["phases"]
    for phase in ("build", "stage_formula", "stage_limits", "stage_all_tensors", "move_nodes",
                  "move_boundary", "replace_domain", "stage_formula_under_limits"):
        assert phases[phase]["count"] <= 5 and phases[phase]["whole_ms"] > 0, phases
        if phase != "build":
            assert 0 < phases[phase]["longest_unasked_ms"] <= phases[phase]["whole_ms"], phases


if __name__ == "__main__":
    main()
