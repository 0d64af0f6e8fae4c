# Sourced by the scripts that render the pairs: the program, the materials that the scenes name, a folder that stays.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
python_environment
build_program
kept=$target/render
materials=$kept/materials
mkdir -p "$materials"
measured_files "$materials"
"$python" "$root/scripts/reference/published_fits.py" "$materials"
