"""The judge and the core's own quality agree: two programs, written apart, from the definitions."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import cases
import judge
import medit

# The judge's name and the report's.
SAME = {"triangles": ("triangles",), "length_mean": ("integrated", "mean"),
        "length_min": ("integrated", "min"), "length_max": ("integrated", "max"),
        "share_sqrt2": ("integrated_sqrt2",), "share_125": ("integrated_125",),
        "q_mean": ("q_mean",), "q_min": ("q_min",)}


class Agreement(unittest.TestCase):
    def test_on_meshes(self):
        for name in ("A", "B", "C", "C1000", "F", "G-hole", "G-flap"):
            with self.subTest(case=name), tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder, "a.mesh")
                done = subprocess.run([PROGRAM, "--case", name, "--nodes", "1500", "--repeat", "1",
                                       "--mesh", path], check=True, capture_output=True)
                ours = json.loads(done.stdout)["result"]["quality"]
                verdict = judge.judge(medit.read(path), cases.by_name(name, 1500))
                self.assertTrue(verdict["valid"])
                for key, keys in SAME.items():
                    value = ours
                    for part in keys:
                        value = value[part]
                    self.assertAlmostEqual(verdict[key], value, delta=1e-6, msg=key)


class Definitions(unittest.TestCase):
    """By hand, where the numbers are known."""

    ONE = cases.Case("one", 0, 1, lambda points: np.tile([4.0, 0, 1.0], (len(points), 1)))

    def test_lengths_and_quality(self):
        # In this metric the triangle has sides 2, 2 and 2.
        points = np.array([[0, 0], [1, 0], [0.5, 3**0.5]])
        triangles = np.array([[0, 1, 2]])
        edges, counts = judge.edges_of(triangles)
        self.assertEqual(counts.tolist(), [1, 1, 1])
        np.testing.assert_allclose(judge.lengths(points, edges, self.ONE.metric), 2, rtol=1e-14)
        np.testing.assert_allclose(judge.qualities(points, triangles, self.ONE.metric), 1,
                                   rtol=1e-14)

    def test_invalid_meshes(self):
        mesh = medit.square(0, 1, 16)
        self.assertTrue(judge.judge(mesh, self.ONE)["valid"])
        missing = medit.Mesh(mesh.points, mesh.triangles[:-1], mesh.edges, mesh.edge_tags)
        self.assertFalse(judge.judge(missing, self.ONE)["valid"])
        turned = mesh.triangles.copy()
        turned[0] = turned[0, ::-1]
        self.assertFalse(judge.judge(medit.Mesh(mesh.points, turned, mesh.edges, mesh.edge_tags),
                                     self.ONE)["valid"])
        moved = mesh.points.copy()
        moved[5] = moved[15]
        self.assertFalse(judge.judge(medit.Mesh(moved, mesh.triangles, mesh.edges, mesh.edge_tags),
                                     self.ONE)["valid"])

    def test_file_round_trip(self):
        mesh = medit.square(-3, 3, 25)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, "a.mesh")
            medit.write(path, mesh)
            again = medit.read(path)
        for a, b in ((mesh.points, again.points), (mesh.triangles, again.triangles),
                     (mesh.edges, again.edges), (mesh.edge_tags, again.edge_tags)):
            np.testing.assert_array_equal(a, b)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
