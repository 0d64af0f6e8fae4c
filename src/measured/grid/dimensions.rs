//! The grid of a MERL file: its size, its index maps and the angles of its samples.
//!
//! Matusik, Pfister, Brand & McMillan, "A Data-Driven Reflectance Model", SIGGRAPH 2003, use the half and difference
//! angles of Rusinkiewicz 1998: theta_h between the half vector and the normal, theta_d between the half vector and the
//! direction to the light, phi_d the azimuth of that direction around the half vector. theta_h is sampled by its square
//! root, so that narrow highlights get most of the bins; theta_d and phi_d are sampled evenly.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::grid::sample_position::SamplePosition;

/// Number of colour planes, in the order R, G, B.
pub const CHANNELS: usize = 3;

/// Names of the colour planes.
pub const CHANNEL_NAMES: [&str; CHANNELS] = ["R", "G", "B"];

/// What a stored number of each plane is multiplied by to give a BRDF value in 1/sr.
pub const CHANNEL_SCALE: [f64; CHANNELS] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// The grid of a MERL file: 90 bins of theta_h, 90 of theta_d, and 180 or 360 of phi_d.
///
/// With 180 bins phi_d covers `[0, pi)` and reciprocity covers the rest; with 360 bins (data that need not be
/// reciprocal) it covers `[0, 2 pi)`. A bin of phi_d is one degree wide in both cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(into = "[usize; 3]", try_from = "[usize; 3]")]
#[schemars(with = "[usize; 3]")]
pub struct Dimensions {
    phi_d: usize,
}

impl Dimensions {
    /// Number of theta_h bins.
    pub const THETA_H: usize = 90;
    /// Number of theta_d bins.
    pub const THETA_D: usize = 90;
    /// The common grid, 90 x 90 x 180.
    pub const HALF_TURN: Self = Self { phi_d: 180 };
    /// The grid without the assumption of reciprocity, 90 x 90 x 360.
    pub const FULL_TURN: Self = Self { phi_d: 360 };

    /// The grid of the given shape (theta_h, theta_d, phi_d), if it is one of the two that exist.
    #[must_use]
    pub const fn from_shape(shape: [usize; 3]) -> Option<Self> {
        match shape {
            [Self::THETA_H, Self::THETA_D, 180] => Some(Self::HALF_TURN),
            [Self::THETA_H, Self::THETA_D, 360] => Some(Self::FULL_TURN),
            _ => None,
        }
    }

    /// Numbers of bins (theta_h, theta_d, phi_d), as in the file's header.
    #[must_use]
    pub const fn shape(self) -> [usize; 3] {
        [Self::THETA_H, Self::THETA_D, self.phi_d]
    }

    /// Number of phi_d bins, 180 or 360.
    #[must_use]
    pub const fn phi_d(self) -> usize {
        self.phi_d
    }

    /// Number of cells in one plane.
    #[must_use]
    pub const fn cells(self) -> usize {
        Self::THETA_H * Self::THETA_D * self.phi_d
    }

    /// Whether opposite phi_d share one cell (180 bins).
    #[must_use]
    pub const fn is_folded(self) -> bool {
        self.phi_d == 180
    }

    /// Cell of the given bins: `phi_d + bins(phi_d) (theta_d + 90 theta_h)`.
    #[must_use]
    pub const fn index(self, theta_h: usize, theta_d: usize, phi_d: usize) -> usize {
        phi_d + self.phi_d * (theta_d + Self::THETA_D * theta_h)
    }

    /// Bins (theta_h, theta_d, phi_d) of a cell: the inverse of [`Self::index`].
    #[must_use]
    pub const fn bins(self, cell: usize) -> (usize, usize, usize) {
        let row = cell / self.phi_d;
        (row / Self::THETA_D, row % Self::THETA_D, cell % self.phi_d)
    }

    /// Bin of an angle theta_h in radians: `floor(90 sqrt(theta_h / (pi/2)))`, clamped to 0..=89.
    #[must_use]
    pub fn theta_h_bin(self, theta_h: f64) -> usize {
        clamped_floor(Self::THETA_H as f64 * (theta_h / FRAC_PI_2).max(0.0).sqrt(), Self::THETA_H)
    }

