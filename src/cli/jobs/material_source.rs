//! Material sources: measured files, fit results, embedded materials.

use std::path::Path;

use brdfit_bandwidth::sidecar::Source;
use brdfit_brdf::{Brdf, MaterialParameters};
use brdfit_measured::{Measurement, SamplePosition};
use tracing::info;

use crate::args::embedded_materials::{self, Embedded};
use crate::jobs::batch::in_pool;
use crate::jobs::inputs::InputFile;
use crate::results::documents::Document;
use crate::terminal::exit_code::Problem;

/// Source of a material, not yet read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MaterialInput {
    /// A measured file.
    Measured(InputFile),
    /// A document with parameters.
    Fit(InputFile),
    /// A material that the program carries with it.
    Embedded(&'static Embedded),
}

/// Options of reading measured files.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reading {
    /// Position of a sample within its cell; `None`: that of the format.
    pub(crate) sample_position: Option<SamplePosition>,
    /// Whether cells that are no numbers count as cells without a measurement.
    pub(crate) accept_non_finite: bool,
}

/// [`Source::kind`] of the results of fits; that of a measurement is its format's.
const FIT: &str = "fit";

/// Origin of a material, as recorded in documents.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Origin {
    pub(crate) source: Source,
    /// Position of a sample of a measurement within its cell.
    pub(crate) sample_position: Option<SamplePosition>,
}

impl Origin {
    /// The origin of a material with parameters; an embedded one has no file and no hash.
    pub(crate) fn fit(name: &str, sha256: Option<String>) -> Self {
        Self { source: Source { name: name.to_owned(), sha256, kind: FIT.to_owned() }, sample_position: None }
    }
}

/// A material that was read and is not yet ready to be evaluated.
#[derive(Debug)]
pub(crate) struct OpenedMaterial {
    pub(crate) origin: Origin,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Measured(Box<dyn Measurement>),
    Fit(MaterialParameters),
}

impl MaterialInput {
    /// Classifies an input: a .json file is a document, any other file a measurement, anything else a name.
    ///
    /// # Errors
    /// An unknown name.
    pub(crate) fn new(input: InputFile) -> Result<Self, Problem> {
        Ok(match embedded_materials::find(&input.path)? {
            Some(material) => Self::Embedded(material),
            None if input.path.extension().is_some_and(|extension| extension == "json") => Self::Fit(input),
            None => Self::Measured(input),
        })
    }

    /// The stem of its results.
    pub(crate) fn name(&self) -> &str {
        match self {
            Self::Measured(input) | Self::Fit(input) => &input.name,
            Self::Embedded(material) => material.name,
        }
    }

    /// Its file.
    pub(crate) fn path(&self) -> Option<&Path> {
        match self {
            Self::Measured(input) | Self::Fit(input) => Some(&input.path),
            Self::Embedded(_) => None,
        }
    }

    /// Its name in messages.
    pub(crate) fn label(&self) -> String {
        self.path().map_or_else(|| self.name().to_owned(), |path| path.display().to_string())
    }

    /// Reads all of it.
    ///
    /// # Errors
    /// A file that cannot be read or is not what it should be.
    pub(crate) fn open(&self, reading: Reading) -> anyhow::Result<OpenedMaterial> {
        info!(material = %self.label(), "open");
        Ok(match self {
            Self::Measured(InputFile { path, name }) => {
                let measurement = brdfit_measured::open(path, reading.sample_position)?;
                let survey = in_pool(|| measurement.survey(reading.accept_non_finite))?;
                let brdfit_measured::Source { format, sample_position, .. } = *measurement.source();
                let source = Source { name: name.clone(), sha256: Some(survey.sha256), kind: format.to_owned() };
                OpenedMaterial {
                    origin: Origin { source, sample_position: Some(sample_position) },
                    content: Content::Measured(measurement),
                }
            }
            Self::Fit(InputFile { path, name }) => {
                let document = Document::open(path, "a fit result")?;
                let parameters = document.material()?;
                OpenedMaterial { origin: Origin::fit(name, Some(document.sha256())), content: Content::Fit(parameters) }
            }
            Self::Embedded(material) => OpenedMaterial {
                origin: Origin::fit(material.name, None),
                content: Content::Fit(material.parameters()),
            },
        })
    }
}

impl OpenedMaterial {
    /// Makes the material ready to be evaluated.
    ///
    /// # Errors
    /// A file without a measurement above the horizon.
    pub(crate) fn brdf(self) -> anyhow::Result<Box<dyn Brdf>> {
        in_pool(|| {
            Ok(match self.content {
                Content::Measured(measurement) => measurement.brdf()?,
                Content::Fit(parameters) => parameters.brdf(),
            })
        })
    }
}
