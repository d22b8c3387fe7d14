#!/usr/bin/env python3
"""Fails unless a shared library shows the symbols that a list names, and no others: the binary interface of libdecid.

    symbols.py NM LIBRARY LIST [--update]

A line of the list is a symbol with its version. One that goes, or changes its meaning, is another DECID_ABI
(bindings/c/decid.h) and a new list; one that is new is added with --update."""
import subprocess
import sys
from pathlib import Path


def shown(nm, library):
    lines = subprocess.run([nm, "-D", "--defined-only", library], check=True, capture_output=True, text=True).stdout
    # The version node itself is an absolute symbol.
    return sorted(line.split()[2] for line in lines.splitlines() if line.split()[1] != "A")


def main(nm, library, listed_in, update=""):
    found = shown(nm, library)
    if update:
        Path(listed_in).write_text("\n".join(found) + "\n")
    listed = Path(listed_in).read_text().split()
    for symbol in sorted(set(found) ^ set(listed)):
        print(f"{symbol}: {'not in ' + listed_in if symbol in found else 'missing from ' + library}", file=sys.stderr)
    print(f"symbols: {len(found)} shown, {len(listed)} listed")
    return 0 if found == listed and found else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
