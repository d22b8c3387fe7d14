#!/usr/bin/env python3
"""Which lines and branches the tests run: builds with gcov's counters in build/coverage, runs the tests, prints a row a folder.

A branch is a way out of a condition, in any of the functions that a template makes of its line; ways out by an exception,
which the compiler adds to nearly every call, are left out.

  tests/coverage.py                 all tests but those that a browser, an emulator or valgrind runs
  tests/coverage.py -L 'nn|sim'     the tests with these labels
  tests/coverage.py --fast          without those that take more than 5 s: most of them are statistics, an hour without -O
  tests/coverage.py --lines FILE    also writes "file:line" of every line that no test ran
"""
import argparse
import collections
import gzip
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/coverage"
FOLDERS = ("base", "sim", "nn", "dataset", "identify", "tools")


def run(*command, **settings):
    subprocess.run([str(word) for word in command], check=True, **settings)


def counts(scratch):
    """{(file, line): how often it ran}, and of (file, line, number of the branch), over all object files."""
    notes = sorted(BUILD.rglob("*.gcda"))
    if not notes:
        sys.exit("tests/coverage.py: no test left counters; did any run?")
    for first in range(0, len(notes), 50):
        run("gcov", "--json-format", "--branch-probabilities", "--preserve-paths", "--hash-filenames", *notes[first:first + 50],
            cwd=scratch, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    lines, branches = collections.Counter(), collections.Counter()
    for report in pathlib.Path(scratch).glob("*.gcov.json.gz"):
        with gzip.open(report) as stream:
            data = json.load(stream)
        for entry in data["files"]:
            path = pathlib.Path(data["current_working_directory"], entry["file"]).resolve()
            if not path.is_relative_to(ROOT):
                continue
            name = str(path.relative_to(ROOT))
            if not name.startswith(tuple(folder + "/" for folder in FOLDERS)):
                continue
            for line in entry["lines"]:
                lines[name, line["line_number"]] += line["count"]
                for i, branch in enumerate(branch for branch in line["branches"] if not branch["throw"]):
                    branches[name, line["line_number"], i] += branch["count"]
    return lines, branches


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-L", "--label", default="", help="labels of tests, as ctest takes them")
    parser.add_argument("--fast", action="store_true", help="without the slow tests")
    parser.add_argument("--lines", help="file for the lines that no test ran")
    options = parser.parse_args()
    run(ROOT / "tools/build", "coverage", stdout=subprocess.DEVNULL)
    for old in BUILD.rglob("*.gcda"):
        old.unlink()
    chosen = ["-L", options.label] if options.label else ["-E", "chromium|qemu|gate|consumer|every compiler"]
    chosen += ["-LE", "slow"] if options.fast else []
    run("ctest", "--test-dir", BUILD, "-j", os.cpu_count(), "--timeout", "1800", "--output-on-failure", *chosen,
        stdout=subprocess.DEVNULL, env=dict(os.environ, OMP_WAIT_POLICY="passive"))
    with tempfile.TemporaryDirectory() as scratch:
        lines, branches = counts(scratch)
    print(f"{'folder':<10} {'lines':>7} {'run':>7} {'part':>7} {'branches':>9} {'run':>7} {'part':>7}")
    rows = collections.defaultdict(lambda: [0, 0, 0, 0])
    for column, counted in ((0, lines), (2, branches)):
        for (name, *_), count in counted.items():
            for key in (name.split("/")[0], "all"):
                rows[key][column] += 1
                rows[key][column + 1] += count > 0
    for folder in (*FOLDERS, "all"):
        if folder in rows:
            total, ran, ways, taken = rows[folder]
            print(f"{folder:<10} {total:>7} {ran:>7} {100 * ran / total:>6.1f}% {ways:>9} {taken:>7} {100 * taken / max(ways, 1):>6.1f}%")
    if options.lines:
        missed = sorted(place for place, count in lines.items() if count == 0)
        pathlib.Path(options.lines).write_text("".join(f"{name}:{line}\n" for name, line in missed))


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"tests/coverage.py: {' '.join(map(str, error.cmd[:3]))} ... failed with {error.returncode}")
