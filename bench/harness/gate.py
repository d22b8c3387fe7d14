"""Instruction counts against their limits. Counted under callgrind, they are the same in every run and on every machine
with AVX2: valgrind shows programs one fixed processor, so neither caches nor the C library's choices differ. Where
misses are limited too, they are those of callgrind's model of caches whose sizes are given here, not the machine's."""
import os
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from harness.project import Failed, run

TOLERANCE = 0.02  # what another patch level of compiler or library may cost
# Misses vary more, and by a fixed number too: they depend on addresses, which a larger library moves.
MISS_TOLERANCE, MISS_SLACK = 0.1, 500
MISSES = {"first-level": ("D1mr", "D1mw"), "last-level": ("DLmr", "DLmw")}  # of data, by callgrind's events
CACHES = ("--cache-sim=yes", "--I1=32768,8,64", "--D1=32768,8,64", "--LL=1048576,16,64")


def count(program, name, misses=False):
    """{"instructions": n} inside guarded_work of one piece of work, and if asked for the misses of each level."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind.out"
        command = ["valgrind", "--tool=callgrind", "--toggle-collect=guarded_work", f"--callgrind-out-file={out}",
                   *(CACHES if misses else ()), str(program), name]
        # An environment of its own: its size moves the stack.
        environment = {"PATH": os.environ["PATH"], "TMPDIR": "/tmp", "LC_ALL": "C", "OMP_NUM_THREADS": "1",
                       "DECID_ISA": "avx2"}
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, env=environment,
                                  check=False)
        except FileNotFoundError as error:
            raise Failed("valgrind is missing: run tools/setup --check") from error
        if done.returncode != 0:
            raise Failed(f"{name}: exit code {done.returncode}: " + "\n".join(done.stderr.strip().splitlines()[-5:]))
        return summary(out.read_text(encoding="utf-8"), name)


def summary(text, name):
    """The totals of a file of callgrind's: instructions, and the misses that it has."""
    events = []
    for line in text.splitlines():
        if line.startswith("events:"):
            events = line.split()[1:]
        if line.startswith(("summary:", "totals:")):
            # Zeros at the end are left out.
            found = dict.fromkeys(events, 0) | dict(zip(events, map(int, line.split()[1:])))
            if found.get("Ir", 0) > 0:
                return {"instructions": found["Ir"],
                        **{level: sum(found[e] for e in of) for level, of in MISSES.items() if of[0] in found}}
    raise Failed(f"{name}: callgrind counted nothing: is guarded_work still in the program?")


def names_of(program):
    return run([program]).split()


def count_all(program, names, with_misses):
    """{name: its counts}, with misses of those that are among with_misses; as many at a time as there are processors,
    which changes no count."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(names, pool.map(lambda name: count(program, name, name in with_misses), names)))


def misses_of(counts):
    """{"name, first-level misses": n} of all that have them."""
    return {f"{name}, {level} misses": c[level] for name, c in counts.items() for level in MISSES if level in c}


class Verdict:
    """Returns (name, limit, instructions) for each name, with None for a missing one."""

    def __init__(self, limits, counts, tolerance=TOLERANCE, slack=0):
        both = [name for name in counts if name in limits]
        self.rows = [(name, limits.get(name), counts.get(name)) for name in sorted({*limits, *counts})]
        self.slower = [name for name in both if counts[name] > limits[name] * (1 + tolerance) + slack]
        self.faster = [name for name in both if counts[name] < limits[name] * (1 - tolerance) - slack]
        self.unknown = sorted(set(counts) - set(limits))
        self.gone = sorted(set(limits) - set(counts))

    @property
    def red(self):
        return bool(self.slower or self.unknown or self.gone)


def table(rows):
    """Old, new and ratio of each row."""
    width = max((len(name) for name, _, _ in rows), default=0)
    lines = [f"{'':{width}} {'limit':>12} {'now':>12}  now / limit"]
    for name, limit, now in rows:
        ratio = f"{now / limit:12.4f}" if limit and now else f"{'-':>12}"
        lines.append(f"{name:{width}} {limit or '-':>12} {now or '-':>12} {ratio}")
    return "\n".join(lines)
