//! The health of a measured file: the basis for deciding whether to use it.

use std::f64::consts::PI;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::Serialize;

use crate::grid::albedo::AlbedoPlan;
use crate::grid::cell_measures::Grid;
use crate::grid::dimensions::{CHANNEL_NAMES, CHANNEL_SCALE, CHANNELS, Dimensions};
use crate::grid::mask::CellMask;
use crate::grid::sample_position::SamplePosition;
use crate::merl::file::MerlFile;
use crate::merl::scan::Scan;

/// Angles theta_i at which the directional albedo is reported, in degrees.
const ALBEDO_DEGREES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

/// The peak of a plane: bin 0 of theta_h, and theta_d below this many degrees.
const PEAK_DEGREES: usize = 60;

/// Prepared checks for files of one shape: the geometry is made once.
#[derive(Clone, Debug)]
pub struct HealthCheck {
    grid: Grid,
    albedo: AlbedoPlan,
}

/// The checks of all grids and positions, each made when it is first needed and then shared by all files of a run.
#[derive(Debug, Default)]
pub struct HealthChecks([OnceLock<HealthCheck>; 4]);

impl HealthChecks {
    /// The check for files of this shape.
    pub(crate) fn of(&self, dimensions: Dimensions, position: SamplePosition) -> &HealthCheck {
        let index = 2 * usize::from(dimensions.is_folded()) + usize::from(position == SamplePosition::Edge);
        self.0[index].get_or_init(|| HealthCheck::new(dimensions, position))
    }
}

/// The state of a measured file.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Health {
    /// File name without its folder.
    pub name: String,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the file in hexadecimal.
    pub sha256: String,
    /// Numbers of bins of theta_h, theta_d and phi_d.
    pub dimensions: Dimensions,
    /// Position of a value within its cell, on which all angles below depend.
    pub sample_position: SamplePosition,
    /// Cells by region.
    pub regions: Regions,
    /// The colour planes R, G, B.
    pub channels: [ChannelHealth; CHANNELS],
    /// Number of planes that are zero around the peak: the colour is outside the gamut of the file's primaries.
    pub zero_peaks: usize,
    /// Directional albedo.
    pub albedo: AlbedoHealth,
}

/// Cells by region. `interior`, `grazing` and `below_horizon` make up `all`; the two rows overlap with them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Regions {
    /// The whole file.
    pub all: Region,
    /// theta_h bin 0: mirror reflection.
    pub specular_row: Region,
    /// theta_d bin 0: reflection back to the light.
    pub retro_row: Region,
    /// Both directions at most 80 degrees from the normal.
    pub interior: Region,
    /// Above the horizon, one direction more than 80 degrees from the normal.
    pub grazing: Region,
    /// A direction on or below the horizon: never used, whatever values the file has there.
    pub below_horizon: Region,
}

/// Counts of the cells of a region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Region {
    /// Number of cells.
    pub cells: usize,
    /// Cells that are finite and not negative in all three planes.
    pub valid: usize,
    /// Finite values below zero (no measurement) in R, G, B.
    pub negative: [usize; CHANNELS],
    /// Values that are not numbers in R, G, B.
    pub nan: [usize; CHANNELS],
    /// Infinite values in R, G, B.
    pub infinite: [usize; CHANNELS],
}

/// The state of one colour plane.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ChannelHealth {
    /// R, G or B.
    pub name: String,
    /// Smallest value over the valid cells above the horizon, in 1/sr.
    pub min: Option<f64>,
    /// Largest value over the valid cells above the horizon, in 1/sr.
    pub max: Option<f64>,
    /// Angles of the largest value (of the first, where there are several).
    pub max_at: Option<Angles>,
    /// Whether more than half of the valid cells around the peak (theta_h bin 0, theta_d below 60 degrees) are zero.
    pub zero_peak: bool,
}

/// The angles of a sample, in degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Angles {
    /// Angle between the half vector and the normal.
    pub theta_h_deg: f64,
    /// Angle between the half vector and the direction to the light.
    pub theta_d_deg: f64,
    /// Azimuth of the direction to the light around the half vector.
    pub phi_d_deg: f64,
    /// Angle between the direction to the light and the normal.
    pub theta_i_deg: f64,
    /// Angle between the direction to the eye and the normal.
    pub theta_o_deg: f64,
}

/// Directional albedo at a few angles, over the valid cells above the horizon.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct AlbedoHealth {
    /// Angles of the light with the normal, in degrees.
    pub theta_i_deg: Vec<f64>,
    /// Fraction of the cosine-weighted solid angle that has a measurement; the rest counts as black below.
    pub covered: Vec<f64>,
    /// Albedo of R, G and B at each angle.
    pub values: [Vec<f64>; CHANNELS],
}

