#!/usr/bin/env python3
"""Runs the cases of bytes_cases.py and hashes their outputs; see bytes.sh, which calls this."""
import argparse
import fnmatch
import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reference"))  # for brdfit_reference

import bytes_inputs
from brdfit_reference.merl import data_folder
from bytes_cases import all_cases

WITHOUT_THREADS = ("", "help", "man", "completions", "schema", "export", "merge", "--help", "-h", "--version")
"""Command lines that get no --threads; nor do those that end in help, or are to fail: usage texts would name it."""
BATCHES = ("fit ", "atlas ")
"""Commands that report a bad input as soon as they meet it: with several threads, lines about errors come in any order."""
LIMIT = 300
"""Seconds that one command may take."""


def say(text):
    print(f"bytes: {text}", file=sys.stderr, flush=True)


def command(line, folder, threads):
    """The arguments of a command line."""
    arguments = shlex.split(line.replace("OUT", folder))
    first = arguments[0] if arguments else ""
    if first in WITHOUT_THREADS or "--help" in arguments or "-h" in arguments or folder.startswith("out/failures/"):
        return arguments
    return [*arguments, "--threads", str(threads)]


def run(binary, case, work, threads):
    """Runs the lines of a case; leaves stdout, stderr and exit code beside the outputs, those of several lines numbered."""
    name = f"out/{case.name}"
    folder = work / name
    folder.mkdir(parents=True)
    environment = {"PATH": os.environ.get("PATH", ""), "LC_ALL": "C.UTF-8"}
    for n, line in enumerate(case.lines, 1):
        mark = f"-{n}" if len(case.lines) > 1 else ""
        try:
            ran = subprocess.run(["brdfit", *command(line, name, threads)], executable=binary, cwd=work, env=environment,
                                 input=case.stdin.encode(), capture_output=True, timeout=LIMIT)  # fmt: skip
            code, out, err = ran.returncode, ran.stdout, ran.stderr
        except subprocess.TimeoutExpired:
            code, out, err = f"none: stopped after {LIMIT} s", b"", b""
        (folder / f"exit-code{mark}").write_text(f"{code}\n")
        err = without_times(err)
        if line.startswith(BATCHES):
            err = in_order(err)
        for stream, content in (("stdout", out), ("stderr", err)):
            if content:
                (folder / f"{stream}{mark}").write_bytes(content)
    for path in folder.rglob("*.stats.json"):
        path.write_bytes(without_milliseconds(path.read_bytes()))


def without_times(text):
    """Durations of messages, such as "0.22 s" and "5 ms"."""
    return re.sub(rb"\b\d+(\.\d+)? (ms|s|min)\b", rb"TIME", text)


def in_order(text):
    """Neighbouring lines about errors, sorted."""
    return re.sub(rb"(^error: .*\n)+", lambda found: b"".join(sorted(found.group().splitlines(keepends=True))), text, flags=re.M)


def without_milliseconds(text):
    """The member "milliseconds" of statistics; everything else stays byte by byte."""
    block = re.compile(rb'"milliseconds": \{[^{}]*\}')
    return block.sub(lambda found: re.sub(rb": [0-9.eE+-]+", rb": 0", found.group()), text)


def hashes(folder, prefix, work):
    """sha256 of every file below a folder, by name."""
    found = {}
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        content = path.read_bytes()
        name = f"{prefix}/{path.relative_to(folder).as_posix()}"
        if os.fsencode(work) in content:
            say(f"WARNING: {name} contains the path of the work folder")
        found[name] = hashlib.sha256(content).hexdigest()
    return found


def read_hashes(path):
    """A list that an earlier run printed."""
    found = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if not (match := re.fullmatch(r"([0-9a-f]{64})  (\S.*)", line)):
            sys.exit(f"bytes: {path}, line {number}: not a hash, two spaces and a name")
        found[match[2]] = match[1]
    return found


EXIT_CODES = {hashlib.sha256(f"{code}\n".encode()).hexdigest(): code for code in range(-64, 256)}


def describe(name, old, new):
    """What happened to an output; exit codes in words."""
    if old is None or new is None:
        return f"{'new' if old is None else 'missing':8} {name}"
    codes = EXIT_CODES.get(old), EXIT_CODES.get(new)
    words = f" (was {codes[0]}, is {codes[1]})" if "exit-code" in name and None not in codes else ""
    return f"changed  {name}{words}"


def belongs(name, cases):
    """The case whose output this is, or none: an input, or an output of a case that is no more."""
    parts = name.split("/")
    return next((cases[key] for n in range(len(parts), 0, -1) if (key := "/".join(parts[:n])) in cases), None)


