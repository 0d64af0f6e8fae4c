//! The RGL format as a measurement.

use std::borrow::Cow;
use std::sync::OnceLock;

use brdfit_brdf::{Brdf, Direction, HalfDifference, direction};
use sha2::{Digest, Sha256};

use crate::cells::Cells;
use crate::error::{MeasurementError, Reason};
use crate::grid::dimensions::{CHANNEL_NAMES, CHANNELS, Dimensions};
use crate::grid::mask::CellMask;
use crate::grid::sample_position::SamplePosition;
use crate::grid::samples::{Samples, is_above_horizon};
use crate::hash::hexadecimal;
use crate::info::{ChannelRange, Info, Summary, TableShape};
use crate::mapped_file::MappedFile;
use crate::measurement::{Described, Format, Measurement, Source, Survey};
use crate::merl::health::HealthChecks;
use crate::rgl::brdf::RglBrdf;
use crate::rgl::container::{MAGIC, TensorFile};
use crate::rgl::tables::Tables;
use crate::slices::Slices;

/// Dupuy & Jakob 2018: warped tables over the half vector, one per measured theta_i. The measurement has no grid of half and
/// difference angles; slices and cells are computed at the centres of the MERL grid.
pub(crate) static RGL: Format =
    Format { id: "rgl", name: "RGL", extensions: &["bsdf"], probe: |start| start.starts_with(MAGIC), open };

const POSITION: SamplePosition = SamplePosition::Centre;
const GRID: Dimensions = Dimensions::HALF_TURN;
/// Value stored for directions below the horizon.
const NO_MEASUREMENT: f64 = -1.0;
/// Pairs of directions over which the non-reciprocity is a median: 12 elevations up to 75 degrees each, 12 azimuths between.
const STEPS: usize = 12;
const STEEPEST_DEGREES: f64 = 75.0;

#[derive(Debug)]
struct Rgl {
    file: MappedFile,
    source: Source,
    brdf: RglBrdf,
    shapes: Vec<TableShape>,
    cells: OnceLock<Vec<[u8; 8]>>,
}

fn open(file: MappedFile, position: Option<SamplePosition>) -> Result<Box<dyn Measurement>, MeasurementError> {
    let failed = |reason: Reason| MeasurementError::new(file.path(), reason);
    if let Some(asked) = position.filter(|&asked| asked != POSITION) {
        return Err(failed(Reason::SamplePosition { format: RGL.name, fixed: POSITION, asked }));
    }
    let tensors = TensorFile::parse(&file).map_err(failed)?;
    let brdf = RglBrdf::new(Tables::new(&tensors).map_err(failed)?);
    let shape =
        |name: &str| tensors.find(name).map(|field| TableShape { name: name.to_owned(), shape: field.shape.clone() });
    let shapes = ["ndf", "sigma", "vndf", "luminance", "rgb"].into_iter().filter_map(shape).collect();
    let source = Source { path: file.path().to_path_buf(), format: RGL.id, sample_position: POSITION };
    Ok(Box::new(Rgl { source, brdf, shapes, cells: OnceLock::new(), file }))
}

impl Rgl {
    /// The mean of both orders of the directions; a negative value, which interpolation makes of a colour near the edge of the
    /// gamut, counts as zero.
    fn reciprocal_value(&self, i: &Direction, o: &Direction) -> [f64; CHANNELS] {
        let (there, back) = (self.brdf.stored_value(i, o), self.brdf.stored_value(o, i));
        [0, 1, 2].map(|c: usize| 0.5 * (there[c].max(0.0) + back[c].max(0.0)))
    }

    /// The same at the centre of a cell.
    fn cell_value(&self, [theta_h, theta_d, phi_d]: [usize; 3]) -> [f64; CHANNELS] {
        let (i, o) = HalfDifference {
            theta_h: GRID.theta_h_sample(theta_h, POSITION),
            theta_d: GRID.theta_d_sample(theta_d, POSITION),
            phi_d: GRID.phi_d_sample(phi_d, POSITION),
        }
        .to_directions();
        self.reciprocal_value(&i, &o)
    }

    fn sha256(&self) -> String {
        hexadecimal(&Sha256::digest(&self.file[..]))
    }

