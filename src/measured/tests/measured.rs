//! Golden counts and known facts of the measured files and of the mask of the genuine ones.

mod data;

use std::path::{Path, PathBuf};

use brdfit_measured::{AlbedoPlan, CellMask, Dimensions, Grid, Health, HealthCheck, MerlFile, SamplePosition, Scan};
use sha2::{Digest, Sha256};

const POSITIONS: [SamplePosition; 2] = [SamplePosition::Edge, SamplePosition::Centre];

/// The mask of the cells that are valid in the genuine MERL files: a NumPy array of bools, version 1.
fn genuine_mask(data: &Path) -> CellMask {
    let npy = data::unpacked(&data.join("tables/merl_valid_mask.npy.xz"));
    assert_eq!(&npy[..8], b"\x93NUMPY\x01\x00");
    let header = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    let text = std::str::from_utf8(&npy[10..10 + header]).unwrap();
    assert!(text.contains("'|b1'") && text.contains("(90, 90, 180)") && text.contains("False"), "{text}");
    let cells = &npy[10 + header..];
    assert_eq!(cells.len(), Dimensions::HALF_TURN.cells());
    CellMask::from_fn(cells.len(), |cell| cells[cell] == 1)
}

/// (cells of the error panel, usable cells) of a mask.
fn counts(valid: &CellMask, position: SamplePosition) -> (usize, usize) {
    let grid = Grid::new(Dimensions::HALF_TURN, position);
    (valid.and(grid.panel()).count(), valid.and(grid.usable()).count())
}

/// The same for every mask and position of `data-fixtures/index.json`, counted by the independent reader:
/// (name, position, valid, usable, panel).
fn golden_counts() -> Vec<(String, SamplePosition, usize, usize, usize)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/index.json");
    let golden: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::from_value(golden["counts"].clone()).unwrap()
}

fn opened(data: &Path) -> Vec<(MerlFile, Scan)> {
    let open = |path: PathBuf| {
        let file = MerlFile::open(&path).unwrap();
        let scan = file.scan();
        (file, scan)
    };
    data::measured(data).into_iter().map(open).collect()
}

#[test]
fn the_mask_of_the_genuine_files_has_the_known_counts() {
    let Some(data) = data::genuine() else { return };
    let mask = genuine_mask(&data);
    assert_eq!(mask.count(), 1_152_174);
    assert_eq!(counts(&mask, SamplePosition::Edge), (923_870, 1_111_430));
    assert_eq!(counts(&mask, SamplePosition::Centre), (909_696, 1_096_216));
}

#[test]
fn all_masks_have_the_golden_counts() {
    let Some(data) = data::genuine() else { return };
    let mut masks = vec![("genuine mask".to_owned(), genuine_mask(&data))];
    for (file, scan) in opened(&data) {
        let name = file.path().file_stem().unwrap().to_string_lossy().into_owned();
        assert_eq!(counts(scan.valid(), SamplePosition::Centre), (909_696, 1_096_120), "{name}");
        masks.push((name, scan.valid().clone()));
    }
    let golden = golden_counts();
    for (name, mask) in &masks {
        let mut found = 0;
        for (_, position, valid, usable, panel) in golden.iter().filter(|row| row.0 == *name) {
            assert_eq!(mask.count(), *valid, "{name}");
            assert_eq!(counts(mask, *position), (*panel, *usable), "{name} {position}");
            found += 1;
        }
        assert!(found > 0, "{name} is not in the golden counts");
    }
}

#[test]
fn one_pass_finds_what_cell_by_cell_reading_finds() {
    let Some(data) = data::folder() else { return };
    for (file, scan) in opened(&data) {
        assert_eq!(scan.fault(), None);
        assert_eq!(scan.sha256(), <[u8; 32]>::from(Sha256::digest(std::fs::read(file.path()).unwrap())));
        let by_cell = CellMask::from_fn(file.dimensions().cells(), |cell| file.is_valid(cell));
        assert_eq!(scan.valid(), &by_cell);
    }
}

/// The slices against the definition, cell by cell and without any of the tables.
#[test]
fn slices_are_means_of_usable_cells() {
    let Some(data) = data::folder() else { return };
    let d = Dimensions::HALF_TURN;
    for (file, _) in opened(&data) {
        for position in POSITIONS {
            let slices = file.slices(position);
            for n in [0, 1, 30, 60, 75, 89] {
                for (row, means, cells) in
                    [((n, 0), &slices.measured_h, &slices.cells_h), ((0, n), &slices.measured_d, &slices.cells_d)]
                {
                    let usable: Vec<usize> = (0..180)
                        .filter(|&k| {
                            let (h, t) = (d.theta_h_sample(row.0, position), d.theta_d_sample(row.1, position));
                            let (along, p) = (h.cos() * t.cos(), d.phi_d_sample(k, position));
                            along - (h.sin() * t.sin() * p.cos()).abs() > 1e-9
                        })
                        .map(|k| k + 180 * (row.1 + 90 * row.0))
                        .filter(|&cell| (0..3).all(|c| file.raw(c, cell).is_finite() && file.raw(c, cell) >= 0.0))
                        .collect();
                    assert_eq!(cells[n], usable.len());
                    for (c, means) in means.iter().enumerate() {
                        let sum: f64 = usable.iter().map(|&cell| file.value(c, cell)).sum();
                        match means[n] {
                            Some(mean) => assert!((mean * usable.len() as f64 - sum).abs() <= 1e-12 * sum.abs()),
                            None => assert!(usable.is_empty()),
                        }
                    }
                }
            }
        }
    }
}

