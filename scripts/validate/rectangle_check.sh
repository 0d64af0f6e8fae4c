#!/usr/bin/env bash
# Lambertian floors under rectangle lights in reference mode against Lambert's polygon formula; fails with 7 where the mean of a
# block of 32 x 32 pixels differs by 0.1 % or more.
#
#     scripts/validate/rectangle_check.sh [SPP]      samples per pixel (default 4096, about a minute)
data_is_optional=yes
source "$(dirname "$0")/../common.sh"
python_environment
temporary_folder
build_program
"$python" "$root/scripts/validate/rectangle_check.py" "$brdfit" "$work" --spp "${1:-4096}"
