#!/usr/bin/env python3
"""Fails on a comment or a message of a source that has a word or an opening which CONTRIBUTING.md avoids, on a comment that
names a source which does not exist, on an elementary function of the system's library in a folder whose results have the same bits on every machine,
and on JSON that is printed without a rule for text that is not UTF-8.

    tests/layout/source_words.py [ROOT]

tests/docs/words.py has the list, which documents keep too."""
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "docs"))
from words import complaints  # noqa: E402

COMMENT = re.compile(r"^(?P<code>.*?)(?<![:\"])//[/<]*(?P<text>.*)$")
BLOCKS = {".c": ("/*", "*/"), ".h": ("/*", "*/"), ".py": ('"""', '"""')}  # of comments over several lines
LINES = {".py": "#", ".sh": "#", ".m": "%", ".cmake": "#", ".in": "#", ".txt": "#", "": "#"}
OWN = ("tests/docs/words.py", "tests/docs/test_check_docs.py", "tests/layout/test_source_words.py")  # have the words
LIBRARY_FUNCTION = re.compile(r"std::(pow|exp|log|sin|cos|atan2|hypot|arg)\(")  # base/math/math.hpp has decid's own
SAME_BITS = ("base", "sim", "nn", "dataset", "posterior", "identify", "recording")
SYSTEM_BITS = ()  # files of these folders that may call the system's, each with the reason
RAW_JSON = re.compile(r"\.dump\(\s*\d+\s*\)")  # ends in an exception for the name of a file that is not UTF-8
NAMED = re.compile(r"(?<![\w/.<*-])[A-Za-z_][\w/-]*\.(?:hpp|cpp|cmake|py|js)\b(?![\w(/.-]\w)")
EXAMPLES = ("tests/docs/", "tests/layout/")  # comments of these folders name sources that are not the project's
SCRIPTS = ("analyse", "bench*", "build", "check", "demo", "fuzz", "mutate", "reproduce-paper", "sbom", "setup")
MESSAGE = re.compile(r'"((?:[^"\\]|\\.)*)"')


def with_slashes(text, suffix):
    """The text with the comments of its language behind // on each line."""
    opening, closing = BLOCKS.get(suffix, (None, None))
    inside, lines = False, []
    for line in text.splitlines():
        if inside or (opening and opening in line):
            before, _, comment = ("", "", line) if inside else line.partition(opening)
            comment, end, _ = comment.partition(closing)
            inside = not end
            line = before + "// " + comment
        elif suffix in LINES:
            line = re.sub(r"(^|\s)" + LINES[suffix] + r"+(?=\s|$)", r"\1//", line, count=1)
        lines.append(line)
    return "\n".join(lines)


def passages(text):
    """Yields the line number and the text of each comment, lines below each other joined, and of each literal with a blank."""
    begin, block = 0, []
    for number, line in enumerate(text.splitlines() + [""], 1):
        found = COMMENT.match(line)
        whole = found and not found["code"].strip()
        if block and not whole:
            yield begin, " ".join(block)
            block = []
        if whole:
            begin = begin if block else number
            block.append(found["text"].strip())
            continue
        if found:
            yield number, found["text"].strip()
        for literal in MESSAGE.findall(found["code"] if found else line):
            if " " in literal:
                yield number, re.sub(r"\\[nrt]", " ", literal)


def library_functions(path, text):
    """Yields the line number and the complaint of each elementary function of the system's library."""
    if Path(path).parts[0] not in SAME_BITS or path in SYSTEM_BITS:
        return
    for number, line in enumerate(text.splitlines(), 1):
        for name in LIBRARY_FUNCTION.findall(COMMENT.sub(r"\g<code>", line)):
            yield number, f"std::{name} has other bits on other machines: use decid::{name} or sqrt (base/math/math.hpp)"


def raw_json(path, text):
    """Yields the line number and the complaint of each indented print of JSON that refuses text which is not UTF-8."""
    if path.startswith("tests/"):
        return
    for number, line in enumerate(text.splitlines(), 1):
        if RAW_JSON.search(COMMENT.sub(r"\g<code>", line)):
            yield number, "dump() throws for a file's name that is not UTF-8: use print_json() (base/files/json_object.hpp)"


def path_ends(sources):
    """The names by which a comment may call sources: nn/layers/conv.hpp, layers/conv.hpp, conv.hpp."""
    return {"/".join(parts[i:]) for parts in (source.split("/") for source in sources) for i in range(len(parts))}


def missing_files(text, ends):
    """Yields the line number and the complaint of each source that a comment names and that is not among path_ends()."""
    for number, line in enumerate(text.splitlines(), 1):
        comment = COMMENT.match(line)
        for name in NAMED.findall(comment["text"]) if comment else ():
            if name not in ends:
                yield number, f"there is no {name}"


def main(root):
    kinds = ["*.cpp", "*.hpp", "*.c", "*.h", "*.js", "*.py", "*.sh", "*.m", "*CMakeLists.txt", "*.cmake", "*.cmake.in",
             *(f"tools/{script}" for script in SCRIPTS), "examples/firmware/run"]
    files = subprocess.run(["git", "ls-files", *kinds], cwd=root, check=True, capture_output=True, text=True).stdout.split()
    found = [f"{path}:{number}: {complaint}" for path in files if (root / path).exists() and path not in OWN
             for number, passage in passages(with_slashes((root / path).read_text(), Path(path).suffix)) for complaint in complaints(passage)]
    found += [f"{path}:{number}: {complaint}" for path in files if (root / path).exists() and Path(path).suffix in (".cpp", ".hpp")
              for check in (library_functions, raw_json) for number, complaint in check(path, (root / path).read_text())]
    ends = path_ends(subprocess.run(["git", "ls-files"], cwd=root, check=True, capture_output=True, text=True).stdout.split())
    found += [f"{path}:{number}: {complaint}" for path in files if (root / path).exists() and not path.startswith(EXAMPLES)
              for number, complaint in missing_files(with_slashes((root / path).read_text(), Path(path).suffix), ends)]
    for complaint in found:
        print(complaint, file=sys.stderr)
    print(f"words: {len(found)} complaints")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]))
