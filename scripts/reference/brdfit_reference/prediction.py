"""What an image needed, to be held against what was predicted (docs/theory.md, "Measuring").

Images here are luminance without texture, exposed, [row, column]; materials are numbers, -1 in the background; pixels are
(rows, columns), two lists.
"""
import numpy as np
from scipy.ndimage import uniform_filter

from .images import exposure, luminance

COARSEST = 5
HIGHEST_LEVEL = 5.9
"""The level of a pixel that could be coarser than the coarsest."""
FINEST_ERROR, ALLOWED_ERROR = 0.004, 0.02
STEP, BORDER, REACH = 5, 40, 24
RAYS = [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if (y, x) != (0, 0)]
NOISE_GAIN = (0.816, 1.011, 1.083, 1.105, 1.106)
"""Variance of an interpolation error of the levels 1 to COARSEST in an image of noise, over that of the noise."""
WINDOW, SIGMA, TAIL, BRIGHTEST = 32, 6.0, 0.05, 4.0
SIGNAL = 4.0
"""Least energy of an image over that of its noise."""


def shaded_luminance(reference):
    """Luminance over the texture, exposed, and the factor of the exposure."""
    factor = exposure(reference.radiance, reference.foreground)
    albedo = np.where(reference.foreground[..., None], reference.layers.triple("albedo"), 1.0)
    return factor * luminance(reference.radiance / albedo), factor


def noise_of(reference, factor):
    """Variance of the exposed luminance over the texture at each pixel of a reference."""
    return factor**2 * reference.layers.scalar("variance.Y") / reference.frames


def chosen_pixels(material):
    """Every fifth pixel, away from the border, with one material all around."""
    rows, columns = (axis.ravel() for axis in np.mgrid[BORDER : material.shape[0] - BORDER : STEP,
                                                       BORDER : material.shape[1] - BORDER : STEP])
    own = material[rows, columns]
    kept = own >= 0
    for y, x in RAYS:
        for distance in range(1, REACH + 1):
            step = round(distance / np.hypot(y, x))
            kept &= material[rows + step * y, columns + step * x] == own
    return rows[kept], columns[kept]


def on_coarse_grid(image, level):
    """The image from its values at the centres of the cells of a level (means of 2 x 2), interpolated bilinearly."""
    size = 2**level
    cells = [-(-extent // size) for extent in image.shape]
    padded = np.pad(image, [(0, size * n - extent) for n, extent in zip(cells, image.shape)], mode="edge")
    half = size // 2
    centres = sum(padded[half - 1 + y :: size, half - 1 + x :: size][: cells[0], : cells[1]] for y in (0, 1) for x in (0, 1)) / 4
    weights = []
    for extent, n in zip(image.shape, cells):
        place = np.clip((np.arange(extent) + 0.5) / size - 0.5, 0, n - 1)
        low = np.minimum(place.astype(int), max(n - 2, 0))
        weights.append((low, np.minimum(low + 1, n - 1), place - low))
    (top, bottom, v), (left, right, u) = weights
    rows = centres[top] * (1 - v)[:, None] + centres[bottom] * v[:, None]
    return rows[:, left] * (1 - u) + rows[:, right] * u


def interpolation_errors(image, material, noise=0.0):
    """Errors of the levels 1 to COARSEST, [level - 1, row, column]: relative, root mean square over a box in the material.

    `noise`: variance of the image, a map, whose share in the errors is subtracted.
    """
    errors = []
    for level in range(1, COARSEST + 1):
        squares = ((on_coarse_grid(image, level) - image) ** 2 - NOISE_GAIN[level - 1] * noise) / (image + 0.02) ** 2
        size = 2 * (2**level // 2 + 1) + 1
        error = np.zeros(image.shape)
        for index in np.unique(material[material >= 0]):
            inside = (material == index).astype(float)
            mean = uniform_filter(squares * inside, size) / np.maximum(uniform_filter(inside, size), 1e-9)
            error = np.where(inside > 0, np.sqrt(np.maximum(mean, 0)), error)
        errors.append(error)
    return np.array(errors)


def required_level(image, material, noise=0.0):
    """The level, a real number, at which the interpolated image would be off by ALLOWED_ERROR; `noise`: `interpolation_errors`."""
    errors = np.concatenate([np.full((1, *image.shape), FINEST_ERROR), interpolation_errors(image, material, noise)])
    errors = np.log(np.maximum.accumulate(errors))
    allowed = np.log(ALLOWED_ERROR)
    level = np.full(image.shape, HIGHEST_LEVEL)
    for fine in reversed(range(COARSEST)):
        below, above = errors[fine], errors[fine + 1]
        passes = (below <= allowed) & (above > allowed)
        level[passes] = fine + ((allowed - below) / np.maximum(above - below, 1e-12))[passes]
    return level


def predicted_level(bandwidth):
    """The level that a bandwidth in cycles per pixel allows, a real number."""
    return np.clip(-np.log2(2 * np.maximum(bandwidth, 1e-6)), 0, HIGHEST_LEVEL)


def windowed_bandwidth(image, noise, pixels):
    """Frequency below which 95 % of the energy in a Gaussian window lies, without its mean, cycles per pixel; at some pixels.

    `noise`: variance of the image at each pixel, not correlated between them. It spreads evenly over all frequencies and is
    subtracted from them; NaN where the rest is less than SIGNAL times as large and nothing can be told.
    """
    offsets = np.arange(WINDOW) - WINDOW // 2
    profile = np.exp(-((offsets / SIGMA) ** 2) / 2)
    window = np.outer(profile, profile)
    frequency = np.fft.fftfreq(WINDOW)
    radius = np.hypot(frequency[:, None], frequency[None, :]).ravel()
    order = np.argsort(radius, kind="stable")[1:]
    radii, counts = np.unique(radius[order], return_counts=True)
    last = np.cumsum(counts) - 1
    shown, spread = (np.pad(values, WINDOW // 2, mode="edge") for values in (np.minimum(image, BRIGHTEST), noise))
    found = []
    for rows, columns in zip(*(np.array_split(axis, len(axis) // 4096 + 1) for axis in pixels)):
        places = rows[:, None, None] + np.arange(WINDOW)[:, None], columns[:, None, None] + np.arange(WINDOW)
        patches = shown[places]
        mean = (patches * window).sum(axis=(1, 2), keepdims=True) / window.sum()
        energy = np.abs(np.fft.fft2((patches - mean) * window)) ** 2
        expected = (spread[places] * window**2).sum(axis=(1, 2))[:, None]
        below = np.cumsum(energy.reshape(len(rows), -1)[:, order] - expected, axis=1)[:, last]
        total = below[:, -1:]
        reached = np.argmax(below >= (1 - TAIL) * total, axis=1)
        found.append(np.where(total[:, 0] > SIGNAL * len(order) * expected[:, 0], radii[reached], np.nan))
    return np.concatenate(found)