fn examined(data: &Path) -> Vec<Health> {
    let check = HealthCheck::new(Dimensions::HALF_TURN, SamplePosition::Centre);
    opened(data).iter().map(|(file, scan)| check.examine(file, scan)).collect()
}

#[test]
fn colours_out_of_gamut_are_found() {
    let Some(data) = data::genuine() else { return };
    for health in examined(&data) {
        let zero = health.channels.each_ref().map(|channel| channel.zero_peak);
        let expected = ["chm_mint.binary", "vch_silk_blue.binary"].contains(&health.name.as_str());
        assert_eq!(zero, [expected, false, false], "{}", health.name);
    }
}

#[test]
fn regions_are_a_partition_and_agree_with_the_scan() {
    let Some(data) = data::genuine() else { return };
    for (health, (_, scan)) in examined(&data).iter().zip(opened(&data)) {
        let r = &health.regions;
        assert_eq!(r.interior.cells + r.grazing.cells + r.below_horizon.cells, 1_458_000);
        assert_eq!(r.all.valid, scan.valid_cells());
        assert_eq!((r.interior.valid, r.interior.valid + r.grazing.valid), (909_696, 1_096_120));
        assert_eq!(r.below_horizon.valid, 0);
        for channel in 0..3 {
            assert_eq!(r.all.negative[channel], scan.channels()[channel].negative.count);
        }
    }
}

/// White paper reflects most of the light and never more than all of it, at every angle that was measured well.
#[test]
fn the_albedo_of_paper_is_that_of_paper() {
    let Some(data) = data::genuine() else { return };
    let paper = examined(&data).into_iter().find(|health| health.name == "paper_white.binary").unwrap();
    for values in &paper.albedo.values {
        assert!(values[..3].iter().all(|albedo| (0.6..1.02).contains(albedo)), "{:?}", paper.albedo);
    }
    assert!(paper.albedo.covered[..2].iter().all(|&covered| covered > 0.98), "{:?}", paper.albedo);
}

/// The plan against the sum over a hemisphere of directions to the eye, an entirely different quadrature.
#[test]
fn albedo_agrees_with_a_sum_over_outgoing_directions() {
    let Some(data) = data::folder() else { return };
    let angles = [10.0_f64, 40.0, 65.0];
    let plan = AlbedoPlan::new(Dimensions::HALF_TURN, SamplePosition::Centre, &angles.map(f64::to_radians));
    for (file, scan) in opened(&data).into_iter().filter(|(file, _)| !file.path().ends_with("chm_mint.binary")) {
        let value = |cell: usize| scan.valid().contains(cell).then(|| file.value(1, cell));
        for (albedo, degrees) in plan.integrate(value).into_iter().zip(angles) {
            let direct = over_outgoing_directions(&file, &value, degrees.to_radians());
            assert!((albedo / direct - 1.0).abs() < 0.01, "{} {degrees}: {albedo} {direct}", file.path().display());
        }
    }
}

/// Midpoint rule in cos^2 theta_o and phi_o, with vectors.
fn over_outgoing_directions(file: &MerlFile, value: &impl Fn(usize) -> Option<f64>, theta_i: f64) -> f64 {
    const RINGS: usize = 400;
    const STEPS: usize = 800;
    let i = [theta_i.sin(), 0.0, theta_i.cos()];
    let mut sum = 0.0;
    for ring in 0..RINGS {
        let cos_o = ((ring as f64 + 0.5) / RINGS as f64).sqrt();
        for step in 0..STEPS {
            let (sin_phi, cos_phi) = ((step as f64 + 0.5) / STEPS as f64 * std::f64::consts::PI).sin_cos();
            let sin_o = (1.0 - cos_o * cos_o).sqrt();
            let o = [sin_o * cos_phi, sin_o * sin_phi, cos_o];
            let h: [f64; 3] = std::array::from_fn(|n| i[n] + o[n]);
            let length = h.iter().map(|x| x * x).sum::<f64>().sqrt();
            let h = h.map(|x| x / length);
            let across = h[0].hypot(h[1]);
            let i_h: f64 = (0..3).map(|n| i[n] * h[n]).sum();
            // x away from the normal in the plane of normal and h, y = n x h direction.
            let x = (i[0] * h[0] + i[1] * h[1]) / across * h[2] - i[2] * across;
            let y = (h[0] * i[1] - h[1] * i[0]) / across;
            let d = file.dimensions();
            let bins = (d.theta_h_bin(across.atan2(h[2])), d.theta_d_bin(i_h.acos()), d.phi_d_bin(y.atan2(x)));
            sum += value(d.index(bins.0, bins.1, bins.2)).unwrap_or(0.0);
        }
    }
    // dw cos = d(cos^2)/2 dphi, and the half turn counts twice.
    sum * std::f64::consts::PI / (RINGS * STEPS) as f64
}
