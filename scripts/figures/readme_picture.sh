#!/usr/bin/env bash
# Makes docs/images/slices.svg: an embedded material with noise, fitted and drawn. The noise is lognormal per cell (sigma 0.6), so
# that the slices, means over 180 cells, scatter by 5 %.
data_is_optional=yes
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
temporary_folder
build_program
name=gold-metallic-paint
"$brdfit" synth --quiet "$name" --noise 0.6 --seed 1 -o "$work/$name-with-noise.binary"
"$brdfit" fit --quiet "$work/$name-with-noise.binary" --picture -o "$work"
cp "$work/$name-with-noise.svg" "$root/docs/images/slices.svg"
