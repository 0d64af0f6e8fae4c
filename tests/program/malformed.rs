//! Inputs, options and outputs that cannot work: each ends with its own message and exit code.

use std::fs::{self, File};
use std::io::{Seek, SeekFrom, Write};

use crate::program::{GLOSSY, Workplace, result};

/// Size of a file with 180 bins of phi_d.
const BYTES: u64 = 34_992_012;

/// A file that starts with three integers and has a size; the rest is zeros (a black material).
fn grid(place: &Workplace, name: &str, dimensions: [i32; 3], size: u64) -> File {
    let mut file = File::create(place.path(name)).unwrap();
    file.write_all(&dimensions.map(i32::to_le_bytes).concat()).unwrap();
    file.set_len(size).unwrap();
    file
}

/// A black material with one wrong value.
fn spoilt(place: &Workplace, name: &str, index: u64, value: f64) {
    let mut file = grid(place, name, [90, 90, 180], BYTES);
    file.seek(SeekFrom::Start(12 + 8 * index)).unwrap();
    file.write_all(&value.to_le_bytes()).unwrap();
}

/// A material in which a cell is measured where `keep(theta_h bin, theta_d bin)` says so.
fn sparse(place: &Workplace, name: &str, keep: impl Fn(usize, usize) -> bool) {
    let mut bytes = [90_i32, 90, 180].map(i32::to_le_bytes).concat();
    for _ in 0..3 {
        for row in 0..8100 {
            let value: f64 = if keep(row / 90, row % 90) { 100.0 } else { -1.0 };
            bytes.extend(value.to_le_bytes().repeat(180));
        }
    }
    fs::write(place.path(name), bytes).unwrap();
}

/// Runs each case `(arguments, exit code, part of the message)` and holds it to what every failure has to keep.
pub(crate) fn check(place: &Workplace, cases: &[(&str, i32, &str)]) {
    for (line, code, part) in cases {
        let before = place.names(".");
        let ran = place.run(line);
        let shown = format!("brdfit {line}: {:?} {}", ran.code, ran.stderr);
        assert_eq!(ran.code, Some(*code), "{shown}");
        assert!(ran.stderr.starts_with("error: "), "{shown}");
        assert!(ran.stderr.contains(part), "no {part:?} in {shown}");
        assert!(!ran.stderr.contains("panicked"), "{shown}");
        assert!(ran.stdout.is_empty() || line.starts_with("info"), "{shown}: {}", ran.stdout);
        // What clap says about a command line takes more lines; everything else takes one.
        assert!(ran.stderr.lines().count() == 1 || ran.stderr.contains("--help"), "{shown}");
        assert_eq!(place.names("."), before, "something is left by {shown}");
    }
}

