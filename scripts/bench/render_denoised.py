#!/usr/bin/env python3
"""Equal total time against constant samples and a denoiser, on the eight pairs: scripts/bench/render_denoised.sh runs it.

    render_denoised.py BRDFIT MATERIALS WORK [--pairs NAME...] [--constant 4 16] [--repeat 5] [-- OPTIONS of brdfit render]

T is the wall time of a frame with N samples at every pixel and of the denoiser (denoise.py: Open Image Denoise with albedo and
normals), medians, two threads. The budget of the adaptive frame is the largest whose frame takes no longer, found by
bisection; OPTIONS are those of the adaptive frame, the same for all pairs. Prints Markdown; ends with 7 where the adaptive
image is the better one on fewer pairs than the bar asks for.
"""
import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

from brdfit_reference.pairs import THREADS, add_arguments, pairs
from denoise import denoise

REFERENCE_SPP = 4096
LOWEST, HIGHEST = 0.25, 256.0
"""Budgets that are tried."""
STEPS = 7
SHORTER = 0.97
"""A frame that takes at least this part of the time is near enough."""
BAR = 5


@dataclass(frozen=True)
class Row:
    """One pair, one N. Times in milliseconds; `budget` is None where no frame is short enough."""

    constant: float
    denoiser: float
    noisy_psnr: float
    denoised_psnr: float
    budget: float | None
    frame: float
    psnr: float


def denoised(image, repeat):
    """The denoised image and the milliseconds that took."""
    guides = image.layers.triple("albedo"), image.layers.triple("normal", "XYZ")
    clean, _, seconds = denoise(*(np.ascontiguousarray(part, np.float32) for part in (image.radiance, *guides)), repeat, THREADS)
    return np.asarray(clean, float), 1000 * seconds


def within(pair, milliseconds, repeat, options):
    """(budget, image) of the largest budget whose frame takes no longer, by bisection in its logarithm; None without any."""

    def frame(budget):
        return pair.render("--spp", budget, "--repeat", repeat, *options)

    low, high = LOWEST, HIGHEST
    image = frame(low)
    if image.milliseconds["frame"] > milliseconds:
        return None, image
    for _ in range(STEPS):
        middle = math.sqrt(low * high)
        tried = frame(middle)
        if tried.milliseconds["frame"] > milliseconds:
            high = middle
            continue
        low, image = middle, tried
        if tried.milliseconds["frame"] >= SHORTER * milliseconds:
            break
    return low, image


def measure(pair, n, repeat, options):
    reference = pair.reference(REFERENCE_SPP)
    noisy = pair.constant(n, "--repeat", repeat)
    clean, denoiser = denoised(noisy, repeat)
    constant = noisy.milliseconds["frame"]
    budget, image = within(pair, constant + denoiser, repeat, options)
    return Row(constant, denoiser, reference.psnr(noisy.radiance), reference.psnr(clean), budget, image.milliseconds["frame"],
               reference.psnr(image.radiance))


def table(n, rows):
    """Prints the table of an N; whether the bar is met."""
    print(f"\n{n} samples at every pixel.\n")
    print("| pair | constant ms | denoiser ms | together | PSNR, noisy | denoised | ours: budget | ms | PSNR | ours − denoised |")
    print("|---|" + "---:|" * 9)
    better = 0
    for name, row in rows.items():
        better += row.budget is not None and row.psnr > row.denoised_psnr
        budget = "none short enough" if row.budget is None else f"{row.budget:.1f}"
        print(f"| {name} | {row.constant:.0f} | {row.denoiser:.0f} | {row.constant + row.denoiser:.0f} | {row.noisy_psnr:.1f} | "
              f"{row.denoised_psnr:.1f} | {budget} | {row.frame:.0f} | {row.psnr:.1f} | {row.psnr - row.denoised_psnr:+.1f} |")
    print(f"\nOurs is better on {better} of {len(rows)} (at least {BAR} of 8).")
    return better >= BAR


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    parser.add_argument("--constant", type=int, nargs="+", default=[4, 16], metavar="N")
    parser.add_argument("--repeat", type=int, default=5)
    ours, _, options = (sys.argv[1:], "", []) if "--" not in sys.argv else (
        sys.argv[1 : sys.argv.index("--")], "--", sys.argv[sys.argv.index("--") + 1 :])
    args = parser.parse_args(ours)
    rows = {n: {} for n in args.constant}
    for pair in pairs(args):
        for n in args.constant:
            print(f"{pair.name}, {n}", file=sys.stderr, flush=True)
            rows[n][pair.name] = measure(pair, n, args.repeat, options)
    print(f"Options of the adaptive frames: {' '.join(options) or 'the defaults'}. References: {REFERENCE_SPP} samples per pixel.")
    met = [table(n, found) for n, found in rows.items()]
    sys.exit(0 if all(met) else 7)


if __name__ == "__main__":
    main()
