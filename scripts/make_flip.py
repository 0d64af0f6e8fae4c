#!/usr/bin/env python3
"""Make data-fixtures/flip.json: LDR-FLIP of small images by the authors' program (PyPI: flip-evaluator).

Usage: make_flip.py
"""
from importlib.metadata import version

import flip_evaluator
import numpy as np

from oracle_json import write_fixture

HEIGHT, WIDTH = 28, 36

DESCRIPTION = f"""\
LDR-FLIP (Andersson et al. 2020) by the authors' program in single precision. Images are {HEIGHT} rows of {WIDTH} pixels
of R, G, B on the curve of sRGB, integers to be divided by 255. cases: [name, pixels per degree, reference, test, mean of
the map, map]; images as one list of numbers row by row, the map rounded to 7 decimals.
""".replace("\n", " ").strip()


def images():
    """Name, pixels per degree, reference and test of each case."""
    rng = np.random.default_rng(20)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    disc = np.hypot(x - 17, y - 13) < 9
    ramp = np.stack([5 * x + 30, 7 * y + 20, 200 - 3 * x - 2 * y], axis=2)
    scene = np.where(disc[..., None], np.array([210, 90, 40]), ramp)
    noise = np.clip(scene + rng.normal(0, 25, scene.shape), 0, 255).astype(int)
    yield "noise", 67.0, scene, noise
    yield "noise, near", 15.0, scene, noise
    yield "shift", 67.0, scene, np.roll(scene, 2, axis=1)
    yield "colour", 30.0, scene, scene[..., ::-1]
    yield "firefly", 67.0, scene // 4, np.where(((x == 20) & (y == 9))[..., None], 255, scene // 4)
    yield "unrelated", 67.0, rng.integers(0, 256, scene.shape), rng.integers(0, 256, scene.shape)


def case(name, density, reference, test):
    shown = [(image / 255).astype(np.float32) for image in (reference, test)]
    values, mean, _ = flip_evaluator.evaluate(*shown, "LDR", applyMagma=False, parameters={"ppd": density})
    values = np.asarray(values, dtype=float).reshape(HEIGHT, WIDTH, -1)[..., 0]
    assert abs(values.mean() - mean) < 1e-6
    lists = [image.ravel().tolist() for image in (reference, test)]
    return [name, density, *lists, float(mean), [round(value, 7) for value in values.ravel().tolist()]]


def main():
    header = {
        "generated_by": f"scripts/make_flip.py, flip-evaluator {version('flip-evaluator')}, numpy {np.__version__}",
        "description": DESCRIPTION,
        "width": WIDTH,
    }
    write_fixture("flip.json", header, {"cases": [case(*images_of_case) for images_of_case in images()]})


if __name__ == "__main__":
    main()
