"""The local bandwidth of a 2-D signal in numpy and PyWavelets, by its definition: whole images, double precision.

Transform: orthonormal Daubechies wavelet with four taps (`db2`), per level one horizontal and one vertical step,
    low[k] = sum_t h[t] x[2k - 1 + t],   high[k] = sum_t g[t] x[2k - 1 + t],   g[t] = (-1)^t h[3 - t],   k = 0 .. n/2 - 1,
down to bands of 4 x 4. Borders are periodic, or reflected by half a sample (x[-1] = x[0]) at every level.
Images are [..., row, column]; row 0 comes first, "horizontal" runs along the columns of a row.
"""
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pywt

BORDERS = ("periodic", "symmetric")
NOISE = 0.02
"""A band counts at a pixel if its energy is above NOISE^2 of the pixel's whole energy."""
TAIL = 0.05
"""Share of the energy above the bandwidth."""
CALIBRATION = {"none": 0.480, "four": 0.471, "mirror": 0.471}
"""Makes the median of log2(estimate / truth) zero on sine gratings (scripts/validate/gratings.py)."""
SMALLEST = 4
STRIP = 32
"""Rows at a time."""
_PAD = 2


def _step(signal, border, axes):
    """pywt's `periodization` has the phase wanted. Reflected borders: two samples more at both ends, one coefficient off."""
    if border == "periodic":
        return pywt.dwtn(signal, "db2", mode="periodization", axes=axes)
    pad = [(_PAD, _PAD) if axis - signal.ndim in axes else (0, 0) for axis in range(signal.ndim)]
    inner = tuple(slice(1, -1) if low else slice(None) for low, _ in pad)
    bands = pywt.dwtn(np.pad(signal, pad, mode="symmetric"), "db2", mode="periodization", axes=axes)
    return {name: band[inner] for name, band in bands.items()}


def analyse_line(signal, border):
    """One step along the last axis: low, high."""
    bands = _step(signal, border, (-1,))
    return bands["a"], bands["d"]


def analyse(image, border):
    """One level: low, (H: high-passed horizontally, V: vertically, D: both)."""
    bands = _step(image, border, (-1, -2))
    return bands["aa"], (bands["da"], bands["ad"], bands["dd"])


def transform(image, border):
    """All levels, finest first: [(H, V, D), ...], and the last approximation, whose shorter side has SMALLEST samples."""
    levels = []
    while min(image.shape[-2:]) > SMALLEST:
        image, details = analyse(image, border)
        levels.append(details)
    return levels, image


@dataclass(frozen=True)
class Energies:
    """Energy per pixel at the blocks of each band: levels[j - 1] = (H + V, D) of level j, blocks of 2^j x 2^j pixels; and the
    image's own, the sum of its squares."""

    shape: tuple
    levels: list
    approximation: np.ndarray
    image: np.ndarray

    def channel(self, index):
        """One channel alone."""
        return Energies(self.shape, [(hv[index], d[index]) for hv, d in self.levels], self.approximation[index], self.image[index])

    def finest_share(self):
        """Share of the finest level in the energy of the image; per channel."""
        hv, d = self.levels[0]
        finest = 4 * (hv + d).sum(axis=(-2, -1))
        return np.divide(finest, self.image, out=np.zeros_like(finest), where=self.image > 0)


def _energies(image, border):
    levels, low = transform(image, border)
    found = [((h * h + v * v) / 4**j, d * d / 4**j) for j, (h, v, d) in enumerate(levels, 1)]
    return [*(band for level in found for band in level), low * low / 4 ** len(levels)]


def _mean(first, second, axis):
    """Mean of `first` and of `second` reflected back along `axis`."""
    return [0.5 * (a + np.flip(b, axis)) for a, b in zip(first, second)]


