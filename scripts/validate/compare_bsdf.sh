#!/usr/bin/env bash
# RGL .bsdf files against Mitsuba 3 and an independent reader; fits of them beside fits of the MERL files that were resampled
# from them. Prints the tables of docs/accuracy.md; ends with 7 where a bar is missed.
#
#     scripts/validate/compare_bsdf.sh
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
build_program
build_example evaluate
script=$root/scripts/validate/compare_bsdf.py
status=0
"$python" "$script" "$example" "$root"/data-fixtures/*_rgb.bsdf "$data"/measured/*_rgb.bsdf || status=$?
measured_files "$work/merl"
"$brdfit" fit --quiet "$work/merl" -o "$work/of_merl" --sample-position centre
"$brdfit" fit --quiet "$data/measured" -o "$work/of_bsdf"
pairs=()
for file in "$work"/merl/*.binary; do
    name=$(basename "$file" .binary)
    pairs+=("$work/of_bsdf/${name}_rgb.json" "$work/of_merl/$name.json")
done
"$python" "$script" --fits "${pairs[@]}"
exit "$status"
