#!/usr/bin/env bash
# Prints the table of atlases in docs/performance.md: single atlases of fitted and measured materials, and a batch of the 100
# published ones.
#
#     scripts/bench/performance_atlas.sh
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
build_program
measured_files "$work/measured"
"$python" "$root/scripts/reference/published_fits.py" "$work/fits"
"$python" "$root/scripts/bench/performance_atlas.py" "$brdfit" "$work/fits" "$work/measured"
