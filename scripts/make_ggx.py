#!/usr/bin/env python3
"""Make data-fixtures/ggx.json: the GGX model from its definitions.

D, Smith's G1 from the integral over slopes (docs/theory.md, section 3.1), f and its five derivatives by mpmath with 40
digits; the derivatives by differentiating the definition with the closed G1, which is checked against the integral. The
directional albedo by Gauss-Legendre quadrature over the half vector in numpy, the horizon of o as a limit of the azimuth;
`error` is its change when the nodes are doubled.

Usage: make_ggx.py
"""
import math

import numpy as np
from mpmath import mp, mpf

from oracle_json import write_fixture

mp.dps = 40

# name, rho_d, rho_s, alpha, f0, f1
SETS = (
    ("mirror", 0.0, 0.75, 0.0009765625, 0.75, 0.0625),
    ("plastic", 0.25, 0.875, 0.03125, 0.0625, 0.0),
    ("satin", 0.125, 0.5, 0.1875, 0.5, 0.125),
    ("matt", 0.375, 0.25, 0.625, 0.25, -0.0625),
    ("rough", 0.0, 1.0, 1.5, 0.0625, 0.03125),
)
THETAS = (0.0009765625, 0.03125, 0.25, 0.75, 1.25, 1.5, 1.5625)
ANGLES = ((0.0, 0.25, 0.5), (0.001, 0.5, 1.0), (0.03125, 0.75, 2.0), (0.25, 0.25, 3.0), (0.5, 0.5, 1.5), (0.75, 0.625, 1.25))
ALBEDO_DEGREES = (0, 30, 60, 80)


def d(alpha, theta):
    return alpha**2 / (mp.pi * mp.cos(theta) ** 4 * (alpha**2 + mp.tan(theta) ** 2) ** 2)


def g1(alpha, theta):
    return 2 / (1 + mp.sqrt(1 + (alpha * mp.tan(theta)) ** 2))


def g1_by_integral(alpha, theta):
    mu = mp.cot(theta)
    slope = lambda rho: 2 * (mp.sqrt(rho**2 - mu**2) / mu - mp.acos(mu / rho)) * alpha**2 / (alpha**2 + rho**2) ** 2 / mp.pi * rho
    lam = mp.quad(lambda t: slope(mu * mp.exp(t)) * mu * mp.exp(t), [0, 1, 3, 6, 12, 25, 60, 120])
    return 1 / (1 + lam)


def f(rho_d, rho_s, alpha, f0, f1, theta_h, theta_d, phi_d):
    same = mp.cos(theta_h) * mp.cos(theta_d)
    turn = mp.sin(theta_h) * mp.sin(theta_d) * mp.cos(phi_d)
    i, o = mp.acos(same - turn), mp.acos(same + turn)
    c = mp.cos(theta_d)
    fresnel = f0 - f1 * c + (1 - f0) * (1 - c) ** 5
    return rho_d / mp.pi + rho_s * fresnel * d(alpha, theta_h) * g1(alpha, i) * g1(alpha, o) / (4 * mp.cos(i) * mp.cos(o))


def derivatives(parameters, angles):
    values = []
    for n in range(5):
        moved = lambda x: f(*parameters[:n], x, *parameters[n + 1 :], *angles)
        values.append(mp.diff(moved, parameters[n], h=mpf(10) ** -15))
    return values


def albedo(rho_d, rho_s, alpha, f0, f1, theta_i, panels):
    x, w = np.polynomial.legendre.leggauss(16)
    x, w = (x + 1) / 2, w / 2
    u, wu = np.polynomial.legendre.leggauss(400)
    u, wu = (u + 1) / 2, wu / 2
    ci, si = math.cos(theta_i), math.sin(theta_i)
    # s = ln(tan theta_h / alpha), with breaks where the limit of the azimuth sets in and where it reaches zero
    limits = [math.tan(abs(math.pi / 4 + side * theta_i / 2)) for side in (-1, 1)]
    ends = np.sort(np.concatenate([np.linspace(-16, 16, panels + 1), [math.log(t / alpha) for t in limits]]))
    total = 0.0
    for low, high in zip(ends[:-1], ends[1:]):
        # nodes crowd at the ends, where the limit behaves like a square root
        v = low + (high - low) * (x * x * (3 - 2 * x))
        dv = (high - low) * 6 * x * (1 - x) * w
        tan = alpha * np.exp(v)
        ch = 1 / np.sqrt(1 + tan * tan)
        sh = tan * ch
        k = (ci / (2 * ch) - ci * ch) / np.maximum(si * sh, 1e-300)
        end = np.arccos(np.clip(k, -1, 1))[:, None]
        cos_d = ci * ch[:, None] + si * sh[:, None] * np.cos(end * u)
        cos_o = 2 * cos_d * ch[:, None] - ci
        inside = (cos_o > 0) & (cos_d > 0)
        cos_o = np.where(inside, cos_o, 1.0)
        tan_o = np.sqrt(np.maximum(1 - cos_o**2, 0)) / cos_o
        masking = 2 / (1 + np.sqrt(1 + (alpha * tan_o) ** 2))
        c = 1 - cos_d
        fresnel = f0 - f1 * cos_d + (1 - f0) * c**5
        ring = (np.where(inside, fresnel * masking * cos_d, 0.0) @ wu) * end[:, 0] * 2  # both half turns
        density = alpha**2 / (math.pi * (alpha**2 + tan * tan) ** 2) / ch**4
        # domega = sin theta_h dtheta_h dphi, dtheta_h = cos^2 theta_h tan dv
        total += np.sum(density * ring * sh * ch * ch * tan * dv)
    g = 2 / (1 + math.sqrt(1 + (alpha * math.tan(theta_i)) ** 2))
    return rho_d + rho_s * g / ci * total


def main():
    sets = []
    for name, *parameters in SETS:
        exact = [mpf(p) for p in parameters]
        alpha = exact[2]
        for theta in THETAS:
            assert abs(g1(alpha, mpf(theta)) / g1_by_integral(alpha, mpf(theta)) - 1) < mpf(10) ** -15, (name, theta)
        rows = []
        for angles in ANGLES:
            at = [mpf(a) for a in angles]
            rows.append([*angles, float(f(*exact, *at)), *(float(v) for v in derivatives(exact, at))])
        albedos = []
        for degrees in ALBEDO_DEGREES:
            coarse, fine = (albedo(*parameters, math.radians(degrees), panels) for panels in (100, 200))
            albedos.append([degrees, fine, abs(fine - coarse)])
        sets.append({
            "name": name,
            "parameters": dict(zip(("rho_d", "rho_s", "alpha", "f0", "f1"), parameters)),
            "D": [[theta, float(d(alpha, mpf(theta)))] for theta in THETAS],
            "G1": [[theta, float(g1_by_integral(alpha, mpf(theta)))] for theta in THETAS],
            "f": rows,
            "albedo": albedos,
        })
    description = (
        "sets: per set D rows (theta_h, D in 1/sr); G1 rows (theta, G1); f rows (theta_h, theta_d, phi_d, f in 1/sr, "
        "df/drho_d, df/drho_s, df/dalpha, df/df0, df/df1); albedo rows (theta_i in degrees, directional albedo, error)"
    )
    write_fixture("ggx.json", {"generated_by": "scripts/make_ggx.py", "description": description}, {"sets": sets})


if __name__ == "__main__":
    main()