impl HealthCheck {
    /// Prepares the geometry for files of one shape.
    #[must_use]
    pub fn new(dimensions: Dimensions, position: SamplePosition) -> Self {
        let angles = ALBEDO_DEGREES.map(|degrees| degrees / 180.0 * PI);
        Self { grid: Grid::new(dimensions, position), albedo: AlbedoPlan::new(dimensions, position, &angles) }
    }

    /// Examines a file that was scanned before. Files with values that are not finite are examined too.
    ///
    /// # Panics
    /// If the file or the scan is of another shape than the check.
    #[must_use]
    pub fn examine(&self, file: &MerlFile, scan: &Scan) -> Health {
        let dimensions = self.grid.dimensions();
        assert_eq!((file.dimensions(), scan.dimensions()), (dimensions, dimensions), "prepared for another shape");
        let used = scan.valid().and(self.grid.usable());
        let channels = std::array::from_fn(|channel| self.channel(file, channel, &used));
        Health {
            name: file.path().file_name().unwrap_or(file.path().as_os_str()).to_string_lossy().into_owned(),
            bytes: dimensions.file_bytes(),
            sha256: scan.sha256_hex(),
            dimensions,
            sample_position: self.grid.position(),
            regions: self.regions(file, scan),
            zero_peaks: channels.iter().filter(|channel: &&ChannelHealth| channel.zero_peak).count(),
            channels,
            albedo: self.albedo(|cell| used.contains(cell), |channel, cell| file.value(channel, cell)),
        }
    }

    /// The geometry.
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The directional albedo of `value(channel, cell)`, in 1/sr, over the cells that are `used`.
    pub(crate) fn albedo(&self, used: impl Fn(usize) -> bool, value: impl Fn(usize, usize) -> f64) -> AlbedoHealth {
        AlbedoHealth {
            theta_i_deg: ALBEDO_DEGREES.to_vec(),
            covered: self.albedo.covered(&used),
            values: std::array::from_fn(|channel| {
                self.albedo.integrate(|cell| used(cell).then(|| value(channel, cell)))
            }),
        }
    }

    fn regions(&self, file: &MerlFile, scan: &Scan) -> Regions {
        let planes: [_; CHANNELS] = std::array::from_fn(|channel| file.plane(channel));
        let mut regions = Regions::default();
        for row in self.grid.rows() {
            for cell in row.first..row.first + self.grid.dimensions().phi_d() {
                let one = Region::of_cell(scan.valid().contains(cell), planes.map(|p| f64::from_le_bytes(p[cell])));
                let part = if self.grid.panel().contains(cell) {
                    &mut regions.interior
                } else if self.grid.usable().contains(cell) {
                    &mut regions.grazing
                } else {
                    &mut regions.below_horizon
                };
                part.add(&one);
                if row.theta_h == 0 {
                    regions.specular_row.add(&one);
                }
                if row.theta_d == 0 {
                    regions.retro_row.add(&one);
                }
            }
        }
        for part in [regions.interior, regions.grazing, regions.below_horizon] {
            regions.all.add(&part);
        }
        regions
    }

    fn channel(&self, file: &MerlFile, channel: usize, used: &CellMask) -> ChannelHealth {
        let plane = file.plane(channel);
        let stored = |cell: usize| f64::from_le_bytes(plane[cell]);
        let mut min = f64::INFINITY;
        let mut max = None;
        for cell in used.iter() {
            let x = stored(cell);
            min = min.min(x);
            if max.is_none_or(|(largest, _)| x > largest) {
                max = Some((x, cell));
            }
        }
        let scale = CHANNEL_SCALE[channel];
        let peak: Vec<usize> =
            (0..self.grid.dimensions().index(0, PEAK_DEGREES, 0)).filter(|&c| used.contains(c)).collect();
        let zeros = peak.iter().filter(|&&cell| stored(cell) == 0.0).count();
        ChannelHealth {
            name: CHANNEL_NAMES[channel].to_owned(),
            min: max.map(|_| min * scale),
            max: max.map(|(x, _)| x * scale),
            max_at: max.map(|(_, cell)| self.angles(cell)),
            zero_peak: 2 * zeros > peak.len(),
        }
    }

    fn angles(&self, cell: usize) -> Angles {
        let (dimensions, position) = (self.grid.dimensions(), self.grid.position());
        let (theta_h, theta_d, phi_d) = dimensions.bins(cell);
        let (cos_i, cos_o) = self.grid.cosines(cell);
        Angles {
            theta_h_deg: dimensions.theta_h_sample(theta_h, position).to_degrees(),
            theta_d_deg: dimensions.theta_d_sample(theta_d, position).to_degrees(),
            phi_d_deg: dimensions.phi_d_sample(phi_d, position).to_degrees(),
            theta_i_deg: libm::acos(cos_i.clamp(-1.0, 1.0)).to_degrees(),
            theta_o_deg: libm::acos(cos_o.clamp(-1.0, 1.0)).to_degrees(),
        }
    }
}

