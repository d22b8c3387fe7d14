"""Statistics of tools/bench-compare, against figures worked out by hand, and its refusals."""
import json
import subprocess
import sys
import tempfile
import unittest
from math import comb
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
import made_up  # noqa: E402
from harness.paired import change, exponent, rank  # noqa: E402
from harness.programs import KERNELS, touched_kernels  # noqa: E402


class Interval(unittest.TestCase):
    def test_ranks_are_those_of_the_binomial_distribution(self):
        # Table of order-statistic intervals of the median at 95%: Conover, table A3 (sign test), two-sided.
        self.assertEqual([rank(n) for n in (5, 6, 8, 9, 11, 12, 15, 20, 25)], [0, 1, 1, 2, 2, 3, 4, 6, 8])

    def test_the_next_rank_would_cover_too_little(self):
        for pairs in range(9, 60):
            k = rank(pairs)
            cover = lambda r: 1 - 2 * sum(comb(pairs, i) for i in range(r)) / 2**pairs
            self.assertGreaterEqual(cover(k), 0.95)
            self.assertLess(cover(k + 1), 0.95)

    def test_ratios_are_of_pairs(self):
        # The machine slows down tenfold half way: pairs do not see it.
        old = [1, 1, 1, 1, 10, 10, 10, 10, 10]
        found = change("x", old, [1.2 * t for t in old], 0.03)
        self.assertAlmostEqual(found.ratio, 1.2)
        self.assertTrue(found.slower)


class Verdict(unittest.TestCase):
    def test_slower_needs_the_interval_and_the_minimum(self):
        steady = [1.0] * 9
        self.assertTrue(change("x", steady, [1.05] * 9, 0.03).slower)
        self.assertFalse(change("x", steady, [1.02] * 9, 0.03).slower)
        noisy = [0.9, 0.95, 0.98, 1.06, 1.07, 1.08, 1.1, 1.2, 1.3]
        self.assertGreater(change("x", steady, noisy, 0.03).ratio, 1.03)
        self.assertFalse(change("x", steady, noisy, 0.03).slower)

    def test_faster_is_the_mirror_image(self):
        found = change("x", [1.05] * 9, [1.0] * 9, 0.03)
        self.assertTrue(found.faster)
        self.assertFalse(found.slower)
        self.assertEqual(change("x", [1.02] * 9, [1.0] * 9, 0.03).verdict, "-")

    def test_too_few_pairs_are_refused(self):
        with self.assertRaises(ValueError):
            change("x", [1.0] * 8, [1.0] * 8, 0.03)
        with self.assertRaises(ValueError):
            change("x", [1.0] * 9, [1.0] * 10, 0.03)


class Exponent(unittest.TestCase):
    def test_a_power_is_found_again(self):
        self.assertAlmostEqual(exponent([16, 32, 64], [5 * s**1.75 for s in (16, 32, 64)]), 1.75)

    def test_one_size_tells_nothing(self):
        for sizes, values in (([4, 4], [1, 2]), ([1, 2], [0, 1]), ([1, 2, 3], [1, 2])):
            with self.assertRaises(ValueError):
                exponent(sizes, values)


class Touched(unittest.TestCase):
    """Kernels' sources and the benchmarks that run them."""
    names = [b["name"] for b in json.loads((ROOT / "bench/history/0.1.0-dev.json").read_text())["benchmarks"]]
    names.append("avx512/posterior/gradient")  # 0.1.0 had none

    def found(self, *paths):
        pattern = touched_kernels(paths)
        return [name for name in self.names if pattern and pattern.search(name)]

    def test_every_row_names_sources_and_benchmarks_that_there_are(self):
        for path in KERNELS:
            self.assertTrue((ROOT / path).exists(), path)
            self.assertTrue(self.found(path), path)

    def test_every_kernel_source_has_benchmarks(self):
        for path in ROOT.glob("*/**/kernels/*.hpp"):
            name = str(path.relative_to(ROOT))
            if not name.startswith(("build/", "tests/")):
                self.assertTrue(self.found(name), name)

    def test_only_what_a_source_is_for(self):
        weights = self.found("nn/kernels/generic_conv_gradient.hpp")
        self.assertTrue(all("/backward_weight/" in name and "conv2d" in name for name in weights), weights)
        both = self.found("nn/kernels/generic_conv_gradient.hpp", "nn/kernels/generic_conv.hpp")
        self.assertGreater(len(both), len(weights))
        self.assertEqual(set(self.found("nn/kernels/vec_avx2.hpp", "nn/kernels/generic_conv.hpp")),
                         set(self.found("nn/kernels/")))

    def test_other_sources_are_no_kernels(self):
        self.assertIsNone(touched_kernels(["nn/network.cpp", "docs/develop/performance.md", "nn/kernels/reference.cpp"]))
        self.assertIsNone(touched_kernels([]))


