#!/usr/bin/env python3
"""Check that every path of the repository that a document names is there.

    document_paths.py         reads all tracked .md files; prints what is missing and exits with 1

A path is what begins with the name of a top-level folder, in backquotes, in a command or in a link; `*` stands for any name.
"""
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = "src|scripts|tests|docs|data-fixtures|\\.ci"
PATH = re.compile(rf"(?<![\w./-])(?:{FOLDERS})/[\w./*-]*[\w*/]")


def main():
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    missing = []
    for document in listed:
        for number, line in enumerate((ROOT / document).read_text(encoding="utf-8").splitlines(), 1):
            missing += [f"{document}:{number}: {path}" for path in PATH.findall(line) if not any(ROOT.glob(path.rstrip("/")))]
    print("\n".join(missing) if missing else f"{len(listed)} documents name nothing that is not there")
    sys.exit(bool(missing))


if __name__ == "__main__":
    main()
