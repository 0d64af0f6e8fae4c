#!/usr/bin/env bash
# Makes docs/images/lobe_bandwidth.png: lobes of a diffuse, a glossy and a chrome-like material beside their bandwidth.
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
names="pink-felt gold-metallic-paint chrome"
cargo build --quiet --release --manifest-path "$root/Cargo.toml" -p brdfit-bandwidth --example lobe_pictures
# shellcheck disable=SC2086 # a list of names
"$python" "$root/scripts/reference/published_fits.py" "$work" $names
files=()
for name in $names; do
    files+=("$work/$name.json")
done
"$target/release/examples/lobe_pictures" "$work/values.f32" "${files[@]}"
# shellcheck disable=SC2086 # a list of names
"$python" "$root/scripts/figures/lobe_pictures.py" "$work/values.f32" "$root/docs/images/lobe_bandwidth.png" $names
