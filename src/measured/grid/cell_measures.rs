//! The geometry of all cells, shared by every file of the same shape.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::grid::dimensions::Dimensions;
use crate::grid::mask::CellMask;
use crate::grid::sample_position::SamplePosition;
use crate::grid::samples::{RowCosines, Samples, is_above_horizon};

/// Largest angle of either direction with the normal in the error panel: 80 degrees, in radians.
pub const PANEL_ANGLE: f64 = 80.0 / 90.0 * FRAC_PI_2;

/// Directions and measures of all cells of a grid, for one [`SamplePosition`]. Make one and share it: 0.4 MB, about
/// 10 ms.
///
/// The cosines of the 1.5 million cells are not stored: from tables along each axis they cost two multiplications and
/// two additions, less than reading them back from memory would.
#[derive(Clone, Debug)]
pub struct Grid {
    dimensions: Dimensions,
    position: SamplePosition,
    samples: Samples,
    dw_h: Vec<f64>,
    dw_d: Vec<f64>,
    usable: CellMask,
    panel: CellMask,
}

/// The cells of one (theta_h, theta_d), which differ by phi_d only.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// Bin of theta_h.
    pub theta_h: usize,
    /// Bin of theta_d.
    pub theta_d: usize,
    /// The cell at phi_d bin 0; the others follow it.
    pub first: usize,
    /// cos theta_d = i.h at the sample.
    pub cos_theta_d: f64,
    /// Measure `dw_i dw_o` of each cell of the row, in steradians squared: [`Grid::weight`].
    pub weight: f64,
    cosines: RowCosines<'a>,
}

impl Row<'_> {
    /// (cos theta_i, cos theta_o) of the sample at bin `phi_d`.
    ///
    /// # Panics
    /// If the bin does not exist.
    #[must_use]
    #[inline]
    pub fn cosines(&self, phi_d: usize) -> (f64, f64) {
        self.cosines.at(phi_d)
    }
}

impl Grid {
    /// Tabulates the geometry of a grid.
    #[must_use]
    pub fn new(dimensions: Dimensions, position: SamplePosition) -> Self {
        let samples = Samples::new(dimensions, position);
        let edges_h: Vec<f64> = (0..=Dimensions::THETA_H).map(|i| dimensions.theta_h_edge(i)).collect();
        let edges_d: Vec<f64> = (0..=Dimensions::THETA_D).map(|j| dimensions.theta_d_edge(j)).collect();
        let dphi_d = 2.0 * PI / dimensions.phi_d() as f64;
        let measure = |edges: &[f64], turn: f64| edges.windows(2).map(|e| turn * cosine_drop(e[0], e[1])).collect();
        let select = |keep: &dyn Fn((f64, f64)) -> bool| {
            CellMask::from_fn(dimensions.cells(), |cell| {
                let (theta_h, theta_d, phi_d) = dimensions.bins(cell);
                keep(samples.row(theta_h, theta_d).at(phi_d))
            })
        };
        let cos_panel = libm::cos(PANEL_ANGLE);
        Self {
            usable: select(&is_above_horizon),
            panel: select(&|(cos_i, cos_o)| cos_i >= cos_panel && cos_o >= cos_panel),
            dw_h: measure(&edges_h, 2.0 * PI),
            dw_d: measure(&edges_d, dphi_d),
            samples,
            dimensions,
            position,
        }
    }

    /// The grid's shape.
    #[must_use]
    pub fn dimensions(&self) -> Dimensions {
        self.dimensions
    }

    /// Where inside its cell each sample lies.
    #[must_use]
    pub fn position(&self) -> SamplePosition {
        self.position
    }

    /// The cells with both directions above the horizon at the sample: both cosines above [`crate::MIN_COSINE`]. Tens of
    /// thousands of cells that files call valid are not among them; never use those.
    #[must_use]
    pub fn usable(&self) -> &CellMask {
        &self.usable
    }

    /// The cells of the error panel: theta_i and theta_o at most 80 degrees at the sample.
    #[must_use]
    pub fn panel(&self) -> &CellMask {
        &self.panel
    }

    /// (cos theta_i, cos theta_o) at the sample of a cell. For whole rows, [`Grid::row`] is cheaper.
    ///
    /// # Panics
    /// If the cell does not exist.
    #[must_use]
    #[inline]
    pub fn cosines(&self, cell: usize) -> (f64, f64) {
        let (theta_h, theta_d, phi_d) = self.dimensions.bins(cell);
        self.samples.row(theta_h, theta_d).at(phi_d)
    }

    /// Solid angle that the half vector sweeps in bin `theta_h`, all azimuths together, in steradians:
    /// `2 pi (cos e_i - cos e_(i+1))` with the bin's edges e.
    #[must_use]
    pub fn dw_h(&self, theta_h: usize) -> f64 {
        self.dw_h[theta_h]
    }

