#!/usr/bin/env python3
"""Line coverage of each folder by the tests: builds the preset "coverage", runs its tests and prints a Markdown table.

    tests/coverage.py [--short] [--least PERCENT]

--short leaves out the tests labelled slow. --least fails below that share of all lines. Counted by gcov, gathered by
Debian's gcovr."""
import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "coverage"
FOLDERS = ["base", "sim", "nn", "dataset/image", "dataset/sets", "dataset/recording", "dataset/npz", "dataset",
           "identify", "tools/firmware", "tools/report", "tools/decid"]


def measure(short):
    subprocess.run([ROOT / "tools" / "build", "coverage"], check=True, stdout=sys.stderr)
    for counts in BUILD.rglob("*.gcda"):
        counts.unlink()
    tests = ["ctest", "--preset", "coverage", "-j", str(os.cpu_count())] + (["-LE", "slow"] if short else [])
    with open(ROOT / "build" / "coverage.tests.log", "w") as log:
        code = subprocess.run(tests, cwd=ROOT, stdout=log, stderr=log, stdin=subprocess.DEVNULL).returncode
    if code != 0:
        sys.exit("coverage: tests failed; see build/coverage.tests.log")
    filters = [argument for folder in ("base", "sim", "nn", "dataset", "identify", "tools")
               for argument in ("--filter", folder + "/")]
    gathered = subprocess.run(["gcovr", "--root", ROOT, *filters, "-j", str(os.cpu_count()), "--json-summary", "-", BUILD],
                              cwd=ROOT, check=True, capture_output=True, text=True)
    return json.loads(gathered.stdout)["files"]


def share(files):
    return sum(file["line_covered"] for file in files), sum(file["line_total"] for file in files)


def table(files):
    """The rows of a Markdown table, and the share of all lines in percent."""
    rows, left = ["| folder | lines | covered |", "|---|---:|---:|"], list(files)
    for folder in FOLDERS:
        inside = [file for file in left if file["filename"].startswith(folder + "/")]
        left = [file for file in left if file not in inside]
        covered, total = share(inside)
        if total:
            rows.append(f"| `{folder}` | {total} | {100 * covered / total:.1f} % |")
    covered, total = share(files)
    rows.append(f"| all | {total} | {100 * covered / total:.1f} % |")
    return rows, 100 * covered / total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--least", type=float, default=0.0)
    arguments = parser.parse_args()
    files = measure(arguments.short)
    rows, percent = table(files)
    print("\n".join(rows))
    worst = sorted((file for file in files if file["line_total"] > 20), key=lambda file: file["line_percent"])[:5]
    print("\nleast covered: " + ", ".join(f"{file['filename']} {file['line_percent']} %" for file in worst))
    if percent < arguments.least:
        sys.exit(f"coverage: {percent:.1f} % of all lines, less than {arguments.least} %")


if __name__ == "__main__":
    main()
