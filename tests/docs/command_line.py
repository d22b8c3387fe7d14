"""Writes docs/reference/command-line.md from `decid --help` and the help of each command, or checks that it is current. Refuses
a command with an option that stands in no group of options, or with fewer than three examples."""

import argparse
import pathlib
import re
import subprocess
import sys

HEAD = """# The command line

This page is for everybody who uses the program. It has the help of each command, as `decid COMMAND --help` prints it. `tests/docs/command_line.py` writes
this page. [Results](../guide/results.md#which-exit-codes-and-files-can-a-script-rely-on) explains exit codes and files.

    decid --help
"""


def help_of(decid, *command):
    done = subprocess.run([decid, *command, "--help"], check=True, stdout=subprocess.PIPE, encoding="utf-8")
    # The number of threads that a machine has, and how a program was started, are not the page's.
    text = "\n".join(line.rstrip() for line in done.stdout.strip().splitlines())
    ungrouped = re.findall(r"^  (?:-\w,)?(--[\w-]+)", text.partition("\nOptions:\n")[2].partition("\n\n")[0], re.MULTILINE)
    ungrouped = [option for option in ungrouped if option not in ("--help", "--version")]
    if ungrouped:
        sys.exit(f"decid {' '.join(command)}: {', '.join(ungrouped)} in no group of options (Command::section)")
    if len(re.findall("^  .*decid ", text.partition("\nExamples:\n")[2], re.MULTILINE)) < 3:
        sys.exit(f"decid {' '.join(command)}: fewer than three examples (Command::footer)")
    return text


def page_of(decid):
    whole = help_of(decid)
    commands = re.findall(r"^  ([a-z]+)  +\S", whole[re.search(r"^\w*commands:", whole, re.MULTILINE | re.IGNORECASE).end():], re.MULTILINE)
    parts = [HEAD, "```text\n" + whole + "\n```\n"]
    for command in commands:
        text = help_of(decid, command)
        parts.append(f"## decid {command}\n\n```text\n{text}\n```\n")
        for sub in re.findall(r"^  ([a-z]+)  +\S", text.partition("ubcommands:")[2], re.MULTILINE):
            parts.append(f"### decid {command} {sub}\n\n```text\n{help_of(decid, command, sub)}\n```\n")
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("decid")
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    page, made = asked.page, page_of(asked.decid)
    if not asked.check:
        page.write_text(made, encoding="utf-8")
    elif page.read_text(encoding="utf-8") != made:
        sys.exit(f"{page} is not what --help prints: tests/docs/command_line.py build/release/tools/decid docs/reference/command-line.md")


if __name__ == "__main__":
    main()
