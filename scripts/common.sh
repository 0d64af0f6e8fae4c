# Sourced by the scripts beside it: where things are, the Python environment, the test files.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
BRDFIT_DATA=${BRDFIT_DATA:-$root/../shared/data}
data=$(cd "$BRDFIT_DATA" 2>/dev/null && pwd) || { echo "no test data in $BRDFIT_DATA: set BRDFIT_DATA" >&2; exit 2; }
export BRDFIT_DATA=$data
tools=$data/../tools
target=${CARGO_TARGET_DIR:-$root/target}

# A virtual environment with the packages of scripts/requirements.txt, made once below the target folder.
python_environment() {
    local venv=$target/venv stamp
    stamp=$venv/$(sha256sum "$root/scripts/requirements.txt" | cut -c1-16)
    if [ ! -e "$stamp" ]; then
        rm -rf "$venv"
        python3 -m venv "$venv"
        "$venv/bin/pip" install --quiet --disable-pip-version-check -r "$root/scripts/requirements.txt"
        touch "$stamp"
    fi
    python=$venv/bin/python
}

# measured_files DIR: the six measured materials (sample position: centre).
measured_files() {
    bash "$tools/unpack_data.sh" "$1" >/dev/null
}

# reconstructed_files DIR NAME...: MERL files of the named materials from the factor tables (sample position: edge).
reconstructed_files() {
    local dir=$1 name
    shift
    mkdir -p "$dir"
    for name in "$@"; do
        [ -s "$dir/$name.binary" ] || "$python" "$tools/make_merl.py" npf "$name" "$dir/.$name.part"
        [ -s "$dir/$name.binary" ] || mv "$dir/.$name.part" "$dir/$name.binary"
    done
}

# A temporary folder that goes with the script.
temporary_folder() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
}

twelve="alum-bronze aluminium beige-fabric black-obsidian blue-rubber chrome colonial-maple-223 gold-metallic-paint nickel
pink-felt red-metallic-paint white-paint"
