"""Shared code of the benchmark tools: paths, running programs, writing files, the name of the machine."""
import argparse
import json
import os
import platform
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class Failed(Exception):
    """Bad input, or something that could not be run: one line for people."""


def run(command, environment=None, folder=ROOT):
    """Standard output of a command. Failed with the end of its errors if it did not succeed."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, cwd=folder,
                              env={**os.environ, **(environment or {})}, check=False)
    except OSError as error:
        raise Failed(f"{words[0]}: cannot be run: {error.strerror}") from error
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["it says nothing"]
        raise Failed(f"{' '.join(words)}: exit code {done.returncode}: " + "\n".join(lines[-10:]))
    return done.stdout


def read_json(path):
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise Failed(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise Failed(f"{path}: is not JSON: {error}") from error


def write_whole(path, text):
    """The file appears whole or not at all."""
    path = Path(path)
    beside = path.with_name(path.name + ".partial")
    try:
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise Failed(f"{path}: cannot be written: {error.strerror}") from error


def regex(text):
    """For argparse: a regular expression."""
    try:
        return re.compile(text)
    except re.error as error:
        raise argparse.ArgumentTypeError(f"'{text}' is no regular expression: {error}") from error


def processor():
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def build_folder_of(program):
    """The build folder of CMake that a program lies in."""
    for folder in Path(program).resolve().parents:
        if (folder / "CMakeCache.txt").exists():
            return folder
    raise Failed(f"{program}: is in no build folder of CMake")


def compiler(build):
    """Name and version of the compiler that CMake chose for a build folder, "GNU 12.2.0"."""
    for path in Path(build).glob("CMakeFiles/*/CMakeCXXCompiler.cmake"):
        found = re.findall(r'set\(CMAKE_CXX_COMPILER_(?:ID|VERSION) "([^"]*)"\)', path.read_text(encoding="utf-8"))
        return " ".join(found)
    raise Failed(f"{build}: is no build folder of CMake")


def commit():
    """The commit of the working tree; -dirty if it was changed since."""
    return run(["git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]).strip()


def main(tool, work):
    """Runs a tool: errors are one line and exit code 2; Ctrl-C ends it quietly."""
    try:
        sys.exit(work())
    except Failed as error:
        print(f"{tool}: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
