#!/usr/bin/env python3
"""Check the documents: every path of the repository that they name is there, and their prose is wrapped at 100 columns.

    documents.py [FILE.md...]            all tracked .md files without names; exits with 1 where something is wrong
    documents.py --fill [FILE.md...]     wraps the prose: paragraphs and list items; code, tables, headings and images stay

A path is what begins with the name of a top-level folder, in backquotes, in a command or in a link; `*` stands for any name.
"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = 100
PATH = re.compile(r"(?<![\w./-])(?:src|scripts|tests|docs|data-fixtures|\.ci)/[\w./*-]*[\w*/]")
ITEM = re.compile(r"(\s*)([-*]|\d+\.)\s+(.*)")
FIXED = re.compile(r"\s*(\||#|!\[)|    ")
"""Lines that are no prose: tables, headings, images, code by indentation."""
MARKUP = re.compile(r"([-+*>|]|\d+[.)]|#+)(\s|$)")
"""What would be read as something else at the head of a line."""
UNBROKEN = re.compile(r"`[^`]{,60}`")
"""Inline code that is kept on one line."""


def filled(text, first, rest):
    """The lines of a paragraph; `first` and `rest` are put in front of the first line and of the others."""
    text = UNBROKEN.sub(lambda code: code[0].replace(" ", "\x01"), " ".join(text.split()))
    words, lines, line = text.split(" "), [], []
    for word, following in zip(words, [*words[1:], ""]):
        length = len((rest if lines else first) + " ".join([*line, word]))
        # a line must not begin with the following word: it takes this one along
        taken_along = MARKUP.match(following) and length + 1 + len(following) > COLUMNS
        if line and (length > COLUMNS or taken_along):
            lines.append(line)
            line = []
        line.append(word)
    prefixes = [first, *[rest] * len(lines)]
    return [(prefix + " ".join(line)).replace("\x01", " ") for prefix, line in zip(prefixes, [*lines, line])]


def blocks(text):
    """(lines, first, rest) of each paragraph or item, with `first` None for lines that stay."""
    paragraph, prefix, fenced = [], ("", ""), False
    for line in text.split("\n"):
        fence = line.startswith("```")
        item = None if fenced else ITEM.match(line)
        fixed = fence or fenced or not line.strip() or FIXED.match(line) and not (item or prefix[0] and paragraph)
        if paragraph and (fixed or item):
            yield paragraph, *prefix
            paragraph, prefix = [], ("", "")
        fenced ^= fence
        if fixed:
            yield [line], None, None
        elif item:
            head = f"{item[1]}{item[2]} "
            paragraph, prefix = [item[3]], (head, " " * len(head))
        else:
            paragraph.append(line)
    if paragraph:
        yield paragraph, *prefix


def fill(text):
    """A document with its prose wrapped."""
    lines = []
    for block, first, rest in blocks(text):
        lines += block if first is None else filled(" ".join(block), first, rest)
    return "\n".join(lines)


def faults(name, text):
    """What is wrong with a document, one line each."""
    for number, line in enumerate(text.splitlines(), 1):
        yield from (f"{name}:{number}: no {path}" for path in PATH.findall(line) if not any(ROOT.glob(path.rstrip("/"))))
    at, lines = 0, text.split("\n")
    for block, first, _ in blocks(text):
        if first is not None and any(len(line) > COLUMNS for line in lines[at : at + len(block)]):
            yield f"{name}:{at + 1}: more than {COLUMNS} columns; documents.py --fill wraps them"
        at += len(block)


def main():
    mend, *names = sys.argv[1:] if sys.argv[1:2] == ["--fill"] else ["", *sys.argv[1:]]
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    documents = [Path(name) for name in names] or [ROOT / name for name in listed]
    found = []
    for document in documents:
        text = document.read_text(encoding="utf-8")
        if mend and fill(text) != text:
            document.write_text(fill(text), encoding="utf-8")
            print(f"wrapped {document}")
        elif not mend:
            found += faults(document, text)
    print("\n".join(found) if found else f"{len(documents)} documents")
    sys.exit(bool(found))


if __name__ == "__main__":
    main()
