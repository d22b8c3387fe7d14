"""The program's messages for wrong input, against tests/golden/messages.txt, which is reviewed as a diff. Each section, from its
heading on, has an empty folder. "$ command" runs in it; the lines below are standard error, "> " and standard output, and the
exit codes of decid other than 2, in brackets. Usage: messages.py PROGRAM [--update]"""

import difflib
import os
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve()
GOLDEN = HERE.with_name("messages.txt")
SOURCE = HERE.parents[2]

# Shell functions of the commands: decid reports an exit code other than 2; lines prints its arguments; wave prints a recording of
# samples at a rate, with the sway of sample k; protocol, frf and groups write the file that they read; identify must leave no
# output.
FUNCTIONS = r"""
decid() { $DECID "$@" </dev/null; code=$?; [ $code = 2 ] || echo "[$code]" >&2; }
lines() { printf '%s\n' "$@"; }
wave() { awk -v n="$1" -v hz="$2" "BEGIN { print \"time,com_sway_deg\"; for (k = 0; k < n; ++k) print k / hz \",\" (${3:-0.3 * (int(k / 7) % 5 - 2)}) }"; }
stimulus() { decid stimulus --protocol p.json -o s.csv; }
protocol() { printf '%s' "$1" > p.json; stimulus; }
frf() { lines "$@" > t.csv; decid fit --frf t.csv -o o.json; }
groups() { lines "$@" > g.csv; decid identify 1.csv 2.csv --group g.csv; }
identify() { decid identify r.csv -o o.json --report o.html "$@"; ls o.* 2>/dev/null; }
"""


def run(command, folder, program):
    done = subprocess.run(["sh", "-c", FUNCTIONS + command], cwd=folder, capture_output=True, text=True, errors="replace",
                          env=dict(os.environ, DECID=program, SOURCE=str(SOURCE), LC_ALL="C"))
    text = done.stderr + "".join(f"> {line}\n" for line in done.stdout.splitlines())
    for given, shown in ((str(folder), "$FOLDER"), (str(SOURCE), "$SOURCE")):
        text = text.replace(given, shown)
    return re.sub(r"\b[0-9a-f]{64}\b", "SHA256", re.sub(r"decid \d+\.\d+\.\d+", "decid VERSION", text))


def messages(text, program):
    """The golden file with what the program prints now."""
    made, folder, kept = [], None, True  # kept: the line is no output
    for line in text.splitlines(keepends=True):
        if line.startswith("# "):
            folder = tempfile.TemporaryDirectory(prefix="decid-test-")
            kept = True
        if line.startswith("$ "):
            made.append(line + run(line[2:], pathlib.Path(folder.name).resolve(), program))
            kept = False
        elif line.startswith("# ") or not line.strip() or kept:
            made.append(line)
    return "".join(made)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    before = GOLDEN.read_text(encoding="utf-8")
    program = sys.argv[1].split()  # an emulator may come first
    now = messages(before, " ".join([*program[:-1], str(pathlib.Path(program[-1]).resolve())]))
    if "--update" in sys.argv:
        GOLDEN.write_text(now, encoding="utf-8")
    elif now != before:
        sys.stdout.writelines(difflib.unified_diff(before.splitlines(True), now.splitlines(True), "messages.txt", "now"))
        sys.exit(f"messages differ: review them, then run {HERE.relative_to(SOURCE)} PROGRAM --update")
    else:
        print(f"{len(re.findall('^[$] ', now, re.MULTILINE))} commands: messages and exit codes are as before")


if __name__ == "__main__":
    main()
