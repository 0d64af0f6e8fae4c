//! The error panel: how far the model is from the measurement on all cells (docs/theory.md, section 6).

use crate::document::{AllCells, ErrorPanel, LargestResidual, PanelTriple};
use crate::metrics::grid_model::{Directions, GridModel};
use brdfit_brdf::{ParameterError, SgdParameters};
use brdfit_measured::{AlbedoPlan, CellMask, Cells, Dimensions, Grid, PANEL_ANGLE, SamplePosition};
use rayon::prelude::*;
use wide::f64x4;

/// Angles of the measured albedo whose largest divides E: 0, 5, .., 80 degrees.
const ALBEDO_ANGLES: usize = 17;
/// Which of them are compared with the model: 10, 30, 50, 70 degrees.
const COMPARED: [usize; 4] = [2, 6, 10, 14];
/// Relative residuals are taken over at least this, 1/sr.
const RESIDUAL_FLOOR: f64 = 1e-3;

/// The geometry of the panel, shared by all files of one shape: 25 MB and less than 0.2 s.
#[derive(Clone, Debug)]
pub struct PanelGeometry {
    grid: Grid,
    directions: Directions,
    albedo: AlbedoPlan,
}

impl PanelGeometry {
    /// The geometry for files of this shape whose samples lie at `position`.
    pub fn new(dimensions: Dimensions, position: SamplePosition) -> Self {
        let grid = Grid::new(dimensions, position);
        let angles: Vec<f64> = (0..ALBEDO_ANGLES).map(|n| (5.0 * n as f64).to_radians()).collect();
        Self { directions: Directions::new(&grid), albedo: AlbedoPlan::new(dimensions, position, &angles), grid }
    }
}

/// Sums of one channel over a set of cells.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// `w cos_i cos_o (g - f)^2`, `w (difference of logarithms)^2`, `w (difference of cube roots)^2`.
    squares: [f64; 3],
    /// `w cos_i cos_o` and `w`.
    weights: [f64; 2],
}

impl Sums {
    fn add(&mut self, other: &Self) {
        for n in 0..3 {
            self.squares[n] += other.squares[n];
        }
        for n in 0..2 {
            self.weights[n] += other.weights[n];
        }
    }

    fn errors(&self, albedo: f64) -> [f64; 3] {
        let root = |sum: f64, weight: f64| if weight > 0.0 { (sum / weight).sqrt() } else { 0.0 };
        let e = root(self.squares[0], self.weights[0]);
        [
            if albedo > 0.0 { e / albedo } else { e },
            root(self.squares[1], self.weights[1]),
            root(self.squares[2], self.weights[1]),
        ]
    }
}

/// Results of one theta_h bin and channel.
#[derive(Clone, Copy, Default)]
struct Part {
    panel: Sums,
    all: Sums,
    largest: Option<LargestResidual>,
}

/// The errors of a model of three channels against a measurement, over the cells of `valid` (the survey's mask).
///
/// Sums run in the file's order within each theta_h bin and over the bins in order: the same bytes for any number of threads.
/// Masking comes from [`brdfit_brdf::G1Curve`] (5e-8 relative); against an independent NumPy implementation E, L and C agree within 1e-6
/// relative (`brdfit compare`, docs/accuracy.md).
///
/// # Errors
/// For parameters with which the model cannot be evaluated.
///
/// # Panics
/// If the shape of the grid is not that of the geometry.
pub fn error_panel(
    cells: &Cells<'_>,
    valid: &CellMask,
    geometry: &PanelGeometry,
    parameters: &[SgdParameters; 3],
) -> Result<ErrorPanel, ParameterError> {
    assert_eq!(cells.dimensions(), geometry.grid.dimensions(), "the geometry belongs to another shape");
    let [r, g, b] = parameters.map(|channel| GridModel::new(channel, &geometry.grid));
    let models = [r?, g?, b?];
    let parts: Vec<([Part; 3], [usize; 2])> = (0..Dimensions::THETA_H)
        .into_par_iter()
        .map(|theta_h| theta_h_bin(cells, valid, geometry, &models, theta_h))
        .collect();
    let mut total = [Part::default(); 3];
    let mut samples = [0; 2];
    for (part, counts) in &parts {
        for c in 0..3 {
            total[c].panel.add(&part[c].panel);
            total[c].all.add(&part[c].all);
            if let Some(found) = part[c].largest
                && total[c].largest.is_none_or(|other| found.value > other.value)
            {
                total[c].largest = Some(found);
            }
        }
        samples = [samples[0] + counts[0], samples[1] + counts[1]];
    }
    let (albedo, albedo_difference) = albedos(cells, valid, geometry, &models);
    let panel = [0, 1, 2].map(|c: usize| total[c].panel.errors(albedo[c]));
    let all = [0, 1, 2].map(|c: usize| total[c].all.errors(albedo[c]));
    let over_channels = |n: usize| (panel.iter().map(|errors| errors[n] * errors[n]).sum::<f64>() / 3.0).sqrt();
    Ok(ErrorPanel {
        limit_degrees: PANEL_ANGLE.to_degrees().round(),
        samples: samples[0],
        e: panel.map(|errors| errors[0]),
        l: panel.map(|errors| errors[1]),
        c: panel.map(|errors| errors[2]),
        over_channels: PanelTriple { e: over_channels(0), l: over_channels(1), c: over_channels(2) },
        albedo,
        albedo_difference,
        largest_relative_residual: total.map(|part| part.largest),
        all_cells: AllCells {
            samples: samples[1],
            errors: PanelTriple {
                e: all.map(|errors| errors[0]),
                l: all.map(|errors| errors[1]),
                c: all.map(|errors| errors[2]),
            },
        },
    })
}

