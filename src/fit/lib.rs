//! The two-step fit of the SGD model to MERL measurements, its solver, its error metrics and its documents.
#![forbid(unsafe_code)]

pub mod compare;
pub mod document;
pub mod lm;
mod metrics;
mod options;
mod report;
mod steps;

pub use metrics::data_errors::{PanelGeometry, error_panel};
pub use metrics::grid_model::synthesise;
pub use options::{
    ALPHA_RANGE, Anchor, Constraint, DistributionSharing, FitOptions, Loss, OptionsError, P_RANGE, Step2Solver,
};
pub use steps::closed_form_fit::fit_g1;
pub use steps::two_step::{FitError, MaterialFit, fit_slices, step_costs};
