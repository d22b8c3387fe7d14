#!/usr/bin/env python3
"""Writes decid.html: one file that holds the programs, the model, the styles and the scripts.

    pack.py OUTPUT VERSION PLAIN RELAXED PROBE MODEL REPORT_CSS
"""
import gzip
import pathlib
import sys

here = pathlib.Path(__file__).parent
output, version, plain, relaxed, probe, model, report_css = sys.argv[1:]


DIGITS = [chr(code) for code in range(32, 127) if chr(code) != "<"]  # which could begin markup


def base94(data):
    """The number of bytes, a blank, then eleven digits for nine bytes: 2.2 % shorter than base 85."""
    digits = []
    for begin in range(0, len(data), 9):
        value, group = int.from_bytes(data[begin:begin + 9].ljust(9, b"\0"), "big"), []
        for _ in range(11):
            value, digit = divmod(value, 94)
            group.append(DIGITS[digit])
        digits += reversed(group)
    return f"{len(data)} " + "".join(digits)


def packed(file, every=1):
    """Compressed, without a date, so that the same input gives the same page.
    every 4: first bytes 0, 4, 8 ..., then 1, 5, 9 ..., as those of numbers that are alike compress by 8 % more that way."""
    content = pathlib.Path(file).read_bytes()
    apart = b"".join(content[first::every] for first in range(every))
    return base94(gzip.compress(apart, 9, mtime=0))


def text(*files):
    joined = "".join(pathlib.Path(file).read_text() for file in files)
    assert "</script" not in joined and "<!--" not in joined, files
    return joined


parts = {
    "css": text(report_css, here / "page.css"),
    "about": f"decid {version}, with the built-in model.",
    "model": packed(model, 4), "plain": packed(plain), "relaxed": packed(relaxed), "probe": packed(probe),
    "worker": text(here / "wasi.js", here / "worker.js"),
    "script": text(here / "program.js", here / "files.js", here / "page.js"),
}
html = (here / "page.html").read_text()
for name, content in parts.items():
    before, mark, after = html.partition("{{" + name + "}}")
    assert mark, name
    html = before + content + after
pathlib.Path(output).write_text(html)
