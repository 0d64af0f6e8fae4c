//! The way of one material: open, look at every cell, cut the slices, fit, measure the errors, write it all down.

use std::sync::OnceLock;

use brdfit_fit::document::{ErrorPanel, FitDocument, Input, SCHEMA_VERSION};
use brdfit_fit::{FitOptions, PanelGeometry, error_panel, fit_slices};
use brdfit_measured::{Dimensions, MerlError, MerlFile, Scan};
use tracing::{debug, info};

use crate::jobs::batch::in_pool;
use crate::jobs::inputs::InputFile;
use crate::results::folder::{PROGRAM, ResultFile, Reusable};
use crate::terminal::exit_code::Problem;

/// What is done with each file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Job {
    /// How it is fitted.
    pub(crate) options: FitOptions,
    /// Whether the whole file is read, for its hash and for cells that are no numbers.
    pub(crate) scan: bool,
    /// Whether the errors over the whole grid are computed; needs the scan.
    pub(crate) panel: bool,
    /// Whether cells that are no numbers count as cells without a measurement.
    pub(crate) accept_non_finite: bool,
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
            sample_position: self.job.options.sample_position,
            valid_fraction: scan.as_ref().map(Scan::valid_fraction),
        };
        Ok(Opened { file, scan, input })
    }

    /// What a fit of an open file would say otherwise than a document, if anything.
    pub(crate) fn differs(&self, document: &FitDocument, opened: &Opened) -> Option<&'static str> {
        let input = opened.input();
        if input.sha256.is_none() || document.input != *input {
            return Some("the input is another one");
        }
        let same = document.options == self.job.options && document.errors.is_some() == self.job.panel;
        (!same).then_some("the options are others")
    }

    /// Fits an open file.
    ///
    /// # Errors
    /// Where the fit or the panel says that it cannot be done.
    pub(crate) fn fit(&self, opened: Opened) -> Result<FitDocument, Problem> {
        let Opened { file, scan, input } = opened;
        let label = file.path().display();
        let position = self.job.options.sample_position;
        let fit = in_pool(|| fit_slices(&file.slices(position), &self.job.options));
        let fit = fit.map_err(|error| Problem::of(&label, &error))?;
        for channel in &fit.channels {
            debug!(file = %label, channel = channel.name, parameters = ?channel.parameters, flags = ?channel.flags, "fitted");
        }
        let errors = match &scan {
            Some(scan) if self.job.panel => {
                let parameters = fit.channels.each_ref().map(|channel| channel.parameters);
                Some(self.panel(&file, scan, &parameters)?)
            }
            _ => None,
        };
        Ok(FitDocument {
            schema_version: SCHEMA_VERSION,
            program: PROGRAM.to_owned(),
            input,
            options: self.job.options.clone(),
            model: "sgd".to_owned(),
            channels: fit.channels,
            errors,
            slices: fit.slices,
        })
    }

    fn panel(
        &self,
        file: &MerlFile,
        scan: &Scan,
        parameters: &[brdfit_brdf::SgdParameters; 3],
    ) -> Result<ErrorPanel, Problem> {
        let geometry = self.geometry(file.dimensions());
        in_pool(|| error_panel(file, scan.valid(), geometry, parameters))
            .map_err(|error| Problem::computation(format!("{}: {error}", file.path().display())))
    }

    /// The geometry of the panel, made when it is first asked for. The caller must not be a thread of the pool: one that
    /// waits for its own work there would wait for ever.
    fn geometry(&self, dimensions: Dimensions) -> &PanelGeometry {
        let cell = if dimensions.is_folded() { &self.half_turn } else { &self.full_turn };
        cell.get_or_init(|| in_pool(|| PanelGeometry::new(dimensions, self.job.options.sample_position)))
    }
}

impl Reusable for FitDocument {
    const SCHEMA_VERSION: u32 = SCHEMA_VERSION;
    const FILE: ResultFile = ResultFile::Fit;

    fn made_by(&self) -> (u32, &str) {
        (self.schema_version, &self.program)
    }

    fn companions(&self) -> impl Iterator<Item = &str> {
        std::iter::empty()
    }
}
