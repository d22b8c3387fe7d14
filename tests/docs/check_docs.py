"""Checks README.md, CONTRIBUTING.md and docs/: relative links and headings exist, sources that pages name exist, pages keep
their shelf's limit of lines, the README leads to every page, no page has the words of words.py, docs/guide/warnings.md lists the
codes of the sources' warnings, each with its severity, docs/reference/errors.md the codes of errors, each of which is thrown, and
each SHA-256 of docs/develop/determinism.md stands in a source or a test. Usage: check_docs.py ROOT"""

import pathlib
import re
import sys
import urllib.parse

import words

README_LIMIT_BYTES = 9216
# Lines of a page, or of a shelf's pages; docs/research keeps dated records of any length.
LIMITS = {"README.md": 120, "docs/start/quickstart.md": 80, "docs/start/concepts.md": 120, "docs/develop/performance.md": 100,
          "docs/tutorials": 150, "docs/guide": 220, "docs/reference": 200, "docs/develop": 120}
GENERATED = "docs/reference/command-line.md"  # from help texts, which have a check of their own
SOURCE = re.compile(r"(?<![\w/.])(?:base|nn|sim|dataset|recording|posterior|identify|tools|bindings|tests|bench|cmake|examples|models)"
                    r"/[\w/.-]*\w\.(?:hpp|cpp|h|c|py|js|json|csv|cmake|txt|safetensors|ipynb)\b")
