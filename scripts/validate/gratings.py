#!/usr/bin/env python3
"""Accuracy of the local bandwidth on signals whose bandwidth is known, and the calibration that it uses.

Prints log2(estimate / truth) for sine gratings (frequency log-uniform in 1/32 .. 0.45 cycles per pixel, every orientation and
phase, pixels at least 64 from the border), with and without the reflections; for Gaussian blobs (truth: the radius that holds
95 % of the energy of the spectrum) and for a smooth lobe of a hemisphere. Exit code 7 where the gratings miss the bars.
Usage: gratings.py [COUNT]
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

from brdfit_reference.bandwidth import CALIBRATION, local_bandwidth
from brdfit_reference.lobes import AngularMap

SIZE = 256
INTERIOR = 64
FREQUENCIES = (1 / 32, 0.45)
BLOB = math.sqrt(-math.log(0.05)) / (2 * math.pi)
"""Of exp(-r^2 / (2 sigma^2)): the energy of its spectrum beyond the radius BLOB / sigma is 5 %."""
BLOBS = (3.0, 5.0, 8.0, 12.0)
LOBE_WIDTH = 0.6
MEDIAN_BAR = 0.05
RANGE_BAR = (-0.65, 0.4)
"""Of the default, with the reflections: 5 and 95 %."""


def grating_octaves(count, reflections, rng):
    """log2(estimate / truth) at 256 random interior pixels of each grating; a reading of 0 counts as 2^-20 of the truth."""
    row, column = np.mgrid[0:SIZE, 0:SIZE]
    found = []
    for _ in range(count):
        nu = math.exp(rng.uniform(*np.log(FREQUENCIES)))
        angle, phase = rng.uniform(0, 2 * math.pi, 2)
        image = np.sin(2 * math.pi * nu * (column * math.cos(angle) + row * math.sin(angle)) + phase)
        estimate = local_bandwidth(image, reflections=reflections)
        at = rng.integers(INTERIOR, SIZE - INTERIOR, (2, 256))
        found.append(np.log2(np.maximum(estimate[at[0], at[1]] / nu, 2.0**-20)))
    return np.concatenate(found)


def blob_octaves(sigma, rng):
    """Bias in the energy-weighted mean and at the centre, mean over 16 positions of the centre between the pixels."""
    row, column = np.mgrid[0:SIZE, 0:SIZE]
    mean, centre = [], []
    for _ in range(16):
        y, x = SIZE / 2 + rng.uniform(-8, 8, 2)
        image = np.exp(-((column - x) ** 2 + (row - y) ** 2) / (2 * sigma**2))
        estimate = local_bandwidth(image)
        weight = np.where(estimate > 0, image**2, 0.0)
        octaves = np.log2(np.where(estimate > 0, estimate, 1.0) * sigma / BLOB)
        mean.append((weight * octaves).sum() / weight.sum())
        centre.append(octaves[round(y), round(x)])
    return np.mean(mean), np.mean(centre)


def smooth_lobe(theta_i):
    """Cycles per radian of exp(-angle^2 / (2 LOBE_WIDTH^2)) around the mirror direction: energy-weighted mean, at the mirror."""
    upper = AngularMap.make(SIZE)
    cosine = -math.sin(theta_i) * upper.x + math.cos(theta_i) * upper.z
    angle = np.arccos(np.clip(cosine, -1, 1))
    half = np.exp(-0.5 * (angle / LOBE_WIDTH) ** 2)
    estimate = local_bandwidth(np.concatenate([half, half[::-1]]), reflections="mirror")[: SIZE // 2] * upper.scale
    weight = np.where(estimate > 0, half**2, 0.0)
    return (weight * estimate).sum() / weight.sum(), estimate.flat[angle.argmin()]


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    print(f"sine gratings, {count} of {SIZE} x {SIZE}, log2(estimate / truth)")
    print("reflections   kappa   median      5 %     95 %   kappa for median 0")
    held = True
    for reflections in ("four", "none"):
        octaves = grating_octaves(count, reflections, np.random.default_rng(7))
        low, middle, high = np.percentile(octaves, (5, 50, 95))
        kappa = CALIBRATION[reflections]
        if reflections == "four":
            held = abs(middle) <= MEDIAN_BAR and low >= RANGE_BAR[0] and high <= RANGE_BAR[1]
        print(f"{reflections:11s}   {kappa:.3f}   {middle:+.3f}   {low:+.3f}   {high:+.3f}   {kappa * 2.0**-middle:.4f}")
    print("\nGaussian blobs, octaves\nsigma (pixels)   energy-weighted mean   centre")
    for sigma in BLOBS:
        mean, centre = blob_octaves(sigma, np.random.default_rng(8))
        print(f"{sigma:14.0f}   {mean:+20.2f}   {centre:+6.2f}")
    truth = BLOB / LOBE_WIDTH
    print(f"\nsmooth lobe of width {LOBE_WIDTH} rad, truth {truth:.2f} cycles per radian; theta_i: weighted mean, at the mirror")
    for degrees in (0, 20, 40):
        print(f"{degrees:2d}: " + "  ".join(f"{value:.2f}" for value in smooth_lobe(math.radians(degrees))))
    if not held:
        print("a bar is missed", file=sys.stderr)
        sys.exit(7)


if __name__ == "__main__":
    main()
