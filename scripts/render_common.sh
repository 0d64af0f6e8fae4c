# Sourced by the scripts that render the pairs: the program, the materials that the scenes name, a folder that stays.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
python_environment
cargo build --quiet --release --manifest-path "$root/Cargo.toml"
brdfit=$target/release/brdfit
kept=$target/render
materials=$kept/materials
mkdir -p "$materials"
measured_files "$materials"
"$python" "$root/scripts/reference/published_fits.py" "$materials"
