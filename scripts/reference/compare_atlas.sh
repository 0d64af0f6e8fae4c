#!/usr/bin/env bash
# Truth of the atlas: texels of ours against those of the numpy and PyWavelets program on five materials, and the times of both
# on all tiles of one. Prints the tables of docs/accuracy.md; fails with 7 where a bar is missed.
#
#     scripts/reference/compare_atlas.sh
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
build_program
measured_files "$work/measured"
"$python" "$root/scripts/reference/published_fits.py" "$work/fits" gold-metallic-paint chrome blue-rubber
"$python" "$root/scripts/reference/compare_atlas.py" "$brdfit" "$work/fits" "$work/measured"
