#!/usr/bin/env bash
# Makes the picture at the head of the README: docs/images/materials.png, measured materials above their fits.
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
cd "$root"
python_environment
temporary_folder
build_program
measured_files "$work/measured"
"$brdfit" fit --quiet --no-panel --sample-position centre "$work/measured" -o "$work/fits"
"$python" scripts/figures/render_materials.py "$brdfit" "$work/measured" "$work/fits" "$work" docs/images/materials.png
