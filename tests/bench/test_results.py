"""The file that tools/bench writes, history, scaling table, and refusals of tools/bench and tools/bench-report."""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
import made_up  # noqa: E402
from harness import results, scaling  # noqa: E402
from harness.project import Failed, commit, processor, run, write_whole  # noqa: E402

CONTEXT = {"date": "2024-01-01T00:00:00+00:00", "host_name": "secret", "executable": "/home/me/bench", "num_cpus": 2}


def entry(name, **more):
    return {"name": name, "family_index": 0, "run_name": name, "run_type": "iteration", "iterations": 5,
            "real_time": 1.23456789e-5, "cpu_time": 2.0, "time_unit": "ns", **more}


class File(unittest.TestCase):
    def test_it_is_google_benchmarks_schema_with_the_machine_in_the_context(self):
        joined = results.join([(CONTEXT, entry("a")), ({}, entry("b"))], machine="m", isa="avx2")
        self.assertEqual(set(joined), {"context", "benchmarks"})
        self.assertEqual(joined["context"], {"date": CONTEXT["date"], "num_cpus": 2, "machine": "m", "isa": "avx2"})
        self.assertEqual([(b["name"], b["family_index"]) for b in joined["benchmarks"]], [("a", 0), ("b", 1)])
        self.assertEqual(joined["benchmarks"][0]["real_time"], 1.23457e-5)
        self.assertEqual(joined["benchmarks"][0]["iterations"], 5)

    def test_two_of_a_name_are_refused(self):
        with self.assertRaises(Failed):
            results.join([(CONTEXT, entry("a")), (CONTEXT, entry("a"))])

    def test_rounding_keeps_six_digits(self):
        self.assertEqual([results.rounded(v) for v in (123456.789, 0.000123456789, 0.0, "x", 7)],
                         [123457, 0.000123457, 0.0, "x", 7])

    def test_every_benchmark_stands_beside_the_machine(self):
        self.assertEqual(results.of_machine(entry("a", **{"%peak": 50})), (50, "%peak"))
        self.assertEqual(results.of_machine(entry("a", **{"%bandwidth": 70})), (70, "%bandwidth"))
        with self.assertRaises(Failed):
            results.of_machine(entry("a"))


class History(unittest.TestCase):
    def test_what_is_kept_is_small_complete_and_tells_nothing_private(self):
        kept = sorted((ROOT / "bench/history").glob("*.json"))
        self.assertTrue(kept)
        for path in kept:
            self.assertLess(path.stat().st_size, 60000, path.name)
            result = json.loads(path.read_text(encoding="utf-8"))
            for key in ("date", "machine", "compiler", "commit", "isa", "threads"):
                self.assertIn(key, result["context"], path.name)
            for key in results.PRIVATE:
                self.assertNotIn(key, result["context"], path.name)
            for benchmark in result["benchmarks"]:
                part, _ = results.of_machine(benchmark)
                self.assertGreater(part, 0, benchmark["name"])


class Scaling(unittest.TestCase):
    def test_the_table_has_exponents_and_the_gain_of_threads(self):
        measured = {("work", 1): [(1, 1.0, 10.0), (2, 2.0, 10.0), (4, 4.0, 10.0)],
                    ("work", 2): [(1, 0.5, 10.0), (2, 1.0, 20.0), (4, 2.0, 40.0)]}
        one, two = list(scaling.rows(measured))
        self.assertEqual(one, "| work 1 to 4 | 1 | 1 to 4 | 1.00 | 10 to 10 | 0.00 | 1.00 |")
        self.assertEqual(two, "| work 1 to 4 | 2 | 0.5 to 2 | 1.00 | 10 to 40 | 1.00 | 2.00 |")
        self.assertTrue(list(scaling.rows({("work", 2): measured["work", 2]}))[0].endswith("| - |"))


class Files(unittest.TestCase):
    def test_a_file_appears_whole_or_not_at_all(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.json"
            write_whole(path, "{}")
            self.assertEqual(path.read_text(encoding="utf-8"), "{}")
            self.assertEqual(os.listdir(folder), ["a.json"])
            with self.assertRaisesRegex(Failed, "cannot be written"):
                write_whole(Path(folder) / "none/a.json", "{}")

    def test_programs_that_fail_are_one_message(self):
        with self.assertRaisesRegex(Failed, "no-such-program: cannot be run"):
            run(["no-such-program"])
        with self.assertRaisesRegex(Failed, "exit code 3: what is wrong"):
            run(["sh", "-c", "echo what is wrong >&2; exit 3"])

    def test_machine_and_commit_have_names(self):
        self.assertTrue(processor())
        if (ROOT / ".git").exists():
            self.assertRegex(commit(), r"^[0-9a-f]{12}(-dirty)?$")


class Bench(unittest.TestCase):
    """tools/bench on a made-up build."""

    def test_one_file_of_all_that_is_measured(self):
        with tempfile.TemporaryDirectory() as folder:
            build = made_up.build(Path(folder) / "b", [2.5], Path(folder) / "log")
            (Path(folder) / "peers.json").write_text('[{"what": "w", "ratio": 2}]', encoding="utf-8")
            out = Path(folder) / "out.json"
            subprocess.run([ROOT / "tools/bench", "--build", build, "--isa", "avx2", "--peers",
                            Path(folder) / "peers.json", "-o", out], check=True, capture_output=True)
            result = json.loads(out.read_text(encoding="utf-8"))
        self.assertEqual({key: result["context"][key] for key in ("date", "compiler", "isa", "threads", "peers")},
                         {"date": "2024-01-01", "compiler": "GNU 12.2.0", "isa": "avx2", "threads": "1, 2",
                          "peers": [{"what": "w", "ratio": 2}]})
        self.assertNotIn("host_name", result["context"])
        self.assertEqual([b["name"] for b in result["benchmarks"]],
                         [name for name in made_up.NAMES if not name.startswith("baseline")])
        self.assertEqual(result["benchmarks"][0]["real_time"], 2.5)

    def test_an_instruction_set_that_is_not_there_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            build = made_up.build(Path(folder) / "b", [1], Path(folder) / "log")
            done = subprocess.run([ROOT / "tools/bench", "--build", build, "--isa", "neon"], capture_output=True,
                                  text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("instruction set 'neon': not among baseline, avx2", done.stderr)


class CommandLine(unittest.TestCase):
    def refused(self, tool, *words):
        return made_up.refused(self, tool, *words)

    def test_wrong_usage_is_exit_code_2(self):
        self.assertIn("--min-time", self.refused("bench", "--min-time", "0"))
        self.assertIn("--filter", self.refused("bench", "--filter", "["))
        self.assertIn("takes no --peers", self.refused("bench", "--scaling", "--peers", "x"))
        self.assertIn("is not a folder", self.refused("bench", "-o", "/no/such/folder/x.json"))
        self.assertIn("No such file", self.refused("bench", "--peers", "/no/such.json"))
        self.assertIn("holds no benchmarks", self.refused("bench", "--build", "/no/such/build"))
        self.assertIn("unknown option", self.refused("bench-report", "--x"))
        self.assertIn("-o needs a file", self.refused("bench-report", "-o"))
        self.assertIn("is not there", self.refused("bench-report", "/no/such.json"))


if __name__ == "__main__":
    unittest.main()
