//! The error panel: errors of the model over all cells (docs/theory.md, section 6).

use crate::document::{AllCells, ErrorPanel, LargestResidual, PanelTriple};
use crate::metrics::grid_model::{Directions, on_grid};
use brdfit_brdf::{CellRow, FourCells, GridModel, MaterialParameters};
use brdfit_measured::{AlbedoPlan, CellMask, Cells, Dimensions, Grid, PANEL_ANGLE, Row, SamplePosition};
use rayon::prelude::*;
use wide::f64x4;

/// Angles of the measured albedo whose largest divides E: 0, 5, .., 80 degrees.
const ALBEDO_ANGLES: usize = 17;
/// Those that are compared with the model: 10, 30, 50, 70 degrees.
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
/// Against an independent NumPy implementation E, L and C agree within 1e-6
/// relative (`brdfit compare`, docs/accuracy.md).
///
/// # Panics
/// If the shape of the grid is not that of the geometry.
pub fn error_panel(
    cells: &Cells<'_>,
    valid: &CellMask,
    geometry: &PanelGeometry,
    parameters: &MaterialParameters,
) -> ErrorPanel {
    assert_eq!(cells.dimensions(), geometry.grid.dimensions(), "the geometry belongs to another shape");
    let models = on_grid(parameters, &geometry.grid);
    let parts: Vec<([Part; 3], [usize; 2])> = (0..Dimensions::THETA_H)
        .into_par_iter()
        .map(|theta_h| Bin { cells, valid, geometry, models: &models, theta_h }.errors())
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
    ErrorPanel {
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
    }
}

/// One theta_h bin of a file against three models.
struct Bin<'a> {
    cells: &'a Cells<'a>,
    valid: &'a CellMask,
    geometry: &'a PanelGeometry,
    models: &'a [Box<dyn GridModel>; 3],
    theta_h: usize,
}

/// The valid cells of a row in blocks of four, and buffers of the results.
#[derive(Default)]
struct RowCells {
    /// Bins of phi_d; `bins.chunks(4)` belong to the blocks.
    bins: Vec<usize>,
    cells: Vec<FourCells>,
    /// 1 inside of the panel's angles, else 0.
    inside: Vec<[f64; 4]>,
    /// 1 for a cell, 0 for padding.
    present: Vec<[f64; 4]>,
    /// The model's values of one channel.
    values: Vec<[f64; 4]>,
}

/// Padding of the last block: harmless values of weight zero.
const PADDING: FourCells = FourCells { cosines: [[0.5; 4]; 2], positions: [[0.0; 2]; 4] };

impl RowCells {
    /// Takes the usable cells of a row; adds the numbers of cells inside of the panel and of all cells to `counts`.
    fn fill(&mut self, geometry: &PanelGeometry, valid: &CellMask, row: &Row<'_>, counts: &mut [usize; 2]) {
        let PanelGeometry { grid, directions, .. } = geometry;
        self.bins.clear();
        self.bins.extend((0..grid.dimensions().phi_d()).filter(|&phi_d| {
            let cell = row.first + phi_d;
            grid.usable().contains(cell) && valid.contains(cell)
        }));
        self.cells.clear();
        self.inside.clear();
        self.present.clear();
        for four in self.bins.chunks(4) {
            let (mut cells, mut inside, mut present) = (PADDING, [0.0; 4], [0.0; 4]);
            for (n, &phi_d) in four.iter().enumerate() {
                (cells.cosines[0][n], cells.cosines[1][n]) = row.cosines(phi_d);
                cells.positions[n] = directions.of(row.first + phi_d);
                present[n] = 1.0;
                if grid.panel().contains(row.first + phi_d) {
                    inside[n] = 1.0;
                    counts[0] += 1;
                }
                counts[1] += 1;
            }
            self.cells.push(cells);
            self.inside.push(inside);
            self.present.push(present);
        }
        self.values.resize(self.cells.len(), [0.0; 4]);
    }
}

impl Bin<'_> {
    /// The sums of the channels, and the numbers of cells inside of the panel and of all cells.
    fn errors(&self) -> ([Part; 3], [usize; 2]) {
        let mut parts = [Part::default(); 3];
        let mut counts = [0; 2];
        let mut cells = RowCells::default();
        for theta_d in 0..Dimensions::THETA_D {
            let row = self.geometry.grid.row(self.theta_h, theta_d);
            cells.fill(self.geometry, self.valid, &row, &mut counts);
            for (c, part) in parts.iter_mut().enumerate() {
                self.add_row(c, &row, &mut cells, part);
            }
        }
        (parts, counts)
    }

    /// Adds the cells of a row to the sums of a channel.
    fn add_row(&self, channel: usize, row: &Row<'_>, row_cells: &mut RowCells, part: &mut Part) {
        let RowCells { bins, cells, inside, present, values } = row_cells;
        self.models[channel].values(CellRow { theta_h: row.theta_h, theta_d: row.theta_d }, cells, values);
        let mut all = [f64x4::splat(0.0); 5];
        let mut panel = [f64x4::splat(0.0); 5];
        for (block, four) in bins.chunks(4).enumerate() {
            let mut f = [0.0; 4];
            for (value, &phi_d) in f.iter_mut().zip(four) {
                *value = self.cells.value(channel, row.first + phi_d);
            }
            note_largest(part, row, four, &f, &values[block], &inside[block]);
            let terms = terms(f64x4::from(f), f64x4::from(values[block]), cells[block].cosines.map(f64x4::from));
            let (inside, present) = (f64x4::from(inside[block]), f64x4::from(present[block]));
            for (n, term) in terms.into_iter().enumerate() {
                all[n] += term * present;
                panel[n] += term * inside;
            }
        }
        let sums = |lanes: [f64x4; 5]| {
            let [e, l, cubes, cosines, ones] = lanes.map(|sum| row.weight * add_lanes(sum));
            Sums { squares: [e, l, cubes], weights: [cosines, ones] }
        };
        part.all.add(&sums(all));
        part.panel.add(&sums(panel));
    }
}

