"""Runs the commands of user pages and compares what they print with the pages. Usage: printed.py SOURCE_FOLDER DECID

An indented block has a command behind `$ ` and lines of its output, in their order; `...` stands for any lines. The block of
the quickstart is the output of tools/demo, whose trial the other commands read. Posteriors change with the sampler, so the
numbers in outputs of `decid fit` do not count. The table of docs/guide/design.md has the numbers of its two commands."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from tutorials import missing_line

PAGES = ("README.md", "docs/start/quickstart.md", "docs/guide/recordings.md", "docs/guide/warnings.md",
         "docs/guide/frequency-responses.md")
DEMO = "tools/demo"
BLOCK = re.compile(r"(?:^    .*\n)+", re.MULTILINE)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
DESIGNS = ("decid design --amplitude 1 4 --json", "decid design --protocol examples/seven_sines.json --cycles 3 6 --json")
DESIGN_ROW = re.compile(r"^\| [^|]+ \| (\d+) s \| ([\d.]+)° \|(( [\d.]+ \|)+)$", re.MULTILINE)


def parts(page):
    """The commands of a page's blocks, each with the lines that the page shows of its output."""
    for block in BLOCK.findall(page):
        lines = [line[4:] for line in block.splitlines()]
        if lines[0].startswith("out/demo/trial.csv ("):
            yield DEMO, lines
        command, shown = None, []
        for line in [*lines, "$ "]:
            if line.startswith(("$ ", "decid ")):  # without `$` a command has no output on the page
                if command and shown:
                    yield command, shown
                command, shown = (line[2:] if line.startswith("$ ") else None), []
            else:
                shown.append(line)


def without_numbers(lines):
    return [" ".join(NUMBER.sub("0", line).split()) for line in lines]


class Shell:
    """Runs commands in a folder with the examples and the trial of tools/demo."""

    def __init__(self, source, decid, folder):
        programs = folder / "programs"
        programs.mkdir()
        (programs / "decid").symlink_to(pathlib.Path(decid).resolve())
        self.work = folder / "work"
        self.work.mkdir()
        (self.work / "examples").symlink_to((source / "examples").resolve())
        self.environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}")
        demo = (source / DEMO).read_text(encoding="utf-8").split('mkdir -p "$out"\n')[1]
        self.demo = self.run(f"decid=decid out=out/demo\nmkdir -p $out\n{demo}")

    def run(self, command):
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=self.work, env=self.environment, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, encoding="utf-8")
        if done.returncode != 0:
            sys.exit(f"exit code {done.returncode}:\n{command}\n{done.stderr}")
        return done.stdout

    def wrong_line(self, command, shown):
        """The first line of `shown` that the command does not print, and the output; None if there is none."""
        printed = (self.demo if command == DEMO else self.run(command)).splitlines()
        if command.startswith("decid fit"):
            shown, printed = without_numbers(shown), without_numbers(printed)
        line = missing_line(shown, printed)
        return None if line is None else (line, "\n".join(printed))


def check_designs(shell, page):
    """The problems of the table: its rows, by length and size, against the commands' predicted variances."""
    found = {}
    for command in DESIGNS:
        for one in json.loads(shell.run(command))["protocols"]:
            variance = {of["name"]: of["relative_variance"] for of in one["parameters"]}
            found[round(one["duration_s"]), round(one["peak_to_peak_deg"], 1)] = [
                f"{value:.3f}" for value in (one["predicted_variance"], *map(variance.get, ("Kp", "Kp_pass", "theta", "delay")))]
    rows = DESIGN_ROW.findall(page)
    if len(rows) != len(found):
        return [f"docs/guide/design.md: {len(rows)} rows, {len(found)} protocols"]
    return [f"docs/guide/design.md: {length} s, {size}°: {values} should be {found.get((int(length), float(size)))}"
            for length, size, values, _ in rows if values.strip(" |").split(" | ") != found.get((int(length), float(size)))]


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    source, problems = pathlib.Path(sys.argv[1]), []
    with tempfile.TemporaryDirectory() as folder:
        shell = Shell(source, sys.argv[2], pathlib.Path(folder))
        for name in PAGES:
            checked = 0
            for command, shown in parts((source / name).read_text(encoding="utf-8")):
                checked += 1
                wrong = shell.wrong_line(command, shown)
                if wrong:
                    problems.append(f"{name}: no line '{wrong[0]}' in the output of {command}:\n{wrong[1]}")
            if checked == 0:
                problems.append(f"{name}: no command has an output")
        problems += check_designs(shell, (source / "docs/guide/design.md").read_text(encoding="utf-8"))
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
