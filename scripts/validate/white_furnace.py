#!/usr/bin/env python3
"""Spheres under a light of radiance 1 from everywhere against the directional albedo by quadrature.

    white_furnace.py BRDFIT MATERIALS [--names NAME...] [--spp 1024]

MATERIALS: folder of published_fits.py. The radiance of such a sphere is the albedo at the angle theta_o of the view; both are
averaged over rings of theta_o. The quadrature (make_albedo.py, exact Smith G1) knows nothing of the renderer. Prints the
largest difference of each ring over the colours; ends with 7 where one is above the bar.
"""
import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "fixtures"))  # for make_albedo

from brdfit_reference.images import Layers
from brdfit_reference.sgd import Sgd
from make_albedo import specular_over_h

NAMES = ("gold-metallic-paint", "blue-rubber", "nickel")
RINGS = (0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85)
"""Limits in degrees."""
ANGLES = np.arange(0, 88, 2.5)
NODES = 16
BAR = 0.005


def scene(fit):
    return {
        "camera": {"eye": [4.2, 0, 0.6], "target": [0, 0, 0], "vertical_fov": 31, "width": 256, "height": 256},
        "light": {"procedural": {"kind": "uniform"}},
        "materials": {"surface": {"source": {"fit": str(fit)}}},
        "objects": [{"mesh": {"sphere": {}}, "material": "surface"}],
    }


def render(brdfit, fit, spp):
    """The image of a sphere and cos theta_o of its pixels."""
    with tempfile.TemporaryDirectory() as work:
        Path(work, "scene.json").write_text(json.dumps(scene(fit)), encoding="utf-8")
        subprocess.run([brdfit, "render", f"{work}/scene.json", "-o", f"{work}/image.exr", "--mode", "reference", "--spp", str(spp),
                        "--layers", "gbuffer", "--background", "black", "--threads", "2", "--quiet"], check=True)
        layers = Layers.read(f"{work}/image.exr")
    cosine = (layers.triple("normal", "XYZ") * layers.triple("view", "XYZ")).sum(axis=2)
    return layers.triple()[layers.foreground], cosine[layers.foreground]


def albedo(fit):
    """The directional albedo of R, G, B as a function of theta_o in radians, by reciprocity of theta_i."""
    channels = [Sgd(**channel["parameters"]) for channel in json.loads(fit.read_text(encoding="utf-8"))["channels"]]
    values = [[model.rho_d + specular_over_h(model, math.radians(angle), NODES) for model in channels] for angle in ANGLES]
    return CubicSpline(np.radians(ANGLES), values)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("brdfit")
    parser.add_argument("materials", type=Path)
    parser.add_argument("--names", nargs="+", default=NAMES)
    parser.add_argument("--spp", type=int, default=1024)
    args = parser.parse_args()
    print(f"Image over albedo, minus 1, in percent, the colour that differs most; {args.spp} samples per pixel.\n")
    print("| material | " + " | ".join(f"{low} to {high}°" for low, high in zip(RINGS, RINGS[1:])) + " |")
    print("|---|" + "---:|" * (len(RINGS) - 1))
    worst = 0.0
    for name in args.names:
        fit = (args.materials / f"{name}.json").resolve()
        image, cosine = render(args.brdfit, fit, args.spp)
        theta = np.arccos(np.clip(cosine, -1, 1))
        ring = np.digitize(np.degrees(theta), RINGS) - 1
        expected = albedo(fit)(np.minimum(theta, np.radians(ANGLES[-1])))
        ratios = [image[ring == k].mean(axis=0) / expected[ring == k].mean(axis=0) - 1 for k in range(len(RINGS) - 1)]
        largest = [ratio[np.abs(ratio).argmax()] for ratio in ratios]
        worst = max(worst, *map(abs, largest))
        print(f"| {name} | " + " | ".join(f"{100 * value:+.3f}" for value in largest) + " |", flush=True)
    print(f"\nLargest difference {100 * worst:.3f} % (at most {100 * BAR:.1f} %).")
    sys.exit(0 if worst <= BAR else 7)


if __name__ == "__main__":
    main()
