"""The error panel E, L, C and the directional albedo (docs/theory.md, section 6).

Samples: valid cells with theta_i and theta_o up to 80 degrees, each weighted by w = 4 cos theta_d dw_h dw_d, with the
solid angles from the cell's edges.
"""
import math

import numpy as np

PANEL_COSINE = math.cos(math.radians(80.0))
ALBEDO_AZIMUTHS = 360
"""Azimuths of the half vector on the half turn."""


class DirectionalAlbedo:
    """Directional albedo of tabulated values: an integral over the half vector, dw_o = 4 cos theta_d dw_h.

    Nodes: the sample angle of each theta_h row with the solid angle of its bin, 360 azimuths on the half turn (the middle of
    each step); theta_d and phi_d are looked up by floor. Cells without measurement are left out. For samples at the edge this
    is up to 4 % above an integration with the middle of each bin, which moves E as much: it is a convention, recorded as such.
    """

    def __init__(self, grid, valid):
        self._grid, self._valid = grid, valid

    def _nodes(self, theta_i):
        grid = self._grid
        h = grid.theta_h[:, None]
        phi = (np.arange(ALBEDO_AZIMUTHS) + 0.5) / ALBEDO_AZIMUTHS * math.pi
        hx, hz = np.sin(h) * np.cos(phi), np.cos(h)
        ix, iz = math.sin(theta_i), math.cos(theta_i)
        dot = hx * ix + hz * iz
        cos_o = 2 * dot * hz - iz
        x = ix * np.cos(phi) * np.cos(h) - iz * np.sin(h)  # i in the frame of h
        y = -ix * np.sin(phi) + 0 * h
        phi_d = np.arctan2(y, x)
        n_phi = len(grid.phi_d)
        period = grid.phi_d_edges[-1]
        i_phi = np.clip(np.floor(np.mod(phi_d, period) / period * n_phi).astype(int), 0, n_phi - 1)
        i_d = np.clip(np.floor(np.arccos(np.clip(dot, -1, 1)) / (math.pi / 2) * 90).astype(int), 0, 89)
        i_h = np.broadcast_to(np.arange(90)[:, None], i_d.shape)
        weight = np.diff(-np.cos(grid.theta_h_edges))[:, None] * (2 * math.pi / ALBEDO_AZIMUTHS)
        inside = (dot > 0) & (cos_o > 0) & self._valid[i_h, i_d, i_phi]
        return np.where(inside, weight * 4 * dot * cos_o, 0.0), (i_h, i_d, i_phi)

    def __call__(self, f, theta_i):
        """Albedo of f[90, 90, n_phi] (1/sr) at one theta_i in radians."""
        weight, cells = self._nodes(theta_i)
        return float(np.sum(np.where(weight > 0, weight * f[cells], 0.0)))


class Panel:
    """The weights of one grid and validity mask; `errors` compares a model with a measurement on them."""

    def __init__(self, grid, valid):
        cos_i, cos_o = grid.cosines()
        self._keep = valid & (cos_i >= PANEL_COSINE) & (cos_o >= PANEL_COSINE)
        self._cos_i, self._cos_o = cos_i[self._keep], cos_o[self._keep]
        d_theta_h = np.diff(-np.cos(grid.theta_h_edges))[:, None, None]
        d_theta_d = np.diff(-np.cos(grid.theta_d_edges))[None, :, None]
        weight = 4 * np.cos(grid.theta_d)[None, :, None] * d_theta_h * d_theta_d * np.diff(grid.phi_d_edges)[None, None, :]
        self._weight = np.broadcast_to(weight, self._keep.shape)[self._keep]
        self._albedo = DirectionalAlbedo(grid, valid & (cos_i > 1e-9) & (cos_o > 1e-9))

    @property
    def samples(self):
        return int(self._keep.sum())

    def errors(self, measured, model):
        """E, L, C, the albedo that E is divided by and the signed relative differences of the albedo, for one channel's values
        [90, 90, n_phi] in 1/sr."""
        f, g, w = measured[self._keep], model[self._keep], self._weight
        cosines = self._cos_i * self._cos_o
        albedo = max(self._albedo(measured, math.radians(angle)) for angle in range(0, 81, 5))
        e = math.sqrt(np.sum(w * cosines * (g - f) ** 2) / np.sum(w * cosines)) / albedo
        g = np.maximum(g, 0.0)  # a fit without constraints may dip below zero: E sees it, L and C take what a renderer would
        logs = np.log1p(g * self._cos_i) - np.log1p(f * self._cos_i)
        roots = np.cbrt(g * self._cos_i) - np.cbrt(f * self._cos_i)
        total = np.sum(w)
        difference = []
        for angle in (10, 30, 50, 70):
            reference = self._albedo(measured, math.radians(angle))
            difference.append(self._albedo(model, math.radians(angle)) / reference - 1.0)
        return {
            "E": e,
            "L": math.sqrt(np.sum(w * logs**2) / total),
            "C": math.sqrt(np.sum(w * roots**2) / total),
            "albedo": albedo,
            "albedo_difference": difference,
        }