#[test]
fn measured_files() {
    let place = Workplace::new();
    place.put("empty.binary", "");
    place.put("byte.binary", [90]);
    place.put("eleven.binary", [90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0]);
    for (name, dimensions, size) in [
        ("header.binary", [90, 90, 180], 12),
        ("short.binary", [90, 90, 180], BYTES - 1),
        ("two-planes.binary", [90, 90, 180], 12 + (BYTES - 12) / 3 * 2),
        ("single-precision.binary", [90, 90, 180], 12 + (BYTES - 12) / 2),
        ("long.binary", [90, 90, 180], BYTES + 1),
        ("twice.binary", [90, 90, 180], 2 * BYTES),
        ("half-named-full.binary", [90, 90, 360], BYTES),
        ("full-named-half.binary", [90, 90, 180], 2 * BYTES - 12),
        ("zeros.binary", [0, 0, 0], BYTES),
        ("no-phi.binary", [90, 90, 0], BYTES),
        ("negative.binary", [-90, 90, 180], BYTES),
        ("huge.binary", [i32::MAX; 3], BYTES),
        ("big-endian.binary", [90_i32.swap_bytes(), 90_i32.swap_bytes(), 180_i32.swap_bytes()], BYTES),
        ("small-grid.binary", [90, 90, 90], 12 + (BYTES - 12) / 2),
        ("turned.binary", [180, 90, 90], BYTES),
        ("one-more.binary", [90, 91, 180], 12 + (BYTES - 12) / 90 * 91),
        ("anisotropic.binary", [90, 90, 90 * 4], BYTES + 8),
    ] {
        grid(&place, name, dimensions, size);
    }
    for (name, start) in [
        ("x.xz.binary", &b"\xfd7zXZ\0"[..]),
        ("x.gz.binary", b"\x1f\x8b"),
        ("x.bz2.binary", b"BZh9"),
        ("x.zst.binary", b"\x28\xb5\x2f\xfd"),
        ("x.zip.binary", b"PK\x03\x04"),
        ("x.bsdf.binary", b"tensor_file"),
        ("x.lfs.binary", b"version https://git-lfs.github.com/spec/v1"),
        ("x.html.binary", b"<!DOCTYPE html><title>404 Not Found</title>"),
        ("x.json.binary", b"{\"channels\": []}"),
        ("x.png.binary", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"),
    ] {
        place.put(name, [start, &[0; 64]].concat());
    }
    spoilt(&place, "nan-first.binary", 0, f64::NAN);
    spoilt(&place, "nan-last.binary", (BYTES - 12) / 8 - 1, -f64::NAN);
    spoilt(&place, "inf.binary", 2_000_000, f64::INFINITY);
    spoilt(&place, "minus-inf.binary", 1, f64::NEG_INFINITY);
    sparse(&place, "unmeasured.binary", |_, _| false);
    sparse(&place, "no-theta-h.binary", |h, d| d > 0 || h < 5);
    sparse(&place, "no-theta-d.binary", |h, d| h > 0 || d < 2);

    check(
        &place,
        &[
            ("fit missing.binary", 2, "missing.binary: no such file; check the path"),
            ("fit empty.binary/x.binary", 2, "x.binary: no such file"),
            ("info .", 2, ".: is a folder, not a measured file"),
            ("info /dev/null", 2, "/dev/null: is a pipe or a device"),
            ("fit empty.binary", 3, "empty.binary: the file is empty (0 bytes)"),
            ("fit byte.binary", 3, "truncated: 1 of 12 bytes in the header alone"),
            ("fit eleven.binary", 3, "truncated: 11 of 12 bytes"),
            ("fit header.binary", 3, "truncated: 12 of 34992012 bytes for three planes of 90 x 90 x 180"),
            ("fit short.binary", 3, "truncated: 34992011 of 34992012 bytes"),
            ("fit two-planes.binary", 3, "truncated: 23328012 of "),
            ("fit single-precision.binary", 3, "truncated: 17496012 of "),
            ("fit long.binary", 3, "trailing bytes: 1, 34992013 instead of 34992012 bytes"),
            ("fit twice.binary", 3, "trailing bytes: 34992012,"),
            ("fit half-named-full.binary", 3, "truncated: 34992012 of 69984012 bytes"),
            ("fit full-named-half.binary", 3, "trailing bytes: 34992000,"),
            ("fit zeros.binary", 3, "implausible dimensions 0 x 0 x 0"),
            ("fit no-phi.binary", 3, "implausible dimensions 90 x 90 x 0"),
            ("fit negative.binary", 3, "implausible dimensions -90 x 90 x 180"),
            ("fit huge.binary", 3, "implausible dimensions 2147483647"),
            ("fit big-endian.binary", 3, "big-endian they would be 90 x 90 x 180"),
            ("fit small-grid.binary", 3, "unsupported dimensions 90 x 90 x 90"),
            ("fit turned.binary", 3, "unsupported dimensions 180 x 90 x 90"),
            ("fit one-more.binary", 3, "unsupported dimensions 90 x 91 x 180"),
            ("fit anisotropic.binary", 3, "truncated: 34992020 of "),
            ("fit x.xz.binary", 3, "is an xz archive, not a MERL file; unpack it first (xz -d)"),
            ("fit x.gz.binary", 3, "is a gzip archive"),
            ("fit x.bz2.binary", 3, "is a bzip2 archive"),
            ("fit x.zst.binary", 3, "is a zstd archive"),
            ("fit x.zip.binary", 3, "is a zip archive"),
            ("fit x.bsdf.binary", 3, "RGL tensor file of version 0.0, not 1.0; convert it"),
            ("fit x.lfs.binary", 3, "is a pointer to a file kept in git-lfs"),
            ("fit x.html.binary", 3, "implausible dimensions"),
            ("fit x.json.binary", 3, "implausible dimensions"),
            ("fit x.png.binary", 3, "implausible dimensions"),
            ("fit nan-first.binary", 3, "values that are not a number (NaN): 1, first at plane R, theta_h bin 0"),
            ("fit nan-last.binary", 3, "first at plane B, theta_h bin 89"),
            ("fit inf.binary", 3, "infinite values: 1, first at plane G"),
            ("info minus-inf.binary", 3, "infinite values: 1, first at plane R"),
            ("fit unmeasured.binary", 3, "no valid cells"),
            ("fit unmeasured.binary --accept-non-finite", 3, "no valid cells"),
            ("fit no-theta-h.binary", 3, "rows of the theta_h slice"),
            ("fit no-theta-d.binary --no-hash", 3, "rows of the theta_d slice"),
        ],
    );
}

#[cfg(unix)]
#[test]
fn a_pipe_is_refused_without_waiting_for_its_writer() {
    let place = Workplace::new();
    let made = std::process::Command::new("mkfifo").arg(place.path("pipe.binary")).status().unwrap();
    assert!(made.success());
    let ran = place.run("fit pipe.binary");
    assert_eq!((ran.code, ran.stderr.contains("is a pipe or a device")), (Some(2), true), "{}", ran.stderr);
}

#[test]
fn lists_and_folders() {
    let place = Workplace::new();
    place.put("list/empty", "");
    place.put("list/comments", "# nothing\n\n   # here\n");
    place.put("list/bytes", b"\xff\xfe a.binary");
    place.put("list/missing", "gone.binary\n");
    place.put("list/of-folder", "../none\n");
    place.put("none/x.txt", "");
    place.put("deep/deeper/x.binary", "");
    place.put("a/x.binary", "");
    place.put("b/x.binary", "");
    place.put("summary.binary", "");
    place.put("file", "");
    check(
        &place,
        &[
            ("fit @gone", 2, "gone: no such file; check the path"),
            ("fit @list", 2, "list: is a folder"),
            ("fit @list/empty", 3, "list/empty: lists no file"),
            ("fit @list/comments", 3, "list/comments: lists no file"),
            ("fit @list/bytes", 3, "list/bytes: is not a text file"),
            ("fit @list/missing", 2, "list/gone.binary: no such file"),
            ("fit @list/of-folder", 3, "no .binary or .bsdf file in this folder"),
            ("fit none", 3, "none: no .binary or .bsdf file in this folder; name another folder, or add --recursive"),
            ("fit none --recursive", 3, "none: no .binary or .bsdf file in this folder; name another folder"),
            ("fit deep", 3, "or add --recursive"),
            ("fit a b -o out", 1, "a/x.binary and b/x.binary: two inputs with the name x"),
            ("fit summary.binary -o out", 1, "summary.binary: its result would overwrite the summary summary.json"),
            ("fit .. -o out", 3, "no .binary or .bsdf file"),
            ("merge gone", 2, "gone: no such file"),
            ("merge file", 2, "file: no such file"),
            ("merge none", 3, "no summary.I-of-N.json in this folder"),
        ],
    );
}

#[test]
fn options() {
    let place = Workplace::new();
    check(
        &place,
        &[
            ("--wrong", 1, "unexpected argument '--wrong'"),
            ("", 1, "requires a subcommand"),
            ("fti x", 1, "unrecognized subcommand 'fti'"),
            ("fit", 1, "<INPUT>"),
            ("fit x --fast", 1, "unexpected argument '--fast'"),
            ("fit x --loss l3", 1, "invalid value 'l3' for '--loss"),
            ("fit x --constraint none", 1, "invalid value 'none'"),
            ("fit x --anchor top", 1, "invalid value 'top'"),
            ("fit x --step2-solver qr", 1, "invalid value 'qr'"),
            ("fit x --sample-position middle", 1, "invalid value 'middle'"),
            ("fit x --cutoff-theta-h 9.9", 1, "cutoff_theta_h is 9.9 degrees, it must lie between 10 and 89.9"),
            ("fit x --cutoff-theta-h -75", 1, "cutoff_theta_h is -75 degrees"),
            ("fit x --cutoff-theta-d 90", 1, "cutoff_theta_d is 90 degrees"),
            ("fit x --cutoff-theta-d nan", 1, "cutoff_theta_d is NaN degrees"),
            ("fit x --cutoff-theta-d inf", 1, "cutoff_theta_d is inf degrees"),
            ("fit x --cutoff-theta-d ten", 1, "invalid value 'ten'"),
            ("fit x --start 0.1", 1, "a starting point of the model sgd is alpha,p, not 1 number"),
            ("fit x --start a,b", 1, "a starting point is one number per shape parameter"),
            ("fit x --start 0,0.4", 1, "the start alpha 0, p 0.4"),
            ("fit x --start 0.1,0.4 --start 2,0.4", 1, "the start alpha 2, p 0.4"),
            ("fit x --start 0.1,-0.4", 1, "the start alpha 0.1, p -0.4"),
            ("fit x --start nan,nan", 1, "the start alpha NaN, p NaN"),
            ("fit x --max-iterations 0", 1, "max_iterations is 0"),
            ("fit x --max-iterations -1", 1, "'-1'"),
            ("fit x --threads 0", 1, "0 is not in 1..=1024"),
            ("fit x --threads many", 1, "invalid value 'many'"),
            ("fit x --color green", 1, "invalid value 'green'"),
            ("fit x --quiet -v", 1, "cannot be used with"),
            ("fit x --shard 1/2", 1, "--output <DIR>"),
            ("fit x --resume", 1, "--output <DIR>"),
            ("fit x --picture", 1, "--output <DIR>"),
            ("fit x --atlas", 1, "--output <DIR>"),
            ("fit x -o d --resume --no-hash", 1, "cannot be used with"),
            ("fit x -o d --shard 0/2", 1, "--shard 0/2: must be I/N"),
            ("fit x -o d --shard 3/2", 1, "--shard 3/2: must be I/N"),
            ("fit x -o d --shard 1/0", 1, "--shard 1/0: must be I/N"),
            ("fit x -o d --shard half", 1, "--shard half: must be I/N"),
            ("fit x -o -", 1, "-o must be a folder"),
            ("fit x y", 1, "2 inputs; add -o DIR"),
            ("atlas", 1, "<INPUT>"),
            ("atlas x", 1, "--output <DIR>"),
            ("atlas x.json -o -", 1, "-o must be a folder"),
            ("atlas x.json -o d --formats png", 1, "invalid value 'png'"),
            (
                "atlas x.json -o d --formats ktx2 --exr-samples float",
                1,
                "--exr-samples float: requires exr in --formats",
            ),
            ("atlas x.json -o d --exr-samples double", 1, "invalid value 'double'"),
            ("atlas x.json -o d --channels rgb", 1, "invalid value 'rgb'"),
            ("atlas x.json -o d --layout square", 1, "invalid value 'square'"),
            ("atlas x.json -o d --max-resolution 2048", 1, "invalid value '2048'"),
            ("atlas x.json -o d --percentile 95 --epsilon 0.01", 1, "cannot be used with"),
            ("atlas x.json -o d --percentile 100", 1, "--percentile 100: must lie between 0 and 100"),
            ("atlas x.json -o d --epsilon -0.01", 1, "--epsilon -0.01: must lie above 0"),
            ("atlas x.json -o d --delta nan", 1, "--delta NaN: must lie from 0 to below 1"),
            ("atlas x.json -o d --finest-share inf", 1, "--finest-share inf: must lie from 0 to 1"),
            ("atlas x.json -o d --shard 3/2", 1, "--shard 3/2: must be I/N"),
            ("atlas red-satn -o d", 1, "red-satn: no such file or embedded material; did you mean red-satin?"),
            ("info x --format xml", 1, "invalid value 'xml'"),
            ("synth x.json", 1, "--output"),
            ("schema albedo", 1, "invalid value 'albedo'"),
            ("export hlsl", 1, "invalid value 'hlsl'"),
            ("completions tcsh", 1, "invalid value 'tcsh'"),
            ("man fti", 1, "fti: no such command; choose one of fit, "),
        ],
    );
}

#[test]
fn outputs() {
    let place = Workplace::new();
    place.put("file", "");
    place.put("good.json", result(&GLOSSY));
    place.put("folder/x", "");
    check(
        &place,
        &[
            ("fit x -o file", 2, "file: is a file, not a folder"),
            ("fit x -o file/below", 2, "file/below: a part of this path is a file"),
            ("atlas good.json -o file", 2, "file: is a file, not a folder"),
            ("atlas good.json -o file/below", 2, "file/below: a part of this path is a file"),
            ("export wgsl -o folder", 2, "folder: is a folder; name a file with -o"),
            ("export glsl -o gone/x.glsl", 2, "gone/x.glsl: its folder does not exist"),
            ("synth good.json -o folder", 2, "folder: is a folder; name a file with -o"),
            ("synth good.json -o gone/x.binary", 2, "gone/x.binary: its folder does not exist"),
            ("synth good.json -o file/x.binary", 2, "its folder does not exist"),
        ],
    );
    if cfg!(target_os = "linux") {
        check(
            &place,
            &[
                ("fit x -o /proc/brdfit", 2, "/proc/brdfit: "),
                ("atlas good.json -o /proc/brdfit", 2, "/proc/brdfit: "),
                ("export wgsl -o /dev/full", 2, "/dev/full: no space left on the device"),
                ("synth good.json -o /proc/x.binary", 2, "/proc/x.binary: "),
                ("synth good.json -o /dev/full", 2, "/dev/full: no space left on the device"),
            ],
        );
        for line in ["schema fit", "export glsl", "completions bash", "man", "--help"] {
            let full = File::options().write(true).open("/dev/full").unwrap();
            let output = place.command(line).stdout(full).output().unwrap();
            assert_eq!(output.status.code(), Some(2), "brdfit {line} > /dev/full");
        }
    }
}

#[test]
fn results() {
    let place = Workplace::new();
    let good = result(&GLOSSY);
    let with = |parameter: usize, value: f64| {
        let mut channels = GLOSSY;
        channels[1][parameter] = value;
        result(&channels)
    };
    let input = |members: &str| good.replacen('{', &format!("{{\"input\": {{{members}}}, "), 1);
    for (name, content) in [
        ("empty.json", String::new()),
        ("text.json", "parameters: none".to_owned()),
        ("cut.json", good[..good.len() / 2].to_owned()),
        ("list.json", "[1, 2, 3]".to_owned()),
        ("none.json", "{}".to_owned()),
        ("two.json", r#"{"channels": [{}, {}]}"#.to_owned()),
        ("no-alpha.json", good.replace("alpha", "beta")),
        ("word.json", good.replace("0.05", "\"0.05\"")),
        ("overflow.json", good.replace("0.05", "1e999")),
        ("nan.json", good.replace("0.05", "NaN")),
        ("null.json", good.replace("0.05", "null")),
        ("later.json", good.replacen('{', "{\"schema_version\": 99, ", 1)),
        ("alpha-zero.json", with(2, 0.0)),
        ("alpha-negative.json", with(2, -0.1)),
        ("alpha-huge.json", with(2, 1e6)),
        ("rho-negative.json", with(0, -0.5)),
        ("p-huge.json", with(3, 50.0)),
        ("scale-huge.json", with(1, 1e308)),
        ("grid.json", input("\"dimensions\": [90, 90, 90]")),
        ("position.json", input("\"sample_position\": \"corner\"")),
    ] {
        place.put(name, content);
    }
    place.put("merl.binary.json", [90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0, 255, 255]);
    place.put("good.json", &good);
    place.put("folder/x", "");
    let cases: Vec<(String, i32, &str)> = [
        ("gone.json", 2, "gone.json: no such file"),
        ("folder", 2, "folder: is a folder"),
        ("empty.json", 3, "the file is empty (0 bytes), not a fit result"),
        ("text.json", 3, "is not JSON, and thus not a fit result"),
        ("merl.binary.json", 3, "is not JSON, and thus not a fit result"),
        ("cut.json", 3, "EOF while parsing"),
        ("list.json", 3, "is not a fit result"),
        ("none.json", 3, "missing field `channels`"),
        ("two.json", 3, "missing field `parameters`"),
        ("no-alpha.json", 3, "missing field `alpha`"),
        ("word.json", 3, "invalid type: string"),
        ("overflow.json", 3, "number out of range"),
        ("nan.json", 3, "is not JSON"),
        ("null.json", 3, "invalid type: null"),
        ("later.json", 3, "has schema version 99; this program reads"),
        ("alpha-zero.json", 3, "alpha = 0 is outside of the model's domain"),
        ("alpha-negative.json", 3, "alpha = -0.1"),
        ("alpha-huge.json", 3, "alpha = 1000000"),
        ("rho-negative.json", 3, "rho_d = -0.5"),
        ("p-huge.json", 3, "p = 50"),
        ("scale-huge.json", 4, "the model of channel G overflows"),
        ("grid.json", 3, "its dimensions 90 x 90 x 90"),
        ("position.json", 3, "unknown variant `corner`"),
        ("good.json --phi-bins 90", 1, "--phi-bins 90: must be 180 or 360"),
        ("good.json --noise -0.1", 1, "--noise -0.1: must lie between 0 and 10"),
        ("good.json --noise nan", 1, "--noise NaN"),
        ("good.json --seed x", 1, "invalid value 'x'"),
        ("gold-metalic-paint", 1, "did you mean gold-metallic-paint?"),
        ("zzzzzzzzzzzzzzzzz", 1, "no such file or embedded material; embedded materials: "),
    ]
    .map(|(source, code, part)| (format!("synth {source} -o x.binary"), code, part))
    .into();
    let cases: Vec<(&str, i32, &str)> = cases.iter().map(|(line, code, part)| (line.as_str(), *code, *part)).collect();
    check(&place, &cases);
}

#[test]
fn comparisons() {
    let place = Workplace::new();
    place.put("empty.json", "");
    place.put("none.json", "{}");
    place.put("later.json", r#"{"schema_version": 99}"#);
    place.put("short.json", result(&GLOSSY));
    place.put("folder/x.json", "");
    check(
        &place,
        &[
            ("compare gone.json none.json", 2, "gone.json: no such file"),
            ("compare none.json", 1, "<REFERENCE>"),
            ("compare empty.json none.json", 3, "empty.json: the file is empty (0 bytes), not a fit result"),
            ("compare none.json none.json", 3, "none.json: is not a fit result (missing field"),
            ("compare later.json none.json", 3, "later.json: has schema version 99"),
            ("compare short.json none.json", 3, "short.json: is not a fit result (missing field"),
            ("compare folder none.json", 1, "folder is a folder and none.json is not"),
            ("compare none.json none.json --cost-fail x", 1, "a tolerance is a non-negative number"),
            ("compare none.json none.json --cost-fail -1", 1, "'-1'"),
        ],
    );
}
