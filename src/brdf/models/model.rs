//! The interface of models for documents, tables, error panels and renderers.

use crate::brdf::Brdf;
use crate::models::configuration::Configuration;
use crate::models::parameter::{Parameter, ParameterError};

/// A reflectance model: its parameters, and what is made from values of them. Values come in the order of
/// [`Model::parameters`]; methods panic where their number is another.
pub trait Model: Send + Sync + 'static {
    /// Its name in documents and options.
    fn name(&self) -> &'static str;

    /// Its name in titles and captions.
    fn title(&self) -> &'static str;

    /// Its parameters.
    fn parameters(&self) -> &[Parameter];

    /// One channel.
    ///
    /// # Errors
    /// The first value outside of the model's domain.
    fn channel(&self, values: &[f64]) -> Result<Box<dyn ChannelModel>, ParameterError>;

    /// A material of three channels (R, G, B), ready to be evaluated and sampled.
    ///
    /// # Errors
    /// The first value outside of the model's domain.
    fn material(&self, channels: [&[f64]; 3]) -> Result<Box<dyn Brdf>, ParameterError>;
}

/// One channel of a model.
pub trait ChannelModel: Send + Sync {
    /// `f` in 1/sr; zero where either direction is at or below the horizon.
    fn value(&self, at: &Configuration) -> f64;

    /// `f` in 1/sr at each cell and its derivatives with respect to the parameters, one row per cell.
    ///
    /// # Panics
    /// If the slices do not hold one value and one row per cell.
    fn values_and_gradients(&self, cells: &[Configuration], values: &mut [f64], gradients: &mut [f64]);

    /// The channel tabulated over the sample angles theta_h and theta_d of a grid, radians.
    fn on_grid(&self, theta_h: &[f64], theta_d: &[f64]) -> Box<dyn GridModel>;

    /// Directional albedo at theta_i in radians: the integral of `f cos theta_o` over the outgoing hemisphere.
    fn directional_albedo(&self, theta_i: f64) -> f64;
}

/// A row of cells: the places of theta_h and theta_d among the angles of [`ChannelModel::on_grid`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellRow {
    /// Place of theta_h.
    pub theta_h: usize,
    /// Place of theta_d.
    pub theta_d: usize,
}

/// The directions of four cells of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourCells {
    /// `[cos theta_i; 4]`, `[cos theta_o; 4]`, above zero.
    pub cosines: [[f64; 4]; 2],
    /// Positions of i and o on masking curves, per cell: [`crate::G1Curve::position`].
    pub positions: [[f64; 2]; 4],
}

/// One channel on the cells of a grid.
pub trait GridModel: Send + Sync {
    /// `f` in 1/sr at one cell above the horizon from its cosines and positions.
    fn value(&self, row: CellRow, cosines: (f64, f64), positions: [f64; 2]) -> f64;

    /// The same for many cells of a row, four at a time; equal up to rounding.
    ///
    /// # Panics
    /// If the slices differ in length.
    fn values(&self, row: CellRow, cells: &[FourCells], values: &mut [[f64; 4]]);
}