LINK = re.compile(r"\[[^\]\[]*\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)


def without_code(text):
    """Links in code are none. Indented lines are code only after a blank line; links stand in no such block here."""
    text = FENCE.sub("", text)
    text = re.sub(r"^ {4}.*$", "", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "`code`", text)


def anchors(text):
    """GitHub's anchors of a page's headings: lower case, punctuation dropped, blanks as hyphens."""
    found = set()
    for heading in re.findall(r"^#+ +(.+?) *#*$", FENCE.sub("", text), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        found.add(re.sub(r"[^\w\- ]", "", words).replace(" ", "-"))
    return found


def links_of(page):
    for target in LINK.findall(without_code(page.read_text(encoding="utf-8"))):
        if not re.match(r"[a-z][a-z0-9+.-]*:", target, re.IGNORECASE):
            path, _, anchor = urllib.parse.unquote(target).partition("#")
            yield target, (page.parent / path).resolve() if path else page, anchor


WARNING = re.compile(r'add_(info|caution|invalid)\(\s*[\w.]+,\s*"(\w+)"|\{Severity::(\w+), "(\w+)"')
VARIABLE = re.compile(r'\{severity, "(\w+)"')  # the severity is computed
EITHER = re.compile(r'add_warning\(\s*[\w.]+,\s*([^"]*?),\s*"(\w+)"')  # the severities are among its arguments
LISTED = re.compile(r"^\| `(\w+)` \| (info|caution|invalid)(?:, (info|caution|invalid))?(?:, (invalid))? \|", re.MULTILINE)


def limit_of(name):
    return LIMITS.get(name) or (LIMITS.get(name.rpartition("/")[0]) if name != GENERATED else None)


def prose_of(text):
    """A page's sentences: without code, tables' rules, links' targets and headings."""
    text = re.sub(r"\]\([^)]*\)", "]", without_code(text)).replace("[", "").replace("]", "")
    return "\n".join(re.sub(r"^\s*(\||[-*] |\d+\. |#+ )", "", line) for line in text.splitlines())


def problems_of_text(name, page, root):
    text = page.read_text(encoding="utf-8")
    limit, lines = limit_of(name), text.count("\n")
    if limit and lines > limit:
        yield f"{name}: {lines} lines, at most {limit}; move text to another page"
    if name == GENERATED or not (name.startswith("docs/") or name in ("README.md", "CONTRIBUTING.md")):
        return
    prose = prose_of(text)
    yield from (f"{name}: {complaint}" for complaint in words.complaints(prose) + words.figures(prose))
    # A folder may be an installed one (decid/sim/fft.hpp), an old one or made; only the project's own count.
    yield from (f"{name}: there is no {source}" for source in sorted(set(SOURCE.findall(FENCE.sub("", text))))
                if (root / source.partition("/")[0]).is_dir() and not (root / source).exists())


def warnings_of(root):
    """(code, severity) of each warning in sources, and of each that docs/guide/warnings.md lists."""
    given, computed = set(), set()
    for folder in ("dataset", "recording", "posterior", "identify"):
        for source in (root / folder).rglob("*.cpp"):
            text = source.read_text(encoding="utf-8")
            for severity, code, other_severity, other in WARNING.findall(text):
                given.add((code or other, severity or other_severity))
            for code in VARIABLE.findall(text):
                computed.add(code)
            for severities, code in EITHER.findall(text):
                given |= {(code, severity) for severity in re.findall(r"Severity::(\w+)", severities)}
    page = root / "docs/guide/warnings.md"
    listed = set()
    for code, *severities in LISTED.findall(page.read_text(encoding="utf-8")) if page.exists() else ():
        listed |= {(code, severity) for severity in severities if severity and (code not in computed or (code, severity) in given)}
    return given, listed


def errors_of(root):
    """The codes of errors: of base/error.hpp, named in base/error.cpp, used by sources, and listed in docs/reference/errors.md."""
    def text(name):
        return (root / name).read_text(encoding="utf-8") if (root / name).exists() else ""
    declared = re.findall(r"^  (\w+),$", text("base/error.hpp"), re.MULTILINE)
    named = re.findall(r'"(\w+)"', text("base/error.cpp").partition("names[]")[2].partition("};")[0])
    used = set()
    for folder in ("base", "nn", "sim", "dataset", "recording", "posterior", "identify", "tools", "bindings"):
        for source in (root / folder).rglob("*.?pp"):
            used |= set(re.findall(r"Code::(\w+)", source.read_text(encoding="utf-8")))
    listed = re.findall(r"^\| `(\w+)` \|", text("docs/reference/errors.md"), re.MULTILINE)
    return declared, named, used, listed


def problems_of_errors(root):
    declared, named, used, listed = errors_of(root)
    if declared != named:
        yield "base/error.cpp: the names are not those of Code, in its order"
    yield from (f"docs/reference/errors.md: the error {code} is not listed" for code in declared if code not in listed)
    yield from (f"docs/reference/errors.md: the error {code} does not exist" for code in listed if code not in declared)
    yield from (f"base/error.hpp: no source throws the error {code}" for code in declared if code not in used)


def problems_of_hashes(root):
    page = "docs/develop/determinism.md"
    hashes = set(re.findall(r"\b[0-9a-f]{64}\b", (root / page).read_text(encoding="utf-8"))) if (root / page).exists() else set()
    for folder in ("identify", "tests"):
        for path in (root / folder).rglob("*"):
            if hashes and path.suffix in (".cpp", ".json"):
                hashes -= set(re.findall(r"\b[0-9a-f]{64}\b", path.read_text(encoding="utf-8", errors="replace")))
    yield from (f"{page}: no source or test has the SHA-256 {value}" for value in sorted(hashes))


def check(root):
    problems = []
    readme = root / "README.md"
    docs = sorted((root / "docs").rglob("*.md"))
    pages = sorted(set(root.glob("*.md")) | set(docs))
    for page in pages:
        for target, path, anchor in links_of(page):
            if not path.exists() or not path.is_relative_to(root):
                problems.append(f"{page.relative_to(root)}: the link {target} leads nowhere")
            elif anchor and anchor not in anchors(path.read_text(encoding="utf-8")):
                problems.append(f"{page.relative_to(root)}: the link {target} names no heading of its page")
    reached, waiting = set(), [readme]
    while waiting:
        page = waiting.pop()
        if page not in reached:
            reached.add(page)
            waiting += [path for _, path, _ in links_of(page) if path.suffix == ".md" and path.is_file()]
    problems += [f"{page.relative_to(root)}: README.md does not lead to it" for page in docs if page not in reached]
    given, listed = warnings_of(root)
    problems += [f"docs/guide/warnings.md: the warning {code} ({severity}) is not listed"
                 for code, severity in sorted(given - listed)]
    problems += [f"docs/guide/warnings.md: no source gives the warning {code} ({severity})"
                 for code, severity in sorted(listed - given)]
    problems += problems_of_errors(root)
    problems += problems_of_hashes(root)
    for page in pages:
        problems += problems_of_text(page.relative_to(root).as_posix(), page, root)
    size = readme.stat().st_size
    if size > README_LIMIT_BYTES:
        problems.append(f"README.md: {size} bytes, at most {README_LIMIT_BYTES}; move text to docs/")
    return problems, len(pages)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    problems, pages = check(pathlib.Path(sys.argv[1]).resolve())
    for problem in problems:
        print(problem, file=sys.stderr)
    if problems:
        sys.exit(1)
    print(f"{pages} pages: links, reach, lengths, words, warnings and errors are right")


if __name__ == "__main__":
    main()
