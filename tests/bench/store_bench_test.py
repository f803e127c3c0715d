#!/usr/bin/env python3
"""Goal: store_bench runs, small, and says what its rows need. Timings decide nothing."""

import json
import subprocess
import sys


def run(*arguments):
    done = subprocess.run([sys.argv[1], *arguments], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def main():
    strict = run("strict", "--nodes", "3000", "--updates", "6")
    for name in ("strict", "none", "fdatasync"):
        assert strict[name]["count"] == 6 and strict[name]["p50_ms"] > 0, strict
    assert strict["updates_in_journal"] > 5 and strict["journal_bytes_per_update"] > 100, strict
    reopen = run("reopen", "--nodes", "20000", "--updates", "20", "--repeats", "1")
    assert 18 < reopen["revisions_since_snapshot"] < 24, reopen
    assert 0 < reopen["store_load_s"] < reopen["reopen_s"], reopen
    assert reopen["snapshot_bytes"] > 1_000_000, reopen
    sleepers = run("sleepers", "--count", "30", "--memory-limit-mib", "4", "--threads", "2",
                   "--pliantd", sys.argv[2])
    assert sleepers["asleep_at_end"] > 10, sleepers
    assert 800 < sleepers["vertices_mean"] < 1300, sleepers
    assert sleepers["second_update"]["one"]["count"] == 30, sleepers


if __name__ == "__main__":
    main()
