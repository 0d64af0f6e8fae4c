#!/usr/bin/env bash
# Spheres under a uniform light against the directional albedo by quadrature; fails with 7 where they differ by more than the bar.
#
#     scripts/validate/white_furnace.sh
source "$(dirname "$0")/../render_common.sh"
"$python" "$root/scripts/validate/white_furnace.py" "$brdfit" "$materials"
