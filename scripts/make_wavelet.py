#!/usr/bin/env python3
"""Make data-fixtures/wavelet.json: the D4 transform and the local bandwidth by PyWavelets, on small inputs.

Every single step in one dimension is checked against the formula by direct summation. Usage: make_wavelet.py
"""
import numpy as np
import pywt

from brdfit_reference.bandwidth import (
    BORDERS,
    CALIBRATION,
    NOISE,
    analyse,
    analyse_line,
    cycles_per_pixel,
    direct_line,
    energies,
    pixel_energies,
    transform,
)
from oracle_json import write_fixture

LENGTHS = (8, 10, 16, 26, 32, 64)
STRIDE = 3
PROBES = ((0, 0), (0, 31), (63, 63), (20, 30), (37, 12), (45, 58))
SCALE = 4096

DESCRIPTION = f"""\
D4 (db2) analysis and local bandwidth in double precision. One step: low[k] = sum_t h[t] x[2k - 1 + t], high[k] =
sum_t g[t] x[2k - 1 + t], k = 0 .. n/2 - 1, t = 0 .. 3, h = (1 + s, 3 + s, 3 - s, 1 - s) / (4 sqrt 2) with s = sqrt 3,
g[t] = (-1)^t h[3 - t]. Border periodic: x[-1] = x[n - 1], x[n] = x[0]; symmetric: x[-1] = x[0], x[n] = x[n - 1], at each
level on that level's input. Images are [row][column]; per level one horizontal step (along a row), one vertical. H:
high-passed horizontally and low-passed vertically; V: the other way round; D: high-passed both ways (PyWavelets calls our
H cV and our V cH). lines: [name, n, border, x, low, high]. images: one level of a small image. pyramid: a 32 x 32 image;
levels: its transform down to bands of 4 x 4: [border, level (1: finest), band (A: the last approximation),
coefficients]. signals: 64 x 64 images, integers to be divided by {SCALE}. bandwidth: of them; reflections: none, or the
mean over four; finest_share: H + V + D of level 1 in the sum of squares of the image; map: cycles per pixel, calibrated, at
rows and columns 0, {STRIDE}, .., 63; probes: [row, column, energies per pixel D1, H1 + V1, D2, H2 + V2, .., their sum with the
approximation's, cycles per pixel]. At these texels no energy is within 1e-9 (relative) of the noise threshold.
""".replace("\n", " ").strip()


def lines():
    rng = np.random.default_rng(4)
    for n in LENGTHS:
        k = np.arange(n, dtype=float)
        yield "random", rng.integers(-30000, 30000, n) / 4096
        yield "ramp", k
        yield "chirp", np.round(np.cos(1.5 * k * k / n) * 1024) / 1024
        yield "edge", np.where(k < n // 2 + 1, 1.0, -2.0)
        yield "ends", np.where(k == 0, 3.0, np.where(k == n - 1, -5.0, 0.0))
    yield "constant", np.full(16, 0.75)


def line_rows():
    for name, x in lines():
        for border in BORDERS:
            low, high = analyse_line(x, border)
            worst = max(np.abs(a - b).max() for a, b in zip((low, high), direct_line(x, border)))
            if worst > 4e-15 * np.abs(x).max():
                raise ArithmeticError(f"{name} {len(x)} {border}: {worst} off the formula")
            yield [name, len(x), border, x.tolist(), low.tolist(), high.tolist()]


def image_rows():
    rng = np.random.default_rng(5)
    for name, shape in (("random", (8, 8)), ("wide", (8, 12)), ("tall", (10, 8))):
        x = rng.integers(-30000, 30000, shape) / 4096
        for border in BORDERS:
            low, details = analyse(x, border)
            bands = {band: values.tolist() for band, values in zip("HVD", details)}
            yield {"name": name, "border": border, "x": x.tolist(), "low": low.tolist(), **bands}


def pyramid_rows(image):
    for border in BORDERS:
        levels, last = transform(image, border)
        for level, details in enumerate(levels, 1):
            for band, values in zip("HVD", details):
                yield [border, level, band, values.tolist()]
        yield [border, len(levels), "A", last.tolist()]


def signals():
    """A chirp whose frequency rises from 0.03 to 0.4 cycles per pixel, and a turned blob near a corner on nothing."""
    row, column = np.mgrid[0:64, 0:64].astype(float)
    along = (3 * column + row) / 256
    chirp = 2048 + 1800 * np.sin(2 * np.pi * 64 * (0.03 * along + 0.18 * along**2))
    a, b = (0.8 * (column - 45.3) + 0.6 * (row - 20.8)) / 2.5, (0.8 * (row - 20.8) - 0.6 * (column - 45.3)) / 5
    blob = 4000 * np.exp(-0.5 * (a * a + b * b))
    return {"chirp": np.round(chirp).astype(int), "blob": np.round(blob).astype(int)}


def bandwidth_rows(images):
    for name, image in images.items():
        for border in BORDERS:
            for reflections in ("none", "four"):
                found = energies(image / SCALE, border, reflections)
                values = cycles_per_pixel(found, CALIBRATION[reflections])
                bands, total = pixel_energies(found, slice(None))
                near = (np.abs(bands - NOISE**2 * total) < 1e-9 * NOISE**2 * total).any(axis=0)
                if near[::STRIDE, ::STRIDE].any() or any(near[probe] for probe in PROBES):
                    raise ArithmeticError(f"{name}: an energy lies at the noise threshold")
                probes = [[r, c, *bands[:, r, c].tolist(), float(total[r, c]), float(values[r, c])] for r, c in PROBES]
                yield {
                    "name": name, "border": border, "reflections": reflections, "finest_share": float(found.finest_share()),
                    "map": values[::STRIDE, ::STRIDE].tolist(), "probes": probes,
                }


def main():
    rng = np.random.default_rng(6)
    pyramid = rng.integers(-30000, 30000, (32, 32)) / 4096
    images = signals()
    header = {
        "generated_by": f"scripts/make_wavelet.py, PyWavelets {pywt.__version__}, numpy {np.__version__}",
        "description": DESCRIPTION,
        "pyramid": pyramid.tolist(),
    }
    tables = {"lines": line_rows(), "images": image_rows(), "levels": pyramid_rows(pyramid)}
    tables["signals"] = [[name, image.tolist()] for name, image in images.items()]
    tables["bandwidth"] = bandwidth_rows(images)
    write_fixture("wavelet.json", header, {key: list(rows) for key, rows in tables.items()})


if __name__ == "__main__":
    main()
