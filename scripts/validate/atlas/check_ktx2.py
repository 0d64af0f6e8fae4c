#!/usr/bin/env python3
"""Compare what ktx2.py reads from an atlas with what ktx-parse reads: every byte of every level, the format, all key/values.

    check_ktx2.py FILE.ktx2 FOLDER        FOLDER: what read_atlas_ktx2.mjs wrote

Prints one line per level; exits with 1 where the two differ or a level is not the maximum over 2 x 2 texels of the one before.
"""
import json
import sys
from pathlib import Path

import numpy as np

import ktx2


def main():
    path, folder = Path(sys.argv[1]), Path(sys.argv[2])
    levels, key_values = ktx2.read(path)
    theirs = json.loads((folder / "ktx2.json").read_text(encoding="utf-8"))
    channels = levels[0].shape[2]
    ours = {
        "format": {1: 76, 4: 97}[channels],
        "size": [1024, 1024],
        "levels": 7,
        "compression": 0,
        "transfer": 1,  # linear
        "bits": [16] * channels,
        "keyValues": key_values,
    }
    problems = [f"{key}: {theirs.get(key)} instead of {value}" for key, value in ours.items() if theirs.get(key) != value]
    if key_values.get("KTXorientation") != "rd":
        problems.append("KTXorientation is not rd")
    for k, level in enumerate(levels):
        if level.tobytes() != (folder / f"level{k}.raw").read_bytes():
            problems.append(f"level {k} differs")
        if k > 0 and not np.array_equal(levels[k - 1].reshape(len(level), 2, len(level), 2, -1).max(axis=(1, 3)), level):
            problems.append(f"level {k} is not the maximum of level {k - 1}")
        if not problems:
            print(
                f"{path} level {k}: {level.shape[1]} x {level.shape[0]}, {channels} x {level.dtype}, "
                f"{level.min():g} to {level.max():g}: ktx-parse = ktx2.py"
                + ("" if k == 0 else f", maximum of level {k - 1}")
            )
    for problem in problems:
        print(f"{path}: {problem}", file=sys.stderr)
    return int(bool(problems))


if __name__ == "__main__":
    sys.exit(main())
