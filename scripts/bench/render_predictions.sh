#!/usr/bin/env bash
# Draws docs/images/predicted_*.png and prints how well bandwidth, level and variance were predicted; fails with 7 where a bar is
# missed.
#
#     scripts/bench/render_predictions.sh
source "$(dirname "$0")/../render_common.sh"
"$python" "$root/scripts/figures/prediction_pictures.py" "$brdfit" "$materials" "$kept" "$root/docs/images"
"$python" "$root/scripts/bench/render_predictions.py" "$brdfit" "$materials" "$kept" "$@"
