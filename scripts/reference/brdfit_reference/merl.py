"""Reader of the MERL container, written from its description alone (docs/theory.md, section 1).

A file is three little-endian i32 dimensions (90, 90, 180 or 360) and three planes (R, G, B) of f64, each indexed
phi_d + n_phi (theta_d + 90 theta_h). BRDF values are in 1/sr after the channel scales. A cell is valid where all three
planes are finite and not negative.
"""
import hashlib
import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

N_THETA_H = 90
N_THETA_D = 90
HALF_PI = math.pi / 2
CHANNEL_SCALES = np.array([1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0])
HORIZON = 1e-9
"""A cell with either cosine at or below this is never used."""


def data_folder(given=None):
    """The folder of the test data: the argument, $BRDFIT_DATA, or ../shared/data beside the repository."""
    if given:
        return Path(given)
    if os.environ.get("BRDFIT_DATA"):
        return Path(os.environ["BRDFIT_DATA"])
    return Path(__file__).resolve().parents[4] / "shared" / "data"


def theta_h_index(theta_h):
    """Index along theta_h: floor(90 sqrt(theta_h / (pi/2))), clamped."""
    return min(max(math.floor(N_THETA_H * math.sqrt(max(theta_h, 0.0) / HALF_PI)), 0), N_THETA_H - 1)


def theta_d_index(theta_d):
    """Index along theta_d: floor(90 theta_d / (pi/2)), clamped."""
    return min(max(math.floor(N_THETA_D * theta_d / HALF_PI), 0), N_THETA_D - 1)


def phi_d_index(phi_d, n_phi=180):
    """Index along phi_d. 180 bins: phi_d is folded into [0, pi) (reciprocity); 360 bins: into [0, 2 pi), not folded."""
    period = math.pi if n_phi == 180 else 2 * math.pi
    while phi_d < 0.0:
        phi_d += period
    while phi_d > period:
        phi_d -= period
    return min(max(math.floor(n_phi * phi_d / period), 0), n_phi - 1)


def flat_index(theta_h, theta_d, phi_d, n_phi=180):
    """Position in a plane."""
    row = theta_d_index(theta_d) + N_THETA_D * theta_h_index(theta_h)
    return phi_d_index(phi_d, n_phi) + n_phi * row


@dataclass(frozen=True)
class Grid:
    """Sample angles and bin edges along the three axes, in radians."""

    theta_h: np.ndarray
    theta_d: np.ndarray
    phi_d: np.ndarray
    theta_h_edges: np.ndarray
    theta_d_edges: np.ndarray
    phi_d_edges: np.ndarray

    @classmethod
    def make(cls, sample_position, n_phi=180):
        """`sample_position`: "edge" (the lower edge of each cell) or "centre" (the middle of its index range)."""
        offset = {"edge": 0.0, "centre": 0.5}[sample_position]
        period = math.pi if n_phi == 180 else 2 * math.pi

        def axes(shift, last):
            return (
                ((np.arange(N_THETA_H + last) + shift) / N_THETA_H) ** 2 * HALF_PI,
                (np.arange(N_THETA_D + last) + shift) / N_THETA_D * HALF_PI,
                (np.arange(n_phi + last) + shift) / n_phi * period,
            )

        return cls(*axes(offset, 0), *axes(0.0, 1))

    def cosines(self, rows_h=slice(None), rows_d=slice(None)):
        """cos theta_i, cos theta_o of the samples of some rows (all by default), shape [theta_h rows, theta_d rows, n_phi]."""
        h, d, phi = np.meshgrid(self.theta_h[rows_h], self.theta_d[rows_d], self.phi_d, indexing="ij")
        along = np.cos(h) * np.cos(d)
        across = np.sin(h) * np.sin(d) * np.cos(phi)
        return along - across, along + across

    def usable(self, rows_h=slice(None), rows_d=slice(None)):
        """Both cosines above the horizon's tolerance."""
        cos_i, cos_o = self.cosines(rows_h, rows_d)
        return (cos_i > HORIZON) & (cos_o > HORIZON)


@dataclass(frozen=True)
class Merl:
    """A MERL file in memory: f[channel, theta_h, theta_d, phi_d] in 1/sr and the mask of valid cells."""

    name: str
    sha256: str
    f: np.ndarray
    valid: np.ndarray

    @property
    def n_phi(self):
        return self.f.shape[3]

    @classmethod
    def read(cls, path):
        data = Path(path).read_bytes()
        dimensions = tuple(int(n) for n in np.frombuffer(data, "<i4", 3))
        if dimensions[:2] != (N_THETA_H, N_THETA_D) or dimensions[2] not in (180, 360):
            raise ValueError(f"{path}: dimensions {dimensions}, expected (90, 90, 180) or (90, 90, 360)")
        cells = math.prod(dimensions)
        if len(data) != 12 + 3 * 8 * cells:
            raise ValueError(f"{path}: {len(data)} bytes, expected {12 + 24 * cells}")
        stored = np.frombuffer(data, "<f8", 3 * cells, 12).reshape(3, *dimensions)
        valid = np.all(np.isfinite(stored) & (stored >= 0.0), axis=0)
        with np.errstate(invalid="ignore"):
            f = stored * CHANNEL_SCALES[:, None, None, None]
        return cls(Path(path).stem, hashlib.sha256(data).hexdigest(), f, valid)
