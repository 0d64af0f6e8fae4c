#!/usr/bin/env bash
# Every texel of every level of a folder of atlases, read by programs that are not ours: the OpenEXR files by Python's OpenEXR
# and OpenImageIO, the KTX2 files by npm's ktx-parse and by ktx2.py, and both formats of one atlas against each other. Prints
# one line per file and level; fails at the first difference.
#
#     scripts/validate/atlas/check_atlas_files.sh FOLDER      FOLDER holds NAME.exr and NAME.ktx2, in any depth of folders
[ $# -eq 1 ] && [ -d "$1" ] || { echo "usage: scripts/validate/atlas/check_atlas_files.sh FOLDER" >&2; exit 1; }
data_is_optional=yes
source "$(dirname "$0")/../../common.sh"
python_environment
temporary_folder
modules=$target/node
if [ ! -e "$modules/node_modules/ktx-parse" ]; then
    mkdir -p "$modules"
    npm install --silent --no-audit --no-fund --no-save --prefix "$modules" ktx-parse@2.0.0
fi
mapfile -t exr < <(find "$1" -name '*.exr' | sort)
mapfile -t ktx2 < <(find "$1" -name '*.ktx2' | sort)
[ ${#exr[@]} -gt 0 ] && [ ${#ktx2[@]} -gt 0 ] || { echo "$1: no atlases in both formats" >&2; exit 1; }
for file in "${exr[@]}"; do
    against=()
    [ ! -e "${file%.exr}.ktx2" ] || against=(--against "${file%.exr}.ktx2")
    "$python" "$root/scripts/validate/atlas/read_atlas_exr.py" "$file" "${against[@]}"
done
for file in "${ktx2[@]}"; do
    node "$root/scripts/validate/atlas/read_atlas_ktx2.mjs" "$modules" "$file" "$work"
    "$python" "$root/scripts/validate/atlas/check_ktx2.py" "$file" "$work"
done
echo "${#exr[@]} OpenEXR and ${#ktx2[@]} KTX2 files: every texel of every level agrees"
