"""Runs the commands of a tutorial and compares what they print with the page. Usage: tutorials.py PAGE DECID [--update]

A block ```sh runs with bash, in one new folder for the page. A block ```text behind it holds lines of its output, in their order;
`...` stands for any lines. --update writes the whole output into each block that is not right; shorten it by hand."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"^```(sh|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def missing_line(expected, printed):
    """The first expected line that the output lacks behind the lines before it; None if there is none."""
    lines = iter(line.rstrip() for line in printed)
    for wanted in expected:
        if wanted.strip() != "..." and not any(line == wanted.rstrip() for line in lines):
            return wanted
    return None


def run(page, decid, update):
    text = page.read_text(encoding="utf-8")
    made, end, output = [], 0, None
    with tempfile.TemporaryDirectory() as folder:
        programs = pathlib.Path(folder, "programs")
        programs.mkdir()
        (programs / "decid").symlink_to(pathlib.Path(decid).resolve())
        work = pathlib.Path(folder, "work")
        work.mkdir()
        environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}")
        for block in BLOCK.finditer(text):
            kind, body = block.groups()
            if kind == "sh":
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", body], cwd=work, env=environment, check=False,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8")
                output = done.stdout.splitlines()
                if done.returncode != 0:
                    return f"{page.name}: exit code {done.returncode}:\n{body}{done.stdout}"
            else:
                wanted = missing_line(body.splitlines(), output)
                if wanted is not None and update:
                    made += [text[end:block.start(2)], "\n".join(line.rstrip() for line in output) + "\n"]
                    end = block.end(2)
                elif wanted is not None:
                    return f"{page.name}: no line '{wanted}' in\n" + "\n".join(output) + "\nif that is right: --update"
    if update:
        page.write_text("".join(made) + text[end:], encoding="utf-8")
    return None


def main():
    if len(sys.argv) not in (3, 4) or sys.argv[3:] not in ([], ["--update"]):
        sys.exit(__doc__)
    problem = run(pathlib.Path(sys.argv[1]), sys.argv[2], sys.argv[3:] == ["--update"])
    if problem:
        sys.exit(problem)


if __name__ == "__main__":
    main()
