#!/usr/bin/env python3
"""Our costs against the best of several reference solvers: the closing figures of scripts/reference/compare_reference.sh.

    solver_truth.py FOLDER      FOLDER/<set>/brdfit/*.json and FOLDER/<set>/<solver>/*.json

Step 2 starts from step 1's result, so its costs are judged against the solvers whose step 1 ended at ours (1e-6 relative).
Bars: never above 1.0001 times the best; at most 1 + 1e-6 times in 99 % of the fits; E, L, C of the two programs within 1e-3.
"""
import json
import sys
from pathlib import Path

NEVER_ABOVE = 1.0001
EQUAL = 1.0 + 1e-6
SHARE = 0.99
ERRORS = 1e-3
SAME_STEP_1 = 1e-6


def steps(document, channel):
    return [step["cost"] for step in document["channels"][channel]["steps"]]


def main():
    ratios, errors = [], []
    for ours_path in sorted(Path(sys.argv[1]).glob("*/brdfit/*.json")):
        if ours_path.name.startswith("summary"):
            continue
        ours = json.loads(ours_path.read_text())
        references = [json.loads(path.read_text()) for path in sorted(ours_path.parent.parent.glob(f"*/{ours_path.name}"))
                      if path.parent.name != "brdfit"]
        assert references, f"no reference fit of {ours_path.stem}"
        for channel in range(3):
            name = f"{ours_path.stem} {'RGB'[channel]}"
            cost_1, cost_2 = steps(ours, channel)
            theirs = [steps(reference, channel) for reference in references]
            ratios.append((cost_1 / min(t[0] for t in theirs), f"{name} step 1"))
            same = [t[1] for t in theirs if abs(t[0] / cost_1 - 1.0) <= SAME_STEP_1]
            if same:
                ratios.append((cost_2 / min(same), f"{name} step 2"))
            for reference in references:
                if "errors" in reference and abs(steps(reference, channel)[0] / cost_1 - 1.0) <= SAME_STEP_1:
                    for kind in "ELC":
                        ratio = ours["errors"][kind][channel] / reference["errors"][kind][channel]
                        errors.append((abs(ratio - 1.0), f"{name} {kind}"))
    worst = max(ratios)
    share = sum(ratio <= EQUAL for ratio, _ in ratios) / len(ratios)
    worst_error = max(errors)
    print(f"costs: {len(ratios)} compared with the best of the reference solvers; "
          f"largest ratio {worst[0]:.10f} ({worst[1]}), smallest {min(ratios)[0]:.10f}; "
          f"at most 1 + 1e-6 in {100 * share:.1f} %")
    print(f"E, L, C: {len(errors)} compared with NumPy's; largest relative difference {worst_error[0]:.1e} ({worst_error[1]})")
    missed = worst[0] > NEVER_ABOVE or share < SHARE or worst_error[0] > ERRORS
    if missed:
        print("a bar is missed", file=sys.stderr)
    sys.exit(7 if missed else 0)


if __name__ == "__main__":
    main()
