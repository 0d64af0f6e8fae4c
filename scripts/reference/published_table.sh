#!/usr/bin/env bash
# Ours against the published parameters: makes MERL files of the 100 materials from the factor tables, a few at a time in a
# temporary folder, fits them, judges our parameters and the published ones on them, and fits files made from the published
# parameters. Writes docs/published_comparison.md and prints its summary; fails where a bar of accuracy is missed.
#
#     scripts/reference/published_table.sh [OUTPUT.md]      (default: docs/published_comparison.md)
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
output=${1:-$root/docs/published_comparison.md}
build_example published_comparison
compare() { "$example" "$data/tables/sgd_published.json" "$@"; }
mapfile -t names < <(make_merl list)
for ((first = 0; first < ${#names[@]}; first += 4)); do
    files=()
    for name in "${names[@]:first:4}"; do
        files+=("$work/$name.binary")
    done
    printf '%s\n' "${names[@]:first:4}" |
        xargs -P 2 -I NAME "$python" "$root/scripts/fixtures/make_merl.py" npf NAME "$work/NAME.binary"
    compare reconstruction edge "${files[@]}" >>"$work/reconstruction.jsonl"
    rm "$work"/*.binary
done
for position in edge centre; do
    compare recovery "$position" >"$work/recovery-$position.jsonl"
done
"$python" "$root/scripts/reference/published_table.py" "$work" "$output"
