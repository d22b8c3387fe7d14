#!/usr/bin/env python3
"""Writes decid.html: one file that holds the programs, the model, the styles and the scripts.

    pack.py OUTPUT VERSION PLAIN RELAXED PROBE MODEL REPORT_CSS
"""
import gzip
import pathlib
import sys

here = pathlib.Path(__file__).parent
output, version, *binaries, report_css = sys.argv[1:]
plain, relaxed, probe, model = (pathlib.Path(file).read_bytes() for file in binaries)


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


def packed(content, every=1):
    """Compressed, without a date, so that the same input gives the same page.
    every 4: first bytes 0, 4, 8 ..., then 1, 5, 9 ..., as those of numbers that are alike compress by 8 % more that way."""
    apart = b"".join(content[first::every] for first in range(every))
    return base94(gzip.compress(apart, 9, mtime=0))


def number(value):
    """Seven bits a byte, the lowest first."""
    low = [value >> shift & 127 for shift in range(0, max(value.bit_length(), 1), 7)]
    return bytes([digit | 128 for digit in low[:-1]] + low[-1:])


def changes(base, target):
    """The size of `target`, then runs that make it of `base`: {count of new bytes, the bytes, place in base, count, differences from the bytes there}.
    The two programs differ in a few functions and elsewhere in the indices of calls, so that most differences are 0."""
    seed, coarse, patience = 16, 4, 16  # equal bytes that begin a run; distance of the places in base that are looked up; a run may lose this much
    base_view, target_view = memoryview(base), memoryview(target)
    places = {base[at:at + seed]: at for at in range(0, len(base) - seed, coarse)}
    runs, done, at = [number(len(target))], 0, 0
    while at < len(target):
        place = places.get(target[at:at + seed])
        if place is None:
            at += 1
            continue
        count = score = best = 0  # the run ends where equal bytes have become rare
        for length, (own, other) in enumerate(zip(target_view[at:], base_view[place:]), 1):
            score += 1 if own == other else -1
            if score > best:
                count, best = length, score
            elif score < best - patience:
                break
        differences = bytes((own - other) & 255 for own, other in zip(target[at:at + count], base[place:place + count]))
        runs += [number(at - done), target[done:at], number(place), number(count), differences]
        at = done = at + count
    return b"".join([*runs, number(len(target) - done), target[done:], number(0), number(0)])


def text(*files):
    joined = "".join(pathlib.Path(file).read_text() for file in files)
    assert "</script" not in joined and "<!--" not in joined, files
    return joined


parts = {
    "css": text(report_css, here / "page.css"),
    "about": f"decid {version}, with the built-in model.",
    "model": packed(model, 4), "plain": packed(changes(relaxed, plain)), "relaxed": packed(relaxed), "probe": packed(probe),
    "worker": text(here / "wasi.js", here / "worker.js"),
    "script": text(here / "program.js", here / "files.js", here / "page.js"),
}
html = (here / "page.html").read_text()
for name, content in parts.items():
    before, mark, after = html.partition("{{" + name + "}}")
    assert mark, name
    html = before + content + after
pathlib.Path(output).write_text(html)