/// The terms of four cells, measured f and model g: squared differences of E, L and C, and the weights of E and of the others.
#[inline(always)]
fn terms(f: f64x4, g: f64x4, [cos_i, cos_o]: [f64x4; 2]) -> [f64x4; 5] {
    // a fit without constraints may dip below zero: E sees it, L and C take what a renderer would
    let (f_cos, g_cos) = (f * cos_i, g.max(f64x4::splat(0.0)) * cos_i);
    let difference = g - f;
    let logarithm = ((g_cos + 1.0) / (f_cos + 1.0)).ln();
    let root = cube_root(g_cos) - cube_root(f_cos);
    let cosines = cos_i * cos_o;
    [cosines * difference * difference, logarithm * logarithm, root * root, cosines, f64x4::splat(1.0)]
}

/// Keeps the cell of the panel with the largest relative residual; the first one on a tie.
fn note_largest(part: &mut Part, row: &Row<'_>, four: &[usize], f: &[f64; 4], g: &[f64; 4], inside: &[f64; 4]) {
    let mut largest = part.largest.map_or(-1.0, |found| found.value);
    for (n, &phi_d) in four.iter().enumerate() {
        let residual = (g[n] - f[n]).abs();
        let floor = f[n].max(RESIDUAL_FLOOR);
        if inside[n] > 0.0 && residual > largest * floor {
            largest = residual / floor;
            let cell = [row.theta_h, row.theta_d, phi_d];
            part.largest = Some(LargestResidual { value: largest, cell, measured: f[n], model: g[n] });
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
    models: &[Box<dyn GridModel>; 3],
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
                    let row = CellRow { theta_h, theta_d };
                    sums[c] += weight * models[c].value(row, grid.cosines(cell), directions.of(cell));
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
    use brdfit_brdf::SgdParameters;
    use brdfit_measured::MerlFile;

    const GLOSSY: SgdParameters = SgdParameters { rho_d: 0.1, rho_s: 0.4, alpha: 0.02, p: 0.7, f0: 0.3, f1: 0.1 };

    fn file_of(parameters: [SgdParameters; 3], position: SamplePosition) -> MerlFile {
        let dimensions = Dimensions::HALF_TURN;
        let planes = synthesise(&parameters.try_into().unwrap(), dimensions, position);
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
        let file = file_of([GLOSSY; 3], SamplePosition::Edge);
        let geometry = PanelGeometry::new(file.dimensions(), SamplePosition::Edge);
        let panel = error_panel(&file.cells(), file.scan().valid(), &geometry, &[GLOSSY; 3].try_into().unwrap());
        for errors in [panel.e, panel.l, panel.c, panel.all_cells.errors.e] {
            assert!(errors.iter().all(|&error| error < 1e-9), "{errors:?}");
        }
        assert!(panel.albedo_difference.iter().flatten().all(|d| d.unwrap().abs() < 1e-9));
    }

    #[test]
    fn a_model_below_zero_still_has_errors() {
        let file = file_of([GLOSSY; 3], SamplePosition::Edge);
        let geometry = PanelGeometry::new(file.dimensions(), SamplePosition::Edge);
        let negative = SgdParameters { rho_s: -40.0, ..GLOSSY };
        let panel = error_panel(&file.cells(), file.scan().valid(), &geometry, &[negative; 3].try_into().unwrap());
        assert!([panel.e, panel.l, panel.c].as_flattened().iter().all(|error| error.is_finite() && *error > 0.0));
    }

    #[test]
    fn diffuse_against_diffuse_has_a_closed_form() {
        // f = 0.2/pi, g = 0.3/pi: E = 0.1/pi / albedo; L and C are means of known functions of cos theta_i over equal cells
        let diffuse = |rho_d| SgdParameters { rho_d, rho_s: 0.0, ..GLOSSY };
        let file = file_of([diffuse(0.2); 3], SamplePosition::Centre);
        let geometry = PanelGeometry::new(file.dimensions(), SamplePosition::Centre);
        let models = [diffuse(0.2), diffuse(0.3), diffuse(0.1)].try_into().unwrap();
        let panel = error_panel(&file.cells(), file.scan().valid(), &geometry, &models);
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
