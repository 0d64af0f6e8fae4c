#!/usr/bin/env python3
"""Equal quality against constant samples per pixel, on the eight pairs: scripts/bench/render_quality.sh runs it.

    render_quality.py BRDFIT MATERIALS WORK [--pairs NAME...] [--budgets 4 16] [--repeat 5]

N_eq is the constant number of samples per pixel whose PSNR equals the adaptive image's: interpolated in log N between measured
images, never extrapolated. Samples include the pilot's; times are those of a frame, from the pilot to the up-sampling, two
threads. Prints Markdown; ends with 7 where a bar is missed.
"""
import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from statistics import geometric_mean

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

from brdfit_reference.pairs import add_arguments, pairs

LADDER = (1, 4, 16, 64, 256, 1024)
REFERENCE_SPP, LONG_REFERENCE_SPP = 4096, 16384
REFERENCE_RATIO = 16
"""Samples of the reference over those of what it is compared with, at least."""
BAR_BUDGET = 4
BAR_SAMPLES, BAR_TIME, BAR_SHARE = 12, 8, 0.35
MODES = ("adaptive", "adaptive-pixels", "adaptive-counts")


@dataclass(frozen=True)
class Equal:
    """The constant image as good as an adaptive one. `sign`: "=", or "<", ">" at either end of what was measured."""

    n: float
    milliseconds: float
    sign: str = "="


class Constant:
    """Constant images of a pair, measured as far as needed."""

    def __init__(self, pair, repeat):
        self._pair, self._repeat = pair, repeat
        self._images = {}
        self._reference = None

    def image(self, n):
        if n not in self._images:
            self._images[n] = self._pair.constant(n, "--repeat", self._repeat)
        return self._images[n]

    @property
    def reference(self):
        return self._reference or self._set_reference(REFERENCE_SPP)

    def _set_reference(self, spp):
        self._reference = self._pair.reference(spp)
        return self._reference

    def psnr(self, n):
        return self.reference.psnr(self.image(n).radiance)

    def lengthen_for(self, images):
        """Takes the longer reference if an image is better than the largest N that the shorter one may judge."""
        largest = self.reference.spp // REFERENCE_RATIO
        if largest < LADDER[-1] and any(self.reference.psnr(image.radiance) > self.psnr(largest) for image in images):
            self._set_reference(LONG_REFERENCE_SPP)

    def equal(self, image):
        """The constant image as good as this one."""
        wanted = self.reference.psnr(image.radiance)
        start = 1
        if wanted < self.psnr(LADDER[1]):
            start = 0
            if wanted < self.psnr(LADDER[0]):
                return Equal(LADDER[0], self._frame(LADDER[0]), "<")
        for low, high in zip(LADDER[start:], LADDER[start + 1 :]):
            if REFERENCE_RATIO * high > self.reference.spp:
                return Equal(low, self._frame(low), ">")
            below, above = self.psnr(low), self.psnr(high)
            if below <= wanted <= above:
                share = (wanted - below) / (above - below)
                return Equal(between(low, high, share), between(self._frame(low), self._frame(high), share))
        return Equal(LADDER[-1], self._frame(LADDER[-1]), ">")

    def _frame(self, n):
        return self.image(n).milliseconds["frame"]


def between(low, high, share):
    """Linear in the logarithm."""
    return math.exp((1 - share) * math.log(low) + share * math.log(high))


@dataclass(frozen=True)
class Row:
    """What one mode reached on one pair."""

    psnr: float
    samples: float
    milliseconds: float
    share: float
    equal: Equal
    reference_spp: int

    @property
    def in_samples(self):
        return self.equal.n / self.samples

    @property
    def in_time(self):
        return self.equal.milliseconds / self.milliseconds


def measure(pair, budgets, repeat):
    """Rows by budget and mode."""
    constant = Constant(pair, repeat)
    images = {(budget, mode): pair.render("--mode", mode, "--spp", budget, "--repeat", repeat)
              for budget in budgets for mode in MODES}
    constant.lengthen_for(images.values())
    rows = {}
    for key, image in images.items():
        times = image.milliseconds
        share = (times["pilot"] + times["bandwidth_buffer"]) / times["frame"]
        rows[key] = Row(constant.reference.psnr(image.radiance), image.samples, times["frame"], share, constant.equal(image),
                        constant.reference.spp)
    return rows


def signed(sign, value):
    return f"{'' if sign == '=' else sign + ' '}{value:.3g}"


def table(results, budget):
    """Prints the table of a budget. A mean with a sign holds at least one ratio that is only known to be beyond it."""
    print(f"\nBudget {budget} samples per pixel. Ratios: constant N of the same PSNR over ours. A sign: PSNR beyond the smallest or "
          "largest N that was measured (nothing is extrapolated).\n")
    print("| pair | PSNR dB | samples per pixel | ms | N of equal PSNR | fewer samples | less time | pilot and bandwidth, % of the "
          "frame | pixels alone: samples | time | counts alone: samples | time | reference |")
    print("|---|" + "---:|" * 12)
    for name, rows in results.items():
        row, *halves = (rows[budget, mode] for mode in MODES)
        sign = row.equal.sign
        cells = [f"{row.psnr:.1f}", f"{row.samples:.2f}", f"{row.milliseconds:.0f}", signed(sign, row.equal.n),
                 signed(sign, row.in_samples), signed(sign, row.in_time), f"{100 * row.share:.0f}"]
        for half in halves:
            cells += [signed(half.equal.sign, half.in_samples), signed(half.equal.sign, half.in_time)]
        print(f"| {name} | " + " | ".join(cells) + f" | {row.reference_spp} |")
    means = []
    for mode in MODES:
        rows = [rows[budget, mode] for rows in results.values()]
        signs = "".join(sorted({row.equal.sign for row in rows} - {"="}))
        means += [signed(signs or "=", geometric_mean(getattr(row, what) for row in rows)) for what in ("in_samples", "in_time")]
    print(f"| **geometric mean** | | | | | {means[0]} | {means[1]} | | {means[2]} | {means[3]} | {means[4]} | {means[5]} | |")


def bars_met(results):
    """Whether the ratios and the share meet the bars at the budget that these are about."""
    rows = [rows[BAR_BUDGET, MODES[0]] for rows in results.values()]
    samples, time = ([getattr(row, what) for row in rows] for what in ("in_samples", "in_time"))
    share = max(row.share for row in rows)
    print(f"\nBars at {BAR_BUDGET} samples per pixel: samples {geometric_mean(samples):.1f} (at least {BAR_SAMPLES}), time "
          f"{geometric_mean(time):.1f} (at least {BAR_TIME}), worst pair {min(samples + time):.2f} (at least 1), largest share of "
          f"pilot and bandwidth {100 * share:.0f} % (below {100 * BAR_SHARE:.0f} %).")
    return (geometric_mean(samples) >= BAR_SAMPLES and geometric_mean(time) >= BAR_TIME and min(samples + time) >= 1
            and share < BAR_SHARE)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_arguments(parser)
    parser.add_argument("--budgets", type=int, nargs="+", default=[4, 16])
    parser.add_argument("--repeat", type=int, default=5)
    args = parser.parse_args()
    results = {}
    for pair in pairs(args):
        print(pair.name, file=sys.stderr, flush=True)
        results[pair.name] = measure(pair, args.budgets, args.repeat)
    for budget in args.budgets:
        table(results, budget)
    sys.exit(0 if BAR_BUDGET not in args.budgets or bars_met(results) else 7)


if __name__ == "__main__":
    main()
