#!/usr/bin/env python3
"""Make data-fixtures/gamma.json: the upper incomplete gamma function Gamma(s, x) by mpmath.

The function normalises the SGD slope density, K = 1 / (alpha Gamma(1 - p, alpha)) (docs/theory.md, section 2), where
s = 1 - p may be zero or negative: the region that common libraries leave out.

Method: mpmath.gammainc with 110 digits; d/ds ln Gamma(s, x) by a central difference with a step of 1e-25 (its truncation
error is about 1e-50 relative). Every 20th row, and every row whose s is near a pole, is checked against a direct
integration of t^(s-1) e^(-t) and of its derivative by s, which share nothing with mpmath's series. Runs in a few minutes.
"""
import random

import mpmath as mp

from oracle_json import nearest_double, write_fixture

mp.mp.dps = 110
STEP = mp.mpf(10) ** -25


def upper_gamma(s, x):
    """Gamma(s, x) and d/ds ln Gamma(s, x) for exact doubles s, x."""
    s, x = mp.mpf(s), mp.mpf(x)
    value = mp.gammainc(s, x)
    slope = (mp.gammainc(s + STEP, x) - mp.gammainc(s - STEP, x)) / (2 * STEP)
    return value, slope / value


def by_integration(s, x):
    """The same two numbers by quadrature over u = ln(t / x), where the integrand is x^s exp(s u - x e^u)."""
    with mp.workdps(40):
        s, x = mp.mpf(s), mp.mpf(x)
        end = mp.log(mp.mpf(200) / x + 2)
        cuts = mp.linspace(0, end, 2 + int(end))
        value = mp.quad(lambda u: mp.exp(s * u - x * mp.expm1(u)), cuts)
        moment = mp.quad(lambda u: u * mp.exp(s * u - x * mp.expm1(u)), cuts)
        return value * x**s * mp.exp(-x), mp.log(x) + moment / value


def inputs():
    """The list of (s, x), fixed by the seed."""
    rng = random.Random(20120)

    def log_uniform(low, high):
        return float(mp.mpf(10) ** (mp.log10(low) + (mp.log10(high) - mp.log10(low)) * rng.random()))

    pairs = [(rng.uniform(-3, 1.5), log_uniform(1e-12, 50)) for _ in range(820)]
    for pole in (-2.0, -1.0, 0.0, 1.0, 0.5, -0.5):
        for offset in (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3):
            for sign in (1, -1) if offset else (1,):
                for x in (1e-12, 1e-5, 0.03, 0.7, 1.6):
                    pairs.append((pole + sign * offset, x * (1 + 0.3 * rng.random())))
    for x in (1 - 2.0**-53, 1.0, 1 + 2.0**-52, 0.999, 1.001, 0.9, 1.1, 2.0, 30.0, 50.0):
        for s in (-2.999, -2.5, -2.0, -1.3, -1.0, -0.5, -1e-9, 0.0, 1e-9, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5):
            pairs.append((s, x))
    pairs += [(s, x) for s in (-1.0, -0.9, 0.0, 0.4, 0.5, 0.6, 0.9, 1.0) for x in (1e-12, 1e-6, 1e-4, 1e-2, 1.0)]
    return pairs


def large_inputs():
    """(s, x) with s up to 20 and x up to 200, for ln Gamma(s, x)."""
    rng = random.Random(20121)
    return [(rng.uniform(1.5, 20), float(mp.mpf(10) ** rng.uniform(-6, 2.3))) for _ in range(60)]


def main():
    rows = []
    for number, (s, x) in enumerate(inputs()):
        value, slope = upper_gamma(s, x)
        if number % 20 == 0 or (abs(s - round(s)) < 1e-5 and number % 3 == 0):
            other, other_slope = by_integration(s, x)
            if abs(other / value - 1) > 1e-25 or abs(other_slope - slope) > 1e-22 * (1 + abs(slope)):
                raise ArithmeticError(f"two methods differ at s = {s!r}, x = {x!r}: {value} {other}, {slope} {other_slope}")
        rows.append([s, x, nearest_double(value), nearest_double(slope)])
    large = [[s, x, nearest_double(mp.log(mp.gammainc(mp.mpf(s), mp.mpf(x))))] for s, x in large_inputs()]
    header = {
        "generated_by": f"scripts/make_gamma.py, mpmath {mp.__version__}",
        "description": "Upper incomplete gamma function Gamma(s, x). rows: [s, x, Gamma(s, x), d/ds ln Gamma(s, x)]; "
        "large_rows: [s, x, ln Gamma(s, x)]. Correctly rounded for the exact doubles s, x.",
    }
    write_fixture("gamma.json", header, {"rows": rows, "large_rows": large})


if __name__ == "__main__":
    main()
