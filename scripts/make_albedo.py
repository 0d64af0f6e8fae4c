#!/usr/bin/env python3
"""Make data-fixtures/albedo.json: the directional albedo of the SGD model, int f cos theta_o domega_o, by quadrature.

For each parameter set and theta_i = 0, 30, 60, 80 degrees, two independent integrations with exact Smith G1
(docs/theory.md, sections 2 and 3): over the half vector (domega_o = 4 cos theta_d domega_h) and over o in spherical
coordinates around the mirror direction. Both are Gauss-Legendre in pieces, with the horizon of o as an integration
limit. The stored value is the first; `error` is the largest of their difference and of its own change under refinement.

Usage: make_albedo.py
"""
import math

import numpy as np

from brdfit_reference.sgd import Sgd, fresnel
from oracle_json import write_fixture

DEGREES = (0, 30, 60, 80)
SETS = (
    ("diffuse", Sgd(0.5, 0.0, 0.5, 0.5, 0.0, 0.0)),
    ("rough", Sgd(0.2, 0.5, 0.8, 0.2, 0.3, 0.1)),
    ("fabric", Sgd(0.1, 0.08, 0.3, 1.2, 0.05, -0.02)),
    ("paint", Sgd(0.3, 0.2, 0.03, 0.6, 0.06, 0.01)),
    ("metallic paint", Sgd(0.02, 0.7, 0.015, 0.45, 0.5, 0.1)),
    ("heavy tail", Sgd(0.05, 0.3, 0.01, 1.6, 0.9, 0.2)),
    ("plastic", Sgd(0.15, 0.9, 1e-3, 0.5, 0.045, 0.0)),
    ("mirror", Sgd(0.001, 0.95, 1e-4, 0.35, 0.9, -0.05)),
    ("sharpest", Sgd(0.0, 1.0, 1e-6, 1.0, 0.8, 0.0)),
)


