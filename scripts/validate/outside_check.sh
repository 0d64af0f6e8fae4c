#!/usr/bin/env bash
# Our reference mode against Mitsuba 3: a Lambert and a GGX sphere under the built-in sky, which Mitsuba gets as a map by latitude
# and longitude; a GGX floor of two widths under a rectangle light, at 1024 samples on both sides. Prints the differences; fails with 7 where one is above the bar.
#
#     scripts/validate/outside_check.sh [SPP]      samples per pixel of Mitsuba (default 256, about a minute each); ours takes 1024
data_is_optional=yes
source "$(dirname "$0")/../common.sh"
spp=${1:-256}
python_environment
temporary_folder
build_program
"$python" "$root/scripts/validate/outside_check.py" --self-check
declare -A sources=(
    [lambert]='{"lambert": [0.8, 0.5, 0.2]}'
    [ggx]='{"ggx": {"rho_d": [0, 0, 0], "rho_s": [0.9, 0.6, 0.3], "m": 0.2}}'
)
for name in lambert ggx; do
    cat >"$work/$name.json" <<SCENE
{
  "camera": {"eye": [3.0, 1.5, 1.0], "target": [0, 0, 0.1], "vertical_fov": 38, "width": 320, "height": 288},
  "light": {"procedural": {"kind": "sky"}},
  "materials": {"surface": {"source": ${sources[$name]}}},
  "objects": [{"mesh": {"sphere": {}}, "material": "surface"}]
}
SCENE
    "$brdfit" render "$work/$name.json" -o "$work/$name.exr" --mode reference --spp 1024 --background black \
        --light-map "$work/light.exr" --quiet
    "$python" "$root/scripts/validate/outside_check.py" "$work/$name.json" "$work/$name.exr" --light "$work/light.exr" --spp "$spp"
done
for alpha in 0.1 0.3; do
    cat >"$work/floor.json" <<SCENE
{
  "camera": {"eye": [0.4, -2.6, 0.9], "target": [0, 0.2, 0], "vertical_fov": 32, "width": 128, "height": 112},
  "lights": [{"rect": {"corner": [-0.6, -0.3, 1], "edges": [[0, 1, 0], [1.4, 0, 0]], "radiance": [4, 3, 2]}}],
  "materials": {"surface": {"source": {"ggx": {"rho_d": [0, 0, 0], "rho_s": [0.9, 0.6, 0.3], "alpha": $alpha}}}},
  "objects": [{"mesh": {"plane": {"size": 40}}, "material": "surface"}]
}
SCENE
    echo "floor under a rectangle, alpha = $alpha"
    "$brdfit" render "$work/floor.json" -o "$work/floor.exr" --mode reference --spp 1024 --quiet
    "$python" "$root/scripts/validate/outside_check.py" "$work/floor.json" "$work/floor.exr" --spp 1024
done
