//! Energy per band: squared coefficients per pixel, averaged over the reflections of the image.

use crate::wavelet::pyramid::{Bands, Pyramid};
use crate::wavelet::simd_dispatch::dispatch_simd;

/// Energies of square blocks of pixels, per pixel, row-major.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Plane {
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    pub(crate) values: Vec<f32>,
}

/// Energies of one level; its blocks have `2^(level + 1)` pixels along a side.
#[derive(Clone, Debug, Default)]
pub(crate) struct LevelEnergy {
    /// Blocks left out above and to the left: fine levels may be known in a window only.
    pub(crate) top: usize,
    pub(crate) left: usize,
    /// Horizontal and vertical detail, added.
    pub(crate) sides: Plane,
    pub(crate) diagonals: Plane,
}

/// Energies of an image per band, finest level first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Energies {
    pub(crate) levels: Vec<LevelEnergy>,
    /// The approximation, on the blocks of the last level; it never counts as bandwidth.
    pub(crate) mean: Plane,
}

/// Axes along which an image was mirrored before the transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Reflected {
    /// Left and right.
    pub(crate) columns: bool,
    /// Top and bottom.
    pub(crate) rows: bool,
}

impl Plane {
    fn clear(&mut self, rows: usize, columns: usize) {
        self.rows = rows;
        self.columns = columns;
        self.values.clear();
        self.values.resize(rows * columns, 0.0);
    }

    /// Adds `density` times the squares of one or two coefficients per block of the reflected image.
    fn add_squares(&mut self, [first, second]: [Option<&[f32]>; 2], reflected: Reflected, density: f32) {
        let (rows, columns) = (self.rows, self.columns);
        let first = first.unwrap_or_default();
        assert_eq!(first.len(), rows * columns, "a band of another shape");
        dispatch_simd(
            #[inline(always)]
            || {
                for (r, row) in self.values.chunks_exact_mut(columns).enumerate() {
                    let from = if reflected.rows { rows - 1 - r } else { r } * columns;
                    let a = &first[from..from + columns];
                    match (second.map(|second| &second[from..from + columns]), reflected.columns) {
                        (None, false) => row.iter_mut().zip(a).for_each(|(e, a)| *e += density * (a * a)),
                        (None, true) => row.iter_mut().zip(a.iter().rev()).for_each(|(e, a)| *e += density * (a * a)),
                        (Some(b), false) => {
                            let both = row.iter_mut().zip(a.iter().zip(b));
                            both.for_each(|(e, (a, b))| *e += density * (a * a + b * b));
                        }
                        (Some(b), true) => {
                            let both = row.iter_mut().zip(a.iter().rev().zip(b.iter().rev()));
                            both.for_each(|(e, (a, b))| *e += density * (a * a + b * b));
                        }
                    }
                }
            },
        );
    }

    /// Adds a plane of the same shape, its rows backwards if `reversed`.
    fn add(&mut self, other: &Self, reversed: bool) {
        assert_eq!((self.rows, self.columns), (other.rows, other.columns), "a plane of another shape");
        for (r, row) in self.values.chunks_exact_mut(self.columns).enumerate() {
            let from = if reversed { self.rows - 1 - r } else { r } * other.columns;
            row.iter_mut().zip(&other.values[from..from + other.columns]).for_each(|(sum, energy)| *sum += energy);
        }
    }

    fn sum(&self) -> f64 {
        self.values.iter().map(|&energy| f64::from(energy)).sum()
    }
}

impl Energies {
    /// Sets the energies of a level to zero, in the shape of a window of `rows x columns` blocks at (top, left).
    pub(crate) fn clear_level(&mut self, level: usize, [top, left]: [usize; 2], [rows, columns]: [usize; 2]) {
        if self.levels.len() <= level {
            self.levels.resize_with(level + 1, LevelEnergy::default);
        }
        let energy = &mut self.levels[level];
        (energy.top, energy.left) = (top, left);
        energy.sides.clear(rows, columns);
        energy.diagonals.clear(rows, columns);
    }

    /// Sets the energies of the levels of a pyramid, the first of which is `first`, to zero, and drops all beyond.
    pub(crate) fn clear_pyramid(&mut self, first: usize, rows: usize, columns: usize, levels: usize) {
        for level in 0..levels {
            self.clear_level(first + level, [0, 0], [rows >> (level + 1), columns >> (level + 1)]);
        }
        self.levels.truncate(first + levels);
        self.mean.clear(rows >> levels, columns >> levels);
    }

    /// Adds the energies of one level of the transform of a reflected image, where they belong in the image itself.
    pub(crate) fn add_bands(&mut self, level: usize, bands: &Bands<f32>, reflected: Reflected, weight: f32) {
        let density = weight / blocks(level);
        let LevelEnergy { sides, diagonals, .. } = &mut self.levels[level];
        sides.add_squares([Some(&bands.horizontal), Some(&bands.vertical)], reflected, density);
        diagonals.add_squares([Some(&bands.diagonal), None], reflected, density);
    }

