//! The fit of one file: open, check all cells, extract the slices, fit, compute the errors, write the document.

use std::sync::OnceLock;

use brdfit_brdf::{MaterialParameters, ModelName};
use brdfit_fit::document::{ErrorPanel, FitDocument, Input, SCHEMA_VERSION};
use brdfit_fit::{FitOptions, PanelGeometry, RecordedOptions, error_panel, fit_slices};
use brdfit_measured::{Dimensions, Measurement, MeasurementError, SamplePosition, Survey};
use tracing::{debug, info};

use crate::jobs::batch::in_pool;
use crate::jobs::inputs::InputFile;
use crate::results::folder::{PROGRAM, ResultFile, Reusable};
use crate::terminal::exit_code::Problem;

/// The job of each file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Job {
    /// The model.
    pub(crate) model: ModelName,
    /// Position of a sample within its cell; `None`: that of the format of each file.
    pub(crate) sample_position: Option<SamplePosition>,
    /// Options of the fit.
    pub(crate) options: FitOptions,
    /// Whether the whole file is read, for its hash and for cells that are no numbers.
    pub(crate) scan: bool,
    /// Whether the errors over the whole grid are computed; needs the scan.
    pub(crate) panel: bool,
    /// Whether cells that are no numbers count as cells without a measurement.
    pub(crate) accept_non_finite: bool,
}

impl Job {
    /// The options as the summary of a batch records them.
    pub(crate) fn recorded(&self) -> RecordedOptions {
        RecordedOptions::new(&self.options, self.sample_position.unwrap_or_default())
    }
}

/// Fits files that share a job, and with it the geometry of their grid.
#[derive(Debug)]
pub(crate) struct Fitter {
    job: Job,
    /// For either number of phi_d bins and either position of the samples.
    geometries: [OnceLock<PanelGeometry>; 4],
}

/// A file that is ready to be fitted.
#[derive(Debug)]
pub(crate) struct Opened {
    measurement: Box<dyn Measurement>,
    survey: Option<Survey>,
    input: Input,
    options: RecordedOptions,
}

impl Opened {
    /// Members of the document about the file.
    pub(crate) fn input(&self) -> &Input {
        &self.input
    }

    /// The recorded options: those of the job, and the position of the samples of this file.
    pub(crate) fn options(&self) -> &RecordedOptions {
        &self.options
    }
}

impl Fitter {
    pub(crate) fn new(job: Job) -> Self {
        Self { job, geometries: Default::default() }
    }

    /// Opens a file and, if the job requires it, checks all cells.
    ///
    /// # Errors
    /// A file that cannot be read or is no measured file.
    pub(crate) fn open(&self, input: &InputFile) -> Result<Opened, MeasurementError> {
        info!(file = %input.path.display(), "open");
        let measurement = brdfit_measured::open(&input.path, self.job.sample_position)?;
        let survey = || in_pool(|| measurement.survey(self.job.accept_non_finite));
        let survey = self.job.scan.then(survey).transpose()?;
        let sample_position = measurement.source().sample_position;
        let input = Input {
            name: input.name.clone(),
            sha256: survey.as_ref().map(|survey| survey.sha256.clone()),
            dimensions: measurement.dimensions().shape(),
            sample_position,
            valid_fraction: survey.as_ref().map(Survey::valid_fraction),
        };
        let options = RecordedOptions::new(&self.job.options, sample_position);
        Ok(Opened { measurement, survey, input, options })
    }

    /// The difference between a document and a fit of an open file, if any.
    pub(crate) fn differs(&self, document: &FitDocument, opened: &Opened) -> Option<&'static str> {
        let input = opened.input();
        if input.sha256.is_none() || document.input != *input {
            return Some("input differs");
        }
        let same = document.model == self.job.model
            && document.options == *opened.options()
            && document.errors.is_some() == self.job.panel;
        (!same).then_some("options differ")
    }

    /// Fits an open file.
    ///
    /// # Errors
    /// Errors of the fit and of the panel.
    pub(crate) fn fit(&self, opened: Opened) -> Result<FitDocument, Problem> {
        let Opened { measurement, survey, input, options } = opened;
        let label = measurement.source().path.display();
        let fit = in_pool(|| fit_slices(&measurement.slices(), self.job.model, &self.job.options));
        let fit = fit.map_err(|error| Problem::of(&label, &error))?;
        for channel in &fit.channels {
            debug!(file = %label, channel = channel.name, parameters = ?channel.parameters, flags = ?channel.flags, "fitted");
        }
        let errors = match &survey {
            Some(survey) if self.job.panel => self.panel(measurement.as_ref(), survey, &fit.parameters),
            _ => None,
        };
        Ok(FitDocument {
            schema_version: SCHEMA_VERSION,
            program: PROGRAM.to_owned(),
            input,
            options,
            model: self.job.model,
            channels: fit.channels,
            errors,
            slices: fit.slices,
        })
    }

    fn panel(
        &self,
        measurement: &dyn Measurement,
        survey: &Survey,
        parameters: &MaterialParameters,
    ) -> Option<ErrorPanel> {
        let cells = in_pool(|| measurement.cells())?;
        let geometry = self.geometry(cells.dimensions(), measurement.source().sample_position);
        Some(in_pool(|| error_panel(&cells, &survey.valid, geometry, parameters)))
    }

    /// The geometry of the panel, computed on first use. The caller must not be a thread of the pool: one that
    /// waits for its own work there would wait for ever.
    fn geometry(&self, dimensions: Dimensions, position: SamplePosition) -> &PanelGeometry {
        let index = 2 * usize::from(dimensions.is_folded()) + usize::from(position == SamplePosition::Edge);
        self.geometries[index].get_or_init(|| in_pool(|| PanelGeometry::new(dimensions, position)))
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
