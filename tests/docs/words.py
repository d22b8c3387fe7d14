"""The words and openings that the project's English avoids (CONTRIBUTING.md), for documents, comments, help and messages."""

import re

# What to write instead stands beside each.
WORDS = {
    "anew": "again", "mended": "fixed", "dear": "expensive", "dearer": "more expensive", "dearest": "most expensive",
    "besides": "also", "likewise": "in the same way, also", "told": "given, reported", "somebody": "you, or name the actor",
    "so many": "this many, the number of", "in place of": "instead of", "held by": "verified by", "ladder": "dependency layers",
    "fresh trial": "new trial", "fresh trials": "test trials, or trials that are simulated during training",
}
OPENINGS = {"Of": "put the subject first", "Beside": "name the subject, then 'also'", "Besides": "name the subject, then 'also'",
            "What": "name the subject", "Whether": "name the subject", "That": "repeat the noun", "Those": "repeat the noun"}
WORD = re.compile(r"\b(" + "|".join(word.replace(" ", r"\s+") for word in sorted(WORDS, key=len, reverse=True)) + r")\b", re.IGNORECASE)
OPENING = re.compile(r"(?:^|(?<=[.:;!?])\s+)[*_>\-\s]*(" + "|".join(OPENINGS) + r")\b(?=\s+[\w`])([^.?!]*[.?!]?)", re.MULTILINE)
FIGURES = (
    (re.compile(r"\d %"), "no blank before %"),
    (re.compile(r"\d degrees?\b(?! per)"), "write ° for degrees beside a figure"),
    (re.compile(r"\d us\b"), "write µs"),
)


def complaints(text):
    """One line for each banned word, and for each sentence that begins with a banned opening. Questions may open with any word."""
    found = ["'" + " ".join(m.group(0).split()) + "': write " + WORDS[" ".join(m.group(0).lower().split())]
             for m in WORD.finditer(text)]
    for m in OPENING.finditer(text):
        if not m.group(2).endswith("?"):
            found.append("sentence opens with '" + m.group(1) + "': " + OPENINGS[m.group(1)] + " ('" +
                         " ".join((m.group(1) + m.group(2)).split()[:6]) + "')")
    return found


def figures(text):
    """One line for each figure that is not written as in the documents: 90%, 0.02°, 110 µs."""
    return [f"'{text[max(0, m.start() - 8):m.end()].strip()}': {rule}" for pattern, rule in FIGURES for m in pattern.finditer(text)]
