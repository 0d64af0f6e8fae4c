//! RGL files that are not usable: each field and each rule has its own message.

use std::path::{Path, PathBuf};

use brdfit_measured::MeasurementError;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures").join(name)
}

/// What a file with one changed field is answered.
fn refused(change: impl Fn(&mut Fields)) -> MeasurementError {
    let mut fields = Fields::of(&std::fs::read(fixture("ggx_rgb.bsdf")).unwrap());
    change(&mut fields);
    refused_bytes(&fields.bytes())
}

fn refused_bytes(bytes: &[u8]) -> MeasurementError {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.bsdf");
    std::fs::write(&path, bytes).unwrap();
    let error = brdfit_measured::open(&path, None).map(|_| ()).unwrap_err();
    assert!(error.is_invalid_input() && error.path() == path && !error.to_string().contains('\n'), "{error}");
    error
}

/// A file in parts: name, type, shape, bytes.
#[derive(Clone)]
struct Fields(Vec<Field>);

type Field = (String, u8, Vec<u64>, Vec<u8>);

impl Fields {
    /// Reads a sound file.
    fn of(bytes: &[u8]) -> Self {
        let number =
            |at: usize, size: usize| bytes[at..at + size].iter().rev().fold(0, |sum, &b| sum << 8 | u64::from(b));
        let mut at = 18;
        let fields = (0..number(14, 4)).map(|_| {
            let name_end = at + 2 + number(at, 2) as usize;
            let name = String::from_utf8(bytes[at + 2..name_end].to_vec()).unwrap();
            let (axes, kind, offset) = (number(name_end, 2), bytes[name_end + 2], number(name_end + 3, 8) as usize);
            let shape: Vec<u64> = (0..axes).map(|axis| number(name_end + 11 + 8 * axis as usize, 8)).collect();
            let size = shape.iter().product::<u64>() as usize * if kind == 10 { 4 } else { 1 };
            at = name_end + 11 + 8 * axes as usize;
            (name, kind, shape, bytes[offset..offset + size].to_vec())
        });
        Self(fields.collect())
    }

    fn get(&mut self, name: &str) -> &mut Field {
        self.0.iter_mut().find(|field| field.0 == name).unwrap()
    }

    fn set(&mut self, name: &str, entry: usize, value: f32) {
        self.get(name).3[4 * entry..4 * entry + 4].copy_from_slice(&value.to_le_bytes());
    }

    /// A file again, its arrays one after the other, without alignment.
    fn bytes(&self) -> Vec<u8> {
        let mut offset = 18 + self.0.iter().map(|(name, _, shape, _)| 13 + name.len() + 8 * shape.len()).sum::<usize>();
        let mut bytes = b"tensor_file\0\x01\0".to_vec();
        bytes.extend((self.0.len() as u32).to_le_bytes());
        for (name, kind, shape, data) in &self.0 {
            bytes.extend((name.len() as u16).to_le_bytes());
            bytes.extend(name.as_bytes());
            bytes.extend((shape.len() as u16).to_le_bytes());
            bytes.push(*kind);
            bytes.extend((offset as u64).to_le_bytes());
            shape.iter().for_each(|length| bytes.extend(length.to_le_bytes()));
            offset += data.len();
        }
        self.0.iter().for_each(|field| bytes.extend(&field.3));
        bytes
    }
}