    /// The values of all cells, computed once.
    fn table(&self) -> Cells<'_> {
        let planes = self.cells.get_or_init(|| {
            let mut planes = vec![NO_MEASUREMENT.to_le_bytes(); CHANNELS * GRID.cells()];
            let valid = valid_cells();
            for cell in (0..GRID.cells()).filter(|&cell| valid.contains(cell)) {
                let (theta_h, theta_d, phi_d) = GRID.bins(cell);
                for (channel, value) in self.cell_value([theta_h, theta_d, phi_d]).into_iter().enumerate() {
                    planes[channel * GRID.cells() + cell] = value.to_le_bytes();
                }
            }
            planes
        });
        Cells::new(GRID, Cow::Borrowed(planes), [1.0; CHANNELS])
    }

    /// Median over pairs of directions of |f(i, o) - f(o, i)| over the mean of the two, each the mean of the channels.
    fn non_reciprocity(&self) -> f64 {
        let mean = |rgb: [f64; CHANNELS]| rgb.iter().sum::<f64>() / CHANNELS as f64;
        let theta = |n: usize| (STEEPEST_DEGREES * (n as f64 + 0.5) / STEPS as f64).to_radians();
        let mut differences = Vec::with_capacity(STEPS * STEPS * STEPS);
        for (a, b) in (0..STEPS).flat_map(|a| (0..a).map(move |b| (a, b))) {
            for turn in 0..STEPS {
                let phi = (turn as f64 + 0.5) / STEPS as f64 * std::f64::consts::PI;
                let (i, o) = (direction(theta(a), 0.0), direction(theta(b), phi));
                let (there, back) = (mean(self.brdf.stored_value(&i, &o)), mean(self.brdf.stored_value(&o, &i)));
                let both = 0.5 * (there + back);
                differences.push(if both > 0.0 { (there - back).abs() / both } else { 0.0 });
            }
        }
        differences.sort_by(f64::total_cmp);
        differences[differences.len() / 2]
    }
}

/// The cells whose two directions lie above the horizon at their centre: an RGL table has a value for all of them.
fn valid_cells() -> CellMask {
    let samples = Samples::new(GRID, POSITION);
    CellMask::from_fn(GRID.cells(), |cell| {
        let (theta_h, theta_d, phi_d) = GRID.bins(cell);
        is_above_horizon(samples.row(theta_h, theta_d).at(phi_d))
    })
}

impl Measurement for Rgl {
    fn source(&self) -> &Source {
        &self.source
    }

    fn dimensions(&self) -> Dimensions {
        GRID
    }

    fn survey(&self, _: bool) -> Result<Survey, MeasurementError> {
        // every value was checked when the file was opened
        Ok(Survey { sha256: self.sha256(), valid: valid_cells() })
    }

    fn slices(&self) -> Slices {
        Slices::of(GRID, POSITION, |bins| Some(self.cell_value(bins)))
    }

    fn cells(&self) -> Option<Cells<'_>> {
        Some(self.table())
    }

    fn brdf(&self) -> Result<Box<dyn Brdf>, MeasurementError> {
        Ok(Box::new(self.brdf.clone()))
    }

    fn info(&self, checks: &HealthChecks) -> Described {
        let check = checks.of(GRID, POSITION);
        let cells = self.table();
        let path = &self.source.path;
        let summary = Summary {
            name: path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            bytes: self.file.len() as u64,
            sha256: self.sha256(),
            format: RGL.id.to_owned(),
            description: self.brdf.tables().description.clone(),
            sample_position: POSITION,
            tables: self.shapes.clone(),
            measured_theta_i_deg: self.brdf.tables().theta_i.iter().map(|theta| theta.to_degrees()).collect(),
            channels: std::array::from_fn(|channel| {
                let values = check.grid().panel().iter().map(|cell| cells.value(channel, cell));
                let (min, max) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
                ChannelRange { name: CHANNEL_NAMES[channel].to_owned(), min, max }
            }),
            albedo: check
                .albedo(|cell| check.grid().usable().contains(cell), |channel, cell| cells.value(channel, cell)),
            non_reciprocity: self.non_reciprocity(),
        };
        Described { info: Info::Summary(Box::new(summary)), fault: None }
    }
}
