"""Compiles the examples of docs/reference/c.md and cpp.md, without running them, and finds functions of libdecid and components
of C++ that no example uses. Usage: examples.py ROOT CC CXX

The blocks ```c and ```cpp of a page become one function. A block stands in the scope of the blocks before it, so it may use their
variables and declare the same names again. Lines with #include, and functions that begin with `static`, stand before it."""

import pathlib
import re
import subprocess
import sys
import tempfile

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
OUTSIDE = re.compile(r"^#include [^\n]*\n|^static [^;\n]*{\n.*?^}\n", re.MULTILINE | re.DOTALL)
COMPONENT = re.compile(r"^decid_component\((\w+)", re.MULTILINE)
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wno-unused", "-fopenmp"]


def blocks_of(page, language):
    return [body for kind, body in BLOCK.findall(page) if kind == language]


def unit_of(blocks):
    """The blocks as one source file."""
    outside = [part for block in blocks for part in OUTSIDE.findall(block)]
    includes = [part for part in outside if part.startswith("#")]
    functions = [part for part in outside if not part.startswith("#")]
    body = "{\n".join(OUTSIDE.sub("", block) for block in blocks)
    return "".join(includes + functions) + "void page(void);\nvoid page(void) {\n" + body + "}" * len(blocks) + "\n"


def uncalled(functions, blocks):
    code = re.sub(r"/\*.*?\*/", "", "\n".join(blocks), flags=re.DOTALL)
    return [name for name in functions if not re.search(rf"\b{name}\(", code)]


def compile_problem(blocks, compiler, ending, folder, standard, include):
    """Returns the compiler's complaints of the blocks; empty if they are right. include: the folder of <decid/..>."""
    with tempfile.TemporaryDirectory() as made:
        pathlib.Path(made, "decid").symlink_to(include)
        source = pathlib.Path(made, "page" + ending)
        source.write_text(unit_of(blocks), encoding="utf-8")
        done = subprocess.run([compiler, f"-std={standard}", *WARNINGS, "-fsyntax-only", "-I", made, "-I", str(folder), str(source)],
                              check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8")
    return done.stdout if done.returncode else ""


def check(root, cc, cxx):
    symbols = (root / "tests/bindings/c/symbols.txt").read_text(encoding="utf-8")
    c = blocks_of((root / "docs/reference/c.md").read_text(encoding="utf-8"), "c")
    cpp_page = (root / "docs/reference/cpp.md").read_text(encoding="utf-8")
    cpp = blocks_of(cpp_page, "cpp")
    problems = [f"docs/reference/c.md: no example calls {name}" for name in uncalled(re.findall(r"^\w+", symbols, re.MULTILINE), c)]
    for name in COMPONENT.findall((root / "CMakeLists.txt").read_text(encoding="utf-8")):
        if not re.search(rf"^#+ .*`{name}`.*\n(?:(?!#+ ).*\n)*?```cpp$", cpp_page, re.MULTILINE):
            problems.append(f"docs/reference/cpp.md: no heading with an example names the component {name}")
    problems += filter(None, [compile_problem(c, cc, ".c", root, "c99", root / "bindings/c"),
                              compile_problem(cpp, cxx, ".cpp", root, "c++20", root)])
    return problems, len(c) + len(cpp)


def main():
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    problems, examples = check(pathlib.Path(sys.argv[1]).resolve(), *sys.argv[2:])
    if problems:
        sys.exit("\n".join(problems))
    print(f"{examples} examples compile and use every function of C and every component of C++")


if __name__ == "__main__":
    main()
