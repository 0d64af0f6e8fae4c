"""The two slices that the fit uses (docs/theory.md, section 4): means over the valid phi_d cells of a row."""
from dataclasses import dataclass

import numpy as np

from .merl import Grid, Merl


@dataclass(frozen=True)
class Slice:
    """One slice: sample angles (radians), bin edges, and the mean per channel (1/sr), NaN where no cell is valid."""

    angles: np.ndarray
    edges: np.ndarray
    mean: np.ndarray  # [3, 90]

    def rows(self, cutoff):
        """Indices of the rows that hold data and whose sample angle is at most `cutoff` degrees."""
        return np.flatnonzero(np.isfinite(self.mean[0]) & (self.angles <= np.radians(cutoff)))


def _row_means(values, mask):
    """Mean over the last axis where `mask` holds: values [3, 90, n], mask [90, n]."""
    count = mask.sum(axis=1)
    total = np.where(mask, values, 0.0).sum(axis=2)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def theta_h_slice(merl: Merl, grid: Grid):
    """m_h: the cells with theta_d index 0, where i = o = h (nearly, for samples at the centre)."""
    mask = merl.valid[:, 0, :] & grid.usable(rows_d=slice(0, 1))[:, 0]
    return Slice(grid.theta_h, grid.theta_h_edges, _row_means(merl.f[:, :, 0, :], mask))


def theta_d_slice(merl: Merl, grid: Grid):
    """m_d: the cells with theta_h index 0, the mirror configuration."""
    mask = merl.valid[0] & grid.usable(rows_h=slice(0, 1))[0]
    return Slice(grid.theta_d, grid.theta_d_edges, _row_means(merl.f[:, 0], mask))
