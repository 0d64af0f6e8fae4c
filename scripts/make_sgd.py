#!/usr/bin/env python3
"""Make data-fixtures/sgd.json: the SGD model by mpmath, from its definitions (docs/theory.md, sections 2 and 3).

For each parameter set: the normalisation K, D at eight theta_h, the exact Smith G1 at twelve angles, F at seven theta_d,
and at six directions (theta_h, theta_d, phi_d) the BRDF f in 1/sr with its derivatives by all six parameters.

The shadowing integral is the reduced form over the slope rho,
    Lambda(theta) = int_mu^inf 2 [sqrt(rho^2 - mu^2)/mu - arccos(mu/rho)] P22(rho^2)/pi rho d rho,   mu = cot theta,
by tanh-sinh quadrature in rho with 36 digits; the transformed form that a program would use is not touched. For three
sets it is checked against the slope projection with Tricomi's U, Lambda = int_mu^inf (r tan theta - 1) P_2(r) dr
(thesis, section V.3.3). Derivatives by alpha and p are central differences (relative step 1e-11, so 20 digits);
f is affine in the other four parameters and their differences are exact. Runs in some minutes.

Usage: make_sgd.py [DATA]; DATA is the folder with tables/sgd_published.json (default: $BRDFIT_DATA or ../shared/data).
"""
import json
import sys

import mpmath as mp

from brdfit_reference.merl import data_folder
from oracle_json import nearest_double, write_fixture

mp.mp.dps = 36
STEP = mp.mpf(10) ** -11
NAMES = ("rho_d", "rho_s", "alpha", "p", "f0", "f1")
PUBLISHED = (
    ("alum-bronze", 0), ("alumina-oxide", 1), ("aluminium", 2), ("beige-fabric", 0), ("black-obsidian", 1),
    ("blue-rubber", 2), ("chrome", 0), ("gold-metallic-paint", 1), ("nickel", 2), ("pink-felt", 0),
    ("red-metallic-paint", 0), ("white-paint", 1),
)
EXTREME = (
    (1e-6, 0.0), (1e-6, 0.7), (1e-6, 2.0), (1e-4, 0.4), (1e-4, 1.0), (1e-3, 1.5), (1e-2, 0.0), (1e-2, 2.0),
    (0.1, 1.0), (0.3, 0.5), (1.0, 0.0), (1.0, 1.0), (1.0, 2.0),
)
G1_DEGREES = (1.0, 5.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0, 88.0, 89.0, 89.9)
FRESNEL_ANGLES = (0.0, 0.2, 0.5, 0.9, 1.2, 1.45, 1.57)
SLOPE_SCALE = (0.0, 0.01, 0.1, 0.5, 2.0, 6.0, 15.0, 40.0)  # tan^2 theta_h / alpha of the D samples
DIRECTIONS = ((0.0, 0.4, 0.7), (0.3, 0.2, 1.0), (1.0, 0.6, 2.2), (3.0, 0.85, 1.5), (8.0, 0.02, 0.4), (20.0, 0.4, 2.8))


def normalisation(alpha, p):
    """K = 1 / (alpha Gamma(1 - p, alpha))."""
    return 1 / (alpha * mp.gammainc(1 - p, alpha))


def p22(x, alpha, p, k):
    """Slope density of x = tan^2 theta_h, with int_0^inf P22 dx = 1."""
    a = alpha + x / alpha
    return k * mp.exp(-a) / a**p


def distribution(theta_h, alpha, p):
    """D(theta_h), normalised to int D cos theta_h domega = 1."""
    return p22(mp.tan(theta_h) ** 2, alpha, p, normalisation(alpha, p)) / (mp.pi * mp.cos(theta_h) ** 4)


def smith_lambda(theta, alpha, p):
    """Smith's Lambda by the reduced integral over the slope."""
    mu = mp.cot(theta)
    lowest = alpha + mu**2 / alpha
    if lowest > 250:  # Lambda < e^-250: nothing that a double of G1 could see
        return mp.mpf(0)
    k = normalisation(alpha, p)
    scale = min(mu**2 / alpha, lowest, mp.mpf(1))
    cuts = [mp.mpf(0)]
    while scale < 90:
        cuts.append(scale)
        scale *= 6
    cuts.append(mp.mpf(95))
    slopes = [mp.sqrt(mu**2 + alpha * t) for t in cuts]

    def integrand(rho):
        if rho <= mu:
            return mp.mpf(0)
        bracket = mp.sqrt(rho**2 - mu**2) / mu - mp.acos(mu / rho)
        return 2 * bracket * p22(rho**2, alpha, p, k) / mp.pi * rho

    unit = integrand(mp.sqrt(mu**2 + alpha))  # mpmath stops on an absolute error: integrate something of order one
    return unit * mp.quad(lambda rho: integrand(rho) / unit, slopes)


def smith_lambda_by_projection(theta, alpha, p):
    """The same through the one-dimensional slope density with Tricomi's U (thesis, section V.3.3)."""
    factor = 1 / (mp.sqrt(mp.pi * alpha) * mp.gammainc(1 - p, alpha))
    mu = mp.cot(theta)

    def integrand(r):
        a = alpha + r**2 / alpha
        return (r / mu - 1) * factor * mp.hyperu(p, p + mp.mpf(1) / 2, a) * mp.exp(-a)

    return mp.quad(integrand, [mp.sqrt(mu**2 + alpha * t) for t in (0, 1, 5, 20, 60)])


def smith_g1(theta, alpha, p):
    return 1 / (1 + smith_lambda(theta, alpha, p))


def fresnel(theta_d, f0, f1):
    """Generalised Schlick term (thesis, equation V.5)."""
    c = mp.cos(theta_d)
    return f0 - f1 * c + (1 - f0) * (1 - c) ** 5


