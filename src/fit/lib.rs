//! The two-step fit of microfacet models to measured BRDFs, its solver, its error metrics and its documents.
//!
//! Fit of a MERL file, with its errors:
//!
//! ```no_run
//! use brdfit_brdf::ModelName;
//! use brdfit_fit::{FitOptions, PanelGeometry, error_panel, fit_slices};
//! use brdfit_measured::{MerlFile, SamplePosition};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (model, position) = (ModelName::default(), SamplePosition::Edge);
//! let file = MerlFile::open("gold-metallic-paint.binary".as_ref())?;
//! let fit = fit_slices(&file.slices(position), model, &FitOptions::new(model))?;
//! let geometry = PanelGeometry::new(file.dimensions(), position);
//! let errors = error_panel(&file.cells(), file.scan().valid(), &geometry, &fit.parameters);
//! println!("{:?}: E {:.3}", fit.parameters.channel(0), errors.e[0]);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod compare;
pub mod document;
pub mod lm;
mod metrics;
mod options;
mod steps;

pub use metrics::data_errors::{PanelGeometry, error_panel};
pub use metrics::grid_model::synthesise;
pub use options::{
    Anchor, Constraint, DistributionSharing, FitOptions, Loss, OptionsError, RecordedOptions, Step2Solver,
};
pub use steps::closed_form_fit::fit_g1;
pub use steps::two_step::{FitError, MaterialFit, fit_slices, step_costs};
