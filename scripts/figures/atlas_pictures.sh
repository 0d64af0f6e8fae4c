#!/usr/bin/env bash
# Makes docs/images/lobe_bandwidth.png: lobes of a diffuse, a glossy and a chrome-like material beside their bandwidth.
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
names="pink-felt gold-metallic-paint chrome"
build_example lobe_pictures
# shellcheck disable=SC2086 # a list of names
"$python" "$root/scripts/reference/published_fits.py" "$work" $names
files=()
for name in $names; do
    files+=("$work/$name.json")
done
"$example" "$work/values.f32" "${files[@]}"
# shellcheck disable=SC2086 # a list of names
"$python" "$root/scripts/figures/lobe_pictures.py" "$work/values.f32" "$root/docs/images/lobe_bandwidth.png" $names