def pieces(cuts, nodes):
    """Gauss-Legendre nodes and weights on consecutive intervals."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    low, high = np.array(cuts[:-1])[:, None], np.array(cuts[1:])[:, None]
    return (low + (high - low) * (x + 1) / 2).ravel(), ((high - low) / 2 * w).ravel()


def slope_cuts(alpha, end):
    """Intervals in tan theta that follow the distribution: it varies on alpha (the shift) and on sqrt(alpha) (the decay)."""
    cuts, step = [0.0], alpha / 2
    while step < min(end, math.sqrt(60.0 * alpha)):
        cuts.append(step)
        step = min(step * 1.7, step + math.sqrt(alpha) * 0.8)
    return cuts + ([end] if end <= math.sqrt(60.0 * alpha) else [math.sqrt(60.0 * alpha)])


def masking_of(shape):
    """Exact G1 as a function of an array of cosines, evaluated in portions."""

    def g1(cosine):
        theta = np.arccos(np.clip(cosine, 0.0, 1.0))
        flat = theta.ravel()
        return np.concatenate([shape.g1(part) for part in np.array_split(flat, 1 + flat.size // 4000)]).reshape(theta.shape)

    return g1


def specular_over_h(model, theta_i, nodes):
    """rho_s / (pi cos theta_i) int F D G1 G1 4 (i.h) domega_h over the h that send o above the horizon."""
    shape = model.distribution()
    g1 = masking_of(shape)
    limit = math.pi / 4 + theta_i / 2  # h turned towards i by more than this sends o below
    other = math.pi / 4 - theta_i / 2  # beyond this, away from i, too: from there on phi has a limit
    cuts = [math.atan(t) for t in slope_cuts(model.alpha, math.tan(limit) if limit < math.pi / 2 else 1e9)]
    cuts = sorted({min(c, limit) for c in cuts} | ({other} if 0 < other < max(cuts) else set()))
    # the phi limit leaves pi like a square root behind `other`: nodes crowd there
    total = 0.0
    for low, high in zip(cuts[:-1], cuts[1:]):
        u, wu = pieces([0.0, 1.0], nodes)
        if low >= other - 1e-15:
            theta, w = low + (high - low) * u**2 * (3 - 2 * u), wu * (high - low) * 6 * u * (1 - u)
        else:
            theta, w = low + (high - low) * u, wu * (high - low)
        # cos theta_o = 2 (i.h) cos theta_h - cos theta_i > 0  <=>  cos phi > bound
        bound = math.cos(theta_i) * -np.cos(2 * theta) / np.maximum(math.sin(theta_i) * np.sin(2 * theta), 1e-300)
        last = np.arccos(np.clip(bound, -1.0, 1.0))
        v, wv = pieces([0.0, 0.25, 0.6, 0.9, 1.0], nodes)
        phi = last[:, None] * v
        dot = math.cos(theta_i) * np.cos(theta)[:, None] + math.sin(theta_i) * np.sin(theta)[:, None] * np.cos(phi)
        cos_o = 2 * dot * np.cos(theta)[:, None] - math.cos(theta_i)
        ok = (cos_o > 0) & (dot > 0)
        value = np.where(ok, 4 * dot * fresnel(np.arccos(np.clip(dot, 0, 1)), model.f0, model.f1) * g1(cos_o), 0.0)
        inner = 2 * last * (value * wv).sum(axis=1)
        total += float((w * np.sin(theta) * shape.d(theta) * inner).sum())
    return model.rho_s * total * float(g1(np.array([math.cos(theta_i)]))[0]) / (math.pi * math.cos(theta_i))


def specular_over_o(model, theta_i, nodes):
    """The same integral over o = (gamma, psi) around the mirror direction, clipped at the horizon."""
    shape = model.distribution()
    g1 = masking_of(shape)
    i = np.array([math.sin(theta_i), 0.0, math.cos(theta_i)])
    mirror = np.array([-i[0], 0.0, i[2]])
    across = np.array([i[2], 0.0, i[0]])  # towards the normal and beyond
    reach = math.pi / 2 + theta_i
    wide = math.atan(min(math.sqrt(60 * model.alpha), 1e9)) * 2
    cuts = [2 * math.atan(t) for t in slope_cuts(model.alpha, 1e9)]
    # towards grazing the lobe in o is narrower across the plane of incidence: also put cuts at those scales
    cuts += [c * math.cos(theta_i) for c in cuts] + [min(wide / max(math.cos(theta_i), 1e-3), reach)]
    cuts = sorted({min(c, reach) for c in cuts} | {math.pi / 2 - theta_i} | set(np.linspace(0, reach, 12)))
    total = 0.0
    for low, high in zip(cuts[:-1], cuts[1:]):
        if high - low < 1e-12:
            continue
        u, wu = pieces([0.0, 1.0], nodes)
        gamma, w = low + (high - low) * u**2 * (3 - 2 * u), wu * (high - low) * 6 * u * (1 - u)
        # cos theta_o = cos gamma cos theta_i + sin gamma sin theta_i cos psi, psi counted from `across`
        bound = -np.cos(gamma) * math.cos(theta_i) / np.maximum(np.sin(gamma) * math.sin(theta_i), 1e-300)
        last = np.arccos(np.clip(bound, -1.0, 1.0))
        v, wv = pieces([0.0, 0.04, 0.12, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0], nodes)
        psi = last[:, None] * v
        cg, sg = np.cos(gamma)[:, None], np.sin(gamma)[:, None]
        o = [cg * mirror[k] + sg * (np.cos(psi) * across[k] + np.sin(psi) * (k == 1)) for k in range(3)]
        half = [o[k] + i[k] for k in range(3)]
        norm = np.sqrt(half[0] ** 2 + half[1] ** 2 + half[2] ** 2)
        tangent = np.sqrt(half[0] ** 2 + half[1] ** 2) / np.maximum(half[2], 1e-300)
        ok = (o[2] > 0) & (half[2] > 0)
        density = np.where(ok, shape.d(np.arctan(np.where(ok, tangent, 0.0))), 0.0)
        value = np.where(ok, density * fresnel(np.arccos(np.clip(norm / 2, 0, 1)), model.f0, model.f1) * g1(o[2]), 0.0)
        total += float((w * np.sin(gamma) * 2 * last * (value * wv).sum(axis=1)).sum())
    return model.rho_s * total * float(g1(np.array([math.cos(theta_i)]))[0]) / (math.pi * math.cos(theta_i))


def main():
    rows = []
    for name, model in SETS:
        for angle in DEGREES:
            theta_i = math.radians(angle)
            if model.rho_s == 0.0:
                specular, error = 0.0, 0.0
            else:
                specular, coarse = specular_over_h(model, theta_i, 24), specular_over_h(model, theta_i, 16)
                error = max(abs(specular - coarse), abs(specular - specular_over_o(model, theta_i, 24)))
            rows.append({
                "name": name,
                "parameters": {key: getattr(model, key) for key in ("rho_d", "rho_s", "alpha", "p", "f0", "f1")},
                "theta_i_degrees": angle,
                "albedo": model.rho_d + specular,
                "error": float(f"{error + 1e-15:.1e}"),
            })
            print(name, angle, rows[-1]["albedo"], rows[-1]["error"], flush=True)
    header = {
        "generated_by": "scripts/make_albedo.py, numpy",
        "description": "Directional albedo int f cos theta_o domega_o of the SGD model with exact Smith G1; `error` is the "
        "absolute difference of two integrations.",
    }
    write_fixture("albedo.json", header, {"rows": rows})


if __name__ == "__main__":
    main()
