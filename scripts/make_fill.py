#!/usr/bin/env python3
"""Make data-fixtures/fill.json: the nearest valid cell of every cell of small grids, by scipy's exact Euclidean distance
transform with steps of 1, 1.01 and 1.02 along the three axes.

Each case has the shape, the validity of the cells in order ("1" valid, "0" not), and the source of each cell: the flat index
of the nearest valid one, its own where it is valid.

Usage: make_fill.py
"""
import numpy as np
from scipy.ndimage import distance_transform_edt

from oracle_json import write_fixture

SAMPLING = (1.0, 1.01, 1.02)


def case(valid):
    """The fixture's entry of a boolean array."""
    nearest = distance_transform_edt(~valid, sampling=SAMPLING, return_distances=False, return_indices=True)
    sources = np.ravel_multi_index(tuple(nearest), valid.shape)
    return {
        "shape": list(valid.shape),
        "valid": "".join("1" if v else "0" for v in valid.ravel()),
        "sources": sources.ravel().tolist(),
    }


def main():
    rng = np.random.default_rng(4)
    h, d, p = np.meshgrid(np.arange(12), np.arange(12), np.arange(13), indexing="ij")
    horizon = np.sin(h / 12 * 1.55) * np.sin(d / 12 * 1.55) * np.cos(p / 12 * np.pi / 2) < np.cos(h / 12 * 1.55) * np.cos(
        d / 12 * 1.55
    )
    single = np.zeros((5, 6, 7), dtype=bool)
    single[3, 1, 4] = True
    grids = [rng.random((9, 8, 11)) < share for share in (0.01, 0.1, 0.6)] + [horizon, single]
    write_fixture("fill.json", {"sampling": SAMPLING}, {"cases": [case(valid) for valid in grids]})


if __name__ == "__main__":
    main()
