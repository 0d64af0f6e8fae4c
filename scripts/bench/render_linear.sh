#!/usr/bin/env bash
# Prints shading time against samples, and the pixels shaded per level; fails with 7 where the time is not linear. To be run on an
# idle machine with two cores.
#
#     scripts/bench/render_linear.sh [--pairs NAME...]
source "$(dirname "$0")/../render_common.sh"
"$python" "$root/scripts/bench/render_linear.py" "$brdfit" "$materials" "$kept" "$@"
