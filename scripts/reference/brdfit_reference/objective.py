"""The residuals of both steps of the fit and their derivatives (docs/theory.md, section 4).

Step 1: unknowns x = (ln rho_d, ln peak, ln alpha, p) with peak = Fr D(0), model
    y(theta_h) = [rho_d + peak (D(theta_h)/D(0)) G1(theta_h)^2 / cos^2 theta_h] / pi.
Step 2: linear in u = rho_s (F0, F1, 1), model
    y(theta_d) = rho_d/pi + q(theta_d) B(theta_d) u,   q = A G1(theta_d)^2 / (pi cos^2 theta_d),
with the basis B = (1 - (1-c)^5, -c, (1-c)^5), c = cos theta_d. Costs are half the sum of the squared residuals.
"""
import math
from dataclasses import dataclass

import numpy as np

from .sgd import Distribution

LOSSES = ("log1p-cos", "sqrt-cos", "l2")
CONSTRAINTS = ("physical", "non-negative", "free", "paper")
LOWER = np.array([math.log(1e-6), math.log(1e-6), math.log(1e-6), 0.0])
UPPER = np.array([math.log(10.0), math.log(1e7), 0.0, 2.0])
START_SHAPES = ((1e-4, 0.4), (3e-3, 0.4), (0.1, 0.4), (0.9, 0.1), (1e-5, 0.4))
SMALLEST_START = 1e-5
NO_SPECULAR = 1e-12
"""Below this rho_s is written as zero, with F0 and F1."""


def theta_h_model(x, theta_h):
    """y of step 1 (1/sr) at angles theta_h, and its derivatives by x: arrays [n] and [n, 4]."""
    rho_d, peak, alpha = math.exp(x[0]), math.exp(x[1]), math.exp(x[2])
    shape = Distribution.make(alpha, float(x[3]))
    ratio, ratio_by_alpha, ratio_by_p = shape.relative(theta_h)
    g1, g1_by_alpha, g1_by_p = shape.g1_with_derivatives(theta_h)
    specular = peak * ratio * (g1 / np.cos(theta_h)) ** 2 / math.pi
    by_alpha = specular * (ratio_by_alpha + 2.0 * g1_by_alpha / g1)
    by_p = specular * (ratio_by_p + 2.0 * g1_by_p / g1)
    slope = np.column_stack([np.full(len(theta_h), rho_d / math.pi), specular, by_alpha, by_p])
    return rho_d / math.pi + specular, slope


class StepOne:
    """The bounded least-squares problem of step 1 for one channel."""

    lower, upper = LOWER, UPPER

    def __init__(self, theta_h, edges_cosine, measured, loss):
        """Rows: sample angles, w_i = cos e_i - cos e_(i+1), the measured mean in 1/sr; `loss`: one of LOSSES."""
        self.theta_h, self.measured, self.loss = theta_h, measured, loss
        self._cosine = np.cos(theta_h)
        self._weight = edges_cosine ** (0.375 if loss == "log1p-cos" else 0.5)
        self._target = self._transform(measured)[0]
        self._memory = (None, None, None)

    def _transform(self, f):
        """T(f) and T'(f)."""
        if self.loss == "log1p-cos":
            return np.log1p(f * self._cosine), self._cosine / (1.0 + f * self._cosine)
        if self.loss == "sqrt-cos":
            root = np.sqrt(f * self._cosine)
            return root, 0.5 * self._cosine / np.maximum(root, 1e-150)
        return f, np.ones_like(f)

    def _evaluate(self, x):
        key = np.asarray(x, dtype=float).tobytes()
        if self._memory[0] != key:
            model, slope = theta_h_model(x, self.theta_h)
            value, factor = self._transform(model)
            self._memory = (key, self._weight * (self._target - value), -(self._weight * factor)[:, None] * slope)
        return self._memory

    def residuals(self, x):
        """w^e (T(m) - T(y))."""
        return self._evaluate(x)[1]

    def jacobian(self, x):
        """Derivatives of the residuals by x."""
        return self._evaluate(x)[2]

    def cost(self, x):
        r = self.residuals(x)
        return 0.5 * float(r @ r)

    def starts(self):
        """The four default starting points."""
        rho_d = max(math.pi * float(np.quantile(self.measured, 0.1)), SMALLEST_START)
        peak = max(math.pi * float(self.measured.max()) - rho_d, SMALLEST_START)
        points = [np.array([math.log(rho_d), math.log(peak), math.log(alpha), p]) for alpha, p in START_SHAPES]
        return [np.clip(point, self.lower, self.upper) for point in points]


def anchor(rho_d, peak, shape, first, anchored):
    """A of step 2: (pi m_h[0] - rho_d)/Fr so that rho_s F(0) = Fr, at least D(0)/2; D(0) without an excess or unanchored."""
    d0 = shape.peak()
    excess = math.pi * first - rho_d
    if not anchored or excess <= 0.0:
        return d0
    return max(excess / (peak / d0), d0 / 2.0)


def fresnel_basis(theta_d):
    """B(theta_d), shape [n, 3]: rho_s F = B u."""
    c = np.cos(theta_d)
    fifth = (1.0 - c) ** 5
    return np.column_stack([1.0 - fifth, -c, fifth])


def cone(constraint):
    """Rows g of the linear constraints g u >= 0, shape [m, 3] (m = 0 for `free` and `paper`)."""
    if constraint in ("free", "paper"):
        return np.zeros((0, 3))
    degrees = np.radians(np.arange(0, 91, 3))
    basis = fresnel_basis(degrees)
    basis[-1] = (0.0, 0.0, 1.0)  # at 90 degrees F = 1: what remains is rho_s >= 0
    if constraint == "non-negative":
        return basis
    return np.vstack([basis, np.array([0.0, 0.0, 1.0]) - basis[:-1]])


@dataclass(frozen=True)
class StepTwo:
    """The linear least-squares problem of step 2: minimise |matrix u - target|^2 / 2 subject to constraints @ u >= 0."""

    matrix: np.ndarray
    target: np.ndarray
    constraints: np.ndarray

    @classmethod
    def make(cls, theta_d, measured, rho_d, shape, anchor_value, constraint, loss):
        """Rows: sample angles and the measured mean in 1/sr; rho_d, shape and anchor from step 1."""
        q = anchor_value * (shape.g1(theta_d) / np.cos(theta_d)) ** 2 / math.pi
        if loss == "l2":
            weight = np.ones_like(measured)
        else:
            c = np.cos(theta_d)
            weight = c / np.maximum(measured * c, 1e-6) ** (2.0 / 3.0)
        matrix = (weight * q)[:, None] * fresnel_basis(theta_d)
        return cls(matrix, weight * (measured - rho_d / math.pi), cone(constraint))

    def cost(self, u):
        r = self.matrix @ u - self.target
        return 0.5 * float(r @ r)
