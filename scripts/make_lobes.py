#!/usr/bin/env python3
"""Make data-fixtures/lobes.json: the bandwidth of GGX lobes in the mirror direction by PyWavelets. Usage: make_lobes.py"""
import math

import numpy as np
import pywt

from brdfit_reference.bandwidth import CALIBRATION, cycles_per_pixel, energies
from brdfit_reference.lobes import TILE, AngularMap
from oracle_json import write_fixture

WIDTHS = (0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.56, 0.8)
ELEVATION = 40.0
SIZE = 256

DESCRIPTION = f"""\
Local bandwidth of the lobe of a GGX material (Walter 2007, eq. 20, 33, 34 without a Fresnel term; rho_d = 0, rho_s = 1) for
light at theta_i = {ELEVATION:g} degrees, on an angular map of {SIZE} x {SIZE} samples reduced to {TILE} x {TILE} texels by the maximum
(docs/theory.md, section 10): cycles per radian, the largest of the texels that touch the mirror direction. readings: [alpha, from
the lobe as it is (kappa {CALIBRATION["none"]}), from the mean over its four reflections (kappa {CALIBRATION["four"]})].
""".replace("\n", " ").strip()


def lobe(alpha):
    """f(i, .) in 1/sr on the whole map, light at (ELEVATION, phi = 0)."""
    upper = AngularMap.make(SIZE)
    theta_i = math.radians(ELEVATION)
    half = np.stack([math.sin(theta_i) + upper.x, upper.y, math.cos(theta_i) + upper.z])
    cos_h = half[2] / np.sqrt((half * half).sum(axis=0))
    tan2 = 1 / cos_h**2 - 1
    distribution = alpha**2 / (math.pi * cos_h**4 * (alpha**2 + tan2) ** 2)

    def masking(cosine):
        return 2 / (1 + np.sqrt(1 + alpha**2 * (1 / cosine**2 - 1)))

    cos_i = math.cos(theta_i)
    values = distribution * masking(cos_i) * masking(upper.z) / (4 * cos_i * upper.z)
    return np.concatenate([values, values[::-1]])


def reading(image, reflections):
    """Cycles per radian in the mirror direction."""
    found = cycles_per_pixel(energies(image, "symmetric", reflections), CALIBRATION[reflections])
    scale = AngularMap.make(SIZE).scale
    block = SIZE // TILE
    texels = (found * np.concatenate([scale, scale[::-1]])).reshape(TILE, block, TILE, block).max(axis=(1, 3))
    # the mirror direction lies at v = 0, between the two rows in the middle
    column = int((1 - ELEVATION / 90) * 0.5 * TILE)
    return float(texels[TILE // 2 - 1 : TILE // 2 + 1, column].max())


def main():
    images = {alpha: lobe(alpha) for alpha in WIDTHS}
    rows = [[alpha, reading(image, "none"), reading(image, "four")] for alpha, image in images.items()]
    header = {
        "generated_by": f"scripts/make_lobes.py, PyWavelets {pywt.__version__}, numpy {np.__version__}",
        "description": DESCRIPTION,
    }
    write_fixture("lobes.json", header, {"readings": rows})


if __name__ == "__main__":
    main()
