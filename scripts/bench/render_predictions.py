#!/usr/bin/env python3
"""Predictions against what the converged images needed, on the eight pairs: scripts/bench/render_predictions.sh runs it.

    render_predictions.py BRDFIT MATERIALS WORK [--pairs NAME...] [--spp 4096] [--frames 256] [--pilot-samples 16 64 256 1024]

Rank correlations (Spearman) of the predicted with the required level, of the predicted with the brute-force variance, and of
the predicted image bandwidth with that of a windowed Fourier transform, each at the pixels that docs/theory.md, "Measuring",
names, and how the first two and the PSNR change with the samples of the pilot. Prints Markdown; ends with 7 where a bar is
missed.
"""
import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import mean

import numpy as np
from scipy.stats import spearmanr

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

from brdfit_reference.pairs import add_arguments, pairs
from brdfit_reference.prediction import (
    chosen_pixels, noise_of, predicted_level, required_level, shaded_luminance, windowed_bandwidth,
)

BUDGET = 4
BAR_PILOT = 16
BAR_LEVEL, BAR_VARIANCE = 0.75, 0.7
QUANTITIES = ("level", "level_without_noise", "bandwidth", "variance")


@dataclass(frozen=True)
class Truth:
    """What a pair needed: levels and bandwidths at `pixels`, the variance of one sample in the foreground, exposed.

    `level_without_noise`: the level after the noise of the reference was subtracted from its errors."""

    pixels: tuple
    level: np.ndarray
    level_without_noise: np.ndarray
    bandwidth: np.ndarray
    noise: float
    foreground: np.ndarray
    exposure: float
    variance: np.ndarray
    psnr: object

    @classmethod
    def of(cls, pair, spp, frames):
        reference = pair.reference(spp)
        image, factor = shaded_luminance(reference)
        material = reference.layers.scalar("material.Y")
        pixels = chosen_pixels(material)
        noise = noise_of(reference, factor)
        error = noise[pixels] / (image[pixels] + 0.02) ** 2
        # one sample of either technique per frame: v = n_b times the variance of the estimate, n_b = 2
        variance = 2 * factor**2 * pair.single_samples(frames).scalar("variance.Y")
        levels = (required_level(image, material, subtracted)[pixels] for subtracted in (0.0, noise))
        return cls(pixels, *levels, windowed_bandwidth(image, noise, pixels), float(np.sqrt(np.mean(error))),
                   reference.foreground, factor, variance[reference.foreground], reference.psnr)


@dataclass(frozen=True)
class Predicted:
    """The same quantities from the pilot, and the quality of the image."""

    level: np.ndarray
    bandwidth: np.ndarray
    variance: np.ndarray
    psnr: float

    @property
    def level_without_noise(self):
        return self.level

    @classmethod
    def of(cls, pair, truth, pilot_samples):
        image = pair.render("--spp", BUDGET, "--pilot-samples", pilot_samples, layers="gbuffer,pilot,bandwidth")
        bandwidth = image.layers.scalar("bandwidth.Y")[truth.pixels]
        variance = truth.exposure**2 * image.layers.scalar("pilot.VARIANCE")[truth.foreground]
        return cls(predicted_level(bandwidth), bandwidth, variance, truth.psnr(image.radiance))


def correlation(predicted, true, what):
    """Spearman's rank correlation over lists of pairs of a quantity, where it could be measured."""
    sides = [np.concatenate([getattr(part, what) for part in side]) for side in (predicted, true)]
    return spearmanr(*sides, nan_policy="omit").statistic


def table_of_pairs(names, truths, predicted):
    print(f"Rank correlations of predicted and true values, pilot of {BAR_PILOT} samples. Noise: of the reference, relative, root "
          "mean square.\n")
    print("| pair | pixels | noise of the reference, % | level | level, noise subtracted | median level, predicted | required | image "
          "bandwidth | measurable, % | variance |")
    print("|---|" + "---:|" * 9)
    for name, truth, guess in zip(names, truths, predicted):
        level, clean, bandwidth, variance = (correlation([guess], [truth], what) for what in QUANTITIES)
        print(f"| {name} | {len(truth.level)} | {100 * truth.noise:.2f} | {level:.2f} | {clean:.2f} | {np.median(guess.level):.1f} | "
              f"{np.median(truth.level_without_noise):.1f} | {bandwidth:.2f} | {100 * np.isfinite(truth.bandwidth).mean():.0f} | "
              f"{variance:.2f} |")
    level, clean, bandwidth, variance = (correlation(predicted, truths, what) for what in QUANTITIES)
    count = sum(len(truth.level) for truth in truths)
    print(f"| **all pixels together** | {count} | | {level:.3f} | {clean:.3f} | | | {bandwidth:.3f} | | {variance:.3f} |")
    return level >= BAR_LEVEL and variance >= BAR_VARIANCE


def table_of_pilots(truths, by_pilot):
    print(f"\nInfluence of the pilot: rank correlations over all pixels, PSNR at {BUDGET} samples per pixel, mean over the pairs.\n")
    print("| samples per pilot point | level | level, noise subtracted | image bandwidth | variance | PSNR dB |\n|" + "---:|" * 6)
    for samples, predicted in by_pilot.items():
        found = " | ".join(f"{correlation(predicted, truths, what):.3f}" for what in QUANTITIES)
        print(f"| {samples} | {found} | {mean(part.psnr for part in predicted):.2f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    parser.add_argument("--spp", type=int, default=4096, help="samples per pixel of the references")
    parser.add_argument("--frames", type=int, default=256, help="frames of the brute-force variance")
    parser.add_argument("--pilot-samples", type=int, nargs="+", default=[16, 64, 256, 1024])
    args = parser.parse_args()
    names, truths, by_pilot = [], [], {samples: [] for samples in args.pilot_samples}
    for pair in pairs(args):
        print(pair.name, file=sys.stderr, flush=True)
        names.append(pair.name)
        truths.append(Truth.of(pair, args.spp, args.frames))
        for samples, predicted in by_pilot.items():
            predicted.append(Predicted.of(pair, truths[-1], samples))
    met = BAR_PILOT not in by_pilot or table_of_pairs(names, truths, by_pilot[BAR_PILOT])
    table_of_pilots(truths, by_pilot)
    sys.exit(0 if met else 7)


if __name__ == "__main__":
    main()
