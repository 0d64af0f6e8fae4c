# Sourced by the scripts beside it: where things are, the Python environment, the test files.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
BRDFIT_DATA=${BRDFIT_DATA:-$root/../shared/data}
data=$(cd "$BRDFIT_DATA" 2>/dev/null && pwd) || data=
if [ -z "$data" ] && [ -z "${data_is_optional:-}" ]; then # set by scripts that can leave parts out
    echo "no test data in $BRDFIT_DATA: set BRDFIT_DATA" >&2
    exit 2
fi
export BRDFIT_DATA=${data:-$BRDFIT_DATA}
target=${CARGO_TARGET_DIR:-$root/target}

# python_environment [PACKAGE]: a virtual environment with the packages of scripts/requirements.txt, made once below the target
# folder; with an argument, a smaller one with this package only, unless the whole one is there.
python_environment() {
    local requirements=$root/scripts/requirements.txt venv=$target/venv stamp
    stamp=$(sha256sum "$requirements" | cut -c1-16)
    if [ $# -gt 0 ] && [ ! -e "$venv/$stamp" ]; then
        venv=$target/venv-$1
    fi
    if [ ! -e "$venv/$stamp" ]; then
        rm -rf "$venv"
        python3 -m venv "$venv"
        grep "^${1:+$1==}" "$requirements" | "$venv/bin/pip" install --quiet --disable-pip-version-check -r /dev/stdin
        touch "$venv/$stamp"
    fi
    python=$venv/bin/python
}

# Makes MERL files and unpacks them; see its head.
make_merl() {
    "$python" "$root/scripts/fixtures/make_merl.py" "$@"
}

# measured_files DIR: the six measured materials (sample position: centre).
measured_files() {
    make_merl unpack "$1"
}

# reconstructed_files DIR NAME...: MERL files of the named materials from the factor tables (sample position: edge).
reconstructed_files() {
    local dir=$1 name
    shift
    mkdir -p "$dir"
    for name in "$@"; do
        [ -s "$dir/$name.binary" ] || make_merl npf "$name" "$dir/$name.binary"
    done
}

# A temporary folder that goes with the script.
temporary_folder() {
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
}

twelve="alum-bronze aluminium beige-fabric black-obsidian blue-rubber chrome colonial-maple-223 gold-metallic-paint nickel
pink-felt red-metallic-paint white-paint"
