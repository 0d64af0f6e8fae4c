//! The way of one material: open, look at every cell, cut the slices, fit, measure the errors, write it all down.

use std::sync::OnceLock;

use brdfit_brdf::{MaterialParameters, ModelName};
use brdfit_fit::document::{ErrorPanel, FitDocument, Input, SCHEMA_VERSION};
use brdfit_fit::{FitError, FitOptions, PanelGeometry, RecordedOptions, error_panel, fit_slices};
use brdfit_measured::{Dimensions, MerlError, MerlFile, SamplePosition, Scan};
use tracing::{debug, info};

use crate::jobs::batch::in_pool;
use crate::jobs::inputs::InputFile;
use crate::terminal::exit_code::Problem;

/// The program as its documents name it.
pub(crate) const PROGRAM: &str = concat!("brdfit ", env!("CARGO_PKG_VERSION"));

/// What is done with each file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Job {
    /// What is fitted.
    pub(crate) model: ModelName,
    /// Where in its cell a sample lies.
    pub(crate) sample_position: SamplePosition,
    /// How it is fitted.
    pub(crate) options: FitOptions,
    /// Whether the whole file is read, for its hash and for cells that are no numbers.
    pub(crate) scan: bool,
    /// Whether the errors over the whole grid are computed; needs the scan.
    pub(crate) panel: bool,
    /// Whether cells that are no numbers count as cells without a measurement.
    pub(crate) accept_non_finite: bool,
}

impl Job {
    /// The options as documents record them.
    pub(crate) fn recorded(&self) -> RecordedOptions {
        RecordedOptions::new(&self.options, self.sample_position)
    }
}

/// Fits files that share a job, and with it the geometry of their grid.
#[derive(Debug)]
pub(crate) struct Fitter {
    job: Job,
    half_turn: OnceLock<PanelGeometry>,
    full_turn: OnceLock<PanelGeometry>,
}

/// A file that is ready to be fitted.
#[derive(Debug)]
pub(crate) struct Opened {
    file: MerlFile,
    scan: Option<Scan>,
    input: Input,
}

impl Opened {
    /// What the documents say about the file.
    pub(crate) fn input(&self) -> &Input {
        &self.input
    }
}

/// Looks at every cell; where `accept_non_finite`, cells that are no numbers count as cells without a measurement.
///
/// # Errors
/// Values that no measurement has, or no measurement at all.
pub(crate) fn scan(file: &MerlFile, accept_non_finite: bool) -> Result<Scan, MerlError> {
    let scan = in_pool(|| file.scan());
    match scan.check(file.path()) {
        Err(MerlError::NotANumber { .. } | MerlError::Infinite { .. })
            if accept_non_finite && scan.valid_cells() > 0 =>
        {
            Ok(scan)
        }
        checked => checked.map(|()| scan),
    }
}

impl Fitter {
    pub(crate) fn new(job: Job) -> Self {
        Self { job, half_turn: OnceLock::new(), full_turn: OnceLock::new() }
    }

    pub(crate) fn job(&self) -> &Job {
        &self.job
    }

    /// Opens a file and, if the job says so, looks at every cell.
    ///
    /// # Errors
    /// A file that cannot be read or is no MERL file.
    pub(crate) fn open(&self, input: &InputFile) -> Result<Opened, MerlError> {
        info!(file = %input.path.display(), "open");
        let file = MerlFile::open(&input.path)?;
        let scan = self.job.scan.then(|| scan(&file, self.job.accept_non_finite)).transpose()?;
        let input = Input {
            name: input.name.clone(),
            sha256: scan.as_ref().map(Scan::sha256_hex),
            dimensions: file.dimensions().shape(),
            sample_position: self.job.sample_position,
            valid_fraction: scan.as_ref().map(Scan::valid_fraction),
        };
        Ok(Opened { file, scan, input })
    }

    /// Fits an open file.
    ///
    /// # Errors
    /// Where the fit or the panel says that it cannot be done.
    pub(crate) fn fit(&self, opened: Opened) -> Result<FitDocument, Problem> {
        let Opened { file, scan, input } = opened;
        let label = file.path().display();
        let Job { model, sample_position, options, .. } = &self.job;
        let fit = in_pool(|| fit_slices(&file.slices(*sample_position), *model, options));
        let fit = fit.map_err(|error| match error {
            FitError::FewRows { .. } => Problem::invalid(format!("{label}: {error}")),
            _ => Problem::computation(format!("{label}: {error}")),
        })?;
        for channel in &fit.channels {
            debug!(file = %label, channel = channel.name, parameters = ?channel.parameters, flags = ?channel.flags, "fitted");
        }
        let errors = match &scan {
            Some(scan) if self.job.panel => Some(self.panel(&file, scan, &fit.parameters)),
            _ => None,
        };
        Ok(FitDocument {
            schema_version: SCHEMA_VERSION,
            program: PROGRAM.to_owned(),
            input,
            options: self.job.recorded(),
            model: *model,
            channels: fit.channels.into(),
            errors,
            slices: fit.slices,
        })
    }

    fn panel(&self, file: &MerlFile, scan: &Scan, parameters: &MaterialParameters) -> ErrorPanel {
        let geometry = self.geometry(file.dimensions());
        in_pool(|| error_panel(file, scan.valid(), geometry, parameters))
    }

    /// The geometry of the panel, made when it is first asked for. The caller must not be a thread of the pool: one that
    /// waits for its own work there would wait for ever.
    fn geometry(&self, dimensions: Dimensions) -> &PanelGeometry {
        let cell = if dimensions.is_folded() { &self.half_turn } else { &self.full_turn };
        cell.get_or_init(|| in_pool(|| PanelGeometry::new(dimensions, self.job.sample_position)))
    }
}