/// What the channels share of four cells of a row. Padding has harmless values and counts for nothing.
#[derive(Clone, Copy)]
struct Lanes {
    cos_i: [f64; 4],
    cos_o: [f64; 4],
    /// Where both directions lie on the masking curve.
    positions: [[f64; 2]; 4],
    /// 1 inside of the panel's angles, else 0.
    inside: [f64; 4],
    /// 1 for a cell, 0 for padding.
    present: [f64; 4],
}

const PADDING: Lanes =
    Lanes { cos_i: [0.5; 4], cos_o: [0.5; 4], positions: [[0.0; 2]; 4], inside: [0.0; 4], present: [0.0; 4] };

fn theta_h_bin(
    cells: &Cells<'_>,
    valid: &CellMask,
    geometry: &PanelGeometry,
    models: &[GridModel; 3],
    theta_h: usize,
) -> ([Part; 3], [usize; 2]) {
    let PanelGeometry { grid, directions, .. } = geometry;
    let mut parts = [Part::default(); 3];
    let mut counts = [0; 2];
    let mut bins: Vec<usize> = Vec::with_capacity(grid.dimensions().phi_d());
    let mut lanes: Vec<Lanes> = Vec::new();
    for theta_d in 0..Dimensions::THETA_D {
        let row = grid.row(theta_h, theta_d);
        bins.clear();
        bins.extend((0..grid.dimensions().phi_d()).filter(|&phi_d| {
            let cell = row.first + phi_d;
            grid.usable().contains(cell) && valid.contains(cell)
        }));
        lanes.clear();
        for four in bins.chunks(4) {
            let mut lane = PADDING;
            for (n, &phi_d) in four.iter().enumerate() {
                (lane.cos_i[n], lane.cos_o[n]) = row.cosines(phi_d);
                lane.positions[n] = directions.of(row.first + phi_d);
                lane.present[n] = 1.0;
                if grid.panel().contains(row.first + phi_d) {
                    lane.inside[n] = 1.0;
                    counts[0] += 1;
                }
                counts[1] += 1;
            }
            lanes.push(lane);
        }
        for c in 0..3 {
            let mut all = [f64x4::splat(0.0); 5];
            let mut panel = [f64x4::splat(0.0); 5];
            for (four, lane) in bins.chunks(4).zip(&lanes) {
                let mut f = [0.0; 4];
                for (value, &phi_d) in f.iter_mut().zip(four) {
                    *value = cells.value(c, row.first + phi_d);
                }
                let [cos_i, cos_o] = [lane.cos_i, lane.cos_o].map(f64x4::from);
                let g = models[c].four_values(theta_h, theta_d, [cos_i, cos_o], &lane.positions);
                note_largest(&mut parts[c], &f, &g.to_array(), lane, four, theta_h, theta_d);
                let f = f64x4::from(f);
                // a fit without constraints may dip below zero: E sees it, L and C take what a renderer would
                let (f_cos, g_cos) = (f * cos_i, g.max(f64x4::splat(0.0)) * cos_i);
                let difference = g - f;
                let logarithm = ((g_cos + 1.0) / (f_cos + 1.0)).ln();
                let root = cube_root(g_cos) - cube_root(f_cos);
                let cosines = cos_i * cos_o;
                let present = f64x4::from(lane.present);
                let terms =
                    [cosines * difference * difference, logarithm * logarithm, root * root, cosines, f64x4::splat(1.0)];
                let inside = f64x4::from(lane.inside);
                for (n, term) in terms.into_iter().enumerate() {
                    all[n] += term * present;
                    panel[n] += term * inside;
                }
            }
            let sums = |lanes: [f64x4; 5]| {
                let [e, l, cubes, cosines, ones] = lanes.map(|sum| row.weight * add_lanes(sum));
                Sums { squares: [e, l, cubes], weights: [cosines, ones] }
            };
            parts[c].all.add(&sums(all));
            parts[c].panel.add(&sums(panel));
        }
    }
    (parts, counts)
}

