#!/usr/bin/env python3
"""Fit MERL files by scipy or NLopt: an implementation of docs/theory.md, sections 1 to 6, that shares nothing with the program.

    reference_fit.py INPUT.binary... -o DIR --solver scipy-trf

writes DIR/<stem>.json, the part of the program's result document that `brdfit compare` reads. The solvers are described
in brdfit_reference/solvers.py. Needs scripts/requirements.txt.
"""
import argparse
import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from brdfit_reference.document import Options, assemble, error_panel, fit_slices
from brdfit_reference.merl import Grid, Merl
from brdfit_reference.objective import CONSTRAINTS, LOSSES
from brdfit_reference.solvers import SOLVERS


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("inputs", nargs="+", type=Path, metavar="INPUT.binary")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    parser.add_argument("--solver", choices=SOLVERS, default="scipy-trf")
    parser.add_argument("--sample-position", choices=("edge", "centre"), default="edge")
    parser.add_argument(
        "--constraint", choices=CONSTRAINTS, default="physical",
        help="default: physical; paper: plain least squares in both steps, free, not anchored, theta_d <= 70",
    )
    parser.add_argument("--loss", choices=LOSSES, help="residual of step 1 (default: log1p-cos; with --constraint paper: l2)")
    parser.add_argument("--starts", default="default", help="default, or random:N for N further starts")
    parser.add_argument("--cutoff-theta-h", type=float, default=75.0, metavar="DEGREES")
    parser.add_argument("--cutoff-theta-d", type=float, metavar="DEGREES", help="default: 75; with --constraint paper: 70")
    parser.add_argument("--slices-only", action="store_true", help="leave the error panel out")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="files at the same time")
    parser.add_argument("--timing", action="store_true", help="print the seconds of each file's fits")
    return parser.parse_args()


def options_of(args):
    """The options with the defaults that depend on the constraint."""
    paper = args.constraint == "paper"
    kind, _, count = args.starts.partition(":")
    if kind not in ("default", "random") or (kind == "random") != count.isdigit():
        sys.exit("--starts: default or random:N")
    return Options(
        solver=args.solver,
        sample_position=args.sample_position,
        constraint=args.constraint,
        loss=args.loss or ("l2" if paper else "log1p-cos"),
        cutoff_theta_h=args.cutoff_theta_h,
        cutoff_theta_d=args.cutoff_theta_d or (70.0 if paper else 75.0),
        random_starts=int(count or 0),
    )


def run(path, output, options, with_errors):
    """Fit one file, write its document, return its name and the seconds of reading, of slices and fits, of the error panel."""
    clock = [time.perf_counter()]
    merl = Merl.read(path)
    clock.append(time.perf_counter())
    grid = Grid.make(options.sample_position, merl.n_phi)
    h, d, fits = fit_slices(merl, grid, options)
    clock.append(time.perf_counter())
    errors = error_panel(merl, grid, fits) if with_errors else None
    clock.append(time.perf_counter())
    document = assemble(merl, options, h, d, fits, errors)
    part = output / f".{path.stem}.json.part"
    part.write_text(json.dumps(document, allow_nan=False, indent=1) + "\n", encoding="utf-8")
    os.replace(part, output / f"{path.stem}.json")
    return path.stem, *(after - before for before, after in zip(clock, clock[1:]))


def main():
    args = arguments()
    options = options_of(args)
    args.output.mkdir(parents=True, exist_ok=True)
    tasks = [(path, args.output, options, not args.slices_only) for path in args.inputs]
    if args.jobs > 1:
        with ProcessPoolExecutor(args.jobs) as pool:
            results = list(pool.map(run, *zip(*tasks)))
    else:
        results = [run(*task) for task in tasks]
    if args.timing:
        totals = ("total", *(sum(column) for column in list(zip(*results))[1:]))
        for name, read, fit, errors in (*results, totals):
            print(f"{name}: read {read:.3f} s, slices and fits {fit:.3f} s, error panel {errors:.3f} s")


if __name__ == "__main__":
    main()
