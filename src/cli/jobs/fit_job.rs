//! The way of one material: open, look at every cell, cut the slices, fit, measure the errors, write it all down.

use std::sync::OnceLock;

use brdfit_brdf::{MaterialParameters, ModelName};
use brdfit_fit::document::{ErrorPanel, FitDocument, Input, SCHEMA_VERSION};
use brdfit_fit::{FitError, FitOptions, PanelGeometry, RecordedOptions, error_panel, fit_slices};
use brdfit_measured::{Dimensions, Measurement, MeasurementError, SamplePosition, Survey};
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
    /// Where in its cell a sample lies; `None`: as the format of each file has it.
    pub(crate) sample_position: Option<SamplePosition>,
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
    /// What the documents say about the file.
    pub(crate) fn input(&self) -> &Input {
        &self.input
    }

    /// How the file is fitted: the options of the job, and where the samples of this file lie.
    pub(crate) fn options(&self) -> &RecordedOptions {
        &self.options
    }
}

impl Fitter {
    pub(crate) fn new(job: Job) -> Self {
        Self { job, geometries: Default::default() }
    }

    pub(crate) fn job(&self) -> &Job {
        &self.job
    }

    /// Opens a file and, if the job says so, looks at every cell.
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

    /// Fits an open file.
    ///
    /// # Errors
    /// Where the fit or the panel says that it cannot be done.
    pub(crate) fn fit(&self, opened: Opened) -> Result<FitDocument, Problem> {
        let Opened { measurement, survey, input, options } = opened;
        let label = measurement.source().path.display();
        let fit = in_pool(|| fit_slices(&measurement.slices(), self.job.model, &self.job.options));
        let fit = fit.map_err(|error| match error {
            FitError::FewRows { .. } => Problem::invalid(format!("{label}: {error}")),
            _ => Problem::computation(format!("{label}: {error}")),
        })?;
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
            channels: fit.channels.into(),
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

    /// The geometry of the panel, made when it is first asked for. The caller must not be a thread of the pool: one that
    /// waits for its own work there would wait for ever.
    fn geometry(&self, dimensions: Dimensions, position: SamplePosition) -> &PanelGeometry {
        let index = 2 * usize::from(dimensions.is_folded()) + usize::from(position == SamplePosition::Edge);
        self.geometries[index].get_or_init(|| in_pool(|| PanelGeometry::new(dimensions, position)))
    }
}