#[test]
fn a_field_that_is_wrong_is_named() {
    type Change = fn(&mut Fields);
    let cases: [(Change, &str); 26] = [
        (|f| f.0.retain(|field| field.0 != "ndf"), "field ndf: is missing"),
        (|f| f.0.retain(|field| field.0 != "rgb"), "field rgb: is missing"),
        (
            |f| f.get("rgb").0 = "spectra".into(),
            "holds spectra, not three colour channels; take the file of the same material",
        ),
        (
            |f| (f.get("phi_i").2, f.get("phi_i").3) = (vec![3], vec![0; 12]),
            "an anisotropic material (3 azimuths phi_i)",
        ),
        (|f| f.get("phi_i").2 = vec![1, 1], "field phi_i: shape [1, 1], not [1]"),
        (|f| f.get("phi_i").1 = 5, "field phi_i: type 5, not 10"),
        (|f| f.get("theta_i").2 = vec![1, 16], "field theta_i: shape [1, 16]"),
        (|f| f.set("theta_i", 3, 2.0), "field theta_i: not increasing"),
        (|f| f.set("theta_i", 3, f32::NAN), "field theta_i: entry 3 is NaN"),
        (|f| f.set("theta_i", 0, -0.5), "field theta_i: entry 0 is negative"),
        (|f| f.get("ndf").1 = 0, "field ndf: type 0 does not exist"),
        (|f| f.get("ndf").1 = 12, "field ndf: type 12 does not exist"),
        (|f| f.get("ndf").2 = vec![256], "field ndf: shape [256]"),
        (|f| f.get("ndf").2 = vec![1, 256], "field ndf: shape [1, 256]"),
        (|f| f.set("sigma", 7, f32::INFINITY), "field sigma: entry 7 is inf"),
        (|f| f.set("vndf", 1030, -1e-3), "field vndf: entry 1030 is negative: -0.001"),
        (|f| f.get("vndf").3[..4096].fill(0), "field vndf: is zero for one of theta_i"),
        (|f| f.get("vndf").2 = vec![16, 1, 32, 32], "field vndf: shape [16, 1, 32, 32]"),
        (|f| f.get("vndf").2 = vec![1, 16, 32, 33], "lies inside of vndf"),
        (|f| f.get("vndf").2 = vec![u64::MAX, 16, 32, 32], "field vndf: ends at byte 18446744073709551615 of"),
        (|f| f.get("luminance").2 = vec![1, 16, 32, 8], "field luminance: shape [1, 16, 32, 8] does not go with"),
        (|f| f.set("rgb", 0, f32::NAN), "field rgb: entry 0 is NaN"),
        (|f| f.get("rgb").2 = vec![1, 16, 16, 16, 3], "field rgb: shape [1, 16, 16, 16, 3]"),
        (|f| f.get("jacobian").3[0] = 7, "field jacobian: is not a single 0 or 1"),
        (|f| f.get("luminance").0 = "vndf".into(), "field vndf: occurs twice"),
        (|f| f.get("sigma").2 = vec![1; 17], "field sigma: 17 axes, more than 16"),
    ];
    for (change, part) in cases {
        let message = refused(change).to_string();
        assert!(message.contains(part), "no {part:?} in {message}");
    }
    assert!(brdfit_measured::open(&fixture("ggx_rgb.bsdf"), None).is_ok());
}

#[test]
fn a_container_that_is_wrong_says_so() {
    let sound = Fields::of(&std::fs::read(fixture("ggx_rgb.bsdf")).unwrap()).bytes();
    let changed = |at: usize, to: &[u8]| {
        let mut bytes = sound.clone();
        bytes[at..at + to.len()].copy_from_slice(to);
        bytes
    };
    // the offset of the first field, `description`: behind its name and the number and type of its axes
    let offset = 18 + 2 + 11 + 3;
    for (bytes, part) in [
        (sound[..13].to_vec(), "truncated: 13 of 14 bytes"),
        (sound[..16].to_vec(), "truncated: 16 of 18 bytes"),
        (sound[..40].to_vec(), "truncated: 40 of"),
        (sound[..sound.len() - 1].to_vec(), "field jacobian: ends at byte"),
        (sound[..sound.len() / 2].to_vec(), "truncated; fetch the file again"),
        ([&sound[..], &[0; 8]].concat(), "trailing bytes: 8"),
        (changed(12, &[2, 0]), "version 2.0, not 1.0"),
        (changed(14, &[255; 4]), "announces 4294967295 fields"),
        (changed(20, &[0xff]), "is not UTF-8"),
        (changed(18, &[0xff, 0xff]), "UTF-8"),
        (changed(offset, &0_u64.to_le_bytes()), "field description: offset 0 lies inside of the list of fields"),
        (changed(offset, &1000_u64.to_le_bytes()), "lies inside of"),
        (changed(offset, &u64::MAX.to_le_bytes()), "field description: ends at byte 18446744073709551615"),
        (changed(0, b"tensor_fill"), "is a file of another kind, not an RGL file"),
        (b"PK\x03\x04".repeat(20), "not an RGL file"),
    ] {
        let message = refused_bytes(&bytes).to_string();
        assert!(message.contains(part), "no {part:?} in {message}");
    }
}

/// Every prefix of a file is refused, and none makes the reader take memory or panic.
#[test]
fn no_cut_file_is_read() {
    let sound = std::fs::read(fixture("ggx_rgb.bsdf")).unwrap();
    for length in (1..400).chain((400..sound.len() - 8).step_by(9973)) {
        refused_bytes(&sound[..length]);
    }
}
