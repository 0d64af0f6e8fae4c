#!/usr/bin/env python3
"""Read every level of an atlas in OpenEXR by two independent readers, OpenEXR and OpenImageIO, and compare.

    read_atlas_exr.py FILE.exr... [--against FILE.ktx2]

Checks that both readers see the same parts, channels and texels, bit for bit; that level k + 1 is the maximum over 2 x 2 texels
of level k; that every texel is finite and not negative; and that brdfit.range is the range of level 0. With --against, every
texel of the KTX2 file is the one of the EXR file or, where that is in single precision, the smallest half not below it.
Prints one line per file and level; exits with 1 at the first difference.
"""
import argparse
import sys

import numpy as np
import OpenEXR
import OpenImageIO

import ktx2

SIZES = [1024 >> k for k in range(7)]
CHANNELS = (["max"], ["R", "G", "B", "max"])


def by_openexr(path):
    """Name, attributes and texels (rows, columns, channels in the order of CHANNELS) of every part."""
    parts = OpenEXR.File(str(path), separate_channels=True).parts
    channels = max(CHANNELS, key=lambda names: len(set(names) & set(parts[0].channels)))
    for part in parts:
        if sorted(part.channels) != sorted(channels):
            raise ValueError(f"channels {sorted(part.channels)}")
    stacked = (np.stack([part.channels[name].pixels for name in channels], axis=2) for part in parts)
    return [(part.header["name"], part.header, texels) for part, texels in zip(parts, stacked)], channels


def by_openimageio(path, channels):
    """The same as by_openexr."""
    image = OpenImageIO.ImageInput.open(str(path))
    if image is None:
        raise ValueError(OpenImageIO.geterror())
    parts = []
    while image.seek_subimage(len(parts), 0):
        spec = image.spec()
        texels = np.asarray(image.read_image(len(parts), 0, 0, spec.nchannels, spec.format))
        texels = texels.reshape(spec.height, spec.width, spec.nchannels)
        if sorted(spec.channelnames) != sorted(channels):
            raise ValueError(f"OpenImageIO: channels {spec.channelnames}")
        order = [spec.channelnames.index(name) for name in channels]
        parts.append((spec["oiio:subimagename"], spec, texels[:, :, order]))
    image.close()
    return parts


def half_up(values):
    """The smallest half not below each value; halves stay."""
    if values.dtype == np.float16:
        return values
    nearest = values.astype(np.float16)
    return np.where(nearest.astype(np.float32) < values, np.nextafter(nearest, np.float16(np.inf)), nearest)


def require(condition, what):
    if not condition:
        raise ValueError(what)


def same_bits(a, b):
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


def check_level(k, levels, other, texture):
    """Compares level k of both readers, with the level before, and with the texture where there is one."""
    (name, header, texels), (other_name, spec, other_texels) = levels[k], other[k]
    require(name == other_name == f"level{k}", f"names {name} and {other_name}")
    require(texels.shape[:2] == (SIZES[k], SIZES[k]), f"{texels.shape[1]} x {texels.shape[0]} texels")
    require(same_bits(texels, other_texels), "OpenEXR and OpenImageIO differ")
    require(np.isfinite(texels).all() and texels.min() >= 0 and not np.signbit(texels).any(), "a texel is no bandwidth")
    texts = [key for key in header if key.startswith("brdfit.") and isinstance(header[key], str)]
    require("brdfit.units" in texts and "brdfit.layout" in texts, "no attributes")
    for key in texts:
        require(header[key] == spec.getattribute(key), f"{key} differs between the readers")
    if k == 0:
        stored = np.asarray(header["brdfit.range"], np.float32)
        require(np.array_equal(stored, [texels.min(), texels.max()]), f"brdfit.range is {stored}")
    else:
        blocks = levels[k - 1][2].reshape(SIZES[k], 2, SIZES[k], 2, -1)
        require(same_bits(blocks.max(axis=(1, 3)), texels), f"not the maximum of level {k - 1}")
    if texture is not None:
        require(same_bits(half_up(texels), texture[k]), "the KTX2 file differs")


def check_file(path, against):
    levels, channels = by_openexr(path)
    other = by_openimageio(path, channels)
    require(len(levels) == len(other) == len(SIZES), f"{len(levels)} and {len(other)} parts")
    texture, key_values = ktx2.read(against) if against else (None, None)
    if against:
        require(len(texture) == len(SIZES), f"{len(texture)} levels in {against}")
        for key in ("brdfit.layout", "brdfit.mapping", "brdfit.source.name", "brdfit.units"):
            require(key_values[key] == levels[0][1][key], f"{key} of the KTX2 file differs")
    for k in range(len(SIZES)):
        try:
            check_level(k, levels, other, texture)
        except ValueError as error:
            raise ValueError(f"level {k}: {error}") from error
        texels = levels[k][2]
        readers = "OpenEXR = OpenImageIO" + (" = KTX2" if against else "") + ("" if k == 0 else f", maximum of level {k - 1}")
        print(
            f"{path} level {k}: {SIZES[k]} x {SIZES[k]} {'+'.join(channels)} {texels.dtype}, "
            f"{texels.min():g} to {texels.max():g}: {readers}"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("files", nargs="+", metavar="FILE.exr")
    parser.add_argument("--against", metavar="FILE.ktx2")
    options = parser.parse_args()
    for path in options.files:
        try:
            check_file(path, options.against)
        except (ValueError, KeyError) as error:
            print(f"{path}: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
