#!/usr/bin/env bash
# Prints the tables of equal quality against constant samples per pixel; fails with 7 where a bar is missed. References stay below
# target/render. To be run on an idle machine with two cores.
#
#     scripts/bench/render_quality.sh [--pairs NAME...] [--budgets N...]
source "$(dirname "$0")/../render_common.sh"
"$python" "$root/scripts/bench/render_quality.py" "$brdfit" "$materials" "$kept" "$@"
