#!/usr/bin/env python3
"""Shading time against samples, and pixels shaded per level, on the eight pairs: scripts/bench/render_linear.sh runs it.

    render_linear.py BRDFIT MATERIALS WORK [--pairs NAME...] [--repeat 5]

Shading time (milliseconds.shading, median, two threads) over budgets of 1 to 64 samples per pixel against the samples that
were taken: straight line and R^2. Prints Markdown; ends with 7 where an R^2 is below the bar.
"""
import argparse
import sys
from pathlib import Path

import numpy as np
from scipy.stats import linregress

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

from brdfit_reference.pairs import add_arguments, pairs

BUDGETS = (1, 2, 4, 8, 16, 32, 64)
SHOWN_BUDGET = 4
BAR = 0.99


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    parser.add_argument("--repeat", type=int, default=5)
    args = parser.parse_args()
    images = {pair.name: [pair.render("--spp", budget, "--repeat", args.repeat).stats for budget in BUDGETS]
              for pair in pairs(args)}
    print(f"Milliseconds of shading (samples per pixel that were taken) at a budget, median of {args.repeat}, and the straight line.\n")
    print("| pair | " + " | ".join(map(str, BUDGETS)) + " | ns per sample | ms at no sample | R² |")
    print("|---|" + "---:|" * (len(BUDGETS) + 3))
    worst = 1.0
    for name, runs in images.items():
        samples = np.array([run["samples"]["shading"] for run in runs])
        times = np.array([run["milliseconds"]["shading"] for run in runs])
        line = linregress(samples, times)
        worst = min(worst, line.rvalue**2)
        cells = [f"{time:.1f} ({run['samples']['shading'] / run['foreground']:.2f})" for time, run in zip(times, runs)]
        print(f"| {name} | {' | '.join(cells)} | {1e6 * line.slope:.1f} | {line.intercept:.1f} | {line.rvalue**2:.4f} |")
    print(f"\nShading points per level at a budget of {SHOWN_BUDGET}: cells of 1, 2, 4, .. 32 pixels along a side.\n")
    print("| pair | foreground | 0 | 1 | 2 | 3 | 4 | 5 | points, % of the pixels |\n|---|" + "---:|" * 8)
    for name, runs in images.items():
        run = runs[BUDGETS.index(SHOWN_BUDGET)]
        points = run["shaded_per_level"]
        share = 100 * sum(points) / run["foreground"]
        print(f"| {name} | {run['foreground']} | {' | '.join(map(str, points))} | {share:.1f} |")
    sys.exit(0 if worst > BAR else 7)


if __name__ == "__main__":
    main()
