"""Conclusions of tools/bench-gate from counts, and its errors; gate_red.sh tries it on programs."""
import sys
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
import made_up  # noqa: E402
from harness.gate import MISSES, Verdict, misses_of, summary, table  # noqa: E402
from harness.project import Failed, read_json  # noqa: E402


class Conclusions(unittest.TestCase):
    def test_more_than_the_tolerance_is_red(self):
        self.assertFalse(Verdict({"a": 1000}, {"a": 1020}).red)
        verdict = Verdict({"a": 1000, "b": 1000}, {"a": 1021, "b": 1000})
        self.assertTrue(verdict.red)
        self.assertEqual(verdict.slower, ["a"])

    def test_fewer_ask_for_an_update_and_are_not_red(self):
        verdict = Verdict({"a": 1000}, {"a": 979})
        self.assertFalse(verdict.red)
        self.assertEqual(verdict.faster, ["a"])

    def test_limits_and_workloads_must_match(self):
        self.assertEqual(Verdict({"a": 1}, {"a": 1, "b": 1}).unknown, ["b"])
        self.assertEqual(Verdict({"a": 1, "b": 1}, {"a": 1}).gone, ["b"])
        self.assertTrue(Verdict({"a": 1}, {"a": 1, "b": 1}).red)
        self.assertTrue(Verdict({"a": 1, "b": 1}, {"a": 1}).red)

    def test_the_table_shows_old_new_and_ratio(self):
        text = table(Verdict({"a": 1000}, {"a": 1100, "b": 7}).rows)
        self.assertRegex(text, r"a +1000 +1100 +1\.1000")
        self.assertRegex(text, r"b +- +7 +-")

    def test_a_count_of_nothing_is_refused(self):
        self.assertEqual(summary("events: Ir\nsummary: 12345\n", "a"), {"instructions": 12345})
        for text in ("summary: 0\n", ""):
            with self.assertRaisesRegex(Failed, "counted nothing"):
                summary(text, "a")

    def test_misses_are_those_of_reads_and_writes(self):
        events = "events: Ir Dr Dw I1mr D1mr D1mw ILmr DLmr DLmw\n"
        found = summary(events + "summary: 100 50 40 9 7 5 8 3 2\n", "a")
        self.assertEqual(found, {"instructions": 100, "first-level": 12, "last-level": 5})
        self.assertEqual(summary(events + "summary: 100 50 40 9 7\n", "a")["first-level"], 7)
        self.assertEqual(misses_of({"a": found, "b": {"instructions": 3}}),
                         {"a, first-level misses": 12, "a, last-level misses": 5})

    def test_few_misses_more_are_let_pass(self):
        self.assertFalse(Verdict({"a": 100}, {"a": 600}, 0.1, 500).red)
        self.assertTrue(Verdict({"a": 100}, {"a": 611}, 0.1, 500).red)
        self.assertEqual(Verdict({"a": 10000}, {"a": 8499}, 0.1, 500).faster, ["a"])


class Limits(unittest.TestCase):
    def test_the_limits_kept_are_numbers_of_guarded_workloads(self):
        limits = read_json(ROOT / "bench/limits.json")
        self.assertRegex(limits["compiler"], r"^GNU \d+$")
        self.assertGreater(len(limits["instructions"]), 30)
        for name, value in limits["instructions"].items():
            self.assertGreater(value, 50000, name)
        self.assertTrue(limits["misses"])
        for name, value in limits["misses"].items():
            self.assertIn(name, limits["instructions"])
            self.assertEqual(set(value), set(MISSES))


class CommandLine(unittest.TestCase):
    def refused(self, *words):
        return made_up.refused(self, "bench-gate", *words)

    def test_wrong_usage_is_exit_code_2(self):
        self.assertIn("--only", self.refused("--only", "("))
        self.assertIn("build the target bench_guarded", self.refused("--program", "/no/such/program"))
        self.assertIn("unrecognized", self.refused("--tolerance", "5"))
        self.assertIn("is in no build folder", self.refused("--program", sys.executable))


if __name__ == "__main__":
    unittest.main()
