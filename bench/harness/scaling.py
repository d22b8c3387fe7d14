"""The scaling study: time and memory of bench_scaling's points, each in a process of its own, and the exponent b of
time = a size^b that least squares in log-log finds."""
import re

from harness.paired import exponent
from harness.programs import Programs
from harness.project import Failed

SECONDS = 0.3


def points(programs, pattern):
    """(what, size, threads, benchmark) of each point, in the program's order."""
    for benchmark in programs.choose(pattern):
        what, size, threads = re.match(r"(.+):(\d+)/threads:(\d+)", benchmark.name).groups()
        yield what, int(size), int(threads), benchmark


def rows(measured):
    """Lines of the table of {(what, threads): [(size, seconds, megabytes)]}."""
    for (what, threads), line in measured.items():
        sizes, seconds, megabytes = zip(*line)
        alone = {size: s for size, s, _ in measured.get((what, 1), [])}
        speed = f"{alone[sizes[-1]] / seconds[-1]:.2f}" if sizes[-1] in alone else "-"
        grows = exponent(sizes, megabytes) if min(megabytes) > 0 else 0.0
        yield (f"| {what} {sizes[0]} to {sizes[-1]} | {threads} | {seconds[0]:.3g} to {seconds[-1]:.3g} "
               f"| {exponent(sizes, seconds):.2f} | {megabytes[0]:.0f} to {megabytes[-1]:.0f} | {grows:.2f} "
               f"| {speed} |")


def table(measured, machine):
    head = (f"{machine['machine']}, {machine['compiler']}, {machine['isa']}, commit {machine['commit']}\n\n"
            "| what | threads | time (s) | exponent | memory (MB) | exponent | times one thread |\n"
            "|---|---|---|---|---|---|---|\n")
    return head + "\n".join(rows(measured)) + "\n"


def study(folder, isa, machine, pattern=None):
    """Runs all points that the pattern finds; the table as Markdown."""
    programs = Programs(folder, isa, ("bench_scaling",))
    measured = {}
    for what, size, threads, benchmark in points(programs, pattern):
        entry = programs.measure(benchmark, SECONDS)[1]
        measured.setdefault((what, threads), []).append((size, entry["best s"], entry["MB"]))
    if not measured:
        raise Failed("--filter finds no point of the scaling study")
    return table(measured, machine)
