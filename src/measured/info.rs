//! The report on a measured file.

use schemars::JsonSchema;
use serde::Serialize;

use crate::grid::dimensions::CHANNELS;
use crate::grid::sample_position::SamplePosition;
use crate::merl::health::{AlbedoHealth, Health};

/// The state of a measured file: cell by cell where the format has a grid of half and difference angles, a summary for any
/// other.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Info {
    /// A file of cells.
    Cells(Box<Health>),
    /// Any other file.
    Summary(Box<Summary>),
}

/// The state of a measured file that has no grid of half and difference angles.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// File name without its folder.
    pub name: String,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the file in hexadecimal.
    pub sha256: String,
    /// The format's name in documents, for instance `rgl`.
    pub format: String,
    /// The description of the material in the file.
    pub description: String,
    /// Position of a sample within its cell, for slices, cells and albedo.
    pub sample_position: SamplePosition,
    /// The tables of the file.
    pub tables: Vec<TableShape>,
    /// Angles of the light with the normal that were measured, in degrees; between them everything is interpolated.
    pub measured_theta_i_deg: Vec<f64>,
    /// The colour channels R, G, B.
    pub channels: [ChannelRange; CHANNELS],
    /// Directional albedo of the mean of both orders of the directions.
    pub albedo: AlbedoHealth,
    /// Median of |f(i, o) - f(o, i)| over the mean of the two, over pairs of directions up to 75 degrees from the normal: 0 for
    /// a material that is reciprocal, as it should be.
    pub non_reciprocity: f64,
}

/// The shape of one table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct TableShape {
    /// The table's name in the file.
    pub name: String,
    /// Number of entries along each axis, the innermost last.
    pub shape: Vec<usize>,
}

/// The range of one colour channel.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ChannelRange {
    /// R, G or B.
    pub name: String,
    /// Smallest value in 1/sr, both angles up to 80 degrees.
    pub min: f64,
    /// Largest value in 1/sr, both angles up to 80 degrees.
    pub max: f64,
}