/// Keeps the cell of the panel with the largest relative residual; the first one on a tie.
fn note_largest(
    part: &mut Part,
    f: &[f64; 4],
    g: &[f64; 4],
    lane: &Lanes,
    four: &[usize],
    theta_h: usize,
    theta_d: usize,
) {
    let mut largest = part.largest.map_or(-1.0, |found| found.value);
    for (n, &phi_d) in four.iter().enumerate() {
        let residual = (g[n] - f[n]).abs();
        let floor = f[n].max(RESIDUAL_FLOOR);
        if lane.inside[n] > 0.0 && residual > largest * floor {
            largest = residual / floor;
            part.largest =
                Some(LargestResidual { value: largest, cell: [theta_h, theta_d, phi_d], measured: f[n], model: g[n] });
        }
    }
}

/// Cube roots of numbers that are not negative, within 1e-13 relative; about 5e-67 for zero. A third of the exponent bits for a
/// start (within 4 %), then two steps of Halley's iteration, which triples the digits.
fn cube_root(x: f64x4) -> f64x4 {
    const THIRD_OF_BIAS: u64 = 0x2a9f_7893_0000_0000;
    let x = x.max(f64x4::splat(1e-200));
    let mut y = f64x4::from(x.to_array().map(|lane| f64::from_bits(lane.to_bits() / 3 + THIRD_OF_BIAS)));
    for _ in 0..2 {
        let cube = y * y * y;
        y = y * (cube + x + x) / (cube + cube + x);
    }
    y
}

fn add_lanes(sum: f64x4) -> f64 {
    let [a, b, c, d] = sum.to_array();
    (a + b) + (c + d)
}

