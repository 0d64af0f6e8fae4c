//! Files that are not usable MERL files: each has its own error, sorted into the right class, with a message of one line
//! that names the file and says what is wrong and what to do.

use std::fs;
use std::path::Path;

use brdfit_measured::{ContainerFault, MeasurementError, MerlFile, Reason, Unreadable, ValueFault};

/// Size in bytes of a file of 90 x 90 x 180 cells.
const FULL: usize = 12 + 3 * 8 * 90 * 90 * 180;
/// Number of cells in one of its planes.
const CELLS: usize = 90 * 90 * 180;

/// One malformed input: its name, its bytes, the kind of error, and the essential words of the message.
struct Case {
    name: &'static str,
    bytes: Vec<u8>,
    kind: &'static str,
    says: &'static [&'static str],
}

fn case(name: &'static str, bytes: Vec<u8>, kind: &'static str, says: &'static [&'static str]) -> Case {
    Case { name, bytes, kind, says }
}

fn header(dimensions: [i32; 3]) -> Vec<u8> {
    dimensions.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// A header and as many zero bytes as make up `size`.
fn sized(dimensions: [i32; 3], size: usize) -> Vec<u8> {
    let mut bytes = header(dimensions);
    bytes.resize(size, 0);
    bytes
}

fn good_header(size: usize) -> Vec<u8> {
    sized([90, 90, 180], size)
}

/// A valid file of one value, but for the given (plane, cell, value).
fn with_values(fill: f64, special: &[(usize, usize, f64)]) -> Vec<u8> {
    let mut bytes = header([90, 90, 180]);
    bytes.extend(fill.to_le_bytes().repeat(3 * CELLS));
    for &(plane, cell, x) in special {
        let at = 12 + 8 * (plane * CELLS + cell);
        bytes[at..at + 8].copy_from_slice(&x.to_le_bytes());
    }
    bytes
}

fn containers() -> Vec<Case> {
    let big_endian = |dimensions: [i32; 3]| dimensions.iter().flat_map(|n| n.to_be_bytes()).collect::<Vec<u8>>();
    let text = b"# a table of angles\n0.0 0.1 0.2\n".to_vec();
    let wide_header = [90_i64, 90, 180].iter().flat_map(|n| n.to_le_bytes()).collect();
    let doubles = [90.0_f64, 90.0, 180.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let appended = |extra: usize| good_header(FULL + extra);
    vec![
        case("empty", vec![], "empty", &["empty (0 bytes)", "fetch it again"]),
        // Cut inside the header.
        case("1-byte", good_header(12)[..1].to_vec(), "truncated", &["1 of 12 bytes", "header"]),
        case("2-bytes", good_header(12)[..2].to_vec(), "truncated", &["2 of 12 bytes"]),
        case("3-bytes", good_header(12)[..3].to_vec(), "truncated", &["3 of 12 bytes"]),
        case("4-bytes", good_header(12)[..4].to_vec(), "truncated", &["4 of 12 bytes"]),
        case("5-bytes", good_header(12)[..5].to_vec(), "truncated", &["5 of 12 bytes"]),
        case("6-bytes", good_header(12)[..6].to_vec(), "truncated", &["6 of 12 bytes"]),
        case("7-bytes", good_header(12)[..7].to_vec(), "truncated", &["7 of 12 bytes"]),
        case("8-bytes", good_header(12)[..8].to_vec(), "truncated", &["8 of 12 bytes"]),
        case("9-bytes", good_header(12)[..9].to_vec(), "truncated", &["9 of 12 bytes"]),
        case("10-bytes", good_header(12)[..10].to_vec(), "truncated", &["10 of 12 bytes"]),
        case("11-bytes", good_header(12)[..11].to_vec(), "truncated", &["11 of 12 bytes", "header", "fetch it again"]),
        // Cut after the header.
        case("header-only", good_header(12), "truncated", &["12 of 34992012 bytes", "90 x 90 x 180"]),
        case("half-a-double", good_header(16), "truncated", &["16 of 34992012 bytes"]),
        case("one-page", good_header(4096), "truncated", &["4096 of 34992012 bytes"]),
        case("one-plane", good_header(12 + 8 * CELLS), "truncated", &["11664012 of 34992012 bytes"]),
        case("two-planes", good_header(12 + 16 * CELLS), "truncated", &["23328012 of 34992012 bytes"]),
        case("single-precision", good_header(12 + 12 * CELLS), "truncated", &["17496012 of 34992012 bytes"]),
        case("a-byte-short", good_header(FULL - 1), "truncated", &["34992011 of 34992012 bytes"]),
        case("a-double-short", good_header(FULL - 8), "truncated", &["34992004 of 34992012 bytes"]),
        case("without-header-size", good_header(FULL - 12), "truncated", &["34992000 of 34992012 bytes"]),
        case(
            "360-in-size-of-180",
            sized([90, 90, 360], FULL),
            "truncated",
            &["34992012 of 69984012 bytes", "90 x 90 x 360"],
        ),
        // Too long.
        case(
            "a-byte-long",
            appended(1),
            "trailing-bytes",
            &["trailing bytes: 1,", "34992013 instead of 34992012 bytes"],
        ),
        case("a-double-long", appended(8), "trailing-bytes", &["trailing bytes: 8,"]),
        case(
            "a-newline",
            [good_header(FULL), b"\n".to_vec()].concat(),
            "trailing-bytes",
            &["trailing bytes: 1,", "truncate it"],
        ),
        case("fourth-plane", appended(8 * CELLS), "trailing-bytes", &["trailing bytes: 11664000,"]),
        case(
            "twice",
            [good_header(FULL), good_header(FULL)].concat(),
            "trailing-bytes",
            &["trailing bytes: 34992012,"],
        ),
        // Dimensions that cannot be.
        case("zeros", vec![0; 12], "implausible-dimensions", &["0 x 0 x 0", "not a MERL binary file"]),
        case("zeros-full-size", vec![0; FULL], "implausible-dimensions", &["0 x 0 x 0"]),
        case("zero-phi", sized([90, 90, 0], FULL), "implausible-dimensions", &["90 x 90 x 0"]),
        case("negative", sized([-90, 90, 180], FULL), "implausible-dimensions", &["-90 x 90 x 180"]),
        case("two-negative", sized([-90, -90, 180], FULL), "implausible-dimensions", &["-90 x -90 x 180"]),
        case("minimal", sized([i32::MIN; 3], 64), "implausible-dimensions", &["-2147483648 x"]),
        case("huge", sized([i32::MAX; 3], FULL), "implausible-dimensions", &["2147483647 x 2147483647 x 2147483647"]),
        case("product-overflows-i32", sized([65536, 65536, 1], 64), "implausible-dimensions", &["65536 x 65536 x 1"]),
        case("product-wraps-u64", sized([1 << 22, 1 << 22, 1 << 20], 64), "implausible-dimensions", &["4194304 x"]),
        case(
            "product-wraps-to-ours",
            sized([90, 90, 180 + (1 << 30)], FULL),
            "implausible-dimensions",
            &["1073742004"],
        ),
        case("ones", vec![0xff; 64], "implausible-dimensions", &["-1 x -1 x -1"]),
        case(
            "big-endian",
            big_endian([90, 90, 180]),
            "implausible-dimensions",
            &["big-endian", "90 x 90 x 180", "convert"],
        ),
        case("big-endian-360", big_endian([90, 90, 360]), "implausible-dimensions", &["big-endian", "90 x 90 x 360"]),
        case("64-bit-integers", wide_header, "implausible-dimensions", &["90 x 0 x 90"]),
        case("doubles-for-integers", doubles, "implausible-dimensions", &["not a MERL binary file"]),
        case("text", text, "implausible-dimensions", &["not a MERL binary file", "check that it is the right one"]),
        case(
            "byte-order-mark",
            [vec![0xef, 0xbb, 0xbf], b"90 90 180".to_vec()].concat(),
            "implausible-dimensions",
            &[],
        ),
        case("html", b"<!DOCTYPE html><html>not found</html>".to_vec(), "implausible-dimensions", &["not a MERL"]),
        // Dimensions that other files have.
        case("one-cell", sized([1, 1, 1], 36), "unsupported-dimensions", &["1 x 1 x 1", "resample"]),
        case(
            "order-reversed",
            sized([180, 90, 90], FULL),
            "unsupported-dimensions",
            &["180 x 90 x 90", "theta_h x theta_d x phi_d"],
        ),
        case("order-turned", sized([90, 180, 90], FULL), "unsupported-dimensions", &["90 x 180 x 90"]),
        case("coarse", sized([45, 45, 90], 64), "unsupported-dimensions", &["45 x 45 x 90"]),
        case("one-off", sized([90, 90, 181], FULL), "unsupported-dimensions", &["90 x 90 x 181"]),
        case("ninety-phi", sized([90, 90, 90], FULL), "unsupported-dimensions", &["90 x 90 x 180 or 90 x 90 x 360"]),
        case("largest-plausible", sized([4096; 3], 64), "unsupported-dimensions", &["4096 x 4096 x 4096"]),
        // Other containers.
        case(
            "xz",
            b"\xfd7zXZ\0\0\x04\xe6\xd6\xb4F\x02\0!\x01".to_vec(),
            "other-format",
            &["xz archive", "unpack it first"],
        ),
        case(
            "gzip",
            b"\x1f\x8b\x08\0\0\0\0\0\0\x03".to_vec(),
            "other-format",
            &["gzip archive", "unpack it first (gzip -d)"],
        ),
        case("bzip2", b"BZh91AY&SY".to_vec(), "other-format", &["bzip2 archive", "unpack"]),
        case("zstd", b"\x28\xb5\x2f\xfd\x24\0\x01\0\0".to_vec(), "other-format", &["zstd archive", "unpack"]),
        case("zip", b"PK\x03\x04\x14\0\0\0\x08\0".to_vec(), "other-format", &["zip archive", "unpack"]),
        case("lfs", b"version https://git-lfs.github.com/spec/v1\n".to_vec(), "other-format", &["git lfs pull"]),
    ]
}

fn values() -> Vec<Case> {
    let last = CELLS - 1;
    let at = |h: usize, d: usize, p: usize| p + 180 * (d + 90 * h);
    let nan = "not-a-number";
    vec![
        case("all-negative", with_values(-1.0, &[]), "no-valid-cells", &["no valid cells", "in all three planes"]),
        case(
            "no-cell-in-all-planes",
            {
                let mut bytes = with_values(1.0, &[]);
                bytes[12..12 + 8 * CELLS].copy_from_slice(&with_values(-1.0, &[])[12..12 + 8 * CELLS]);
                bytes
            },
            "no-valid-cells",
            &["no valid cells"],
        ),
        case("all-nan", with_values(f64::NAN, &[]), nan, &["not a number (NaN): 4374000,", "plane R, theta_h bin 0"]),
        case(
            "nan-in-red",
            with_values(1.0, &[(0, at(9, 33, 77), f64::NAN)]),
            nan,
            &[
                "not a number (NaN): 1,",
                "plane R, theta_h bin 9 (0.90 deg), theta_d bin 33 (33 deg), phi_d bin 77 (77 deg)",
                "write -1",
            ],
        ),
        case("nan-in-green", with_values(1.0, &[(1, 0, f64::NAN)]), nan, &["plane G, theta_h bin 0"]),
        case(
            "nan-in-blue",
            with_values(1.0, &[(2, last, f64::NAN)]),
            nan,
            &["plane B, theta_h bin 89", "phi_d bin 179"],
        ),
        case("negative-nan", with_values(1.0, &[(1, 5, -f64::NAN)]), nan, &["plane G", "phi_d bin 5"]),
        case(
            "signalling-nan",
            with_values(1.0, &[(1, 6, f64::from_bits(0x7ff0_0000_0000_0001))]),
            nan,
            &["phi_d bin 6"],
        ),
        case(
            "nan-and-infinity",
            with_values(1.0, &[(0, 1, f64::INFINITY), (2, 2, f64::NAN)]),
            nan,
            &["(NaN): 1,", "plane B"],
        ),
        case(
            "plus-infinity",
            with_values(1.0, &[(1, at(89, 0, 0), f64::INFINITY)]),
            "infinite",
            &["infinite values: 1,", "plane G, theta_h bin 89 (88.01 deg)", "write -1"],
        ),
        case(
            "minus-infinity",
            with_values(1.0, &[(0, last, f64::NEG_INFINITY)]),
            "infinite",
            &["infinite values: 1,", "plane R"],
        ),
        case("all-infinite", with_values(f64::INFINITY, &[]), "infinite", &["infinite values: 4374000,"]),
        case(
            "both-infinities",
            with_values(1.0, &[(2, 3, f64::NEG_INFINITY), (2, 9, f64::INFINITY)]),
            "infinite",
            &["infinite values: 2,", "phi_d bin 3"],
        ),
    ]
}

/// Opens and checks a file as a program would.
fn load(path: &Path) -> Result<(), MeasurementError> {
    brdfit_measured::open(path, None)?.survey(false).map(|_| ())
}

/// A short name of what is wrong.
fn kind(error: &MeasurementError) -> &'static str {
    match error.reason() {
        Reason::Unreadable(Unreadable::NotFound) => "not-found",
        Reason::Unreadable(Unreadable::PermissionDenied) => "permission-denied",
        Reason::Unreadable(Unreadable::IsDirectory) => "is-directory",
        Reason::Unreadable(Unreadable::NotARegularFile) => "not-a-regular-file",
        Reason::Container(ContainerFault::Empty) => "empty",
        Reason::Container(ContainerFault::OtherFormat { .. }) => "other-format",
        Reason::Container(ContainerFault::Truncated { .. }) => "truncated",
        Reason::Container(ContainerFault::TrailingBytes { .. }) => "trailing-bytes",
        Reason::Container(ContainerFault::ImplausibleDimensions { .. }) => "implausible-dimensions",
        Reason::Container(ContainerFault::UnsupportedDimensions { .. }) => "unsupported-dimensions",
        Reason::Values(ValueFault::NoValidCells) => "no-valid-cells",
        Reason::Values(ValueFault::NotANumber { .. }) => "not-a-number",
        Reason::Values(ValueFault::Infinite { .. }) => "infinite",
        other => panic!("{other:?}"),
    }
}

/// The message is one line that names the file and says what it must.
fn check_message(error: &MeasurementError, path: &Path, says: &[&str]) {
    let message = error.to_string();
    assert!(!message.contains('\n'), "{message}");
    assert!(message.starts_with(&format!("{}: ", path.display())), "{message}");
    assert_eq!(error.path(), path);
    for words in says {
        assert!(message.contains(words), "{words:?} is not in {message:?}");
    }
}

#[test]
fn every_malformed_file_has_its_own_error() {
    let folder = tempfile::tempdir().unwrap();
    let cases: Vec<Case> = [containers(), values()].into_iter().flatten().collect();
    assert!(cases.len() >= 60, "{}", cases.len());
    for Case { name, bytes, kind: expected, says } in cases {
        let path = folder.path().join(format!("{name}.binary"));
        fs::write(&path, &bytes).unwrap();
        let error = load(&path).expect_err(name);
        assert_eq!(kind(&error), expected, "{name}: {error}");
        assert!(error.is_invalid_input(), "{name}: {error}");
        check_message(&error, &path, says);
        fs::remove_file(&path).unwrap();
        // The same bytes in memory fail in the same way, where the container is to blame.
        if let Err(in_memory) = MerlFile::from_bytes(&path, bytes) {
            assert_eq!(in_memory.to_string(), error.to_string());
        }
    }
}

/// What looks odd and is fine.
#[test]
fn unusual_values_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.binary");
    let mostly_missing: Vec<(usize, usize, f64)> = (0..3).map(|plane| (plane, 77, 0.5)).collect();
    for (name, bytes) in [
        ("all zero", with_values(0.0, &[])),
        ("negative zero", with_values(-0.0, &[])),
        ("denormal", with_values(5e-324, &[])),
        ("largest", with_values(f64::MAX, &[])),
        ("one valid cell", with_values(-1.0, &mostly_missing)),
        ("one plane without a measurement", with_values(1.0, &[(1, 3, -1.0)])),
    ] {
        fs::write(&path, bytes).unwrap();
        load(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// Input that cannot be read is no fault of its contents.
#[test]
fn unreadable_input_is_sorted_apart() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.binary");
    let inside_a_file = folder.path().join("file").join("x.binary");
    fs::write(folder.path().join("file"), b"x").unwrap();
    for (path, expected, says) in [
        (missing.as_path(), "not-found", "no such file"),
        (inside_a_file.as_path(), "not-found", "check the path"),
        (folder.path(), "is-directory", "is a folder"),
    ] {
        let error = load(path).unwrap_err();
        assert_eq!((kind(&error), error.is_invalid_input()), (expected, false), "{error}");
        check_message(&error, path, &[says]);
    }
}

#[cfg(unix)]
#[test]
fn devices_and_dangling_links_are_not_opened() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("link.binary");
    std::os::unix::fs::symlink(folder.path().join("nowhere"), &link).unwrap();
    let socket = folder.path().join("socket.binary");
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    for (path, expected) in [
        (link.as_path(), "not-found"),
        (socket.as_path(), "not-a-regular-file"),
        (Path::new("/dev/zero"), "not-a-regular-file"),
    ] {
        let error = load(path).unwrap_err();
        assert_eq!((kind(&error), error.is_invalid_input()), (expected, false), "{error}");
        check_message(&error, path, &[]);
    }
}

#[cfg(unix)]
#[test]
fn a_file_without_permission_says_so() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("secret.binary");
    fs::write(&path, with_values(1.0, &[])).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(&path).is_ok() {
        eprintln!(
            "SKIPPED: this user may read files without permission (root?), so permission errors cannot be tested"
        );
        return;
    }
    let error = load(&path).unwrap_err();
    assert_eq!((kind(&error), error.is_invalid_input()), ("permission-denied", false), "{error}");
    check_message(&error, &path, &["permission denied", "make the file readable"]);
}