def compare(old, new, cases, allowed):
    """Prints what differs, by case; the number of differences that count."""
    differences, counted = {}, 0
    tally = {"changed": 0, "missing": 0, "new": 0, "allowed": 0}
    for name in sorted(old.keys() | new.keys()):
        if old.get(name) == new.get(name):
            continue
        text = describe(name, old.get(name), new.get(name))
        if any(fnmatch.fnmatchcase(name, pattern) for pattern in allowed):
            text, kind = f"allowed  {text}", "allowed"
        else:
            kind, counted = text.split()[0], counted + 1
        tally[kind] += 1
        differences.setdefault(belongs(name, cases), []).append(text)
    for case, texts in differences.items():
        if case is not None:
            print(f"{case.name}: " + "; ".join(f"brdfit {line}" for line in case.lines).replace("OUT", f"out/{case.name}"))
        print("\n".join(f"    {text}" for text in texts))
    if any(name.startswith("input/") and old.get(name) not in (None, new.get(name)) for name in new):
        print("inputs differ (other data, or another processor or NumPy): what is computed from them says nothing")
    equal = sum(old.get(name) == value for name, value in new.items())
    print(f"{equal} outputs equal, " + ", ".join(f"{count} {kind}" for kind, count in tally.items()))
    return counted


def arguments():
    parser = argparse.ArgumentParser(prog="bytes.sh", description="Hashes of all outputs of the program; see the head of bytes.sh.")
    parser.add_argument("--binary", type=Path, help="the program (default: built here)")
    parser.add_argument("--quick", action="store_true", help="the cases that touch each kind of output once")
    parser.add_argument("--work", type=Path, help="folder that keeps inputs and outputs (default: a temporary one)")
    parser.add_argument("--threads", type=int, default=2, help="threads of the program (default 2)")
    parser.add_argument("--against", type=Path, metavar="HASHES", help="compare with these instead of printing")
    parser.add_argument("--allow", action="append", default=[], metavar="PATTERN", help="names that may differ, such as 'help/*'")
    parser.add_argument("--list", action="store_true", help="print the commands instead of running them")
    return parser.parse_args()


def select(cases, quick, missing):
    """The cases to run, with a loud word about those whose data is not there."""
    cases = [case for case in cases if case.quick or not quick]
    for part, files in missing.items():
        if files:
            count = sum(part in case.needs for case in cases)
            say(f"SKIPPED: {count} cases that need {part}: {files[0]} is not there; set BRDFIT_DATA")
    if any(missing.values()) and os.environ.get("CI") == "true":
        sys.exit("bytes: data is missing and CI=true")
    absent = {part for part, files in missing.items() if files}
    return [case for case in cases if not case.needs & absent]


def main():
    options = arguments()
    cases = all_cases(bytes_inputs.pair_names())
    if options.list:
        for case in cases:
            for line in case.lines:
                print(f"{case.name}{' (quick)' if case.quick else ''}: brdfit {line}")
        return 0
    if options.binary is None or not options.binary.is_file():
        sys.exit(f"bytes: {options.binary}: no such program; check --binary")
    old = read_hashes(options.against) if options.against else None
    data = data_folder()
    missing = bytes_inputs.available(data)
    chosen = select(cases, options.quick, missing)
    with tempfile.TemporaryDirectory(prefix="brdfit-bytes-") as temporary:
        work = (options.work or Path(temporary)).resolve()
        new = run_all(options, chosen, work, data, [part for part, files in missing.items() if not files])
    if old is None:
        print("\n".join(f"{value}  {name}" for name, value in sorted(new.items())))
        return 0
    by_name = {case.name: case for case in cases}
    ran = {case.name for case in chosen}
    left_out = [name for name in old if (case := belongs(name, by_name)) is not None and case.name not in ran]
    if left_out:
        say(f"{len(left_out)} outputs of {options.against} belong to cases that were not run, and are not compared")
    absent = {f"input/{part}" for part, files in missing.items() if files}
    left_out += [name for name in old if name.rpartition("/")[0] in absent and name not in new]
    old = {name: value for name, value in old.items() if name not in set(left_out)}
    return 1 if compare(old, new, by_name, options.allow) else 0


def run_all(options, cases, work, data, parts):
    """Inputs, outputs and their hashes."""
    start = time.monotonic()
    (work / "in").mkdir(parents=True, exist_ok=True)
    shutil.rmtree(work / "out", ignore_errors=True)
    bytes_inputs.make(work / "in", data, parts)
    say(f"inputs made, {time.monotonic() - start:.0f} s")
    found = hashes(work / "in", "input", work)
    binary = options.binary.resolve()
    times = {}
    for case in cases:
        began = time.monotonic()
        run(binary, case, work, options.threads)
        found.update(hashes(work / "out" / case.name, case.name, work))
        times[case.name] = time.monotonic() - began
        if len(times) % 50 == 0:
            say(f"{len(times)} of {len(cases)} cases, {time.monotonic() - start:.0f} s")
    slowest = sorted(times, key=times.get, reverse=True)[:5]
    say(f"{len(cases)} cases, {len(found)} hashes, {time.monotonic() - start:.0f} s; slowest: "
        + ", ".join(f"{name} {times[name]:.1f} s" for name in slowest))  # fmt: skip
    return found


if __name__ == "__main__":
    sys.exit(main())
