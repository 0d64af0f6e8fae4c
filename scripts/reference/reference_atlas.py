#!/usr/bin/env python3
"""Bandwidth atlas of a material by numpy and PyWavelets: the definition, shared with nothing in the program.

    reference_atlas.py NAME|FIT.json|FILE.binary (--all | --tiles 0,100,255) -o OUT.npz [--max-resolution 256]

NAME is one of the published materials. The .npz holds `tiles`, `theta_i`, `map` [tile, 64, 64] (cycles per radian, the
maximum over the channels), `channels` [tile, 3, 64, 64], `resolution`, `finest_share`, `saturated` and `seconds` per tile, and
`setup_seconds` (0 with --jobs). Row 0 of a tile is v = -1. Needs scripts/requirements.txt.
"""
import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

import numpy as np

from brdfit_reference.lobes import SIZES, TILES, FittedLobes, MeasuredLobes, isotropic_angle, lobe_bandwidth
from brdfit_reference.merl import Merl, data_folder


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", metavar="NAME|FIT.json|FILE.binary")
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--tiles", type=lambda text: [int(tile) for tile in text.split(",")], metavar="T,T,..")
    which.add_argument("--all", action="store_const", dest="tiles", const=list(range(TILES)))
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="OUT.npz")
    parser.add_argument("--layout", choices=("isotropic",), default="isotropic")
    parser.add_argument("--sample-position", choices=("edge", "centre"), default="edge")
    parser.add_argument("--max-resolution", type=int, choices=SIZES, default=SIZES[-1])
    parser.add_argument("--data", metavar="DATA", help="folder with tables/sgd_published.json")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="tiles at the same time")
    return parser.parse_args()


def published_channels(entry):
    """The three channels of an entry of the published table."""
    return [
        {**{name: entry[name][c] for name in ("rho_d", "rho_s", "alpha", "p")}, "f0": entry["F0"][c], "f1": entry["F1"][c]}
        for c in range(3)
    ]


def open_lobes(name, sample_position, data):
    """The lobes of a measured file, of a result document or of a published material."""
    suffix = Path(name).suffix
    if suffix == ".binary":
        return MeasuredLobes(Merl.read(name), sample_position)
    if suffix == ".json":
        document = json.loads(Path(name).read_text(encoding="utf-8"))
        return FittedLobes.from_parameters([channel["parameters"] for channel in document["channels"]])
    table = json.loads((data_folder(data) / "tables" / "sgd_published.json").read_text(encoding="utf-8"))
    if name not in table:
        sys.exit(f"{name}: neither .binary nor .json, and no published material of this name")
    return FittedLobes.from_parameters(published_channels(table[name]))


LOBES = None
"""The material of this process, set once."""


def set_lobes(*material):
    global LOBES
    LOBES = open_lobes(*material)


def make_tile(tile, sizes):
    start = time.perf_counter()
    result = lobe_bandwidth(LOBES, isotropic_angle(tile), sizes)
    return result, time.perf_counter() - start


def main():
    args = arguments()
    start = time.perf_counter()
    material = (args.input, args.sample_position, args.data)
    sizes = [n for n in SIZES if n <= args.max_resolution]
    if args.jobs > 1:
        setup = 0.0
        with ProcessPoolExecutor(args.jobs, initializer=set_lobes, initargs=material) as pool:
            results = list(pool.map(make_tile, args.tiles, repeat(sizes), chunksize=4))
    else:
        set_lobes(*material)
        setup = time.perf_counter() - start
        results = [make_tile(tile, sizes) for tile in args.tiles]
    total = time.perf_counter() - start
    made = [result for result, _ in results]
    np.savez_compressed(
        args.output,
        tiles=args.tiles,
        theta_i=[isotropic_angle(tile) for tile in args.tiles],
        map=[result.tile for result in made],
        channels=[result.channels for result in made],
        resolution=[result.resolution for result in made],
        finest_share=[result.finest_share for result in made],
        saturated=[result.saturated for result in made],
        seconds=[seconds for _, seconds in results],
        setup_seconds=setup,
    )
    counts = {n: sum(result.resolution == n for result in made) for n in SIZES}
    saturated = sum(result.saturated for result in made)
    print(f"{args.input}: {len(made)} tiles in {total:.2f} s, setup {setup:.2f} s; {counts}, saturated {saturated}")


if __name__ == "__main__":
    main()
