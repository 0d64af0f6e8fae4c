"""The SGD reflectance model in numpy, with exact Smith shadowing (docs/theory.md, sections 2 and 3).

    f(i, o) = [rho_d + rho_s F(theta_d) D(theta_h) G1(theta_i) G1(theta_o) / (cos theta_i cos theta_o)] / pi

Lambda uses the form without cancellation of section 3,
    Lambda(theta) = (alpha K / pi) e^(-a0) int_0^inf e^(-t) (a0 + t)^(-p) g(sqrt(alpha t) / mu) dt,   g(s) = s - arctan s,
with double-exponential nodes t = exp(x - e^(-x)). Derivatives are taken under the integral. Angles in radians.
Against the mpmath vectors of data-fixtures/sgd.json: G1 within 1e-15, f within 1e-14 (check_reference.py measures it).
"""
import math
from dataclasses import dataclass

import numpy as np

from .gamma import log_upper_gamma

_X = np.arange(-61, 66) / 16.0
_T = np.exp(_X - np.exp(-_X))
_W = _T * (1.0 + np.exp(-_X)) / 16.0 * np.exp(-_T)
_FAR = 700.0  # e^(-a0) beyond this is zero as far as G1 can see


def slope_excess(s):
    """g(s) = s - arctan s, by its series where the difference cancels."""
    small = np.minimum(s, 0.05)
    q = small * small
    series = small * q * (1 / 3 - q * (1 / 5 - q * (1 / 7 - q * (1 / 9 - q * (1 / 11 - q * (1 / 13 - q / 15))))))
    return np.where(s < 0.05, series, s - np.arctan(s))


@dataclass(frozen=True)
class Distribution:
    """The microfacet distribution of one (alpha, p) and what follows from it."""

    alpha: float
    p: float
    log_k: float
    log_k_by_log_alpha: float
    log_k_by_p: float

    @classmethod
    def make(cls, alpha, p):
        """K = 1 / (alpha Gamma(1 - p, alpha)) with its derivatives."""
        log_gamma, by_s = log_upper_gamma(1.0 - p, alpha)
        by_log_alpha = -1.0 + math.exp((1.0 - p) * math.log(alpha) - alpha - log_gamma)
        return cls(alpha, p, -math.log(alpha) - log_gamma, by_log_alpha, by_s)

    @property
    def k(self):
        return math.exp(self.log_k)

    def peak(self):
        """D(0)."""
        return math.exp(self.log_k - self.alpha - self.p * math.log(self.alpha)) / math.pi

    def relative(self, theta_h):
        """D(theta_h) / D(0) and its logarithmic derivatives by ln alpha and by p: three arrays."""
        x = np.tan(theta_h) ** 2
        rise = x / self.alpha
        a = self.alpha + rise
        log_ratio = np.log1p(rise / self.alpha)  # ln(a / alpha)
        value = np.exp(-rise - self.p * log_ratio) / np.cos(theta_h) ** 4
        return value, rise + self.p * 2.0 * rise / a, -log_ratio

    def d(self, theta_h):
        """D(theta_h)."""
        return self.peak() * self.relative(theta_h)[0]

    def smith_lambda(self, theta):
        """Lambda(theta), and its derivatives by ln alpha and by p: three arrays."""
        theta = np.atleast_1d(np.asarray(theta, dtype=float))
        result = np.zeros((3,) + theta.shape)
        mu = np.maximum(np.cos(theta), 0.0) / np.maximum(np.sin(theta), 1e-300)
        horizon = mu < 1e-15
        near = (np.minimum(mu, 1e9) ** 2 / self.alpha + self.alpha < _FAR) & ~horizon
        m = mu[near][:, None]
        a0 = self.alpha + m * m / self.alpha
        s = np.sqrt(self.alpha * _T) / m
        log_a = np.log(a0 + _T)
        factor = np.exp(self.log_k + math.log(self.alpha / math.pi) - a0 - self.p * log_a) * _W
        terms = factor * slope_excess(s)
        value = terms.sum(axis=1)
        a0_slope = self.alpha - m * m / self.alpha  # d a0 / d ln alpha
        by_s = (factor * (0.5 * s * s * s / (1.0 + s * s))).sum(axis=1)
        by_a0 = -a0_slope[:, 0] * (value + (terms * (self.p / (a0 + _T))).sum(axis=1))
        result[0][near] = value
        result[1][near] = value * (1.0 + self.log_k_by_log_alpha) + by_s + by_a0
        result[2][near] = value * self.log_k_by_p - (terms * log_a).sum(axis=1)
        result[0][horizon] = np.inf
        return result

    def g1(self, theta):
        """Smith's G1 = 1 / (1 + Lambda): 1 at normal incidence, 0 at the horizon."""
        return 1.0 / (1.0 + self.smith_lambda(theta)[0])

    def g1_with_derivatives(self, theta):
        """G1 and its derivatives by ln alpha and by p: three arrays."""
        value, by_log_alpha, by_p = self.smith_lambda(theta)
        g1 = 1.0 / (1.0 + value)
        return g1, -g1 * g1 * by_log_alpha, -g1 * g1 * by_p


