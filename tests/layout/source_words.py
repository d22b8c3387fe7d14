#!/usr/bin/env python3
"""Fails on a comment or a message of a source that has a word or an opening which CONTRIBUTING.md avoids.

    tests/layout/source_words.py [ROOT]

tests/docs/words.py has the list, which documents keep too."""
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "docs"))
from words import complaints  # noqa: E402

COMMENT = re.compile(r"^(?P<code>.*?)(?<![:\"])//[/<]*(?P<text>.*)$")
MESSAGE = re.compile(r'"((?:[^"\\]|\\.)*)"')


def passages(text):
    """Yields the line number and the text of each comment, lines below each other joined, and of each literal with a blank."""
    begin, block = 0, []
    for number, line in enumerate(text.splitlines() + [""], 1):
        found = COMMENT.match(line)
        whole = found and not found["code"].strip()
        if block and not whole:
            yield begin, " ".join(block)
            block = []
        if whole:
            begin = begin if block else number
            block.append(found["text"].strip())
            continue
        if found:
            yield number, found["text"].strip()
        for literal in MESSAGE.findall(found["code"] if found else line):
            if " " in literal:
                yield number, re.sub(r"\\[nrt]", " ", literal)


def main(root):
    files = subprocess.run(["git", "ls-files", "*.cpp", "*.hpp"], cwd=root, check=True, capture_output=True, text=True).stdout.split()
    found = [f"{path}:{number}: {complaint}" for path in files if (root / path).exists()
             for number, passage in passages((root / path).read_text()) for complaint in complaints(passage)]
    for complaint in found:
        print(complaint, file=sys.stderr)
    print(f"words: {len(found)} complaints")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]))
