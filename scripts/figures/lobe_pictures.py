#!/usr/bin/env python3
"""Draw lobes beside their local bandwidth: the picture of scripts/figures/atlas_pictures.sh.

    lobe_pictures.py VALUES.f32 PICTURE.png NAME...      VALUES.f32: by the example lobe_pictures, for materials in this order
"""
import argparse
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator

ANGLES = (40, 75)
LOBE, MAP = 256, 64
RANGE = (0.5, 128)
"""Cycles per radian from dark to bright, for all materials."""
INK = "0.25"


def read(path, count):
    """For each material and angle: the lobe and its bandwidth."""
    values = np.fromfile(path, "<f4").reshape(count, len(ANGLES), LOBE**2 + MAP**2)
    return values[..., : LOBE**2].reshape(count, -1, LOBE, LOBE), values[..., LOBE**2 :].reshape(count, -1, MAP, MAP)


def draw(axes, image, degrees, norm, colours):
    """An angular map with its circles at 30 and 60 degrees, the mirror direction (ring) and the light (dot)."""
    rim = plt.Circle((0, 0), 1, transform=axes.transData)
    shown = axes.imshow(image, extent=(-1, 1, 1, -1), norm=norm, cmap=colours, interpolation="nearest", clip_path=rim)
    shown.set_clip_path(rim)
    for theta in (30, 60):
        axes.add_patch(plt.Circle((0, 0), theta / 90, fill=False, color="white", alpha=0.35, linewidth=0.6))
    axes.plot(-degrees / 90, 0, "o", markersize=11, markerfacecolor="none", markeredgecolor="white", markeredgewidth=0.8)
    axes.plot(degrees / 90, 0, "o", markersize=4.5, color="white", markeredgecolor=INK, markeredgewidth=0.6)
    axes.add_patch(plt.Circle((0, 0), 1, fill=False, color=INK, linewidth=0.8))
    axes.set(xlim=(-1.02, 1.02), ylim=(1.02, -1.02))
    axes.axis("off")
    return shown


def bar(figure, shown, axes, label, base):
    colour_bar = figure.colorbar(shown, cax=axes, ticks=LogLocator(base, numticks=12), format="%g")
    colour_bar.minorticks_off()
    colour_bar.outline.set_visible(False)
    colour_bar.ax.tick_params(labelsize=8, colors=INK)
    colour_bar.set_label(label, fontsize=9, color=INK)


def picture(names, lobes, maps):
    rows = len(names)
    figure = plt.figure(figsize=(11.4, 0.5 + 2.45 * rows), facecolor="white")
    grid = figure.add_gridspec(rows, 7, width_ratios=(1, 1, 0.05, 0.33, 1, 1, 0.05), left=0.045, right=0.94, bottom=0.055,
                               top=0.955, wspace=0.07, hspace=0.1)
    band_colours = plt.get_cmap("viridis").copy()
    band_colours.set_bad("0.8")
    for row, name in enumerate(names):
        norm = LogNorm(lobes[row].min() / 3, lobes[row].max())
        for k, degrees in enumerate(ANGLES):
            axes = figure.add_subplot(grid[row, k])
            lobe = draw(axes, lobes[row, k], degrees, norm, "magma")
            beside = figure.add_subplot(grid[row, 4 + k])
            band = draw(beside, np.ma.masked_equal(maps[row, k], 0), degrees, LogNorm(*RANGE), band_colours)
            if row == 0:
                axes.set_title(f"lobe, light at {degrees}°", fontsize=10, color=INK)
                beside.set_title(f"bandwidth, light at {degrees}°", fontsize=10, color=INK)
            if k == 0:
                axes.text(-1.1, 0, name, rotation=90, ha="right", va="center", fontsize=10, color=INK)
        bar(figure, lobe, figure.add_subplot(grid[row, 2]), "f, 1/sr", 10)
    bar(figure, band, figure.add_subplot(grid[:, 6]), "cycles per radian", 2)
    legend = "Ring: mirror direction. Dot: light. Circles: 30° and 60° from the normal. Grey: no bandwidth. Green channel."
    figure.text(0.49, 0.016, legend, ha="center", fontsize=8.5, color=INK)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("values", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("names", nargs="+")
    args = parser.parse_args()
    made = picture(args.names, *read(args.values, len(args.names)))
    made.savefig(args.picture, dpi=100, metadata={"Software": None})


if __name__ == "__main__":
    main()
