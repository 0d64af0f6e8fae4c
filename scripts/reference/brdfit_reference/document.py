"""The two-step fit of one file and its result document (docs/theory.md, section 4; docs/formats.md for the keys)."""
import math
from dataclasses import dataclass

import numpy as np

from . import objective, solvers
from .panel import Panel
from .sgd import Distribution, Sgd
from .slices import theta_d_slice, theta_h_slice

CHANNELS = ("R", "G", "B")


@dataclass(frozen=True)
class Options:
    """What influences a fit. Cut-offs in degrees; `loss` is the residual of step 1."""

    solver: str = "scipy-trf"
    sample_position: str = "edge"
    constraint: str = "physical"
    loss: str = "log1p-cos"
    cutoff_theta_h: float = 75.0
    cutoff_theta_d: float = 75.0
    random_starts: int = 0

    @property
    def anchored(self):
        return self.constraint != "paper"


@dataclass(frozen=True)
class ChannelFit:
    """One channel: the parameters, and what the document says about the two steps."""

    model: Sgd
    shape: Distribution
    fr: float
    anchor: float
    u: np.ndarray
    steps: list
    flags: list


def fit_channel(h, d, channel, options):
    """Both steps on the slices h and d of one channel."""
    rows = h.rows(options.cutoff_theta_h)
    weight = np.cos(h.edges[:-1]) - np.cos(h.edges[1:])
    measured_h = h.mean[channel]
    problem = objective.StepOne(h.angles[rows], weight[rows], measured_h[rows], options.loss)
    one = solvers.solve_step_one(problem, problem.starts() + _random_starts(options.random_starts), options.solver)
    rho_d, peak, alpha = (math.exp(v) for v in one.x[:3])
    p = float(one.x[3])
    shape = Distribution.make(alpha, p)
    fr = peak / shape.peak()
    first = float(measured_h[np.flatnonzero(np.isfinite(measured_h))[0]])
    anchor = objective.anchor(rho_d, peak, shape, first, options.anchored)

    rows_d = d.rows(options.cutoff_theta_d)
    measured_d = d.mean[channel][rows_d]
    linear = objective.StepTwo.make(d.angles[rows_d], measured_d, rho_d, shape, anchor, options.constraint, options.loss)
    two = solvers.solve_step_two(linear, options.solver)
    flags = _bound_flags(one.x)
    if abs(two.x[2]) <= objective.NO_SPECULAR:
        rho_s, f0, f1 = 0.0, 0.0, 0.0
        flags.append("no_specular")
    else:
        rho_s, f0, f1 = float(two.x[2]), float(two.x[0] / two.x[2]), float(two.x[1] / two.x[2])
    steps = [_step("theta_h", one, len(rows)), _step("theta_d", two, len(rows_d))]
    return ChannelFit(Sgd(rho_d, rho_s, alpha, p, f0, f1), shape, fr, anchor, two.x, steps, flags)


def _random_starts(count):
    """Further starting points, uniform in a part of the box; the same ones every time."""
    rng = np.random.default_rng(2012)
    low, high = np.log([1e-4, 1e-2, 1e-5]), np.log([1.0, 1e4, 1.0])
    return [np.append(rng.uniform(low, high), rng.uniform(0.05, 1.9)) for _ in range(count)]


def _step(name, solution, rows):
    result = {"name": name, "cost": solution.cost, "iterations": solution.iterations}
    return {**result, "termination": solution.termination, "rows": rows}


def _bound_flags(x):
    flags = []
    for name, value, low, high in zip(("rho_d", "peak", "alpha", "p"), x, objective.LOWER, objective.UPPER):
        if value <= low + 1e-7:
            flags.append(f"{name}_at_lower_bound")
        if value >= high - 1e-7:
            flags.append(f"{name}_at_upper_bound")
    return flags


def fitted_slices(fit, h, d):
    """The model of each step on all rows that hold data (1/sr): step 1's with Fr, step 2's with A."""
    m = fit.model
    cos_h, cos_d = np.cos(h.angles), np.cos(d.angles)
    theta_h = (m.rho_d + fit.fr * fit.shape.d(h.angles) * (fit.shape.g1(h.angles) / cos_h) ** 2) / math.pi
    q = fit.anchor * (fit.shape.g1(d.angles) / cos_d) ** 2 / math.pi
    u = np.array([m.rho_s * m.f0, m.rho_s * m.f1, m.rho_s])
    return theta_h, m.rho_d / math.pi + q * (objective.fresnel_basis(d.angles) @ u)


def _numbers(values, present):
    return [float(v) if ok else None for v, ok in zip(values, present)]


def fit_slices(merl, grid, options):
    """Both slices of a file and the fits of its three channels."""
    h, d = theta_h_slice(merl, grid), theta_d_slice(merl, grid)
    if not len(h.rows(options.cutoff_theta_h)) or not len(d.rows(options.cutoff_theta_d)):
        raise ValueError(f"{merl.name}: a slice has no valid row")
    return h, d, [fit_channel(h, d, channel, options) for channel in range(3)]


def error_panel(merl, grid, fits):
    """The member "errors" of the document, over the full data."""
    panel = Panel(grid, merl.valid)
    found = [panel.errors(merl.f[c], fits[c].model.on_grid(grid)) for c in range(3)]
    errors = {key: [e[key] for e in found] for key in ("E", "L", "C", "albedo", "albedo_difference")}
    return {**errors, "samples": panel.samples}


def assemble(merl, options, h, d, fits, errors):
    """The result document; `errors` may be None."""
    fitted = [fitted_slices(fit, h, d) for fit in fits]
    present_h, present_d = np.isfinite(h.mean[0]), np.isfinite(d.mean[0])
    document = {
        "schema_version": 1,
        "program": "reference",
        "input": {
            "name": merl.name,
            "sha256": merl.sha256,
            "dimensions": list(merl.f.shape[1:]),
            "sample_position": options.sample_position,
            "valid_fraction": float(merl.valid.mean()),
        },
        "options": dict(vars(options)),
        "model": "sgd",
        "channels": [
            {
                "name": name,
                "parameters": dict(vars(fit.model)),
                "derived": {"K": fit.shape.k, "fr": fit.fr, "anchor": fit.anchor},
                "steps": fit.steps,
                "flags": fit.flags,
            }
            for name, fit in zip(CHANNELS, fits)
        ],
    }
    if errors is not None:
        document["errors"] = errors
    document["slices"] = {
        "theta_h": h.angles.tolist(),
        "theta_d": d.angles.tolist(),
        "measured": {"theta_h": [_numbers(m, present_h) for m in h.mean], "theta_d": [_numbers(m, present_d) for m in d.mean]},
        "fitted": {
            "theta_h": [_numbers(curves[0], present_h) for curves in fitted],
            "theta_d": [_numbers(curves[1], present_d) for curves in fitted],
        },
    }
    return document
