"""Holds README.md and docs/ to what readers rely on: relative links lead somewhere, headings that are linked to exist,
the README is short, it leads to every page of docs/, and the codes of
warnings that sources give are those that docs/recordings.md lists, each with its severity. Usage: check_docs.py ROOT"""

import pathlib
import re
import sys
import urllib.parse

README_LIMIT_BYTES = 9216
LINK = re.compile(r"\[[^\]\[]*\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
FENCE = re.compile(r"^(```|~~~).*?^\1", re.MULTILINE | re.DOTALL)


def without_code(text):
    """Links in code are none. Indented lines are code only after a blank line; links stand in no such block here."""
    text = FENCE.sub("", text)
    text = re.sub(r"^ {4}.*$", "", text, flags=re.MULTILINE)
    return re.sub(r"`[^`\n]*`", "`code`", text)


def anchors(text):
    """What GitHub calls a page's headings: lower case, punctuation dropped, blanks as hyphens."""
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
LISTED = re.compile(r"^\| `(\w+)` \| (info|caution|invalid)(?:, (info|caution|invalid))? \|", re.MULTILINE)


def warnings_of(root):
    """(code, severity) of each warning in sources, and of each that docs/recordings.md lists."""
    given = set()
    for folder in ("dataset", "identify"):
        for source in (root / folder).rglob("*.cpp"):
            for severity, code, other_severity, other in WARNING.findall(source.read_text(encoding="utf-8")):
                given.add((code or other, severity or other_severity))
    page = root / "docs/recordings.md"
    listed = set()
    for code, *severities in LISTED.findall(page.read_text(encoding="utf-8")) if page.exists() else ():
        listed |= {(code, severity) for severity in severities if severity}
    return given, listed


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
    problems += [f"docs/recordings.md: the warning {code} ({severity}) is not listed"
                 for code, severity in sorted(given - listed)]
    problems += [f"docs/recordings.md: no source gives the warning {code} ({severity})"
                 for code, severity in sorted(listed - given)]
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
    print(f"{pages} pages: links, reach and length are right")


if __name__ == "__main__":
    main()
