#!/usr/bin/env python3
"""Lambertian floors under rectangle lights against Lambert's polygon formula.

    rectangle_check.py BRDFIT FOLDER [--spp 4096]

The reflected radiance of a floor of albedo rho under a polygon of radiance L_e is rho L_e / pi times the integral of the cosine over
the polygon's solid angle, which is half the sum over its edges of the angle that an edge subtends times the component along the
floor's normal of the unit normal of its plane; the polygon is first clipped at the horizon. Renders `--mode reference`, takes the
positions of the pixels from the image's own layers, and prints the largest relative difference of means of 32 x 32 pixels.
"""
import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR

BAR = 1e-3
BLOCK = 32
ALBEDO = np.array([0.8, 0.5, 0.2])
RADIANCE = np.array([4.0, 2.0, 1.0])
LIGHTS = {
    "above": ([-0.5, -0.5, 1.0], [[0, 1, 0], [1, 0, 0]]),
    "near": ([-0.4, -0.3, 0.25], [[0, 0.9, 0], [0.8, 0, 0]]),
    "beside": ([-1.5, -0.5, 0.0], [[0, 1, 0], [0, 0, 1]]),
    "through the horizon": ([-0.6, 1.2, -0.4], [[1.2, 0, 0], [0, 0.6, 0.8]]),
    "far": ([-0.5, -0.5, 20.0], [[0, 1, 0], [1, 0, 0]]),
}


def scene(corner, edges, size):
    rect = {"corner": corner, "edges": edges, "radiance": RADIANCE.tolist()}
    return {
        "camera": {"eye": [0, -2.6, 0.9], "target": [0, 0.2, 0], "vertical_fov": 32, "width": size, "height": size},
        "lights": [{"rect": rect}],
        "materials": {"floor": {"source": {"lambert": ALBEDO.tolist()}}},
        "objects": [{"mesh": {"plane": {"size": 60}}, "material": "floor"}],
    }


def clipped(polygon):
    """The part of a polygon above z = 0."""
    kept = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0)):
        if a[2] >= 0:
            kept.append(a)
        if a[2] * b[2] < 0:
            kept.append(a + (b - a) * a[2] / (a[2] - b[2]))
    return np.array(kept)


def cosine_integral(points, polygon):
    """For points of the plane z = 0 that the light faces, (n, 3)."""
    corners = clipped(polygon)[None] - points[:, None]
    a, b = corners, np.roll(corners, -1, axis=1)
    across = np.cross(a, b)
    length = np.linalg.norm(across, axis=2)
    angle = np.arctan2(length, np.sum(a * b, axis=2))
    return np.abs(np.sum(angle * across[..., 2] / length, axis=1)) / 2


def radiance(points, corner, edges):
    corner, (u, v) = np.array(corner, float), np.array(edges, float)
    lit = (points - corner) @ np.cross(u, v) > 0
    polygon = np.array([corner, corner + u, corner + u + v, corner + v])
    factor = np.where(lit, cosine_integral(points, polygon), 0.0) / np.pi
    return factor[:, None] * ALBEDO * RADIANCE


def means(image):
    height, width, channels = image.shape
    return image.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, channels).mean(axis=(1, 3))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("brdfit")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--spp", type=int, default=4096)
    parser.add_argument("--size", type=int, default=64)
    arguments = parser.parse_args()
    worst = 0.0
    for name, (corner, edges) in LIGHTS.items():
        described, rendered = arguments.folder / "floor.json", arguments.folder / "floor.exr"
        described.write_text(json.dumps(scene(corner, edges, arguments.size)), encoding="utf-8")
        options = ["--mode", "reference", "--spp", str(arguments.spp), "--layers", "gbuffer", "--quiet"]
        subprocess.run([arguments.brdfit, "render", described, "-o", rendered, *options], check=True)
        channels = OpenEXR.File(str(rendered), separate_channels=True).channels()

        def layer(names):
            return np.stack([channels[name].pixels for name in names], axis=2).astype(float)

        position, ours = layer(["position.X", "position.Y", "position.Z"]), layer("RGB")
        exact = radiance(position.reshape(-1, 3), corner, edges).reshape(ours.shape)
        surface = np.broadcast_to((channels["material.Y"].pixels >= 0)[..., None], ours.shape).astype(float)
        # blocks that show the floor alone, all of it in front of the light
        whole = (means(surface) == 1) & (means((exact > 0).astype(float)) == 1)
        difference = np.abs(means(ours)[whole] / means(exact)[whole] - 1)
        print(f"{name}: largest difference {difference.max():.1e} over {whole[..., 0].sum()} blocks of 32 x 32")
        worst = max(worst, difference.max())
    sys.exit(7 if worst >= BAR else 0)


if __name__ == "__main__":
    main()
