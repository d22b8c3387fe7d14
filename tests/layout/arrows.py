#!/usr/bin/env python3
"""Draws which folder includes which, and fails on an include that the layers do not allow, on a library's message that names an
option of the program, on a folder with too many sources, and on a private header outside of detail/.

    tests/layout/arrows.py [ROOT]

The layers are those of CMakeLists.txt (decid_component) and, above them, of tools/ and bindings/. Headers in a folder detail/ are
private: only their own library and tests may include them. A library's header that is neither installed (HEADERS of
decid_library) nor included by another library's folder is private, too, and has to be in such a folder. A folder's
tests may include what the folder may, and tests' own headers of these folders."""
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

# Above the libraries: the program's folders, the bindings, and what each stands on.
PROGRAM = {
    "tools/mpi": ["base"],
    "tools/report/json": ["identify"],
    "tools/report": ["tools/report/json"],
    "tools/compare": ["identify"],
    "tools/firmware": ["identify"],
    "tools/onnx": ["identify"],
    "tools/decid": ["tools/report", "tools/compare", "tools/firmware", "tools/onnx", "tools/mpi"],
    "bindings/c": ["tools/report/json"],
    "bindings/python": ["bindings/c"],
    "bench": ["tools/decid"],
}
# Who may include what is not ours. Tests as their folders.
FOREIGN = [
    (r"<mpi\.h>", "MPI", ["tools/mpi"]),
    (r"<CLI/", "the command-line parser", ["tools/decid"]),
    (r"<matio\.h>", "matio", ["recording"]),
    (r"<zip\.h>", "libzip", ["dataset/npz"]),
    (r"<xlsxwriter\.h>", "libxlsxwriter", ["tools/decid"]),
    (r"<Eigen/", "Eigen", ["tools/compare"]),
    (r"<pybind11/", "pybind11", ["bindings/python"]),
]
LOOSE = re.compile(r"^(?!\s*//).*\bApprox\b")  # of doctest, however it is named
# A value of JSON needs its type, not its name alone, or the header compiles behind luckier ones only.
JSON_VALUE = re.compile(r"^\s+(?:const )?Json \w+(?:, \w+)*(?: = [^;]*)?;")
# Libraries name settings; only the program names its options.
OPTION = re.compile(r'^(?!\s*//)[^"]*(?:"[^"]*"[^"]*)*?"[^"]*--[a-z]')
# Headers and sources of a folder, not counting its subfolders.
MAX_SOURCES = 25
# Private wherever they are: decid_kernels compiles these folders once for each instruction set.
KERNELS = "/kernels/"
INCLUDE = re.compile(r'^\s*#\s*include\s*(<[^>]+>|"[^"]+")')


def read_layers(root):
    """Returns the folders that each folder may include, with itself: folder -> set of folders."""
    text = (root / "CMakeLists.txt").read_text()
    folder_of, allowed = {}, {}
    for name, folder, needs in re.findall(r"^decid_component\((\w+) ([\w/]+)([^)]*)\)", text, re.MULTILINE):
        folder_of[name] = folder
        allowed[folder] = {folder}.union(*(allowed[folder_of[need]] for need in needs.split()))
    for folder, needs in PROGRAM.items():
        allowed[folder] = {folder}.union(*(allowed[need] for need in needs))
    return allowed


def libraries_of(allowed):
    return [folder for folder in allowed if folder not in PROGRAM]


def step_of(path, allowed):
    """The layer's folder that a file belongs to, and whether it is one of its tests; None for neither."""
    is_test = path.startswith("tests/")
    name = path.removeprefix("tests/")
    steps = [folder for folder in allowed if name.startswith(folder + "/")]
    if steps:
        return max(steps, key=len), is_test
    # The fixtures of all tests use only base.
    return ("base", True) if is_test and "/" not in name else (None, is_test)


def is_allowed(source, source_is_test, target, target_is_test, allowed):
    if source_is_test and source.startswith("tools/"):
        source = "tools/decid"  # they run the program
    return target in allowed[source] and (source_is_test or not target_is_test)


