#!/usr/bin/env bash
# Prints the tables of equal time against constant samples and a denoiser; fails with 7 where a bar is missed. To be run on an idle
# machine with two cores.
#
#     scripts/bench/render_denoised.sh [--pairs NAME...] [-- OPTIONS of brdfit render]
source "$(dirname "$0")/../render_common.sh"
"$python" "$root/scripts/bench/render_denoised.py" "$brdfit" "$materials" "$kept" "$@"
