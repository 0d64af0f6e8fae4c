#!/usr/bin/env python3
"""Draw what was predicted beside what was needed: the pictures of scripts/bench/render_predictions.sh.

    prediction_pictures.py BRDFIT MATERIALS WORK IMAGES [--pairs NAME...] [--spp 4096] [--frames 256]

Writes IMAGES/predicted_bandwidth.png, predicted_variance.png and predicted_levels.png, one row per pair.
"""
import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import BoundaryNorm, LogNorm

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

from brdfit_reference.images import exposure, srgb
from brdfit_reference.pairs import add_arguments, pairs
from brdfit_reference.prediction import noise_of, predicted_level, required_level, shaded_luminance, windowed_bandwidth

SHOWN = ("sphere-red-metallic-paint", "knot-nickel", "bumpy-sphere-gold-metallic-paint", "three-on-a-floor")
BUDGET = 4
STEP = 2
"""The windowed transform is taken at every second pixel."""
INK = "0.25"
INCHES = 2.3


@dataclass(frozen=True)
class Maps:
    """Images [row, column] of one pair; NaN where there is nothing to show."""

    name: str
    image: np.ndarray
    bandwidth: tuple
    variance: tuple
    level: tuple

    @classmethod
    def of(cls, pair, spp, frames):
        reference = pair.reference(spp)
        shaded, factor = shaded_luminance(reference)
        shown, material = reference.foreground, reference.layers.scalar("material.Y")
        ours = pair.render("--spp", BUDGET, layers="gbuffer,pilot,bandwidth,list").layers

        def masked(values, mask=shown):
            return np.where(mask, values, np.nan)

        rows, columns = np.nonzero(shown[::STEP, ::STEP])
        windowed = np.full(shown[::STEP, ::STEP].shape, np.nan)
        windowed[rows, columns] = windowed_bandwidth(shaded, noise_of(reference, factor), (STEP * rows, STEP * columns))
        bandwidth = masked(ours.scalar("bandwidth.Y")), windowed
        variance = (masked(factor**2 * ours.scalar("pilot.VARIANCE")),
                    masked(2 * factor**2 * pair.single_samples(frames).scalar("variance.Y")))
        level = (masked(ours.scalar("list.LEVEL"), shown & (ours.scalar("list.LEVEL") >= 0)),
                 masked(np.floor(predicted_level(bandwidth[0]))), masked(np.floor(required_level(shaded, material, noise_of(reference, factor)))))
        exposed = exposure(reference.radiance, shown) * reference.radiance
        return cls(pair.name, np.where(shown[..., None], srgb(exposed), 1.0), bandwidth, variance, level)


def sheet(maps, titles, what, norm, colours, label, legend, ticks=None):
    """A figure: the image and the maps of a quantity, a row per pair, one colour bar for all."""
    count, columns = len(maps), 1 + len(titles)
    width, height = INCHES * columns + 1.2, INCHES * count + 0.75
    figure = plt.figure(figsize=(width, height), facecolor="white")
    grid = figure.add_gridspec(count, columns + 1, width_ratios=[1] * columns + [0.05], wspace=0.04, hspace=0.04,
                               left=0.3 / width, right=1 - 0.75 / width, bottom=0.4 / height, top=1 - 0.3 / height)
    palette = plt.get_cmap(colours).copy()
    palette.set_bad("0.93")
    for row, pair in enumerate(maps):
        shown = [pair.image, *getattr(pair, what)]
        for column, values in enumerate(shown):
            axes = figure.add_subplot(grid[row, column])
            drawn = axes.imshow(values, norm=norm if column else None, cmap=palette, interpolation="nearest")
            axes.axis("off")
            if row == 0:
                axes.set_title(("converged image", *titles)[column], fontsize=10, color=INK)
            if column == 0:
                axes.text(-0.02, 0.5, pair.name, rotation=90, ha="right", va="center", fontsize=7.5, color=INK,
                          transform=axes.transAxes)
    bar = figure.colorbar(drawn, cax=figure.add_subplot(grid[:, columns]), ticks=ticks)
    if ticks is not None:
        bar.ax.set_yticklabels([f"{tick:g}" if tick >= 1 or what != "bandwidth" else f"1/{round(1 / tick)}" for tick in ticks])
        bar.minorticks_off()
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=8, colors=INK)
    bar.set_label(label, fontsize=9, color=INK)
    figure.text(0.5, 0.12 / height, legend, ha="center", fontsize=8.5, color=INK)
    return figure


def save(figure, path):
    figure.savefig(path, dpi=100, metadata={"Software": None})
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    parser.set_defaults(pairs=SHOWN)
    parser.add_argument("images", type=Path)
    parser.add_argument("--spp", type=int, default=4096, help="samples per pixel of the references")
    parser.add_argument("--frames", type=int, default=256, help="frames of the brute-force variance")
    args = parser.parse_args()
    maps = [Maps.of(pair, args.spp, args.frames) for pair in pairs(args)]
    args.images.mkdir(parents=True, exist_ok=True)
    save(sheet(maps, ("predicted", "windowed Fourier transform"), "bandwidth", LogNorm(1 / 128, 1 / 2), "viridis",
               "cycles per pixel", "The window, sigma 6 pixels, blurs: it reads nothing below 1/16, and the background at rims. Grey inside: "
               "hidden by noise.",
               [1 / 128, 1 / 64, 1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2]), args.images / "predicted_bandwidth.png")
    save(sheet(maps, ("predicted", f"brute force, {args.frames} frames"), "variance", LogNorm(1e-3, 1e2), "magma",
               "variance of one sample, exposed luminance squared", "One pilot point of 16 samples for each tile of 4 x 4 pixels.",
               [1e-3, 1e-2, 1e-1, 1, 10, 100]), args.images / "predicted_variance.png")
    save(sheet(maps, ("shaded at", "predicted level", "required level"), "level", BoundaryNorm(np.arange(-0.5, 6), 256), "turbo",
               "level: cells of 2ᵏ x 2ᵏ pixels", "Shaded at: grey is interpolated between shaded cells. Required: the coarsest grid "
               "whose interpolation stays within 2 %.", range(6)), args.images / "predicted_levels.png")


if __name__ == "__main__":
    main()
