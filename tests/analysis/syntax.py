#!/usr/bin/env python3
"""Compiles sources of a configured build without making code, with the compiler and flags of compile_commands.json.

    tests/analysis/syntax.py BUILD FOLDER...      FOLDER: of the project, for example tools

Templates are instantiated, so this finds what the compiler refuses or warns of in half the time of a build.
"""
import concurrent.futures
import json
import os
import pathlib
import shlex
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def commands(build, folders):
    """Returns the (source, command, folder) entries of the sources below the folders, generated sources included."""
    found = []
    for entry in json.loads((build / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        place = source.relative_to(build if source.is_relative_to(build) else ROOT)
        if place.parts[0] in folders:
            found.append((str(place), shlex.split(entry["command"]) + ["-fsyntax-only"], entry["directory"]))
    return found


def compile_one(entry):
    source, command, folder = entry
    done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return source, done.returncode, done.stdout


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    entries = commands(pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:])
    if not entries:
        sys.exit("syntax: no source in these folders")
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for source, code, text in pool.map(compile_one, entries):
            if code != 0:
                failed += 1
                print(f"{source}: exit code {code}\n{text}", file=sys.stderr)
    print(f"syntax: {len(entries) - failed} of {len(entries)} sources compile")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
