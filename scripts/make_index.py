#!/usr/bin/env python3
"""Make data-fixtures/index.json: golden values of the MERL conventions (docs/theory.md, section 1).

- queries: (theta_h, theta_d, phi_d) and their indices for 180 and for 360 phi_d bins, including edges, angles outside the
  half turn and clamped ones. Indices are computed with 40 digits from the exact doubles; a query nearer than 1e-11 of a
  bin to an edge (where rounding could decide) is refused, unless it is exactly 0 or lies beyond the last bin.
- directions: (theta_i, phi_i, theta_o, phi_o) and their half/difference angles, from vectors with 40 digits.
- samples: where the sample of a cell lies, and the cosines there.
- counts: how many cells of the genuine files' mask and of the six measured files are in the error panel and usable.

The reader of the reference fits (brdfit_reference/merl.py) must agree with every one of them.

Usage: make_index.py [DATA]; DATA holds tables/ and measured/ (default: $BRDFIT_DATA or ../shared/data).
"""
import io
import lzma
import math
import random
import sys

import mpmath as mp
import numpy as np

from brdfit_reference import merl
from brdfit_reference.panel import PANEL_COSINE
from oracle_json import nearest_double, write_fixture

mp.mp.dps = 40


def bin_of(position, bins):
    """floor and clamp, refusing what rounding could move."""
    nearest = mp.nint(position)
    inside = 0 < nearest < bins
    if inside and abs(position - nearest) < mp.mpf("1e-11"):
        raise ValueError(f"{mp.nstr(position, 20)} is too near an edge")
    return int(min(max(mp.floor(position), 0), bins - 1))


def indices(theta_h, theta_d, phi_d):
    """[theta_h index, theta_d index, phi_d index and flat index of 180 bins, the same of 360 bins]."""
    h = bin_of(90 * mp.sqrt(max(mp.mpf(theta_h), 0) / (mp.pi / 2)), 90)
    d = bin_of(90 * mp.mpf(theta_d) / (mp.pi / 2), 90)
    result = [h, d]
    for bins, period in ((180, mp.pi), (360, 2 * mp.pi)):
        phi = mp.mpf(phi_d)
        phi -= period * mp.floor(phi / period)
        phi_bin = bin_of(bins * phi / period, bins)
        result += [phi_bin, phi_bin + bins * (d + 90 * h)]
    return result


def queries():
    rng = random.Random(90)
    pi = math.pi
    rows = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (1e-12, 1e-12, 1e-12)]
    rows += [(pi / 2, pi / 2, 3.0), (1.6, 1.7, 3.14), (2.0, 3.0, 0.1)]
    for i in (1, 2, 3, 10, 45, 64, 88, 89):
        edge_h, edge_d, edge_phi = (i / 90) ** 2 * pi / 2, i / 90 * pi / 2, i / 90 * pi
        for shift in (-1e-9, 1e-9):
            rows.append((edge_h * (1 + shift), edge_d * (1 - shift), edge_phi * (1 + shift)))
            rows.append((edge_h * (1 - shift), edge_d * (1 + shift), edge_phi * (1 + shift) - pi))
    for phi in (-1e-9, -0.5, -pi + 1e-9, -pi / 2 - 0.01, pi - 1e-9, pi + 1e-9, 3.5, 4.75, 6.28, -3.1, 2 * pi - 1e-9):
        rows.append((0.3, 0.7, phi))
        rows.append((1.2, 1.3, phi))
    while len(rows) < 200:
        rows.append((rng.uniform(0, 1) ** 2 * pi / 2, rng.uniform(0, pi / 2), rng.uniform(-pi, 2 * pi)))
    return rows


def difference_angles(theta_i, phi_i, theta_o, phi_o):
    """theta_h, theta_d, phi_d in (-pi, pi]: phi_d is the azimuth of i around h, counted in the frame of h turned to the
    normal by its azimuth and then by theta_h. None where h is the normal or i is h (phi_d has no meaning there)."""

    def vector(theta, phi):
        theta, phi = mp.mpf(theta), mp.mpf(phi)
        return mp.matrix([mp.sin(theta) * mp.cos(phi), mp.sin(theta) * mp.sin(phi), mp.cos(theta)])

    i, o = vector(theta_i, phi_i), vector(theta_o, phi_o)
    half = i + o
    half /= mp.norm(half)
    theta_h = mp.atan2(mp.sqrt(half[0] ** 2 + half[1] ** 2), half[2])
    phi_h = mp.atan2(half[1], half[0])
    x = mp.cos(phi_h) * i[0] + mp.sin(phi_h) * i[1]
    y = -mp.sin(phi_h) * i[0] + mp.cos(phi_h) * i[1]
    x, z = mp.cos(theta_h) * x - mp.sin(theta_h) * i[2], mp.sin(theta_h) * x + mp.cos(theta_h) * i[2]
    theta_d = mp.atan2(mp.sqrt(x**2 + y**2), z)
    defined = theta_h > 1e-14 and theta_d > 1e-14
    angles = [float(theta_h) if theta_h > 1e-14 else 0.0, float(theta_d) if theta_d > 1e-14 else 0.0]
    return angles + [float(mp.atan2(y, x)) if defined else None]