/// The largest measured albedo per channel and the relative differences of the model's at the compared angles.
fn albedos(
    cells: &Cells<'_>,
    valid: &CellMask,
    geometry: &PanelGeometry,
    models: &[GridModel; 3],
) -> ([f64; 3], [[Option<f64>; 4]; 3]) {
    let PanelGeometry { grid, directions, albedo } = geometry;
    let keep = |cell: usize| grid.usable().contains(cell) && valid.contains(cell);
    let measured: Vec<[f64; 3]> = (0..ALBEDO_ANGLES)
        .into_par_iter()
        .map(|angle| {
            let mut sums = [0.0; 3];
            for (cell, weight) in albedo.cells(angle).filter(|&(cell, _)| keep(cell)) {
                for c in 0..3 {
                    sums[c] += weight * cells.value(c, cell);
                }
            }
            sums
        })
        .collect();
    let model: Vec<[f64; 3]> = COMPARED
        .par_iter()
        .map(|&angle| {
            let mut sums = [0.0; 3];
            for (cell, weight) in albedo.cells(angle).filter(|&(cell, _)| keep(cell)) {
                let (theta_h, theta_d, _) = grid.dimensions().bins(cell);
                for c in 0..3 {
                    sums[c] += weight * models[c].value(theta_h, theta_d, grid.cosines(cell), directions.of(cell));
                }
            }
            sums
        })
        .collect();
    let largest = [0, 1, 2].map(|c: usize| measured.iter().map(|sums| sums[c]).fold(0.0, f64::max));
    let differences = [0, 1, 2].map(|c: usize| {
        [0, 1, 2, 3].map(|n: usize| {
            let reference = measured[COMPARED[n]][c];
            (reference > 0.0).then(|| model[n][c] / reference - 1.0)
        })
    });
    (largest, differences)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::grid_model::synthesise;
    use brdfit_measured::MerlFile;

    const GLOSSY: SgdParameters = SgdParameters { rho_d: 0.1, rho_s: 0.4, alpha: 0.02, p: 0.7, f0: 0.3, f1: 0.1 };

    fn file_of(parameters: &[SgdParameters; 3], position: SamplePosition) -> MerlFile {
        let dimensions = Dimensions::HALF_TURN;
        let planes = synthesise(parameters, dimensions, position).unwrap();
        MerlFile::from_fn("synthetic", dimensions, |c, h, d, p| planes[c][dimensions.index(h, d, p)]).unwrap()
    }

    #[test]
    fn cube_roots_have_thirteen_digits() {
        for n in -600..300 {
            let x = 10f64.powf(f64::from(n) / 10.0);
            let root = cube_root(f64x4::splat(x)).to_array()[0];
            assert!((root / libm::cbrt(x) - 1.0).abs() < 1e-13, "{x}: {root}");
        }
        assert!(cube_root(f64x4::splat(0.0)).to_array()[0] < 1e-60);
    }

    #[test]
    fn the_model_has_no_distance_from_itself() {
        let file = file_of(&[GLOSSY; 3], SamplePosition::Edge);
        let geometry = PanelGeometry::new(file.dimensions(), SamplePosition::Edge);
        let panel = error_panel(&file.cells(), file.scan().valid(), &geometry, &[GLOSSY; 3]).unwrap();
        for errors in [panel.e, panel.l, panel.c, panel.all_cells.errors.e] {
            assert!(errors.iter().all(|&error| error < 1e-9), "{errors:?}");
        }
        assert!(panel.albedo_difference.iter().flatten().all(|d| d.unwrap().abs() < 1e-9));
    }

    #[test]
    fn a_model_below_zero_still_has_errors() {
        let file = file_of(&[GLOSSY; 3], SamplePosition::Edge);
        let geometry = PanelGeometry::new(file.dimensions(), SamplePosition::Edge);
        let negative = SgdParameters { rho_s: -40.0, ..GLOSSY };
        let panel = error_panel(&file.cells(), file.scan().valid(), &geometry, &[negative; 3]).unwrap();
        assert!([panel.e, panel.l, panel.c].as_flattened().iter().all(|error| error.is_finite() && *error > 0.0));
    }

    #[test]
    fn diffuse_against_diffuse_has_a_closed_form() {
        // f = 0.2/pi, g = 0.3/pi: E = 0.1/pi / albedo; L and C are means of known functions of cos theta_i over equal cells
        let diffuse = |rho_d| SgdParameters { rho_d, rho_s: 0.0, ..GLOSSY };
        let file = file_of(&[diffuse(0.2); 3], SamplePosition::Centre);
        let geometry = PanelGeometry::new(file.dimensions(), SamplePosition::Centre);
        let panel =
            error_panel(&file.cells(), file.scan().valid(), &geometry, &[diffuse(0.2), diffuse(0.3), diffuse(0.1)])
                .unwrap();
        let expected = 0.1 / std::f64::consts::PI / panel.albedo[1];
        assert!(
            panel.e[0] < 1e-12
                && (panel.e[1] / expected - 1.0).abs() < 1e-9
                && (panel.e[2] / expected - 1.0).abs() < 1e-9
        );
        assert!((panel.albedo[0] - 0.2).abs() < 2e-3);
        assert!((panel.albedo_difference[1][0].unwrap() - 0.5).abs() < 1e-9);
        // the weighted sums once more, in the plainest way
        let grid = Grid::new(file.dimensions(), SamplePosition::Centre);
        let (mut logs, mut roots, mut weights) = (0.0, 0.0, 0.0);
        for cell in (0..file.dimensions().cells()).filter(|&cell| grid.panel().contains(cell)) {
            let (h, d, _) = file.dimensions().bins(cell);
            let (weight, (cos_i, _)) = (grid.weight(h, d), grid.cosines(cell));
            let (f, g) = (0.2 / std::f64::consts::PI, 0.3 / std::f64::consts::PI);
            logs += weight * ((1.0 + g * cos_i).ln() - (1.0 + f * cos_i).ln()).powi(2);
            roots += weight * ((g * cos_i).cbrt() - (f * cos_i).cbrt()).powi(2);
            weights += weight;
        }
        assert!((panel.l[1] / (logs / weights).sqrt() - 1.0).abs() < 1e-9);
        assert!((panel.c[1] / (roots / weights).sqrt() - 1.0).abs() < 1e-9);
        let largest = panel.largest_relative_residual[1].unwrap();
        assert!((largest.value - 0.5).abs() < 1e-9);
    }
}
