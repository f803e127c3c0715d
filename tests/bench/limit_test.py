"""The program limit and limit.py, run small: complete tables of sane numbers."""

import json
import pathlib
import subprocess
import sys
import unittest


class Limit(unittest.TestCase):
    def test_phases_are_those_of_a_build(self):
        done = subprocess.run([PROGRAM, "--nodes", "10000"], check=True, capture_output=True,
                              text=True)
        report = json.loads(done.stdout)
        nodes = [level["nodes"] for level in report["levels"]]
        self.assertAlmostEqual(nodes[-1] / 10000, 1, delta=0.05)
        self.assertGreater(len(nodes), 2)
        for coarse, fine in zip(nodes, nodes[1:]):
            self.assertAlmostEqual(fine / coarse, 4, delta=0.5)
        visits = sum(level["visits"] for level in report["levels"])
        self.assertGreater(visits / nodes[-1], 1.5)
        self.assertLess(visits / nodes[-1], 8)
        # A vertex and two triangles take 128 bytes; what a program starts with is not counted.
        self.assertGreater(report["bytes_per_node"], 100)
        self.assertGreaterEqual(report["peak_bytes_per_node"], report["bytes_per_node"])
        self.assertGreater(report["clock_ghz"], 0.2)

    def test_script_prints_a_row_for_every_size_and_level(self):
        script = pathlib.Path(__file__).with_name("limit.py")
        done = subprocess.run([sys.executable, "-B", script, PROGRAM, "--nodes", "1000,3000"],
                              check=True, capture_output=True, text=True)
        rows = [line for line in done.stdout.splitlines() if line.startswith("| ")]
        self.assertGreaterEqual(len(rows), 2 + 2 + 2 + 2)
        for row in rows:
            self.assertGreaterEqual(row.count("|"), 6)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop()
    unittest.main()
