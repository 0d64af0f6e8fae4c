#!/usr/bin/env bash
# Prints the studies of the bandwidth atlas in docs/accuracy.md: the error of a look-up, and compression by principal components
# against the mip level of the same size. Fails with 7 where the bar of the look-up is missed.
#
#     scripts/figures/atlas_study.sh
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
build_program
build_example lookup_error --release
measured_files "$work/measured"
"$python" "$root/scripts/reference/published_fits.py" "$work/fits"
for layout in isotropic hemisphere; do
    make() { "$brdfit" atlas --quiet --formats ktx2 --layout $layout "$@"; }
    make "$work/fits" -o "$work/$layout/fitted"
    make "$work/measured" --sample-position centre -o "$work/$layout/measured"
    "$python" "$root/scripts/figures/atlas_pca.py" "$work/$layout/fitted" "$work/$layout/measured"
    echo
done
five=()
for name in pink-felt blue-rubber gold-metallic-paint nickel chrome; do
    five+=("$work/fits/$name.json")
done
"$example" "${five[@]}" "$work"/measured/{paper_white,chm_mint}.binary
