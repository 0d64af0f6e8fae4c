#!/usr/bin/env python3
"""Denoise an image with Intel Open Image Denoise (PyPI: pyoidn), guided by its layers albedo (R, G, B) and normal (X, Y, Z).

    denoise.py NOISY.exr DENOISED.exr [--threads 2] [--runs 5] [--clean-guides] [--json]

Prints the wall time: the median over the runs of one call (filter set up, executed, waited for), and that of the first
call, which also starts the library. Reading and writing of files is not counted. --clean-guides tells the library that
albedo and normals are free of noise, which ours are: a larger network, slower.
"""
import argparse
import json
import os
import statistics
import time
from importlib.metadata import version

import numpy as np
import OpenEXR


def layer(channels, names):
    """Channels side by side: (rows, columns, 3) in single precision, contiguous."""
    missing = [name for name in names if name not in channels]
    if missing:
        raise SystemExit(f"no channel {', '.join(missing)}; render with the layers albedo and normal")
    return np.stack([np.asarray(channels[name].pixels, np.float32) for name in names], axis=2)


def denoise(radiance, albedo, normal, runs=5, threads=2, clean_guides=False):
    """The denoised image, the seconds of the first call, and the median of the seconds of `runs` more."""
    os.environ["OIDN_NUM_THREADS"] = str(threads)  # read when the library starts
    import pyoidn

    seconds = []
    for _ in range(runs + 1):
        start = time.perf_counter()
        image = pyoidn.denoise(radiance, albedo, normal, hdr=True, clean_aux=clean_guides)
        seconds.append(time.perf_counter() - start)
    return image, seconds[0], statistics.median(seconds[1:] or seconds)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("noisy")
    parser.add_argument("denoised")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--clean-guides", action="store_true")
    parser.add_argument("--json", action="store_true", help="print one line of JSON")
    arguments = parser.parse_args()
    channels = OpenEXR.File(arguments.noisy, separate_channels=True).channels()
    names = ("R", "G", "B"), ("albedo.R", "albedo.G", "albedo.B"), ("normal.X", "normal.Y", "normal.Z")
    radiance, albedo, normal = (layer(channels, components) for components in names)
    image, first, median = denoise(
        radiance, albedo, normal, arguments.runs, arguments.threads, arguments.clean_guides
    )
    planes = {name: np.ascontiguousarray(image[..., c]) for c, name in enumerate("RGB")}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, planes).write(arguments.denoised)
    if arguments.json:
        times = {"seconds": median, "first_seconds": first}
        print(json.dumps({"pyoidn": version("pyoidn"), "threads": arguments.threads, **times}))
    else:
        times = f"{median:.3f} s, median of {arguments.runs}; the first {first:.3f} s"
        print(f"pyoidn {version('pyoidn')}, {arguments.threads} threads: {times}")


if __name__ == "__main__":
    main()