def energies(image, border="symmetric", reflections="four"):
    """Energies of the bands. `reflections`: "none", the mean over "four" reflections of the image, or "mirror", the same
    with half the transforms for an image that does not change when its rows are reversed."""
    flat = _energies(image, border)
    if reflections != "none":
        flat = _mean(flat, _energies(image[..., ::-1], border), -1)
    if reflections == "mirror":
        flat = _mean(flat, flat, -2)
    elif reflections == "four":
        turned = image[..., ::-1, :]
        flat = _mean(flat, _mean(_energies(turned, border), _energies(turned[..., ::-1], border), -1), -2)
    return Energies(image.shape[-2:], list(zip(flat[:-1:2], flat[1:-1:2])), flat[-1], (image * image).sum(axis=(-2, -1)))


@lru_cache
def _nodes(size, count):
    """For each of `size` pixels the block centre before it, of `count`, and the weight of the next one."""
    position = np.clip((np.arange(size) + 0.5) * count / size - 0.5, 0, count - 1)
    low = np.minimum(position.astype(int), count - 2)
    return low, position - low


def interpolate(blocks, shape, rows):
    """Linear between the centres of the blocks, held outside the outermost ones: [m, m'] -> the slice `rows` of `shape`."""
    low, weight = _nodes(shape[0], blocks.shape[0])
    low, weight = low[rows], weight[rows, None]
    lines = (1 - weight) * blocks[low] + weight * blocks[low + 1]
    low, weight = _nodes(shape[1], blocks.shape[1])
    return (1 - weight) * lines[:, low] + weight * lines[:, low + 1]


def pixel_energies(found, rows):
    """All bands of one image at its pixels, [band, row, column]: D and H + V of level 1, of level 2, ..; and their sum with
    the approximation."""
    bands = np.array([interpolate(band, found.shape, rows) for hv, d in found.levels for band in (d, hv)])
    return bands, bands.sum(axis=0) + interpolate(found.approximation, found.shape, rows)


def _strip(found, calibration, rows):
    """Bandwidth over a slice of rows.

    H + V of level j cover the octave [2^-(j+1), 2^-j], D the one half an octave higher, each with even density in log2:
    in steps of half an octave from 2^-1/2 down, D of level j lies in steps 2j - 2 and 2j - 1, H + V in 2j - 1 and 2j.
    """
    bands, total = pixel_energies(found, rows)
    bands[bands <= NOISE**2 * total] = 0.0
    steps = np.zeros((len(bands) + 1, *total.shape))
    steps[:-1] = bands
    steps[1:] += bands
    cumulated = np.cumsum(steps, axis=0)
    target = TAIL * cumulated[-1]
    step = np.argmax(cumulated >= target, axis=0)[None]
    inside, reached = (np.take_along_axis(a, step, 0)[0] for a in (steps, cumulated))
    with np.errstate(invalid="ignore"):
        octaves = -0.5 - 0.5 * (step[0] + 1 - (reached - target) / inside)
    return np.where(cumulated[-1] > 0, calibration * np.exp2(octaves), 0.0)


def cycles_per_pixel(found, calibration, rows=None):
    """Bandwidth of one image at its pixels (the first `rows` rows), cycles per pixel; in strips that fit into a cache."""
    last = rows or found.shape[0]
    strips = [slice(first, min(first + STRIP, last)) for first in range(0, last, STRIP)]
    return np.concatenate([_strip(found, calibration, strip) for strip in strips])


def local_bandwidth(image, border="symmetric", reflections="four"):
    """Bandwidth of one image at its pixels, cycles per pixel, calibrated."""
    return cycles_per_pixel(energies(image, border, reflections), CALIBRATION[reflections])


def direct_line(signal, border):
    """The step of one line by the formula alone; the check of the padding above."""
    h = np.array([1 + math.sqrt(3), 3 + math.sqrt(3), 3 - math.sqrt(3), 1 - math.sqrt(3)]) / (4 * math.sqrt(2))
    g = np.array([h[3], -h[2], h[1], -h[0]])
    n = len(signal)
    index = 2 * np.arange(n // 2)[:, None] - 1 + np.arange(4)
    if border == "periodic":
        index %= n
    else:
        index = np.where(index < 0, -1 - index, np.where(index >= n, 2 * n - 1 - index, index))
    return signal[index] @ h, signal[index] @ g
