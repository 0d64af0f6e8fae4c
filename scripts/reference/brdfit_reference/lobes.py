"""Outgoing lobes f(i, .) of fitted and measured materials as images, and their bandwidth in cycles per radian.

The hemisphere is drawn by the angular map: theta = min(r pi/2, arccos 0.02), phi = atan2(v, u), texel (row, column) of
n x n at u = 2 (column + 1/2)/n - 1, v = 2 (row + 1/2)/n - 1. The light lies at phi = 0, so the image does not change when
its rows are reversed: the upper half is computed, and two of the four reflections are transformed.
"""
import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates

from .bandwidth import CALIBRATION, cycles_per_pixel, energies
from .merl import HALF_PI, HORIZON, Grid, Merl
from .sgd import MaskingTable, Sgd, fresnel

TILE = 64
TILES = 256
SIZES = (256, 512, 1024)
FINEST_SHARE = 0.0005
"""More than this in the finest level, in any channel: the next size."""
RIM_COSINE = 0.02


@dataclass(frozen=True)
class AngularMap:
    """The upper half (v < 0) of the map of n x n texels: directions [row, column]; cycles per radian by cycles per pixel."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    scale: np.ndarray

    @classmethod
    @lru_cache
    def make(cls, n):
        centres = 2 * (np.arange(n) + 0.5) / n - 1
        u, v = np.meshgrid(centres, centres[: n // 2])
        r = np.hypot(u, v)
        theta = np.minimum(r * HALF_PI, math.acos(RIM_COSINE))
        inside = np.minimum(r, 1.0)
        across = np.sin(inside * HALF_PI) / inside
        sine = np.sin(theta)
        return cls(sine * u / r, sine * v / r, np.cos(theta), n / 2 / np.sqrt(HALF_PI * across))


def isotropic_angle(tile):
    """theta_i of a tile of the isotropic layout."""
    return (tile + 0.5) / TILES * HALF_PI


def half_difference(theta_i, outgoing):
    """theta_h, theta_d and phi_d folded into [0, pi/2] for the light at (theta_i, phi = 0) and a map of directions."""
    sin_i, cos_i = math.sin(theta_i), math.cos(theta_i)
    x, y, z = sin_i + outgoing.x, outgoing.y, cos_i + outgoing.z
    length, flat = np.sqrt(x * x + y * y + z * z), np.hypot(x, y)
    cos_h, sin_h = z / length, flat / length
    # The components of i along h, in the plane of h and n, and across it.
    along = (sin_i * x + cos_i * z) / length
    radial = sin_i * x / flat * cos_h - cos_i * sin_h
    lateral = sin_i * y / flat
    return np.arctan2(flat, z), np.arctan2(np.hypot(radial, lateral), along), np.arctan2(np.abs(lateral), np.abs(radial))


class FittedLobes:
    """Lobes of the SGD model, exact G1 by table."""

    def __init__(self, channels):
        self._channels = channels
        self._shapes = [channel.distribution() for channel in channels]
        self._masking = [MaskingTable(shape) for shape in self._shapes]
        self._outgoing_factors = lru_cache(self._make_outgoing_factors)

    @classmethod
    def from_parameters(cls, channels):
        """`channels`: for each a mapping with rho_d, rho_s, alpha, p, f0, f1."""
        return cls([Sgd(**{name: float(channel[name]) for name in Sgd.__annotations__}) for channel in channels])

    def _make_outgoing_factors(self, n):
        z = AngularMap.make(n).z
        return [table(z) / z for table in self._masking]

    def half_image(self, theta_i, n):
        """f in 1/sr over the upper half of the map, [channel, n/2, n]."""
        theta_h, theta_d, _ = half_difference(theta_i, AngularMap.make(n))
        cos_i = math.cos(theta_i)
        lobes = []
        for model, shape, outgoing in zip(self._channels, self._shapes, self._outgoing_factors(n)):
            incident = float(shape.g1(theta_i)[0]) / cos_i
            specular = fresnel(theta_d, model.f0, model.f1) * shape.d(theta_h) * outgoing * incident
            lobes.append((model.rho_d + model.rho_s * specular) / math.pi)
        return np.array(lobes)


class MeasuredLobes:
    """Lobes of a MERL file: linear between samples along theta_h^(1/2), theta_d and phi_d, held at the ends.

    phi_d and pi - phi_d are the same by reciprocity and mirror symmetry: means of the valid ones of both. What then has no
    valid sample above the horizon takes the nearest one that has.
    """

    def __init__(self, merl: Merl, sample_position):
        if merl.n_phi != 180:
            raise ValueError(f"{merl.name}: {merl.n_phi} bins of phi_d; only reciprocal files (180) are folded here")
        self._offset = {"edge": 0.0, "centre": 0.5}[sample_position]
        grid = Grid.make(sample_position)
        usable = merl.valid & grid.usable()
        phi = np.arange(91 if sample_position == "edge" else 90)
        partner = (180 - phi) % 180 if sample_position == "edge" else 179 - phi
        first, second = usable[..., phi], usable[..., partner]
        total = np.where(first, merl.f[..., phi], 0.0) + np.where(second, merl.f[..., partner], 0.0)
        count = first.astype(int) + second
        nearest = distance_transform_edt(count == 0, sampling=(1, 1.01, 1.02), return_distances=False, return_indices=True)
        self._table = (total / np.maximum(count, 1))[:, *nearest]

    def half_image(self, theta_i, n):
        """f in 1/sr over the upper half of the map, [channel, n/2, n]."""
        theta_h, theta_d, phi_d = half_difference(theta_i, AngularMap.make(n))
        position = np.array([90 * np.sqrt(theta_h / HALF_PI), 90 * theta_d / HALF_PI, 180 * phi_d / math.pi]) - self._offset
        return np.array([map_coordinates(values, position, order=1, mode="nearest") for values in self._table])


@dataclass(frozen=True)
class LobeBandwidth:
    """The bandwidth of a lobe in cycles per radian, per channel and reduced to TILE x TILE texels by the maximum."""

    channels: np.ndarray
    resolution: int
    finest_share: float

    @property
    def saturated(self):
        return self.finest_share > FINEST_SHARE

    @property
    def tile(self):
        """The maximum over the channels."""
        return self.channels.max(axis=0)


def lobe_energies(lobes, theta_i, n):
    """Energies of the bands of a lobe drawn with n x n texels, [channel] first."""
    half = lobes.half_image(theta_i, n)
    return energies(np.concatenate([half, half[:, ::-1]], axis=1), "symmetric", "mirror")


def half_bandwidth(found):
    """Cycles per radian over the upper half of the map, [channel, n/2, n]."""
    n = found.shape[0]
    scale = AngularMap.make(n).scale
    channels = range(len(found.approximation))
    return np.array([cycles_per_pixel(found.channel(c), CALIBRATION["mirror"], n // 2) * scale for c in channels])


def reduce_to_tile(half):
    """The upper half of a map to a whole tile by the maximum over blocks: [.., n/2, n] -> [.., TILE, TILE]."""
    block = half.shape[-1] // TILE
    upper = half.reshape(*half.shape[:-2], TILE // 2, block, TILE, block).max(axis=(-3, -1))
    return np.concatenate([upper, upper[..., ::-1, :]], axis=-2)


def lobe_bandwidth(lobes, theta_i, sizes=SIZES):
    """The tile of one incident angle, at the first of `sizes` whose finest level holds at most FINEST_SHARE, or the last."""
    for n in sizes:
        found = lobe_energies(lobes, theta_i, n)
        share = float(found.finest_share().max())
        if share <= FINEST_SHARE:
            break
    return LobeBandwidth(reduce_to_tile(half_bandwidth(found)), n, share)