    /// Bin of an angle theta_d in radians: `floor(90 theta_d / (pi/2))`, clamped to 0..=89.
    #[must_use]
    pub fn theta_d_bin(self, theta_d: f64) -> usize {
        clamped_floor(Self::THETA_D as f64 * (theta_d / FRAC_PI_2), Self::THETA_D)
    }

    /// Bin of an angle phi_d in radians: `floor(180 phi_d / pi)` after folding phi_d into `[0, pi)` (180 bins) or
    /// `[0, 2 pi)` (360 bins), clamped.
    ///
    /// Any finite angle is accepted; pi itself folds to 0 where there are 180 bins.
    #[must_use]
    pub fn phi_d_bin(self, phi_d: f64) -> usize {
        let period = if self.is_folded() { PI } else { 2.0 * PI };
        clamped_floor(180.0 * phi_d.rem_euclid(period) / PI, self.phi_d)
    }

    /// Lower edge of theta_h bin `i`, in radians: `(i/90)^2 pi/2`; `i = 90` is the upper end.
    #[must_use]
    pub fn theta_h_edge(self, i: usize) -> f64 {
        self.theta_h_sample(i, SamplePosition::Edge)
    }

    /// Lower edge of theta_d bin `j`, in radians: `(j/90) pi/2`; `j = 90` is the upper end.
    #[must_use]
    pub fn theta_d_edge(self, j: usize) -> f64 {
        self.theta_d_sample(j, SamplePosition::Edge)
    }

    /// Sample angle of theta_h bin `i`, in radians.
    #[must_use]
    pub fn theta_h_sample(self, i: usize, position: SamplePosition) -> f64 {
        let x = (i as f64 + position.offset()) / Self::THETA_H as f64;
        x * x * FRAC_PI_2
    }

    /// Sample angle of theta_d bin `j`, in radians.
    #[must_use]
    pub fn theta_d_sample(self, j: usize, position: SamplePosition) -> f64 {
        (j as f64 + position.offset()) / Self::THETA_D as f64 * FRAC_PI_2
    }

    /// Sample angle of phi_d bin `k`, in radians: below pi with 180 bins, below 2 pi with 360.
    #[must_use]
    pub fn phi_d_sample(self, k: usize, position: SamplePosition) -> f64 {
        (k as f64 + position.offset()) / 180.0 * PI
    }
}

/// `floor(x)` clamped to `0..bins`; not-a-number gives 0.
fn clamped_floor(x: f64, bins: usize) -> usize {
    // The cast truncates toward zero, which is the floor of a positive number, and saturates elsewhere.
    (x as usize).min(bins - 1)
}

/// Cosines (cos theta_i, cos theta_o) of the two directions with the normal, from half and difference angles in radians:
///
/// `cos theta_h cos theta_d -+ sin theta_h sin theta_d cos phi_d`, minus for i and plus for o.
#[must_use]
pub fn cosines(theta_h: f64, theta_d: f64, phi_d: f64) -> (f64, f64) {
    let even = libm::cos(theta_h) * libm::cos(theta_d);
    let odd = libm::sin(theta_h) * libm::sin(theta_d) * libm::cos(phi_d);
    (even - odd, even + odd)
}

impl fmt::Display for Dimensions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [theta_h, theta_d, phi_d] = self.shape();
        write!(f, "{theta_h} x {theta_d} x {phi_d}")
    }
}

impl From<Dimensions> for [usize; 3] {
    fn from(dimensions: Dimensions) -> Self {
        dimensions.shape()
    }
}

/// The shape is neither 90 x 90 x 180 nor 90 x 90 x 360.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} is not a MERL grid: expected [90, 90, 180] or [90, 90, 360]")]
pub struct NotAMerlGrid(pub [usize; 3]);

impl TryFrom<[usize; 3]> for Dimensions {
    type Error = NotAMerlGrid;

