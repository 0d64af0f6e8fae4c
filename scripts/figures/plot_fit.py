#!/usr/bin/env python3
"""Draw both slices of a fit, measured and fitted, per channel, from its result JSON (the program's or the reference's).

    plot_fit.py RESULT.json [-o PICTURE.png]

A starting point for your own pictures: all that is drawn stands under "slices" (angles in radians, f in 1/sr; see
docs/formats.md). The upper row is the theta_h slice (theta_d = 0), the lower one the theta_d slice (theta_h = 0); the
relative difference is drawn below each, where both curves are positive. Grey: rows beyond the cut-off, not fitted.
"""
import argparse
import json
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

COLOURS = {"R": "tab:red", "G": "tab:green", "B": "tab:blue"}
TITLES = {"theta_h": "theta_h slice", "theta_d": "theta_d slice"}


def curve(values):
    """A JSON list with nulls as an array with NaN."""
    return np.array([np.nan if v is None else v for v in values], dtype=float)


def positive(values):
    """What a logarithmic axis can show."""
    return np.where(values > 0, values, np.nan)


def draw_slice(upper, lower, degrees, measured, fitted, colour, cutoff):
    upper.semilogy(degrees, positive(measured), ".", color=colour, markersize=4, label="measured")
    upper.semilogy(degrees, positive(fitted), "-", color="black", linewidth=1, label="fitted")
    lower.plot(degrees, 100 * (positive(fitted) / positive(measured) - 1), color=colour, linewidth=1)
    lower.axhline(0, color="black", linewidth=0.5)
    lower.set_ylim(-100, 100)
    lower.set_ylabel("difference, %")
    for axes in (upper, lower):
        axes.set_xlim(0, 90)
        if cutoff is not None:
            axes.axvspan(cutoff, 90, color="0.92", zorder=0)


def draw(document):
    """The figure of one result document."""
    channels = [channel["name"] for channel in document["channels"]]
    figure, axes = plt.subplots(4, len(channels), figsize=(4 * len(channels), 9), height_ratios=(3, 1, 3, 1), squeeze=False)
    slices, options = document["slices"], document.get("options", {})
    for row, axis in enumerate(("theta_h", "theta_d")):
        degrees = np.degrees(np.array(slices[axis]))
        for column, name in enumerate(channels):
            upper, lower = axes[2 * row][column], axes[2 * row + 1][column]
            measured, fitted = (curve(slices[kind][axis][column]) for kind in ("measured", "fitted"))
            draw_slice(upper, lower, degrees, measured, fitted, COLOURS.get(name, "tab:gray"), options.get(f"cutoff_{axis}_degrees", options.get(f"cutoff_{axis}")))
            upper.set_title(f"{name}: {TITLES[axis]}", fontsize=10)
            upper.set_ylabel("f, 1/sr")
            lower.set_xlabel(f"{axis}, degrees")
    axes[0][0].legend(fontsize=8)
    figure.suptitle(f"{document['input']['name']}, {document.get('model', '')}")
    figure.tight_layout()
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("result", type=Path, metavar="RESULT.json")
    parser.add_argument("-o", "--output", type=Path, metavar="PICTURE.png", help="default: RESULT.png beside the input")
    args = parser.parse_args()
    output = args.output or args.result.with_suffix(".png")
    draw(json.loads(args.result.read_text(encoding="utf-8"))).savefig(output, dpi=110)
    print(f"wrote {output}")


if __name__ == "__main__":
    main()
