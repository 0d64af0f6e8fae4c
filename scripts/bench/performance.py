#!/usr/bin/env python3
"""Times of brdfit on 100 materials and against the scipy reference: the tables of docs/performance.md.

    performance.py BRDFIT FOLDER [--runs 5]      FOLDER: the MERL files (scripts/bench/performance.sh makes them)

Every figure is the median of the runs, all variants in turn within each run. CPU seconds are the operating system's count for
the process; wall seconds on a shared machine also contain what it takes for others ("stolen" below, from /proc/stat).
"""
import argparse
import hashlib
import os
import resource
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median

VARIANTS = {
    "slices and fits (`--no-panel --no-hash`)": ["--no-panel", "--no-hash"],
    "with hashes and documents (`--no-panel`)": ["--no-panel"],
    "with the error panel on all cells": [],
}
BATCH = 12
"""Materials on which scipy is timed."""


def stolen():
    """Seconds of processor time taken by others so far, over all processors; None where the system does not tell."""
    try:
        return int(Path("/proc/stat").read_text().split("\n", 1)[0].split()[8]) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return None


def run(command):
    """(wall seconds, CPU seconds, peak MB) of a command."""
    start = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - start
    if os.waitstatus_to_exitcode(status) != 0:
        sys.exit(f"{command} failed")
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def hash_all(files):
    """Wall seconds of reading the files and hashing them with OpenSSL on two threads: a scale for what hashing costs."""
    start = time.perf_counter()
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda file: hashlib.sha256(file.read_bytes()).digest(), files))
    return time.perf_counter() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("brdfit")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    files = sorted(arguments.folder.glob("*.binary"))
    hash_all(files)  # into the page cache
    results = {name: [] for name in VARIANTS}
    hashing = []
    with tempfile.TemporaryDirectory() as work:
        before, start = stolen(), time.perf_counter()
        for _ in range(arguments.runs):
            for name, options in VARIANTS.items():
                results[name].append(run([arguments.brdfit, "fit", str(arguments.folder), "-o", f"{work}/fits", "--quiet",
                                          "--threads", "2", *options]))
            hashing.append(hash_all(files))
        lost = stolen() - before if before is not None else None
        elapsed = time.perf_counter() - start
        some = [str(file) for file in files[:: max(1, len(files) // BATCH)]][:BATCH]
        scipy, ours = [], []
        script = Path(__file__).resolve().parents[1] / "reference" / "reference_fit.py"
        for n in range(3):
            output = subprocess.run([sys.executable, script, *some, "-o", f"{work}/scipy{n}", "--slices-only", "--timing"],
                                    check=True, capture_output=True, text=True)
            scipy.append(fit_seconds(output.stdout + output.stderr))
            ours.append(run([arguments.brdfit, "fit", *some, "-o", f"{work}/ours{n}", "--quiet", "--threads", "1", "--no-panel",
                             "--no-hash"])[1])
    print(f"{len(files)} materials, two threads, files in the page cache, medians of {arguments.runs} runs:\n")
    print("| what | wall s | CPU s | peak MB |\n|---|---|---|---|")
    for name, rows in results.items():
        wall, cpu, peak = (median(column) for column in zip(*rows))
        print(f"| {name} | {wall:.2f} | {cpu:.2f} | {peak:.0f} |")
    print(f"| for comparison: reading and hashing the same files, nothing else (Python, OpenSSL, two threads) | {median(hashing):.2f} | | |")
    if lost is not None:
        print(f"\nProcessor time taken by others meanwhile: {100 * lost / elapsed / os.cpu_count():.0f} %.")
    print(f"\nscipy `least_squares` (trf) on the same slices of {len(some)} materials, one process: {median(scipy):.2f} s in its fits; "
          f"brdfit with one thread: {median(ours):.3f} CPU s for the whole program, reading and writing included; "
          f"ratio {median(a / b for a, b in zip(scipy, ours)):.0f}.")


def fit_seconds(text):
    """The seconds of the fits alone from reference_fit.py --timing."""
    total = next(line for line in text.splitlines() if line.startswith("total:"))
    return float(total.split("fits")[1].split()[0])


if __name__ == "__main__":
    main()
