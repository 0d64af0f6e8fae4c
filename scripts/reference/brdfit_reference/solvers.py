"""The solvers of the reference fits: scipy's and NLopt's, none of our own (docs/theory.md, sections 4 and 5).

Step 1 is a least-squares problem in a box. Each solver honours the box in its own way:
- scipy-trf: trust region reflective with bounds; it stays strictly inside, so variables that end beside a bound with the
  gradient pointing outwards are put on it and the others are finished by MINPACK;
- scipy-lm: MINPACK's lmder on z with x = middle + half sin z, which maps every z into the box;
- nlopt-slsqp, nlopt-lbfgs (gradient), nlopt-bobyqa, nlopt-sbplx (derivative-free): NLopt's own bounds, started again from
  their result until the cost stands still.

Step 2 is a strictly convex quadratic problem in a cone. It is whitened, y = R u with matrix = Q R, and solved by
- scipy-trf: the dual non-negative least squares (scipy.optimize.nnls; Lawson & Hanson 1974, chapter 23), and one
  projection on the constraints that it found active;
- scipy-lm: MINPACK where there are no constraints, scipy's SLSQP otherwise;
- nlopt-slsqp and nlopt-lbfgs: LD_SLSQP; nlopt-bobyqa and nlopt-sbplx: LN_COBYLA.
"""
import itertools
from dataclasses import dataclass

import nlopt
import numpy as np
from scipy import optimize

TINY = 3e-16
NLOPT_STEP_ONE = {
    "nlopt-slsqp": nlopt.LD_SLSQP,
    "nlopt-lbfgs": nlopt.LD_LBFGS,
    "nlopt-bobyqa": nlopt.LN_BOBYQA,
    "nlopt-sbplx": nlopt.LN_SBPLX,
}
SOLVERS = ("scipy-trf", "scipy-lm", *NLOPT_STEP_ONE)


@dataclass(frozen=True)
class Solution:
    x: np.ndarray
    cost: float
    iterations: int
    termination: str


def solve_step_one(problem, starts, solver):
    """The best result over the starts (ties: the first)."""
    results = [_STEP_ONE[solver](problem, start) for start in starts]
    return min(results, key=lambda result: result.cost)


def _trf(problem, start):
    inside = np.clip(start, problem.lower + 1e-9, problem.upper - 1e-9)
    found = optimize.least_squares(
        problem.residuals, inside, problem.jacobian, bounds=(problem.lower, problem.upper), method="trf",
        x_scale="jac", ftol=TINY, xtol=TINY, gtol=TINY, max_nfev=400,
    )
    best = Solution(found.x, problem.cost(found.x), int(found.nfev), found.message)
    polished = _finish_on_bounds(problem, found.x)
    if polished.cost < best.cost:
        return Solution(polished.x, polished.cost, best.iterations + polished.iterations, best.termination)
    return best


def _finish_on_bounds(problem, x):
    """Put variables that lean on a bound on it, finish the others by MINPACK."""
    gradient = problem.jacobian(x).T @ problem.residuals(x)
    reach = 1e-3 * (problem.upper - problem.lower)
    low, high = (x - problem.lower < reach) & (gradient > 0), (problem.upper - x < reach) & (gradient < 0)
    held = np.where(low, problem.lower, np.where(high, problem.upper, x))
    free = ~(low | high)

    def spread(part):
        full = held.copy()
        full[free] = np.clip(part, problem.lower[free], problem.upper[free])
        return full

    found = optimize.least_squares(
        lambda part: problem.residuals(spread(part)), held[free], lambda part: problem.jacobian(spread(part))[:, free],
        method="lm", x_scale="jac", ftol=TINY, xtol=TINY, gtol=TINY, max_nfev=200,
    )
    x = spread(found.x)
    return Solution(x, problem.cost(x), int(found.nfev), found.message)


def _lm(problem, start):
    middle, half = (problem.lower + problem.upper) / 2, (problem.upper - problem.lower) / 2

    def box(z):
        return np.clip(middle + half * np.sin(z), problem.lower, problem.upper)

    found = optimize.least_squares(
        lambda z: problem.residuals(box(z)), np.arcsin(np.clip((start - middle) / half, -0.999, 0.999)),
        lambda z: problem.jacobian(box(z)) * (half * np.cos(z)),
        method="lm", x_scale="jac", ftol=TINY, xtol=TINY, gtol=TINY, max_nfev=2000,
    )
    x = box(found.x)
    return Solution(x, problem.cost(x), int(found.nfev), found.message)


def _nlopt(solver):
    def solve(problem, start):
        def objective(x, gradient):
            residuals = problem.residuals(x)
            if gradient.size:
                gradient[:] = problem.jacobian(x).T @ residuals
            return 0.5 * float(residuals @ residuals)

        x, cost, evaluations, message = np.array(start), problem.cost(start), 0, "not run"
        for step in (0.5, 0.05, 0.005, 0.0005, 0.00005):
            opt = nlopt.opt(NLOPT_STEP_ONE[solver], len(x))
            opt.set_lower_bounds(problem.lower)
            opt.set_upper_bounds(problem.upper)
            opt.set_min_objective(objective)
            opt.set_initial_step(step)
            opt.set_ftol_rel(1e-15)
            opt.set_xtol_rel(1e-13)
            opt.set_maxeval(3000)
            try:
                candidate = np.clip(opt.optimize(x), problem.lower, problem.upper)
                message = _nlopt_reason(opt.last_optimize_result())
            except (nlopt.RoundoffLimited, RuntimeError) as error:
                message = f"nlopt: {type(error).__name__}"
                break
            finally:
                evaluations += opt.get_numevals()
            before, now = cost, problem.cost(candidate)
            if now < cost:
                x, cost = candidate, now
            if before - now <= 1e-13 * before and step < 0.1:
                break
        return Solution(x, cost, evaluations, message)

    return solve


