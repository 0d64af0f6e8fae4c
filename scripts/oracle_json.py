"""Writing of oracle fixtures: one compact JSON object per file, one row per line, so that diffs stay readable.

Numbers are rounded once, from an mpmath value to the nearest double, and printed with `repr` (the shortest decimal that
reads back as the same double). Inputs of every row are exact doubles: the stored value belongs to the stored input.
"""
import json
import math
from pathlib import Path

FIXTURES = Path(__file__).resolve().parent.parent / "data-fixtures"


def write_fixture(name, header, tables):
    """Write data-fixtures/<name>: the `header` items, then each table (a list of rows) under its key, one row per line."""
    parts = [f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in header.items()]
    for key, rows in tables.items():
        lines = ",\n".join(json.dumps(row, separators=(",", ":"), allow_nan=False) for row in rows)
        parts.append(f"{json.dumps(key)}: [\n{lines}\n]")
    path = FIXTURES / name
    path.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")
    print(f"wrote {path.name}: {path.stat().st_size} bytes, " + ", ".join(f"{len(r)} {k}" for k, r in tables.items()))


def nearest_double(value):
    """The double nearest to an mpmath value; refuses results that leave the normal range of doubles."""
    result = float(value)
    if not math.isfinite(result) or (result != 0.0 and abs(result) < 1e-300):
        raise ValueError(f"{value} is no normal double")
    return result
