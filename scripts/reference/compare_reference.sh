#!/usr/bin/env bash
# Truth of the solver: our fits of the six measured materials (centre) and of twelve reconstructions (edge) against the Python
# reference fits by four solvers of scipy and NLopt: same data, objective, bounds and starts. Prints the comparison with each
# solver and, at the end, both figures that docs/accuracy.md quotes; fails where a bar is missed.
#
#     scripts/reference/compare_reference.sh [FOLDER]      FOLDER keeps the fits (default: a temporary one)
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
out=${1:-$work/fits}
build_program
measured_files "$work/measured"
# shellcheck disable=SC2086 # a list of names
reconstructed_files "$work/reconstructed" $twelve
solvers="scipy-trf scipy-lm nlopt-slsqp nlopt-bobyqa"
for set in measured:centre reconstructed:edge; do
    files=$work/${set%:*} position=${set#*:}
    ours=$out/${set%:*}/brdfit
    "$brdfit" fit "$files" -o "$ours" --sample-position "$position" --quiet
    for solver in $solvers; do
        theirs=$out/${set%:*}/$solver
        # the error panel once: it does not depend on the solver
        panel=--slices-only
        [ "$solver" != scipy-trf ] || panel=
        # shellcheck disable=SC2086 # an option or none
        "$python" "$root/scripts/reference/reference_fit.py" "$files"/*.binary -o "$theirs" --solver "$solver" \
            --sample-position "$position" --jobs 2 $panel
        echo "== ${set%:*}, $solver"
        "$brdfit" compare "$ours" "$theirs" || [ $? -eq 7 ]
    done
done
"$python" "$root/scripts/reference/solver_truth.py" "$out"