def _nlopt_reason(code):
    names = {nlopt.SUCCESS: "success", nlopt.FTOL_REACHED: "ftol", nlopt.XTOL_REACHED: "xtol", nlopt.MAXEVAL_REACHED: "evaluations"}
    return "nlopt: " + names.get(code, str(code))


_STEP_ONE = {"scipy-trf": _trf, "scipy-lm": _lm, **{name: _nlopt(name) for name in NLOPT_STEP_ONE}}


@dataclass(frozen=True)
class _Whitened:
    """The problem of step 2 in y = R u: minimise |y - target|^2 / 2 (plus a constant) subject to rows @ y >= 0."""

    r: np.ndarray
    target: np.ndarray
    rows: np.ndarray

    @classmethod
    def make(cls, problem):
        scale = np.linalg.norm(problem.matrix, axis=0)
        q, r = np.linalg.qr(problem.matrix / scale)
        r = r * scale
        rows = np.linalg.solve(r.T, problem.constraints.T).T if len(problem.constraints) else problem.constraints
        norms = np.linalg.norm(rows, axis=1, keepdims=True) if len(rows) else 1.0
        return cls(r, q.T @ problem.target, rows / norms)

    def back(self, y):
        return np.linalg.solve(self.r, y)


def solve_step_two(problem, solver):
    """u = rho_s (F0, F1, 1) of the constrained linear problem."""
    white = _Whitened.make(problem)
    scale = max(float(np.linalg.norm(white.target)), 1e-300)
    if not len(problem.constraints) and solver == "scipy-lm":
        found = optimize.least_squares(lambda y: y - white.target, np.zeros(3), method="lm", xtol=TINY, ftol=TINY, gtol=TINY)
        y, count, reason = found.x, int(found.nfev), found.message
    elif not len(problem.constraints):
        y, count, reason = white.target, 1, "linear"
    elif solver == "scipy-trf":
        y, count, reason = _cone_nnls(white)
    elif solver == "scipy-lm":
        y, count, reason = _cone_scipy_slsqp(white, scale)
    else:
        y, count, reason = _cone_nlopt(white, scale, solver in ("nlopt-slsqp", "nlopt-lbfgs"))
    u = white.back(y)
    return Solution(u, problem.cost(u), count, reason)


def _cone_nnls(white):
    dual, _ = optimize.nnls(white.rows.T, -white.target, maxiter=1000)
    active = white.rows[dual > 0.0]
    y = white.target
    if len(active):  # project on the face: exact where the primal of the dual loses digits
        basis = np.linalg.svd(active, full_matrices=False)
        directions = basis[2][basis[1] > 1e-12 * basis[1][0]]
        y = y - directions.T @ (directions @ y)
    return y, len(active), f"nnls, {len(active)} active"


def _cone_scipy_slsqp(white, scale):
    target = white.target / scale
    found = optimize.minimize(
        lambda y: (0.5 * float((y - target) @ (y - target)), y - target), np.zeros(3), jac=True, method="SLSQP",
        constraints={"type": "ineq", "fun": lambda y: white.rows @ y, "jac": lambda y: white.rows},
        options={"ftol": 1e-16, "maxiter": 500},
    )
    return found.x * scale, int(found.nit), f"scipy SLSQP: {found.message}"


def _cone_nlopt(white, scale, with_gradient):
    target = white.target / scale

    def objective(y, gradient):
        if gradient.size:
            gradient[:] = y - target
        return 0.5 * float((y - target) @ (y - target))

    def constraint(result, y, gradient):
        result[:] = -(white.rows @ y)
        if gradient.size:
            gradient[:] = -white.rows

    y, evaluations, reason = np.zeros(3), 0, "not run"
    for step in (0.3, 1e-2, 1e-4, 1e-6):
        opt = nlopt.opt(nlopt.LD_SLSQP if with_gradient else nlopt.LN_COBYLA, 3)
        opt.set_min_objective(objective)
        opt.add_inequality_mconstraint(constraint, np.full(len(white.rows), 1e-14))
        opt.set_initial_step(step)
        opt.set_xtol_abs(1e-14)
        opt.set_ftol_rel(1e-15)
        opt.set_maxeval(3000)
        try:
            y = opt.optimize(y)
            reason = _nlopt_reason(opt.last_optimize_result())
        except (nlopt.RoundoffLimited, RuntimeError) as error:
            reason = f"nlopt: {type(error).__name__}"
        evaluations += opt.get_numevals()
    return y * scale, evaluations, reason


def solve_step_two_by_enumeration(problem):
    """The exact minimum by trying every face of the cone (none, one, two constraints active, the apex): the judge of the others."""
    white = _Whitened.make(problem)
    faces = [white.target, np.zeros(3)]
    faces += [white.target - row * (row @ white.target) for row in white.rows]
    for one, two in itertools.combinations(white.rows, 2):
        edge = np.cross(one, two)
        length = np.linalg.norm(edge)
        if length > 1e-9:
            faces.append(edge / length * (edge @ white.target) / length)
    feasible = [y for y in faces if np.all(white.rows @ y >= -1e-11 * (np.linalg.norm(y) + 1e-300))]
    y = min(feasible, key=lambda y: float(np.sum((y - white.target) ** 2)))
    u = white.back(y)
    return Solution(u, problem.cost(u), len(faces), "enumeration")
