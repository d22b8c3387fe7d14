#!/usr/bin/env python3
"""Which lines and branches the tests run: builds with gcov's counters in build/coverage, runs the tests, prints a row a folder.

A branch is a way out of a condition, in any of the functions that a template makes of its line. Left out are ways out by an
exception, which the compiler adds to nearly every call, and those of lines that hold no condition: what it adds to destroy
half of a list, or an object that may have been made.

  tests/coverage.py                 all tests but those that a browser, an emulator or valgrind runs
  tests/coverage.py -L 'nn|sim'     the tests with these labels
  tests/coverage.py --fast          without those that take more than 5 s: most of them are statistics, an hour without -O
  tests/coverage.py --missed FILE   also writes "file:line" of every line that no test ran, and, with how many ways out, of every
                                    condition of which some were not taken
  tests/coverage.py --again         counts what the last tests left, without running any
"""
import argparse
import collections
import gzip
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/coverage"
FOLDERS = ("base", "sim", "nn", "recording", "dataset", "posterior", "identify", "tools")
# Text that is not code, then the tokens that make a line conditional.
NO_CODE = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\'|//.*')
CONDITION = re.compile(r"\b(?:if|for|while|switch|case)\b|\?|&&|\|\||[=!<>]=| [<>] ")


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
    conditions = {}
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
            if name not in conditions:
                conditions[name] = [bool(CONDITION.search(NO_CODE.sub("", line))) for line in path.read_text().splitlines()]
            if entry["lines"] and entry["lines"][-1]["line_number"] > len(conditions[name]):
                sys.exit(f"tests/coverage.py: {name} has changed since the counted tests ran; leave out --again")
            for line in entry["lines"]:
                lines[name, line["line_number"]] += line["count"]
                if not conditions[name][line["line_number"] - 1]:
                    continue
                for i, branch in enumerate(branch for branch in line["branches"] if not branch["throw"]):
                    branches[name, line["line_number"], i] += branch["count"]
    return lines, branches


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-L", "--label", default="", help="labels of tests, as ctest takes them")
    parser.add_argument("--fast", action="store_true", help="without the slow tests")
    parser.add_argument("--missed", help="file for the lines and conditions that no test ran")
    parser.add_argument("--again", action="store_true", help="no tests, only what the last ones left")
    options = parser.parse_args()
    if not options.again:
        run_tests(options)
    report(options)


def run_tests(options):
    run(ROOT / "tools/build", "coverage", stdout=subprocess.DEVNULL)
    for old in BUILD.rglob("*.gcda"):
        old.unlink()
    # A child that may write no file could not leave its counters.
    chosen = ["-L", options.label] if options.label else ["-E", "chromium|qemu|gate|consumer|every compiler|and write none"]
    chosen += ["-LE", "slow|long" if options.fast else "long"]
    run("ctest", "--test-dir", BUILD, "-j", os.cpu_count(), "--timeout", "1800", "--output-on-failure", *chosen,
        stdout=subprocess.DEVNULL, env=dict(os.environ, OMP_WAIT_POLICY="passive"))


def report(options):
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
    if options.missed:
        missed = [f"{name}:{line}" for (name, line), count in lines.items() if count == 0]
        ways = collections.Counter((name, line) for (name, line, _), count in branches.items() if count == 0)
        missed += [f"{name}:{line} {count}" for (name, line), count in ways.items()]
        pathlib.Path(options.missed).write_text("".join(place + "\n" for place in sorted(missed)))


if __name__ == "__main__":
    try:
        main()
    except subprocess.CalledProcessError as error:
        sys.exit(f"tests/coverage.py: {' '.join(map(str, error.cmd[:3]))} ... failed with {error.returncode}")
