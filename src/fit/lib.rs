//! The two-step fit of the SGD model to MERL measurements, its solver, its error metrics and its documents.
#![forbid(unsafe_code)]

pub mod compare;
mod cone;
pub mod document;
mod g1_fit;
mod g1_table;
mod grid_model;
pub mod lm;
mod nnls;
mod options;
mod panel;
mod report;
mod rows;
mod step1;
mod step2;
mod two_step;

pub use g1_fit::fit_g1;
pub use grid_model::synthesise;
pub use options::{
    ALPHA_RANGE, Anchor, Constraint, DistributionSharing, FitOptions, Loss, OptionsError, P_RANGE, Step2Solver,
};
pub use panel::{PanelGeometry, error_panel};
pub use two_step::{FitError, MaterialFit, fit_slices, step_costs};
