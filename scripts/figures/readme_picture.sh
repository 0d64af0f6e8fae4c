#!/bin/sh
# Makes docs/images/slices.svg, the picture of the README: an embedded material with noise, fitted and drawn. The noise is
# lognormal per cell (sigma 0.6), so that the slices, means over 180 cells, scatter by 5 %.
set -eu
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
name=gold-metallic-paint
brdfit() { cargo run --quiet --release -- --quiet "$@"; }
brdfit synth "$name" --noise 0.6 --seed 1 -o "$work/$name-with-noise.binary"
brdfit fit "$work/$name-with-noise.binary" --picture -o "$work"
mkdir -p docs/images
cp "$work/$name-with-noise.svg" docs/images/slices.svg
