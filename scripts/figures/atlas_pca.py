#!/usr/bin/env python3
"""How well principal components store the tiles of bandwidth atlases: tables of docs/accuracy.md (scripts/figures/atlas_study.sh).

    atlas_pca.py FITTED MEASURED      folders with NAME.atlas.ktx2 in the isotropic layout, or all in the hemisphere layout

A tile is a vector of its texels inside the disc (of the upper half where the lower one mirrors it). Mean and components are
those of the tiles of one material, or of all fitted materials together; of the bandwidths or of their logarithms. Errors per
material, over all texels and with a floor of 0.1 cycles per radian under both: of the texture, rms(reconstruction - value) /
rms(value); in octaves, the rms of log2 of the ratio; and the share of texels that read more than a quarter of an octave too low.
Level 2 stands beside them: one value for 4 x 4 texels, their maximum; and one that is the mean of their logarithms.
"""
import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "validate/atlas"))  # for ktx2

import ktx2

SIZE, TILE, TILES = 1024, 64, 256
COUNTS = (1, 2, 4, 8, 16, 32)
SHARED_COUNTS = (*COUNTS, 64, 128)
FLOOR = 0.1
LOW = -0.25
"""Octaves; below this a texel reads too low."""
BLOCK = 4
"""Texels of level 0 along a side of one of level 2."""


def disc(rows):
    """The texels with their centre inside the disc, in the first `rows` rows of a tile."""
    centre = 2 * (np.arange(TILE) + 0.5) / TILE - 1
    return np.hypot(centre, centre[:rows, None]) <= 1


def read(path):
    """Tiles [tile, row, column] of level 0, of level 2 with every value repeated, of the means beside it; and the layout."""
    levels, key_values = ktx2.read(path)
    fine, coarse = (levels[k][..., -1].astype("f4") for k in (0, 2))
    logarithms = Logarithmic.encode(fine).reshape(256, BLOCK, 256, BLOCK).mean(axis=(1, 3))

    def tiles(image):
        image = image.repeat(SIZE // len(image), 0).repeat(SIZE // len(image), 1)
        return image.reshape(16, TILE, 16, TILE).transpose(0, 2, 1, 3).reshape(TILES, TILE, TILE)

    return tiles(fine), tiles(coarse), tiles(Logarithmic.decode(logarithms).astype("f4")), key_values["brdfit.layout"]


class Material:
    """Tiles of an atlas as vectors."""

    def __init__(self, path):
        tiles, coarse, means, self.layout = read(path)
        self.name = path.name.removesuffix(".atlas.ktx2")
        self.mirrored = self.layout == "isotropic"
        mask = disc(TILE // 2 if self.mirrored else TILE)
        self.tiles, self.coarse, self.means = (image[:, : len(mask)][:, mask] for image in (tiles, coarse, means))


def errors(values, made):
    """Of the texture; in octaves; share of texels that read too low."""
    made, values = np.maximum(made, FLOOR), np.maximum(values, FLOOR)
    octaves = np.log2(made / values)
    texture = np.linalg.norm(made - values) / np.linalg.norm(values)
    return texture, np.sqrt(np.mean(octaves**2)), np.mean(octaves < LOW)


class Linear:
    """Components of the bandwidths."""

    name = "bandwidths"
    encode = staticmethod(lambda values: values.astype(float))
    decode = staticmethod(lambda code: code)


class Logarithmic:
    """Components of their logarithms."""

    name = "logarithms"
    encode = staticmethod(lambda values: np.log2(np.maximum(values.astype(float), FLOOR)))
    decode = staticmethod(np.exp2)


DOMAINS = (Linear, Logarithmic)


def own_basis(domain, values):
    """Mean and components [component, texel] of the tiles of one material."""
    code = domain.encode(values)
    mean = code.mean(axis=0)
    # the tiles are fewer than their texels
    values, vectors = np.linalg.eigh((code - mean) @ (code - mean).T)
    highest = slice(-1, -1 - max(COUNTS), -1)
    scale = np.sqrt(np.maximum(values[highest], values[-1] * 1e-14 + np.finfo(float).tiny))
    return mean, (vectors[:, highest] / scale).T @ (code - mean)


def shared_basis(domain, materials):
    """Mean and components of the tiles of all materials, by the matrix of second moments."""
    total, size = 0.0, materials[0].tiles.shape[1]
    moments = np.zeros((size, size))
    for material in materials:
        code = domain.encode(material.tiles)
        total = total + code.sum(axis=0)
        moments += code.T @ code
    count = sum(len(material.tiles) for material in materials)
    mean = total / count
    _, vectors = np.linalg.eigh(moments / count - np.outer(mean, mean))
    return mean, vectors[:, ::-1].T


def reconstruct(domain, values, mean, components):
    code = domain.encode(values) - mean
    return domain.decode(mean + (code @ components.T) @ components)


def numbers(count, material):
    """Numbers stored: mean, components and coefficients (whole rectangles of texels, half of a tile where it is mirrored)."""
    texels = TILE * TILE // (2 if material.mirrored else 1)
    return (count + 1) * texels + count * TILES


def row(label, stored, found):
    """Median over the materials and the worst one, for each error."""
    cells = []
    for column in zip(*found):
        cells += [f"{np.median(column):.3f}", f"{max(column):.3f}"]
    print(f"| {label} | {stored} | " + " | ".join(cells) + " |", flush=True)


def table(title, materials, bases, counts, memory):
    """One row per domain and number of components. `bases(domain)`: for a material its mean and components."""
    print(f"\n{title}\n")
    print("| components | numbers | texture: median | worst | octaves: median | worst | too low: median | worst |")
    print("|---|---|---|---|---|---|---|---|")
    for domain in DOMAINS:
        found = {count: [] for count in counts}
        for material in materials:
            mean, components = bases(domain)(material)
            for count in counts:
                made = reconstruct(domain, material.tiles, mean, components[:count])
                found[count].append(errors(material.tiles, made))
        for count in counts:
            row(f"{count}, of {domain.name}", memory(count), found[count])
    texels = 65536 // (2 if materials[0].mirrored else 1)
    row("level 2 instead", texels, [errors(material.tiles, material.coarse) for material in materials])
    row("means instead", texels, [errors(material.tiles, material.means) for material in materials])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fitted", type=Path)
    parser.add_argument("measured", type=Path)
    args = parser.parse_args()
    fitted, measured = ([Material(path) for path in sorted(folder.glob("*.atlas.ktx2"))] for folder in (args.fitted, args.measured))
    if not fitted or not measured:
        sys.exit("no atlases in KTX2")
    one = fitted[0]
    print(f"Layout: {one.layout}. {len(fitted)} materials from their published parameters, {len(measured)} measured ones.")

    def own(domain):
        return lambda material: own_basis(domain, material.tiles)

    for what, materials in (("Fitted", fitted), ("Measured", measured)):
        table(f"{what} materials, each with components of its own", materials, own, COUNTS, lambda n: numbers(n, one))
    common = {domain: shared_basis(domain, fitted) for domain in DOMAINS}
    for what, materials in (("Fitted", fitted), ("Measured", measured)):
        table(f"{what} materials, components shared by all fitted ones (numbers: coefficients of one material)", materials,
              lambda domain: lambda material: common[domain], SHARED_COUNTS, lambda n: TILES * n)


if __name__ == "__main__":
    main()