def look_at(path, text, allowed, arrows, complaints):
    """Adds a file's arrows and what is wrong with it."""
    source, source_is_test = step_of(path, allowed)
    if source is None:
        return
    libraries = libraries_of(allowed)
    for number, line in enumerate(text.splitlines(), 1):
        where = f"{path}:{number}"
        if path.startswith("tests/") and LOOSE.match(line):
            complaints.append(f"{where}: Approx adds 1 to the scale; use near() of tests/near.hpp")
        if path.endswith(".hpp") and JSON_VALUE.match(line) and '#include "base/files/json_object.hpp"' not in text:
            complaints.append(f"{where}: a value of Json needs base/files/json_object.hpp")
        if not source_is_test and source in libraries and OPTION.match(line):
            complaints.append(f"{where}: a library names a setting with setting(), of base/setting.hpp, and no option")
        match = INCLUDE.match(line)
        if not match:
            continue
        included = match[1]
        for pattern, name, folders in FOREIGN:
            if re.match(pattern, included) and source not in folders:
                complaints.append(f"{where}: only {' and '.join(folders)} may include {name}")
        if included[0] == "<" or included.startswith('"embedded/'):
            continue
        target, target_is_test = step_of(included.strip('"'), allowed)
        if target is None:
            complaints.append(f"{where}: {included} is not written from the root of the project")
            continue
        if target != source and not source_is_test:
            arrows.setdefault(source, {}).setdefault(target, 0)
            arrows[source][target] += 1
        if "/detail/" in included and target != source and not path.startswith("tests/"):
            complaints.append(f"{where}: {included} is private to {target}")
        if not is_allowed(source, source_is_test, target, target_is_test, allowed):
            may = ", ".join(folder for folder in allowed if folder in allowed[source])
            complaints.append(f"{where}: {included}; {source} may include {may}")


def crowded(files):
    """Returns a complaint for each folder with too many sources."""
    counts = Counter(str(Path(path).parent) for path in files)
    return [f"{folder}: {count} sources, at most {MAX_SOURCES}; make subfolders by what they do"
            for folder, count in sorted(counts.items()) if count > MAX_SOURCES]


def read_installed(root, libraries):
    """The headers that CMake installs, by the lists of the libraries."""
    installed = set()
    for folder in libraries:
        path = root / folder / "CMakeLists.txt"
        text = path.read_text() if path.exists() else ""
        for headers in re.findall(r"^decid_library\([^)]*?\bHEADERS\b([^)]*?)(?:\b(?:SOURCES|FINDS)\b|\))", text, re.MULTILINE):
            installed.update(f"{folder}/{name}" for name in headers.split())
    return installed


def misplaced(texts, installed, allowed):
    """Returns a complaint for each private header outside of detail/, and for each installed one within."""
    includers = {}
    for path, text in texts.items():
        if not path.startswith("tests/"):
            for match in filter(None, map(INCLUDE.match, text.splitlines())):
                includers.setdefault(match[1].strip('"'), set()).add(step_of(path, allowed)[0])
    complaints = []
    for path in texts:
        folder = step_of(path, allowed)[0]
        if not path.endswith(".hpp") or path.startswith("tests/") or folder not in libraries_of(allowed):
            continue
        if "/detail/" in path:
            if path in installed:
                complaints.append(f"{path}: it is installed, so it cannot be in detail/, which is private to {folder}")
        elif path not in installed and KERNELS not in path and includers.get(path, set()) <= {folder}:
            complaints.append(f"{path}: it is private to {folder}: neither installed nor included by another folder; move it to detail/")
    return complaints


def main(root):
    allowed = read_layers(root)
    files = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.cpp", "*.hpp"],
                           cwd=root, check=True, capture_output=True, text=True).stdout.split()
    arrows, complaints = {}, []
    texts = {path: (root / path).read_text() for path in files if (root / path).exists()}
    complaints += crowded(texts)
    complaints += misplaced(texts, read_installed(root, libraries_of(allowed)), allowed)
    for path, text in texts.items():
        look_at(path, text, allowed, arrows, complaints)
    for source in reversed(list(allowed)):
        targets = arrows.get(source, {})
        drawn = ", ".join(f"{target} ({targets[target]})" for target in reversed(list(allowed)) if target in targets)
        print(f"{source:<18}-> {drawn}" if drawn else source)
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    print(f"arrows: {len(texts)} files, {len(complaints)} complaints")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]))
