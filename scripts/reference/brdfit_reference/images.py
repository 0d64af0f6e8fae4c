"""Images and how they are compared (docs/theory.md, "Measuring"): layers of an OpenEXR file, exposure, the sRGB curve, PSNR.

Images are [row, column, colour] in double precision, linear radiance; masks and scalar layers are [row, column].
"""
from dataclasses import dataclass

import numpy as np
import OpenEXR

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@dataclass(frozen=True)
class Layers:
    """The channels of a file by their full names."""

    channels: dict

    @classmethod
    def read(cls, path):
        found = OpenEXR.File(str(path), separate_channels=True).channels()
        return cls({name: np.asarray(channel.pixels, float) for name, channel in found.items()})

    def scalar(self, name):
        """One channel, by its full name: "bandwidth.Y"."""
        return self.channels[name]

    def triple(self, layer=None, components="RGB"):
        """Three channels of a layer, or of none: the radiance."""
        prefix = f"{layer}." if layer else ""
        return np.stack([self.channels[prefix + component] for component in components], axis=2)

    @property
    def foreground(self):
        """The pixels that show a surface; needs the layer `material`."""
        return self.channels["material.Y"] >= 0


def luminance(image):
    return image @ LUMINANCE


def exposure(reference, mask):
    """Factor from radiance to display: min(0.35 / mean, 0.9 / 95th percentile) of the luminance of the masked pixels."""
    values = luminance(reference[mask])
    return min(0.35 / values.mean(), 0.9 / np.percentile(values, 95))


def srgb(linear):
    """The curve of sRGB on values from 0 to 1, limited to them."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def psnr(image, reference, mask):
    """Decibel, exposed by the reference, under the curve of sRGB, mean over the colours of the masked pixels."""
    factor = exposure(reference, mask)
    difference = srgb(factor * image[mask]) - srgb(factor * reference[mask])
    return float(-10 * np.log10(np.mean(difference**2)))