class MaskingTable:
    """G1 as a function of the cosine for millions of directions: linear interpolation on 40000 nodes, equally spaced in the
    angle up to 80 degrees and in ln cos beyond (down to 1e-10). Error below 1e-7 for every (alpha, p) of the published fits."""

    def __init__(self, distribution):
        cosine = np.unique(np.concatenate([np.cos(np.linspace(0, 1.40, 20000)), np.geomspace(1e-10, math.cos(1.40), 20000)]))
        self._cosine = cosine
        self._g1 = np.concatenate([distribution.g1(part) for part in np.array_split(np.arccos(cosine), 40)])

    def __call__(self, cosine):
        return np.interp(cosine, self._cosine, self._g1)


def fresnel(theta_d, f0, f1):
    """Generalised Schlick term F0 - F1 c + (1 - F0) (1 - c)^5, c = cos theta_d (thesis, equation V.5)."""
    c = np.cos(theta_d)
    return f0 - f1 * c + (1.0 - f0) * (1.0 - c) ** 5


@dataclass(frozen=True)
class Sgd:
    """One channel of the model."""

    rho_d: float
    rho_s: float
    alpha: float
    p: float
    f0: float
    f1: float

    def distribution(self):
        return Distribution.make(self.alpha, self.p)

    def evaluate(self, theta_h, theta_d, phi_d):
        """f in 1/sr for arrays of half/difference angles, exact G1."""
        along = np.cos(theta_h) * np.cos(theta_d)
        across = np.sin(theta_h) * np.sin(theta_d) * np.cos(phi_d)
        cos_i, cos_o = along - across, along + across
        shape = self.distribution()
        masking = shape.g1(np.arccos(cos_i)) * shape.g1(np.arccos(cos_o))
        specular = fresnel(theta_d, self.f0, self.f1) * shape.d(theta_h) * masking / (cos_i * cos_o)
        return (self.rho_d + self.rho_s * specular) / math.pi

    def on_grid(self, grid):
        """f at the samples of a MERL grid, shape [90, 90, n_phi]; zero at and below the horizon."""
        cos_i, cos_o = grid.cosines()
        usable = (cos_i > 1e-9) & (cos_o > 1e-9)
        result = np.zeros(cos_i.shape)
        if self.rho_s != 0.0:
            shape = self.distribution()
            table = MaskingTable(shape)
            factor = shape.d(grid.theta_h)[:, None, None] * fresnel(grid.theta_d, self.f0, self.f1)[None, :, None]
            spread = np.broadcast_to(factor, cos_i.shape)[usable]
            i, o = cos_i[usable], cos_o[usable]
            result[usable] = self.rho_s * spread * table(i) * table(o) / (i * o)
        result[usable] += self.rho_d
        return result / math.pi
