#!/usr/bin/env python3
"""Times of `brdfit atlas`, whole processes with two threads: the table of atlases in docs/performance.md.

    performance_atlas.py BRDFIT FITS MEASURED      folders of documents and of MERL files (performance_atlas.sh makes them)
"""
import os
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

from performance import run, stolen

RUNS = 5
SINGLE = ("pink-felt", "gold-metallic-paint", "nickel", "chrome")
MEASURED = ("paper_white", "satin_rosaline", "chm_mint")


def main():
    program, fits, measured = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    inputs = {f"{name}, published parameters": [fits / f"{name}.json"] for name in SINGLE}
    inputs |= {f"{name}, measured": [measured / f"{name}.binary", "--sample-position", "centre"] for name in MEASURED}
    rows = {name: [] for name in inputs}
    before, start = stolen(), time.perf_counter()
    with tempfile.TemporaryDirectory() as work:
        command = [program, "atlas", "--quiet", "--threads", "2", "-o", work]
        for _ in range(RUNS):
            for name, arguments in inputs.items():
                rows[name].append(run([*command, *map(str, arguments)]))
        batch = run([*command, str(fits)])
    print(f"Whole processes, two threads, files in the page cache, medians of {RUNS} runs (the batch: one run):\n")
    print("| atlas (KTX2, OpenEXR, sidecar) | wall s | CPU s | peak MB |\n|---|---|---|---|")
    for name, results in rows.items():
        wall, cpu, peak = (median(column) for column in zip(*results))
        print(f"| {name} | {wall:.2f} | {cpu:.2f} | {peak:.0f} |")
    wall, cpu, peak = batch
    print(f"| the {len(list(fits.glob('*.json')))} published materials | {wall:.1f} | {cpu:.1f} | {peak:.0f} |")
    if before is not None:
        share = (stolen() - before) / (time.perf_counter() - start) / os.cpu_count()
        print(f"\nProcessor time taken by others meanwhile: {100 * share:.0f} %.")


if __name__ == "__main__":
    main()
