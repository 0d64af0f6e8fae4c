# Sourced by the scripts below it: where things are, the Python environment, the program, the test files.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
named_data=${BRDFIT_DATA:-}
BRDFIT_DATA=${BRDFIT_DATA:-$root/../shared/data}
data=$(cd "$BRDFIT_DATA" 2>/dev/null && pwd) || data=
if [ -z "$data" ] && [ -z "${data_is_optional:-}" ]; then # set by scripts that can leave parts out
    echo "no test data in $BRDFIT_DATA: set BRDFIT_DATA, or make stand-ins with scripts/fixtures/make_stand_ins.sh" >&2
    exit 2
fi
export BRDFIT_DATA=${data:-$BRDFIT_DATA}
target=${CARGO_TARGET_DIR:-$root/target}

# Stand-ins for the test data (CONTRIBUTING.md): said at once, taken in CI only where they are named, and no bar counts on them.
stand_ins=
if [ -n "$data" ] && [ -e "$data/STAND_INS" ] && [ -z "${data_is_optional:-}" ]; then
    if [ "${CI:-}" = true ] && [ -z "$named_data" ]; then
        echo "$data holds stand-ins and CI=true: name them by BRDFIT_DATA, or provide the genuine data" >&2
        exit 2
    fi
    stand_ins=yes
    echo "STAND-INS: $data is no genuine data; figures differ from those in docs/" >&2
fi

# What happens at the end of every script: the temporary folder goes; a bar (exit code 7) that was missed on stand-ins is forgiven.
work=
finish() {
    local status=$?
    [ -z "$work" ] || rm -rf "$work"
    if [ "$status" -eq 7 ] && [ -n "$stand_ins" ]; then
        echo "NOT COUNTED: a bar was missed, on stand-ins" >&2
        exit 0
    fi
}
trap finish EXIT

# A folder, $work, that goes with the script.
temporary_folder() {
    work=$(mktemp -d)
}

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

# Builds the program for use, $brdfit.
build_program() {
    cargo build --quiet --release --locked --manifest-path "$root/Cargo.toml"
    brdfit=$target/release/brdfit
}

# build_example NAME [OPTION...]: builds an example, $example. All members are selected, as by `cargo test`: with one package
# alone the features of its dependencies are others, and all of them are compiled again.
build_example() {
    local name=$1 profile=debug
    shift
    case " $* " in *" --release "*) profile=release ;; esac
    cargo build --quiet --locked --manifest-path "$root/Cargo.toml" --example "$name" "$@"
    example=$target/$profile/examples/$name
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

twelve="alum-bronze aluminium beige-fabric black-obsidian blue-rubber chrome colonial-maple-223 gold-metallic-paint nickel
pink-felt red-metallic-paint white-paint"
