#!/usr/bin/env bash
# Prints the tables of docs/performance.md: times of a batch of 100 materials and the ratio to the scipy reference.
#
#     scripts/bench/performance.sh [FOLDER]     FOLDER keeps the 100 MERL files, 3.5 GB (default: a temporary one)
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
files=${1:-$work/files}
build_program
mapfile -t names < <(make_merl list)
reconstructed_files "$files" "${names[@]}"
"$python" "$root/scripts/bench/performance.py" "$brdfit" "$files"
