#!/usr/bin/env python3
"""Check the reference implementation itself, in a few seconds, without measured data.

- Gamma(s, x), K, D, G1, F, f and the derivatives by ln alpha and p against the mpmath vectors in data-fixtures/;
- the analytic Jacobian of step 1 against central differences, for every loss;
- step 2: every solver against trying all faces of the cone, on problems made from random parameters;
- step 1: every solver finds a curve made from known parameters again.

Prints the largest error of each and exits with 1 where one is beyond its tolerance.
"""
import json
import math
import sys
from pathlib import Path

import numpy as np

from brdfit_reference import objective, solvers
from brdfit_reference.gamma import log_upper_gamma
from brdfit_reference.merl import Grid
from brdfit_reference.sgd import Distribution, Sgd, fresnel

FIXTURES = Path(__file__).resolve().parents[2] / "data-fixtures"
FAILURES = []


def report(what, error, tolerance):
    verdict = "ok" if error <= tolerance else "FAILED"
    if verdict != "ok":
        FAILURES.append(what)
    print(f"{what:52s} {error:9.2e}  (tolerance {tolerance:.0e})  {verdict}")


def check_gamma():
    fixture = json.loads((FIXTURES / "gamma.json").read_text())
    value = slope = 0.0
    for s, x, gamma, by_s in fixture["rows"]:
        log_gamma, derivative = log_upper_gamma(s, x)
        value = max(value, abs(math.expm1(log_gamma - math.log(gamma))))
        slope = max(slope, abs(derivative - by_s) / max(abs(by_s), 1.0))
    large = max(abs(log_upper_gamma(s, x)[0] - log_gamma) for s, x, log_gamma in fixture["large_rows"])
    report("Gamma(s, x), relative", value, 1e-13)
    report("d/ds ln Gamma(s, x)", slope, 1e-13)
    report("ln Gamma(s, x), large s", large, 1e-12)


def check_model():
    worst = dict.fromkeys(("K", "D", "G1", "F", "f", "df"), 0.0)

    def note(key, error):
        worst[key] = max(worst[key], float(np.max(error)))

    for entry in json.loads((FIXTURES / "sgd.json").read_text())["sets"]:
        model = Sgd(**entry["parameters"])
        shape = model.distribution()
        d, g1, f_d, f = (np.array(entry[key]) for key in ("D", "G1", "F", "f"))
        note("K", abs(shape.k / entry["K"] - 1))
        note("D", np.abs(shape.d(d[:, 0]) / d[:, 1] - 1))
        note("G1", np.abs(shape.g1(g1[:, 0]) - g1[:, 1]))
        note("F", np.abs(fresnel(f_d[:, 0], model.f0, model.f1) - f_d[:, 1]))
        note("f", np.abs(model.evaluate(f[:, 0], f[:, 1], f[:, 2]) / f[:, 3] - 1))
        for row in f:
            by_alpha, by_p, scale = shape_derivatives(model, shape, row[:3])
            note("df", abs(by_alpha - row[6]) / (scale / model.alpha))
            note("df", abs(by_p - row[7]) / (scale * (1 - math.log(model.alpha))))
    names = {"G1": "G1, absolute", "F": "F, absolute", "df": "df by alpha and p, relative to the specular term"}
    for key, error in worst.items():
        report(names.get(key, key), error, 1e-12)


def shape_derivatives(model, shape, angles):
    """df/dalpha and df/dp from the analytic logarithmic derivatives, and the size of the specular term."""
    theta_h, theta_d, phi_d = angles
    along, across = math.cos(theta_h) * math.cos(theta_d), math.sin(theta_h) * math.sin(theta_d) * math.cos(phi_d)
    cosines = np.array([along - across, along + across])
    g1, g1_by_alpha, g1_by_p = shape.g1_with_derivatives(np.arccos(cosines))
    ratio, by_alpha, by_p = shape.relative(np.array([theta_h]))
    specular = model.rho_s * float(fresnel(theta_d, model.f0, model.f1)) * shape.peak() * float(ratio[0])
    specular *= float(np.prod(g1) / np.prod(cosines)) / math.pi
    by_alpha = float(by_alpha[0]) + shape.log_k_by_log_alpha - model.alpha - model.p + float(np.sum(g1_by_alpha / g1))
    by_p = float(by_p[0]) + shape.log_k_by_p - math.log(model.alpha) + float(np.sum(g1_by_p / g1))
    scale = abs(specular) * (1 + math.tan(theta_h) ** 2 / model.alpha)
    return specular * by_alpha / model.alpha, specular * by_p, scale


