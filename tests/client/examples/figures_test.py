#!/usr/bin/env python3
"""Goal: anyone can make the paper's figures, and they are what the paper shows.

Method: client/examples/figures/run with small sizes for figure 12; the others are small as they
are. What it printed and left behind is judged by NumPy, an XML parser and the standard library.
Environment: PLIANT_BIN, the folder of the programs; PYTHONPATH with the Python package.
"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as xml

import numpy as np

RUN = pathlib.Path(__file__).resolve().parents[3] / "client/examples/figures/run"
ENVIRONMENT = dict(os.environ, PATH=f"{os.environ['PLIANT_BIN']}:{os.environ['PATH']}",
                   PLIANTD=f"{os.environ['PLIANT_BIN']}/pliantd")
LINE = re.compile(r" *(\d+)  (.+?) +([\d,]+) nodes(?: \(paper ([\d,]+)\))? +([\d.]+) s  "
                  r"mean Q ([\d.]+) +([\d.]+) % of edges in")


def run(*arguments):
    return subprocess.run([RUN, *arguments], env=ENVIRONMENT, capture_output=True, text=True,
                          check=False, timeout=280)


def read_medit(path):
    """Points and triangles of a Medit file, by its keywords."""
    words = path.read_text().split()

    def section(name, column_count, kind):
        at = words.index(name)
        count = int(words[at + 1])
        values = words[at + 2:at + 2 + column_count * count]
        return np.array(values, kind).reshape(count, column_count)

    return section("Vertices", 3, float)[:, :2], section("Triangles", 4, int)[:, :3] - 1


class FiguresTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.output = pathlib.Path(cls.folder.name)
        cls.done = run("--start", cls.output, "--nodes-max", "10000", "--paper-nodes-max", "1000",
                       "--picture-size", "300")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_every_figure_has_a_line_with_good_numbers(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        rows = [LINE.match(line) for line in self.done.stdout.splitlines()[:-1]
                if "time grows" not in line]
        self.assertTrue(all(rows), self.done.stdout)
        counts = {row[1]: int(row[3].replace(",", "")) for row in rows}
        self.assertEqual(sorted(counts, key=int), ["7", "10", "11", "12", "13", "15"])
        for figure, paper in (("11", 925), ("13", 8712), ("15", 5523)):
            self.assertLess(abs(counts[figure] / paper - 1), 0.15, f"figure {figure}")
        for row in rows:
            if row[1] != "7":  # Which has poor meshes on purpose.
                self.assertGreater(float(row[6]), 0.93, row[0])
                self.assertGreater(float(row[7]), 90, row[0])

    def test_meshes_cover_their_domains_with_positive_triangles(self):
        areas = {"figure10": 36, "figure11": 1, "figure13": 1, "figure07_pliant": 1}
        for name, area in areas.items():
            points, triangles = read_medit(self.output / "meshes" / f"{name}.mesh")
            a, b, c = (points[triangles[:, k]] for k in range(3))
            doubled = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
            self.assertGreater(doubled.min(), 0, name)
            self.assertAlmostEqual(doubled.sum() / 2 / area, 1, places=12, msg=name)
            self.assertEqual(len(np.unique(triangles)), len(points), name)

    def test_all_that_the_index_shows_is_there(self):
        index = (self.output / "index.html").read_text()
        names = re.findall(r"img src=pictures/(\w+)\.png", index)
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual(set(names), {"figure07", "figure10a", "figure10b", "figure11", "figure12",
                                      "figure13", "figure14", "figure15", "figure15_quality"})
        for name in names:
            png = (self.output / "pictures" / f"{name}.png").read_bytes()
            self.assertTrue(png.startswith(b"\x89PNG\r\n\x1a\n") and len(png) > 5000, name)
            root = xml.parse(self.output / "pictures" / f"{name}.svg").getroot()
            self.assertTrue(root.tag.endswith("svg") and len(list(root.iter())) >= 3, name)
        for name in ("figure10", "figure11", "figure13", "figure15"):
            xml.parse(self.output / "meshes" / f"{name}.vtu")

    def test_says_what_is_wrong(self):
        done = run(f"unix:{self.output}/nobody", self.output / "other")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("nobody", done.stderr)
        self.assertEqual(run(self.output).returncode, 2)


if __name__ == "__main__":
    unittest.main()