def polar_angles(theta_h, theta_d, phi_d):
    """theta_i and theta_o of half/difference angles."""
    along = mp.cos(theta_h) * mp.cos(theta_d)
    across = mp.sin(theta_h) * mp.sin(theta_d) * mp.cos(phi_d)
    return mp.acos(along - across), mp.acos(along + across)


def shape(theta_h, theta_i, theta_o, alpha, p):
    """D G1 G1 / (pi cos theta_i cos theta_o): all that depends on alpha and p."""
    masking = smith_g1(theta_i, alpha, p) * smith_g1(theta_o, alpha, p)
    return distribution(theta_h, alpha, p) * masking / (mp.pi * mp.cos(theta_i) * mp.cos(theta_o))


def brdf_row(parameters, direction):
    """[theta_h, theta_d, phi_d, f, df/d(rho_d, rho_s, alpha, p, f0, f1)] at one direction."""
    rho_d, rho_s, alpha, p, f0, f1 = (mp.mpf(parameters[name]) for name in NAMES)
    theta_h, theta_d, phi_d = (mp.mpf(angle) for angle in direction)
    theta_i, theta_o = polar_angles(theta_h, theta_d, phi_d)
    centre = shape(theta_h, theta_i, theta_o, alpha, p)
    step = alpha * STEP
    up = shape(theta_h, theta_i, theta_o, alpha + step, p)
    by_alpha = (up - shape(theta_h, theta_i, theta_o, alpha - step, p)) / (2 * step)
    up = shape(theta_h, theta_i, theta_o, alpha, p + STEP)
    by_p = (up - shape(theta_h, theta_i, theta_o, alpha, p - STEP)) / (2 * STEP)
    schlick = fresnel(theta_d, f0, f1)
    values = (
        rho_d / mp.pi + rho_s * schlick * centre,
        1 / mp.pi,
        schlick * centre,
        rho_s * schlick * by_alpha,
        rho_s * schlick * by_p,
        rho_s * centre * (fresnel(theta_d, f0 + 1, f1) - schlick),
        rho_s * centre * (fresnel(theta_d, f0, f1 + 1) - schlick),
    )
    return list(direction) + [nearest_double(v) for v in values]


def parameter_sets(data):
    table = json.loads((data / "tables" / "sgd_published.json").read_text())
    keys = {"rho_d": "rho_d", "rho_s": "rho_s", "alpha": "alpha", "p": "p", "f0": "F0", "f1": "F1"}
    for name, channel in PUBLISHED:
        yield f"{name} {'RGB'[channel]}", {ours: float(table[name][theirs][channel]) for ours, theirs in keys.items()}
    for number, (alpha, p) in enumerate(EXTREME):
        rest = {"rho_d": 0.01 * (1 + number), "rho_s": 0.3, "f0": 0.04 + 0.07 * number, "f1": 0.02 * (number - 6)}
        yield f"alpha {alpha:g}, p {p:g}", {"alpha": alpha, "p": p, **rest}


def one_set(name, parameters):
    alpha, p = mp.mpf(parameters["alpha"]), mp.mpf(parameters["p"])
    angles = [float(mp.atan(mp.sqrt(alpha * scale))) for scale in SLOPE_SCALE]
    directions = []
    for scale, share, phi_d in DIRECTIONS:
        theta_h = min(float(mp.atan(mp.sqrt(alpha * scale))), 1.1)
        directions.append((theta_h, share * (1.5 - theta_h), phi_d))
    degrees = mp.pi / 180
    masking = []
    for angle in G1_DEGREES:
        theta = float(mp.mpf(angle) * degrees)
        value = smith_lambda(mp.mpf(theta), alpha, p)
        masking.append([theta, nearest_double(1 / (1 + value)), float(value) if value > 1e-300 else 0.0])
    return {
        "name": name,
        "parameters": parameters,
        "K": nearest_double(normalisation(alpha, p)),
        "D": [[t, nearest_double(distribution(mp.mpf(t), alpha, p))] for t in angles],
        "G1": masking,
        "F": [[t, nearest_double(fresnel(mp.mpf(t), *(mp.mpf(parameters[n]) for n in ("f0", "f1"))))] for t in FRESNEL_ANGLES],
        "f": [brdf_row(parameters, direction) for direction in directions],
    }


def check_projection():
    """Two derivations of Lambda agree."""
    for alpha, p, theta in ((0.05, 0.6, 1.2), (0.9, 0.3, 0.8), (1e-3, 0.9, 1.55)):
        alpha, p, theta = mp.mpf(alpha), mp.mpf(p), mp.mpf(theta)
        one, two = smith_lambda(theta, alpha, p), smith_lambda_by_projection(theta, alpha, p)
        if abs(one / two - 1) > 1e-18:
            raise ArithmeticError(f"Lambda differs: {one} {two}")
        print("Lambda by two derivations:", mp.nstr(one, 12), "difference", mp.nstr(one / two - 1, 3))


def main():
    check_projection()
    sets = []
    for name, parameters in parameter_sets(data_folder(sys.argv[1] if len(sys.argv) > 1 else None)):
        sets.append(one_set(name, parameters))
        print(name, flush=True)
    header = {
        "generated_by": f"scripts/make_sgd.py, mpmath {mp.__version__}",
        "description": "SGD model. Angles in radians, f in 1/sr. D: [theta_h, D]; G1: [theta, exact Smith G1, Lambda (0: below "
        "1e-100)]; F: [theta_d, F]; f: [theta_h, theta_d, phi_d, f, df/drho_d, df/drho_s, df/dalpha, df/dp, df/df0, df/df1].",
    }
    write_fixture("sgd.json", header, {"sets": sets})


if __name__ == "__main__":
    main()