def synthetic_rows(cutoff=75.0):
    grid = Grid.make("edge")
    rows = grid.theta_h <= math.radians(cutoff)
    weight = -np.diff(np.cos(grid.theta_h_edges))
    return grid.theta_h[rows], weight[rows]


def check_jacobian():
    theta_h, weight = synthetic_rows()
    rng = np.random.default_rng(4)
    for loss in objective.LOSSES:
        worst = 0.0
        for alpha, p in ((1e-5, 0.3), (1e-3, 1.2), (0.05, 0.5), (0.7, 0.1)):
            x = np.array([math.log(0.1), math.log(20.0), math.log(alpha), p])
            measured = objective.theta_h_model(x, theta_h)[0] * np.exp(rng.normal(0, 0.3, len(theta_h)))
            problem = objective.StepOne(theta_h, weight, measured, loss)
            exact = problem.jacobian(x)
            for k in range(4):
                step = np.eye(4)[k] * 1e-4
                # fourth order: the truncation error is far below the rounding error
                near = problem.residuals(x + step) - problem.residuals(x - step)
                far = problem.residuals(x + 2 * step) - problem.residuals(x - 2 * step)
                numeric = (8 * near - far) / (12 * 1e-4)
                worst = max(worst, np.max(np.abs(numeric - exact[:, k])) / np.max(np.abs(exact[:, k])))
        report(f"Jacobian of step 1, {loss}", worst, 1e-9)


def step_two_problems():
    """Problems whose free optimum lies inside the cone, beyond one wall, and beyond several."""
    rng = np.random.default_rng(5)
    theta_d = Grid.make("edge").theta_d
    theta_d = theta_d[theta_d <= math.radians(75.0)]
    for alpha, p in ((1e-4, 0.4), (0.01, 0.6), (0.3, 0.5)):
        shape = Distribution.make(alpha, p)
        for f0, f1 in ((0.04, 0.0), (0.9, -0.05), (0.5, 0.5), (0.02, 0.05), (1.3, 0.2), (0.3, -0.9)):
            u = 0.2 * np.array([f0, f1, 1.0])
            q = shape.peak() * (shape.g1(theta_d) / np.cos(theta_d)) ** 2 / math.pi
            measured = np.maximum(0.1 / math.pi + q * (objective.fresnel_basis(theta_d) @ u), 0.0)
            measured = measured * np.exp(rng.normal(0, 0.1, len(theta_d)))
            for constraint in ("physical", "non-negative"):
                yield objective.StepTwo.make(theta_d, measured, 0.1, shape, shape.peak(), constraint, "log1p-cos")


def check_step_two():
    problems = list(step_two_problems())
    exact = [solvers.solve_step_two_by_enumeration(problem) for problem in problems]
    for solver in solvers.SOLVERS:
        worst = outside = 0.0
        for problem, truth in zip(problems, exact):
            found = solvers.solve_step_two(problem, solver)
            worst = max(worst, abs(found.cost / truth.cost - 1))
            free = np.linalg.lstsq(problem.matrix, problem.target)[0]
            outside = max(outside, float(np.max(-(problem.constraints @ found.x))) / np.linalg.norm(free))
        report(f"step 2 by {solver}, relative cost", worst, 1e-9)
        report(f"step 2 by {solver}, violation", outside, 1e-9)


def check_step_one():
    theta_h, weight = synthetic_rows()
    for solver in ("scipy-trf", "scipy-lm", "nlopt-slsqp", "nlopt-bobyqa"):
        worst = 0.0
        for alpha, p in ((2e-4, 0.35), (0.02, 0.6), (0.4, 0.2)):
            x = np.array([math.log(0.1), math.log(20.0), math.log(alpha), p])
            problem = objective.StepOne(theta_h, weight, objective.theta_h_model(x, theta_h)[0], "log1p-cos")
            found = solvers.solve_step_one(problem, problem.starts(), solver)
            worst = max(worst, float(np.max(np.abs(found.x - x))))
        report(f"step 1 by {solver}, recovery of x", worst, 1e-5)


def main():
    check_gamma()
    check_model()
    check_jacobian()
    check_step_two()
    check_step_one()
    if FAILURES:
        sys.exit(f"failed: {', '.join(FAILURES)}")


if __name__ == "__main__":
    main()