impl Region {
    /// A region of one cell.
    fn of_cell(valid: bool, stored: [f64; CHANNELS]) -> Self {
        Self {
            cells: 1,
            valid: usize::from(valid),
            negative: stored.map(|x| usize::from(x < 0.0 && x.is_finite())),
            nan: stored.map(|x| usize::from(x.is_nan())),
            infinite: stored.map(|x| usize::from(x.is_infinite())),
        }
    }

    fn add(&mut self, other: &Self) {
        self.cells += other.cells;
        self.valid += other.valid;
        for channel in 0..CHANNELS {
            self.negative[channel] += other.negative[channel];
            self.nan[channel] += other.nan[channel];
            self.infinite[channel] += other.infinite[channel];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grey file with one bright cell, a red plane that is zero at the peak, and what `spoil` overwrites.
    fn examine(spoil: &[(usize, usize, f64)]) -> (Health, Scan) {
        let d = Dimensions::HALF_TURN;
        let file = MerlFile::from_fn("folder/grey.binary", d, |c, h, t, p| match (c, h, t, p) {
            (0, 0, 0..50, _) => 0.0,
            (1, 20, 30, 40) => 7.0,
            (_, 89, 89, _) => -1.0,
            _ => 0.5 / PI,
        })
        .unwrap();
        let mut bytes = file.bytes().to_vec();
        for &(channel, cell, x) in spoil {
            let at = 12 + 8 * (channel * d.cells() + cell);
            bytes[at..at + 8].copy_from_slice(&x.to_le_bytes());
        }
        let file = MerlFile::from_bytes("folder/grey.binary", bytes).unwrap();
        let scan = file.scan();
        (HealthCheck::new(d, SamplePosition::Centre).examine(&file, &scan), scan)
    }

    #[test]
    fn a_healthy_file() {
        let (health, scan) = examine(&[]);
        assert_eq!((health.name.as_str(), health.bytes), ("grey.binary", 34_992_012));
        assert_eq!(health.sha256, scan.sha256_hex());
        let r = &health.regions;
        assert_eq!(r.all.cells, 1_458_000);
        assert_eq!(r.all.valid, 1_458_000 - 180);
        assert_eq!(r.all.negative, [180; 3]);
        assert_eq!((r.specular_row.cells, r.retro_row.cells), (90 * 180, 90 * 180));
        assert_eq!(r.below_horizon.negative, [180; 3]);
        assert_eq!((health.channels[0].zero_peak, health.channels[1].zero_peak, health.zero_peaks), (true, false, 1));
        let green = &health.channels[1];
        let at = green.max_at.unwrap();
        assert!((green.max.unwrap() - 7.0).abs() < 1e-12 && (green.min.unwrap() - 0.5 / PI).abs() < 1e-12);
        assert!((at.theta_d_deg - 30.5).abs() < 1e-9 && (at.phi_d_deg - 40.5).abs() < 1e-9);
        assert!((at.theta_h_deg - (20.5_f64 / 90.0).powi(2) * 90.0).abs() < 1e-9);
        assert_eq!(health.channels[0].min, Some(0.0));
        for albedo in &health.albedo.values[2] {
            assert!((albedo - 0.5).abs() < 0.01, "{albedo}");
        }
        assert!(health.albedo.covered.iter().all(|&c| c > 0.98 && c <= 1.0), "{:?}", health.albedo.covered);
    }

    #[test]
    fn a_sick_file_is_still_described() {
        let (health, scan) =
            examine(&[(0, 7, f64::NAN), (1, 8, f64::INFINITY), (2, 8, -2.0), (2, 9, f64::NEG_INFINITY)]);
        let r = &health.regions;
        for region in [&r.all, &r.specular_row, &r.retro_row, &r.interior] {
            assert_eq!((region.nan, region.infinite), ([1, 0, 0], [0, 1, 1]));
        }
        assert_eq!(r.all.negative, [180, 180, 181]);
        assert_eq!(r.all.valid, scan.valid_cells());
        for channel in 0..CHANNELS {
            let found = scan.channels()[channel];
            assert_eq!(r.all.negative[channel], found.negative.count);
            assert_eq!(r.all.nan[channel], found.nan.count);
            assert_eq!(r.all.infinite[channel], found.infinite.count);
        }
        let json = serde_json::to_value(&health).unwrap();
        assert_eq!(json["dimensions"], serde_json::json!([90, 90, 180]));
        assert_eq!(json["sample_position"], "centre");
    }

    #[test]
    fn a_file_without_measurements_is_still_described() {
        let d = Dimensions::HALF_TURN;
        let file = MerlFile::from_fn("x", d, |_, _, _, _| -1.0).unwrap();
        let health = HealthCheck::new(d, SamplePosition::Edge).examine(&file, &file.scan());
        assert_eq!((health.channels[0].min, health.channels[0].max, health.zero_peaks), (None, None, 0));
        assert_eq!(health.albedo.covered, [0.0; 4]);
    }
}