def directions():
    rng = random.Random(91)
    rows = [
        (0.0, 0.0, 0.0, 0.0), (0.5, 1.0, 0.5, 1.0), (0.7, 0.0, 0.0, 0.0), (0.0, 0.0, 0.7, 2.0), (1.5, 0.3, 1.5, -2.0),
        (1.55, 0.1, 0.02, 3.0), (0.4, 0.2, 1e-6, 0.0), (0.6, 1.0, 0.6000001, 4.0), (1.2, -3.0, 1.3, 3.0), (0.9, 0.5, 0.9, 0.5001),
    ]
    while len(rows) < 50:
        thetas = math.acos(rng.uniform(0.01, 1)), math.acos(rng.uniform(0.01, 1))
        rows.append((thetas[0], rng.uniform(-math.pi, math.pi), thetas[1], rng.uniform(-math.pi, math.pi)))
    return [list(row) + difference_angles(*row) for row in rows]


def samples():
    rows = []
    for position, offset in (("edge", mp.mpf(0)), ("centre", mp.mpf(1) / 2)):
        for h, d, phi in ((0, 0, 0), (1, 0, 0), (0, 5, 90), (30, 40, 50), (60, 10, 179), (80, 20, 100), (89, 89, 17), (45, 60, 90)):
            theta_h = ((h + offset) / 90) ** 2 * mp.pi / 2
            theta_d, phi_d = (d + offset) / 90 * mp.pi / 2, (phi + offset) / 180 * mp.pi
            along, across = mp.cos(theta_h) * mp.cos(theta_d), mp.sin(theta_h) * mp.sin(theta_d) * mp.cos(phi_d)
            values = (theta_h, theta_d, phi_d, along - across, along + across)
            rows.append([position, h, d, phi] + [nearest_double(v) for v in values])
    return rows


def counts(data):
    packed = (data / "tables" / "merl_valid_mask.npy.xz").read_bytes()
    masks = {"genuine mask": (("edge", "centre"), np.load(io.BytesIO(lzma.decompress(packed))))}
    for path in sorted((data / "measured").glob("*.binary.xz")):
        stem = path.name.removesuffix(".binary.xz")
        cells = np.frombuffer(lzma.decompress(path.read_bytes()), "<f8", offset=12).reshape(3, 90, 90, 180)
        masks[stem] = (("centre",), np.all(np.isfinite(cells) & (cells >= 0), axis=0))
    rows = []
    for name, (positions, mask) in masks.items():
        for position in positions:
            cos_i, cos_o = merl.Grid.make(position).cosines()
            usable = mask & (cos_i > merl.HORIZON) & (cos_o > merl.HORIZON)
            panel = mask & (cos_i >= PANEL_COSINE) & (cos_o >= PANEL_COSINE)
            rows.append([name, position, int(mask.sum()), int(usable.sum()), int(panel.sum())])
    return rows


def main():
    rows = []
    for theta_h, theta_d, phi_d in queries():
        row = indices(theta_h, theta_d, phi_d)
        ours = [merl.theta_h_index(theta_h), merl.theta_d_index(theta_d)]
        for bins in (180, 360):
            ours += [merl.phi_d_index(phi_d, bins), merl.flat_index(theta_h, theta_d, phi_d, bins)]
        if ours != row:
            raise ArithmeticError(f"the reader disagrees at {(theta_h, theta_d, phi_d)}: {ours}, {row}")
        rows.append([theta_h, theta_d, phi_d] + row)
    header = {
        "generated_by": f"scripts/make_index.py, mpmath {mp.__version__}",
        "description": "MERL conventions, angles in radians. queries: [theta_h, theta_d, phi_d, i_h, i_d, i_phi and flat index with "
        "180 phi_d bins, i_phi and flat index with 360]; directions: [theta_i, phi_i, theta_o, phi_o, theta_h, theta_d, phi_d or "
        "null]; samples: [position, i_h, i_d, i_phi, theta_h, theta_d, phi_d, cos theta_i, cos theta_o]; counts: [mask, position, "
        "valid, usable (valid, cosines > 1e-9), panel (valid, both angles <= 80 degrees)].",
        "channel_scales": [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0],
    }
    data = merl.data_folder(sys.argv[1] if len(sys.argv) > 1 else None)
    tables = {"queries": rows, "directions": directions(), "samples": samples(), "counts": counts(data)}
    write_fixture("index.json", header, tables)


if __name__ == "__main__":
    main()
