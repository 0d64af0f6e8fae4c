"""The upper incomplete gamma function for any real s by composite Gauss-Legendre quadrature.

Gamma(s, x) = x^s e^(-x) int_0^inf exp(s u - x (e^u - 1)) du     (t = x e^u in the definition)

The integrand is entire and falls double-exponentially, so a fixed rule on [0, ln(1 + (90 + 4 |s|)/x)] converges for s <= 0
exactly as for s > 0, and the derivative by s is a moment of the same samples. Against the mpmath vectors of
data-fixtures/gamma.json: 1.5e-14 relative at worst, 1e-16 typically (check_reference.py measures it).
"""
import math

import numpy as np

_PANELS = 14
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_UNIT = ((np.arange(_PANELS)[:, None] + (_NODES + 1) / 2) / _PANELS).ravel()
_UNIT_WEIGHTS = np.tile(_WEIGHTS / 2 / _PANELS, _PANELS)


def log_upper_gamma(s, x):
    """ln Gamma(s, x) and its derivative by s, for scalars s and x > 0."""
    end = math.log1p((90.0 + 4.0 * abs(s)) / x)
    u = end * _UNIT
    exponent = s * u - x * np.expm1(u)
    largest = float(exponent.max())
    terms = _UNIT_WEIGHTS * np.exp(exponent - largest)
    total = float(terms.sum())
    value = s * math.log(x) - x + largest + math.log(end * total)
    return value, math.log(x) + float((terms * u).sum()) / total
