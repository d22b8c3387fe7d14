#!/usr/bin/env python3
"""The program of a page in node: its files are those of the program, byte for byte, with each instruction set. Names of files.

    test_node.py DECID RELAXED PLAIN
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

native, relaxed, plain = (pathlib.Path(name).resolve() for name in sys.argv[1:4])
run = pathlib.Path(__file__).resolve().parents[3] / "bindings/web/run"


class Same(unittest.TestCase):
    def outputs(self, folder, program, isa):
        """JSON, table and page that this program writes."""
        names = ["found.json", "found.csv", "found.html"]
        subprocess.run([*program, "identify", "trial.csv", "--quiet", "-o", names[0], "--table", names[1], "--report", names[2]],
                       cwd=folder, check=True, stdout=subprocess.DEVNULL, env=os.environ | ({"DECID_ISA": isa} if isa else {}))
        return [(folder / name).read_bytes() for name in names]

    def test_identify(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = pathlib.Path(scratch)
            subprocess.run([native, "simulate", "--quiet", "--seed", "3", "-o", "trial.csv"], cwd=folder, check=True)
            expected = self.outputs(folder, [native], None)
            for program, isa in ((relaxed, "relaxed"), (relaxed, "wasm"), (plain, "wasm"), (plain, "reference")):
                with self.subTest(program=program.name, isa=isa):
                    self.assertEqual(self.outputs(folder, [run, program], isa), expected)

    def test_relaxed_vectors_are_refused_where_there_are_none(self):
        done = subprocess.run([run, plain, "simulate", "-o", "/dev/null"], env=os.environ | {"DECID_ISA": "relaxed"}, capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)


class Names(unittest.TestCase):
    def test_each_is_no_option_and_there_once(self):
        page = run.parent / "page/files.js"
        names = ["-a.csv", "-a.csv", "b.csv", "b.csv", "c", "c"]
        script = page.read_text() + f";console.log(JSON.stringify(namesOf({json.dumps([{'name': name} for name in names])})))"
        done = subprocess.run(["node", "-e", script], check=True, capture_output=True, text=True)
        self.assertEqual(json.loads(done.stdout), ["./-a.csv", "./-a (2).csv", "b.csv", "b (2).csv", "c", "c (2)"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