    /// Adds a whole pyramid, the finest level of which is `first` here.
    pub(crate) fn add_pyramid(&mut self, first: usize, pyramid: &Pyramid<f32>, reflected: Reflected, weight: f32) {
        for (level, bands) in pyramid.levels.iter().enumerate() {
            self.add_bands(first + level, bands, reflected, weight);
        }
        let density = weight / blocks(first + pyramid.levels.len() - 1);
        self.mean.add_squares([Some(&pyramid.approximation), None], reflected, density);
    }

    /// Sets all energies to zero, in the shape of another image, or of its finest level alone.
    pub(crate) fn clear_like(&mut self, other: &Self, finest_only: bool) {
        let levels = if finest_only { 1 } else { other.levels.len() };
        for (level, energy) in other.levels[..levels].iter().enumerate() {
            self.clear_level(level, [energy.top, energy.left], [energy.sides.rows, energy.sides.columns]);
        }
        self.levels.truncate(levels);
        let mean = if finest_only { [0, 0] } else { [other.mean.rows, other.mean.columns] };
        self.mean.clear(mean[0], mean[1]);
    }

    /// Adds energies of the same shape, or of the finest level alone, their rows backwards if `reversed`.
    pub(crate) fn add(&mut self, other: &Self, reversed: bool) {
        for (energy, other) in self.levels.iter_mut().zip(&other.levels) {
            energy.sides.add(&other.sides, reversed);
            energy.diagonals.add(&other.diagonals, reversed);
        }
        if !other.mean.values.is_empty() {
            self.mean.add(&other.mean, reversed);
        }
    }

    /// Sum of the squared coefficients of the finest level.
    pub(crate) fn finest(&self) -> f64 {
        let LevelEnergy { sides, diagonals, .. } = &self.levels[0];
        f64::from(blocks(0)) * (sides.sum() + diagonals.sum())
    }
}

/// Pixels of a block.
fn blocks(level: usize) -> f32 {
    4.0_f32.powi(level as i32 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wavelet::daubechies::Border;
    use crate::wavelet::energy_interpolation::{Axis, RowSamples, interpolate_row};

    #[derive(serde::Deserialize)]
    struct Fixture {
        signals: Vec<(String, Vec<Vec<f64>>)>,
        bandwidth: Vec<Bandwidth>,
    }

    #[derive(serde::Deserialize)]
    struct Bandwidth {
        name: String,
        border: String,
        reflections: String,
        finest_share: f64,
        probes: Vec<Vec<f64>>,
    }

    /// In single precision, to 1e-5 of the sum of all energies of the pixel.
    #[test]
    fn energies_at_pixels_are_those_of_pywavelets() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data-fixtures/wavelet.json");
        let fixture: Fixture = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        for Bandwidth { name, border, reflections, finest_share, probes } in fixture.bandwidth {
            let signal = &fixture.signals.iter().find(|signal| signal.0 == name).unwrap().1;
            let image: Vec<f32> = signal.concat().iter().map(|&value| (value / 4096.0) as f32).collect();
            let border = if border == "periodic" { Border::Periodic } else { Border::Reflect };
            let turned = if reflections == "four" { &[false, true][..] } else { &[false] };
            let weight = if reflections == "four" { 0.25 } else { 1.0 };
            let (mut energies, mut pyramid) = (Energies::default(), Pyramid::default());
            energies.clear_pyramid(0, 64, 64, 4);
            for &rows in turned {
                for &columns in turned {
                    let at = |n: usize, back: bool| if back { 63 - n } else { n };
                    let image: Vec<f32> =
                        (0..64 * 64).map(|n| image[64 * at(n / 64, rows) + at(n % 64, columns)]).collect();
                    pyramid.analyse(&image, 64, 64, border);
                    energies.add_pyramid(0, &pyramid, Reflected { columns, rows }, weight);
                }
            }
            let all: f64 = image.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
            assert!((energies.finest() / all / finest_share - 1.0).abs() < 1e-5);
            let axis = Axis::new(64, 4, [0.125, 0.375, 0.625, 0.875]);
            for probe in probes {
                let (r, c, total) = (probe[0] as usize, probe[1] as usize, probe[10]);
                let at = |plane: &Plane, level: usize| {
                    let mut row = [0.0; 64];
                    let samples = RowSamples { rows: &axis, row: r, columns: &axis, cells: 0..16 };
                    interpolate_row(plane, level, &samples, &mut row, &mut [0.0; 68]);
                    f64::from(row[c])
                };
                let mut sum = at(&energies.mean, 3);
                for (level, energy) in energies.levels.iter().enumerate() {
                    let ours = [at(&energy.diagonals, level), at(&energy.sides, level)];
                    for (ours, theirs) in ours.iter().zip(&probe[2 + 2 * level..]) {
                        assert!((ours - theirs).abs() <= 1e-5 * total, "{name} level {level}: {ours} {theirs}");
                        sum += ours;
                    }
                }
                assert!((sum - total).abs() <= 1e-5 * total, "{name}: {sum} {total}");
            }
        }
    }
}
