#!/usr/bin/env python3
"""Compare values of RGL .bsdf files: ours, those of an independent reader, and those of Mitsuba 3 (PyPI: mitsuba).

    compare_bsdf.py EVALUATE FILE.bsdf ...           EVALUATE: the built example of src/measured/examples/evaluate.rs
    compare_bsdf.py --fits FIT.json OTHER.json ...   pairs of fits: errors E, L, C and parameters side by side

Pairs of directions up to 80 degrees with the normal, a third of them near the mirror direction. Differences are relative to
the value, at least 1e-6/sr. Ends with 7 where the median to Mitsuba exceeds 1e-4.
"""
import argparse
import json
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "fixtures"))
import rgl_bsdf  # noqa: E402

PAIRS = 2000
BAR = 1e-4


def ours(evaluate, path, i, o):
    text = "".join(" ".join(map(repr, row)) + "\n" for row in np.concatenate([i, o], axis=1).tolist())
    ran = subprocess.run([evaluate, path], input=text, capture_output=True, text=True, check=True)
    return np.array([line.split() for line in ran.stdout.splitlines()], float)


def mitsubas(path, i, o):
    """f = eval / cos theta_o of the plugin `measured`, with i for its wi."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    bsdf = mi.load_dict({"type": "measured", "filename": path})
    found = []
    for wi, wo in zip(i.tolist(), o.tolist()):
        surface = mi.SurfaceInteraction3f()
        surface.wi = wi
        found.append(np.array(bsdf.eval(mi.BSDFContext(), surface, mi.Vector3f(wo))) / wo[2])
    return np.array(found)


def difference(values, reference):
    """Median, 99th percentile and largest."""
    relative = np.abs(values - reference) / np.maximum(np.abs(reference), 1e-6)
    return [np.median(relative), np.percentile(relative, 99), relative.max()]


def non_reciprocity(evaluate, path, i, o):
    near = np.minimum(i[:, 2], o[:, 2]) > np.cos(np.radians(75))
    there, back = (ours(evaluate, path, a[near], b[near]).mean(axis=1) for a, b in ((i, o), (o, i)))
    return np.median(np.abs(there - back) / ((there + back) / 2))


def values(evaluate, paths):
    i, o = rgl_bsdf.pairs(PAIRS, seed=7)
    worst = 0
    print("| file | ours against Mitsuba: median, 99 %, largest | ours against the reader | non-reciprocity |\n|---|---|---|---|")
    for path in paths:
        found, theirs = ours(evaluate, path, i, o), mitsubas(path, i, o)
        to_mitsuba = difference(found, theirs)
        to_reader = difference(found, rgl_bsdf.evaluate(rgl_bsdf.read(path), i, o))
        columns = [", ".join(f"{x:.1e}" for x in numbers) for numbers in (to_mitsuba, to_reader)]
        name = pathlib.Path(path).stem.removesuffix("_rgb")
        print(f"| {name} | {columns[0]} | {columns[1]} | {non_reciprocity(evaluate, path, i, o):.3f} |")
        worst = max(worst, to_mitsuba[0])
    return worst


def fits(paths):
    print("| material | E, L, C of the .bsdf | of the .binary | largest ratio - 1 | alpha | rho_d | rho_s F(0) |\n|---|---|---|---|---|---|---|")
    for one, other in zip(paths[::2], paths[1::2]):
        documents = [json.loads(pathlib.Path(path).read_text(encoding="utf-8")) for path in (one, other)]
        panels = [[document["errors"]["over_channels"][name] for name in "ELC"] for document in documents]
        ratio = max(abs(a / b - 1) for name in "ELC" for a, b in zip(*(d["errors"][name] for d in documents)))

        def largest(of):
            pairs = zip(*(document["channels"] for document in documents))
            return max(abs(of(a) / of(b) - 1) if of(b) else abs(of(a)) for a, b in pairs)

        moved = [largest(of) for of in (lambda c: c["parameters"]["alpha"], lambda c: c["parameters"]["rho_d"],
                                        lambda c: c["derived"]["fr"])]
        name = documents[1]["input"]["name"]
        columns = [", ".join(f"{x:.4f}" for x in panel) for panel in panels] + [f"{x:.1e}" for x in [ratio, *moved]]
        print(f"| {name} | " + " | ".join(columns) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fits", action="store_true")
    parser.add_argument("arguments", nargs="+")
    arguments = parser.parse_args()
    if arguments.fits:
        fits(arguments.arguments)
        sys.exit(0)
    sys.exit(7 if values(arguments.arguments[0], arguments.arguments[1:]) > BAR else 0)


if __name__ == "__main__":
    main()
