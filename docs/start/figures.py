#!/usr/bin/env python3
"""Draws the two figures of concepts.md as SVG: a body on the tilting platform with a trial's tilt and sway, and three densities.

    The commands of concepts.md, then:
    docs/start/figures.py trial.csv draws.npz docs/start"""
import ast
import csv
import pathlib
import struct
import sys
import zipfile

STYLE = """<style>text{font:13px sans-serif;fill:#222}.a{stroke:#222}.t{stroke:#c2571a}.s{stroke:#1b6ca8}.g{stroke:#999}
.ft{fill:#c2571a}.fs{fill:#1b6ca8}path,line{fill:none;stroke-width:1.6}
@media(prefers-color-scheme:dark){text{fill:#ddd}.a{stroke:#ddd}.t{stroke:#f0a060}.s{stroke:#6cb8ee}.ft{fill:#f0a060}.fs{fill:#6cb8ee}}</style>"""
TRUTH = {"Kp_pass": 151.0, "delay": 0.145, "Nv": 0.15}
RANGES = {"Kp_pass": (62.9243, 377.546), "delay": (0.0, 0.24), "Nv": (0.0, 1.0)}
ORDER = ["Kp", "Kd", "Kp_pass", "Kd_pass", "Nv", "theta", "delay"]
LABELS = {"Kp_pass": ("Passive stiffness, N m/rad", 1), "delay": ("Reaction delay, ms", 1000), "Nv": ("Sensory noise", 1)}


def svg(width, height, label, parts):
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" aria-label="{label}">'
            f"{STYLE}\n" + "\n".join(parts) + "\n</svg>\n")


def path(points, kind):
    return f'<path class="{kind}" d="M' + "L".join(f"{x:.1f},{y:.1f}" for x, y in points) + '"/>'


def body():
    return ['<path class="t" d="M40,236L150,216"/>', '<path class="g" stroke-dasharray="4 4" d="M95,226L95,40M40,226L160,226"/>',
            '<path class="s" d="M95,226L116,70" style="stroke-width:5"/>', '<circle class="fs" cx="116" cy="70" r="14"/>',
            '<circle class="fs" cx="108" cy="130" r="6"/>', '<text x="120" y="134">centre of mass</text>',
            '<text class="fs" x="98" y="50">sway</text>', '<text class="ft" x="112" y="246">tilt of the platform</text>']


def balance(trial):
    left, right, top, bottom = 300.0, 800.0, 20.0, 220.0
    rows = [(float(r["time"]), float(r["tilt_deg"]), float(r["com_sway_deg"])) for r in csv.DictReader(open(trial))]
    rows = [r for r in rows if 30 <= r[0] <= 70][::8]
    low, high = -0.6, 0.6
    middle = [sum(r[k] for r in rows) / len(rows) for k in (1, 2)]
    def place(time, value):
        return left + (time - 30) / 40 * (right - left), bottom - (value - low) / (high - low) * (bottom - top)
    parts = body() + [f'<path class="a" d="M{left},{top}V{bottom}H{right}"/>']
    for value in (-0.5, 0, 0.5):
        parts.append(f'<text x="{left - 8}" y="{place(30, value)[1] + 4:.0f}" text-anchor="end">{value:g}°</text>')
    for time in (30, 40, 50, 60, 70):
        parts.append(f'<text x="{place(time, 0)[0]:.0f}" y="{bottom + 18}" text-anchor="middle">{time} s</text>')
    for k, kind in ((0, "t"), (1, "s")):
        parts.append(path([place(r[0], r[k + 1] - middle[k]) for r in rows], kind))
    parts += [f'<text class="ft" x="{left + 12}" y="{top + 2}">tilt</text>', f'<text class="fs" x="{left + 52}" y="{top + 2}">sway</text>']
    return svg(820, 260, "A body on a tilting platform, and 40 s of its tilt and sway", parts)


def draws(file):
    """The rows of parameters.npy in an .npz file."""
    data = zipfile.ZipFile(file).read("parameters.npy")
    length = struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10:10 + length].decode())
    values = struct.unpack(f"<{(len(data) - 10 - length) // 8}d", data[10 + length:])
    columns = header["shape"][1]
    return [values[i:i + columns] for i in range(0, len(values), columns)]


def posterior(file):
    rows, parts = draws(file), []
    for panel, name in enumerate(("delay", "Nv", "Kp_pass")):
        low, high = RANGES[name]
        left, width, top, bottom, bins = 20 + 270 * panel, 240.0, 30.0, 190.0, 48
        counts = [0] * bins
        for row in rows:
            counts[min(bins - 1, max(0, int((row[ORDER.index(name)] - low) / (high - low) * bins)))] += 1
        top_count = max(counts)
        def x(value):
            return left + (value - low) / (high - low) * width
        points = [(left, bottom)]
        for i, count in enumerate(counts):
            y = bottom - count / top_count * (bottom - top)
            points += [(left + i * width / bins, y), (left + (i + 1) * width / bins, y)]
        even = bottom - len(rows) / bins / top_count * (bottom - top)
        label, scale = LABELS[name]
        parts += [path(points + [(left + width, bottom)], "s"), f'<path class="a" d="M{left},{bottom}h{width}"/>',
                  f'<path class="g" stroke-dasharray="5 4" d="M{left},{bottom}V{even:.1f}h{width}V{bottom}"/>',
                  f'<path class="t" d="M{x(TRUTH[name]):.1f},{bottom}V{top - 8}"/>',
                  f'<text x="{left + width / 2}" y="228" text-anchor="middle">{label}</text>']
        for value in (low, high):
            parts.append(f'<text x="{x(value):.0f}" y="208" text-anchor="middle">{value * scale:.3g}</text>')
    return svg(820, 240, "Densities of reaction delay, sensory noise and passive stiffness before and after the recording", parts)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[3])
    (folder / "balance.svg").write_text(balance(sys.argv[1]), encoding="utf-8")
    (folder / "posterior.svg").write_text(posterior(sys.argv[2]), encoding="utf-8")


if __name__ == "__main__":
    main()
