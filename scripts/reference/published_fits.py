#!/usr/bin/env python3
"""Write the published parameters of materials as documents that `brdfit atlas` and reference_atlas.py read.

    published_fits.py DIR [NAME...]      DIR/NAME.json; all 100 without names
"""
import json
import sys
from pathlib import Path

from brdfit_reference.merl import data_folder
from reference_atlas import published_channels


def main():
    folder, *names = sys.argv[1:] or sys.exit(__doc__)
    table = json.loads((data_folder(None) / "tables" / "sgd_published.json").read_text(encoding="utf-8"))
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name in names or table:
        channels = [{"parameters": parameters} for parameters in published_channels(table[name])]
        Path(folder, f"{name}.json").write_text(json.dumps({"channels": channels}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
