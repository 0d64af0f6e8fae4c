#!/usr/bin/env bash
# The judge of a change that must not change results: runs the program on some hundred command lines and prints a hash of every
# output. Every byte counts, apart from times, which are replaced before hashing, and the order in which a batch reports bad inputs.
#
#     scripts/validate/bytes.sh [OPTION...] > hashes.txt               sha256 and name of each output, sorted by name
#     scripts/validate/bytes.sh [OPTION...] --against hashes.txt       0: equal; 1: not, with a list of what differs
#
#     --binary PATH     the program (default: built here, in release mode)
#     --quick           the cases that touch each kind of output once; their names and hashes are those of the whole set
#     --work DIR        keeps inputs and outputs there (default: a temporary folder); outputs of two runs can then be compared
#     --threads N       threads of the program (default 2); the hashes must not depend on it
#     --allow PATTERN   names that may differ, such as 'help/*'; they are listed and do not count; may be repeated
#     --list            prints the commands instead of running them
#
# Test data: BRDFIT_DATA. Without it, what needs it is SKIPPED and not compared; where CI=true that is a failure.
data_is_optional=yes
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
python_environment numpy
binary=()
case " $* " in
*" --binary "* | *" --binary="* | *" --list "* | *" --help "* | *" -h "*) ;;
*)
    build_program
    binary=(--binary "$brdfit")
    ;;
esac
exec "$python" "$root/scripts/validate/bytes.py" "${binary[@]}" "$@"