    fn try_from(shape: [usize; 3]) -> Result<Self, NotAMerlGrid> {
        Self::from_shape(shape).ok_or(NotAMerlGrid(shape))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BOTH: [Dimensions; 2] = [Dimensions::HALF_TURN, Dimensions::FULL_TURN];

    #[test]
    fn index_and_bins_are_inverse_and_cover_the_plane() {
        for d in BOTH {
            let mut next = 0;
            for h in 0..90 {
                for t in 0..90 {
                    for p in 0..d.phi_d() {
                        assert_eq!(d.index(h, t, p), next);
                        assert_eq!(d.bins(next), (h, t, p));
                        next += 1;
                    }
                }
            }
            assert_eq!(next, d.cells());
        }
    }

    #[test]
    fn the_middle_of_every_bin_maps_to_that_bin() {
        let centre = SamplePosition::Centre;
        for d in BOTH {
            for i in 0..90 {
                assert_eq!(d.theta_h_bin(d.theta_h_sample(i, centre)), i);
                assert_eq!(d.theta_d_bin(d.theta_d_sample(i, centre)), i);
            }
            for k in 0..d.phi_d() {
                assert_eq!(d.phi_d_bin(d.phi_d_sample(k, centre)), k);
            }
        }
    }

    #[test]
    fn angles_outside_the_range_are_clamped_and_phi_is_folded() {
        let d = Dimensions::HALF_TURN;
        assert_eq!(
            (d.theta_h_bin(-0.1), d.theta_h_bin(0.0), d.theta_h_bin(FRAC_PI_2), d.theta_h_bin(3.0)),
            (0, 0, 89, 89)
        );
        assert_eq!(
            (d.theta_d_bin(-0.1), d.theta_d_bin(0.0), d.theta_d_bin(FRAC_PI_2), d.theta_d_bin(3.0)),
            (0, 0, 89, 89)
        );
        assert_eq!((d.phi_d_bin(PI), d.phi_d_bin(-PI), d.phi_d_bin(-1e-300)), (0, 0, 179));
        assert_eq!(d.phi_d_bin(f64::NAN), 0);
        let full = Dimensions::FULL_TURN;
        assert_eq!((full.phi_d_bin(PI), full.phi_d_bin(-0.01), full.phi_d_bin(2.0 * PI)), (180, 359, 0));
    }

    #[test]
    fn theta_h_bins_are_narrow_at_the_highlight() {
        let d = Dimensions::HALF_TURN;
        // 1 degree is bin floor(90 sqrt(1/90)) = 9, a linear map would say 1; 10 degrees is bin 30 or, rounded down, 29.
        assert_eq!(d.theta_h_bin(1.0_f64.to_radians()), 9);
        assert_eq!(d.theta_h_bin(10.1_f64.to_radians()), 30);
        assert!((d.theta_h_edge(30).to_degrees() - 10.0).abs() < 1e-12);
    }

    #[test]
    fn json_is_the_shape() {
        assert_eq!(serde_json::to_string(&Dimensions::FULL_TURN).unwrap(), "[90,90,360]");
        assert_eq!(serde_json::from_str::<Dimensions>("[90,90,180]").unwrap(), Dimensions::HALF_TURN);
        assert!(serde_json::from_str::<Dimensions>("[90,90,90]").is_err());
    }

    proptest! {
        /// Building i and o from h and the difference vector by explicit rotations gives the same cosines.
        #[test]
        fn cosines_agree_with_rotated_vectors(h in 0.0..FRAC_PI_2, t in 0.0..FRAC_PI_2, p in -PI..PI) {
            let local = [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()];
            // Rotating about y by theta_h takes the normal to the half vector.
            let z = |v: [f64; 3]| v[2] * h.cos() - v[0] * h.sin();
            let (cos_i, cos_o) = cosines(h, t, p);
            prop_assert!((cos_i - z(local)).abs() < 1e-14);
            prop_assert!((cos_o - z([-local[0], -local[1], local[2]])).abs() < 1e-14);
        }

        /// Folding by pi (reciprocity) exchanges i and o and stays in the cell.
        #[test]
        fn folding_exchanges_the_directions(h in 0.0..FRAC_PI_2, t in 0.0..FRAC_PI_2, k in 0usize..180) {
            let d = Dimensions::HALF_TURN;
            let p = d.phi_d_sample(k, SamplePosition::Centre);
            let (a, b) = (cosines(h, t, p), cosines(h, t, p - PI));
            prop_assert!((a.0 - b.1).abs() < 1e-14 && (a.1 - b.0).abs() < 1e-14);
            prop_assert_eq!(d.phi_d_bin(p - PI), k);
        }
    }
}