    /// Solid angle that the difference vector sweeps in one cell of bin `theta_d`, in steradians:
    /// `(cos e_j - cos e_(j+1)) 2 pi / bins(phi_d)`. With 180 bins a cell stands for its reciprocal twin too.
    #[must_use]
    pub fn dw_d(&self, theta_d: usize) -> f64 {
        self.dw_d[theta_d]
    }

    /// Measure of a cell in pairs of directions, in steradians squared: `dw_i dw_o = 4 cos theta_d dw_h dw_d`, with
    /// theta_d at the sample.
    #[must_use]
    #[inline]
    pub fn weight(&self, theta_h: usize, theta_d: usize) -> f64 {
        4.0 * self.samples.cos_theta_d(theta_d) * self.dw_h[theta_h] * self.dw_d[theta_d]
    }

    /// The cells of one (theta_h, theta_d).
    ///
    /// # Panics
    /// If a bin does not exist.
    #[must_use]
    pub fn row(&self, theta_h: usize, theta_d: usize) -> Row<'_> {
        Row {
            theta_h,
            theta_d,
            first: self.dimensions.index(theta_h, theta_d, 0),
            cos_theta_d: self.samples.cos_theta_d(theta_d),
            weight: self.weight(theta_h, theta_d),
            cosines: self.samples.row(theta_h, theta_d),
        }
    }

    /// All rows in the order of the file.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        (0..Dimensions::THETA_H)
            .flat_map(move |theta_h| (0..Dimensions::THETA_D).map(move |theta_d| self.row(theta_h, theta_d)))
    }
}

/// `cos a - cos b` without cancellation: the solid angle over 2 pi between two polar angles, radians.
pub fn cosine_drop(a: f64, b: f64) -> f64 {
    2.0 * libm::sin(0.5 * (a + b)) * libm::sin(0.5 * (b - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grids() -> impl Iterator<Item = Grid> {
        [Dimensions::HALF_TURN, Dimensions::FULL_TURN]
            .into_iter()
            .flat_map(|d| [SamplePosition::Edge, SamplePosition::Centre].map(|position| Grid::new(d, position)))
    }

    #[test]
    fn solid_angles_of_the_bins_add_up_to_half_spheres() {
        for grid in grids() {
            let half: f64 = (0..90).map(|i| grid.dw_h(i)).sum();
            assert!((half - 2.0 * PI).abs() < 1e-13);
            let difference: f64 = (0..90).map(|j| grid.dw_d(j) * grid.dimensions().phi_d() as f64).sum();
            assert!((difference - 2.0 * PI).abs() < 1e-13);
        }
    }

    /// The integral of cos theta_i cos theta_o over all pairs of directions is pi^2, that of 1 is (2 pi)^2: this pins
    /// the Jacobian 4 cos theta_d. Measured here, relative: at
    /// the centre 1.9e-4 and 1.5e-4; at the edge, where all samples lie to one side, 4.2e-2 and 5.4e-2.
    #[test]
    fn weights_integrate_pairs_of_directions() {
        for grid in grids() {
            let (mut ones, mut cosines) = (0.0, 0.0);
            for row in grid.rows() {
                for k in 0..grid.dimensions().phi_d() {
                    if grid.usable().contains(row.first + k) {
                        let (cos_i, cos_o) = row.cosines(k);
                        ones += row.weight;
                        cosines += row.weight * cos_i * cos_o;
                    }
                }
            }
            let (ones, cosines) = (ones / (4.0 * PI * PI) - 1.0, cosines / (PI * PI) - 1.0);
            println!("{:?} {}: {ones:.2e} {cosines:.2e}", grid.dimensions(), grid.position());
            let (of_ones, of_cosines) =
                if grid.position() == SamplePosition::Centre { (3e-4, 3e-4) } else { (6e-2, 6e-2) };
            assert!(ones.abs() < of_ones && cosines.abs() < of_cosines);
        }
    }

    #[test]
    fn rows_and_cells_agree() {
        for grid in grids() {
            for row in grid.rows().step_by(37) {
                for k in (0..grid.dimensions().phi_d()).step_by(7) {
                    let cell = row.first + k;
                    assert_eq!(grid.dimensions().bins(cell), (row.theta_h, row.theta_d, k));
                    let (cos_i, cos_o) = grid.cosines(cell);
                    assert_eq!(row.cosines(k), (cos_i, cos_o));
                    assert_eq!(grid.usable().contains(cell), cos_i > 1e-9 && cos_o > 1e-9);
                    if grid.panel().contains(cell) {
                        assert!(grid.usable().contains(cell) && cos_i.min(cos_o).acos().to_degrees() < 80.0 + 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn cosine_drop_is_exact_for_small_angles() {
        // cos a - cos b = (b^2 - a^2)/2 - (b^4 - a^4)/24 + ...
        let (a, b) = (1e-5, 2e-5_f64);
        let series = (b * b - a * a) / 2.0 - (b.powi(4) - a.powi(4)) / 24.0;
        assert!((cosine_drop(a, b) / series - 1.0).abs() < 1e-14);
    }
}