class Programs(unittest.TestCase):
    """tools/bench-compare on two made-up builds."""

    def compare(self, old, new, *words):
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log"
            builds = [made_up.build(Path(folder) / side, times, log) for side, times in (("old", old), ("new", new))]
            done = subprocess.run([ROOT / "tools/bench-compare", "--builds", *builds, "--isa", "avx2", "--json",
                                   Path(folder) / "out.json", *words], capture_output=True, text=True, check=False)
            runs = [line.split() for line in log.read_text().splitlines()] if log.exists() else []
            written = Path(folder) / "out.json"
            return done, runs, json.loads(written.read_text()) if written.exists() else None

    def test_a_slow_down_is_exit_code_1_and_runs_take_turns(self):
        done, runs, result = self.compare([100, 90, 110], [110, 99, 121], "--filter", "conv2d")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("1 slower, 0 faster by 3% or more, of 1", done.stdout)
        self.assertEqual([side for side, _, _ in runs], ["old", "new"] * 9)
        self.assertEqual({(isa, name) for _, isa, name in runs}, {("avx2", "avx2/conv2d/one/forward/manual_time")})
        self.assertEqual(result["changes"][0]["verdict"], "slower")
        self.assertAlmostEqual(result["changes"][0]["ratio"], 1.1)

    def test_a_report_of_a_slow_down_is_exit_code_0(self):
        done, _, _ = self.compare([100], [110], "--filter", "conv2d", "--report")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("1 slower", done.stdout)

    def test_noise_a_gain_and_a_change_below_the_minimum_are_exit_code_0(self):
        for old, new, words, said in (([100, 90, 110], [100, 90, 110], (), "0 slower, 0 faster"),
                                      ([100], [80, 120, 101], (), "0 slower, 0 faster"),
                                      ([100], [90], (), "0 slower, 1 faster"),
                                      ([100], [110], ("--minimum", "12"), "0 slower, 0 faster")):
            done, runs, _ = self.compare(old, new, "--filter", "plane", *words)
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
            self.assertIn(said, done.stdout)
            self.assertEqual(len(runs), 18)

    def test_nothing_in_common_is_exit_code_2(self):
        done, _, result = self.compare([1], [1], "--filter", "no such benchmark")
        self.assertEqual(done.returncode, 2)
        self.assertIn("no benchmark that both", done.stderr)
        self.assertIsNone(result)


class CommandLine(unittest.TestCase):
    def refused(self, *words):
        return made_up.refused(self, "bench-compare", *words)

    def test_wrong_usage_is_exit_code_2(self):
        self.assertIn("give REF, --release or --builds", self.refused())
        self.assertIn("give REF, --release or --builds", self.refused("HEAD", "--release"))
        self.assertIn("--touched", self.refused("HEAD", "--touched", "--filter", "conv2d"))
        self.assertIn("holds no benchmarks", self.refused("--builds", "/no/such", "/build"))
        self.assertIn("--pairs: 9 or more", self.refused("HEAD", "--pairs", "8"))
        self.assertIn("--minimum", self.refused("HEAD", "--minimum", "-1"))
        self.assertIn("--min-time", self.refused("HEAD", "--min-time", "0"))
        self.assertIn("no-such-commit: is not a commit here", self.refused("no-such-commit"))
        self.assertIn("--filter", self.refused("HEAD", "--filter", "("))


if __name__ == "__main__":
    unittest.main()
