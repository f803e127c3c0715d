"""The program workloads, run small: its reports are complete and their numbers sane."""

import json
import subprocess
import sys
import unittest

NODES = 1000


def report(*arguments, nodes=NODES):
    """What the program reports for a few nodes."""
    command = [PROGRAM, "--nodes", str(nodes), "--repeat", "2", *arguments]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(command)} ended with {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


class Builds(unittest.TestCase):
    def check(self, *arguments):
        full = report(*arguments)
        for key in ("processor", "cores", "compiler", "flags", "commit"):
            self.assertTrue(full["machine"][key], key)
        result = full["result"]
        quality = result["quality"]
        self.assertTrue(result["converged"])
        # Boundaries and steep metrics cost a few nodes more than the ideal mesh has.
        self.assertAlmostEqual(result["nodes"] / NODES, 1, delta=0.15)
        self.assertAlmostEqual(quality["complexity"] / (NODES * 0.75**0.5), 1, delta=0.05)
        self.assertEqual(result["nodes"] - quality["edges"] + quality["triangles"], 1)
        self.assertGreater(quality["q_mean"], 0.94)
        self.assertGreater(quality["integrated_sqrt2"], 0.98)
        self.assertGreater(result["visits_per_node"], 1)
        self.assertLess(result["visits_per_node"], 40)
        self.assertEqual(len(result["time"]["cpu_s_all"]), 2)
        self.assertGreater(result["time"]["cpu_s"], 1e-4)
        self.assertAlmostEqual(
            result["nodes_per_cpu_s"] * result["time"]["cpu_s"] / result["nodes"], 1, places=6)
        self.assertGreater(result["peak_rss_mib"], 1)
        return result

    def test_cases(self):
        for case in ("A", "B", "C", "C1000", "E", "F"):
            with self.subTest(case=case):
                self.check("--case", case)

    def test_variants(self):
        visits = {}
        for variant in ("nested", "cooled", "paper"):
            with self.subTest(variant=variant):
                visits[variant] = self.check("--case", "A", "--variant", variant)["visits"]
        # What the variants are for.
        self.assertLess(visits["nested"], visits["cooled"])
        self.assertLess(visits["cooled"], visits["paper"])

    # The formulas are the C++ functions: any mistake in them shows as another mesh.
    def test_formulas(self):
        for case in ("A", "B", "C", "C1000", "E", "F"):
            with self.subTest(case=case):
                formulas = self.check("--case", case, "--metric", "expression")
                function = report("--case", case)["result"]
                self.assertAlmostEqual(formulas["nodes"] / function["nodes"], 1, delta=0.02)
                self.assertAlmostEqual(formulas["quality"]["q_mean"],
                                       function["quality"]["q_mean"], delta=0.01)

    def test_background(self):
        for case in ("A", "C"):
            with self.subTest(case=case):
                self.check("--case", case, "--metric", "background")


    def test_limits(self):
        limits = self.check("--case", "A", "--metric", "expression", "--hgrad", "1.5")["limits"]
        # Case A is smooth: nothing but its steepest places is limited.
        self.assertLess(limits["gradation_count"], 0.1 * NODES)
        self.assertAlmostEqual(limits["limited_complexity"] / limits["raw_complexity"], 1,
                               delta=0.02)


class Updates(unittest.TestCase):
    def test_tensors(self):
        tensors = report("--case", "F", "--update", "tensors", nodes=10000)["result"]["tensors"]
        # A thousandth of the nodes is told, four times as many stand there afterwards.
        self.assertAlmostEqual(tensors["sent_nodes"], 10, delta=4)
        for way in ("on", "off"):
            self.assertGreater(tensors[way]["changed_nodes"], tensors["sent_nodes"])
            self.assertLess(tensors[way]["changed_nodes"], 30 * tensors["sent_nodes"])
            self.assertEqual(tensors[way]["updates"], 2)

    def test_disc(self):
        # A disc of a thousandth of the area: it must hold a few nodes.
        disc = report("--case", "F", "--update", "disc", nodes=5000)["result"]["disc"]
        self.assertGreater(disc["on"]["changed_nodes"], 0)
        self.assertLess(disc["on"]["changed_nodes"], 0.2 * NODES)
        self.assertEqual(disc["on"]["updates"], 2)

    def test_bump(self):
        result = report("--case", "A", "--update", "bump", "--changed", "100")["result"]
        self.assertGreater(result["bump"]["on"]["changed_nodes"], 20)
        self.assertAlmostEqual(result["nodes_after"] / result["nodes"], 1, delta=0.05)

    def test_same_metric(self):
        same = report("--case", "A", "--update", "same")["result"]["same"]
        self.assertEqual(same["formulas"]["changed_nodes"], 0)
        self.assertEqual(same["tensors"]["changed_nodes"], 0)
        self.assertEqual(same["tensors"]["visits"], 0)

    def test_nodes(self):
        nodes = report("--case", "A", "--update", "nodes")["result"]["nodes"]
        self.assertEqual(nodes["swirl"]["updates"], 2)
        self.assertEqual(nodes["shake"]["updates"], 2)
        self.assertEqual(nodes["sub_steps_per_step"], 1)
        self.assertGreater(nodes["quality_last"]["q_mean"], 0.95)

    def test_domain(self):
        domain = report("--case", "F", "--update", "domain")["result"]["domain"]
        self.assertEqual(domain["open"]["updates"], 2)
        self.assertEqual(domain["close"]["updates"], 2)
        self.assertGreater(domain["untouched"]["untouched"], 0.5)

    def test_front(self):
        front = report("--case", "E", "--front", "0.2", "--update", "front", "--steps",
                       "3")["result"]["front"]
        self.assertEqual(front["steps"]["updates"], 3)
        self.assertGreater(front["q_mean_of_steps"], 0.94)
        self.assertGreater(front["quality_last"]["integrated_sqrt2"], 0.97)

    def test_front_with_tensors_is_compared_with_a_build_from_them(self):
        front = ("--case", "E", "--front", "0.2", "--update", "front", "--steps", "2")
        for more in ((), ("--displace",), ("--displace", "--displaced-tensors", "together")):
            result = report(*front, "--metric", "tensors", *more)["result"]["front"]
            self.assertEqual(result["steps"]["updates"], 2)
            self.assertEqual(len(result["builds_as_sent"]["cpu_s_all"]), 1)
            self.assertGreater(result["q_mean_of_steps"], 0.94)
        self.assertNotIn("builds_as_sent", report(*front)["result"]["front"])

    def test_drift(self):
        drift = report("--case", "A", "--update", "drift", "--size-step", "0.97", "--steps",
                       "4")["result"]["drift"]
        self.assertEqual(drift["steps"]["updates"], 4)
        self.assertEqual(len(drift["nodes_over_ideal_of_steps"]), 4)
        self.assertAlmostEqual(drift["nodes_over_ideal_before"], 1, delta=0.05)
        self.assertLessEqual(drift["nodes_over_ideal_least"], drift["nodes_over_ideal_last"])
        self.assertGreater(drift["quality_last"]["integrated_sqrt2"], 0.97)


class Refusals(unittest.TestCase):
    def test_unknown_case(self):
        for arguments in (("--case", "Z"), ("--case", "A", "--update", "no"), ("--case", "D"),
                          ("--case", "F-on", "--metric", "expression")):
            with self.subTest(arguments=arguments), self.assertRaises(AssertionError):
                report(*arguments)


if __name__ == "__main__":
    PROGRAM = sys.argv.pop(1)
    unittest.main()
