//! The documents of a fit: one per material, one per batch. Their JSON Schema is generated from these types.

use crate::lm::termination::Termination;
use crate::options::RecordedOptions;
pub use brdfit_brdf::SCHEMA_VERSION;
use brdfit_brdf::{ModelName, NamedValues};
use brdfit_measured::SamplePosition;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The fit of one material. Angles in radians unless a name says degrees, BRDF values in 1/sr, no NaN, no time, no host name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "brdfit fit result")]
pub struct FitDocument {
    /// Version of this layout.
    pub schema_version: u32,
    /// Program that wrote it, with its version.
    pub program: String,
    /// The measurement.
    pub input: Input,
    /// All options that influenced the result.
    pub options: RecordedOptions,
    /// The model.
    pub model: ModelName,
    /// The fit of R, G and B.
    pub channels: [ChannelFit; 3],
    /// Errors of the model over all cells; absent if they were not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub errors: Option<ErrorPanel>,
    /// The two slices that were fitted.
    pub slices: SliceCurves,
}

/// The measured file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Input {
    /// File name without its folder and extension.
    pub name: String,
    /// SHA-256 of the whole file, lower-case hexadecimal; absent if it was not requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// Bins of theta_h, theta_d, phi_d.
    pub dimensions: [usize; 3],
    /// Position of a sample within its cell.
    pub sample_position: SamplePosition,
    /// Cells with a measurement in all three channels, as a share of all cells; absent if the file was not scanned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_fraction: Option<f64>,
}

/// One channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ChannelFit {
    /// R, G or B.
    pub name: String,
    /// The free parameters of the model.
    pub parameters: NamedValues<f64>,
    /// Quantities derived from them.
    pub derived: Derived,
    /// Standard errors of what the two steps estimated, `sigma^2 (J^T J)^-1` over the parameters that are not at a bound; null for
    /// one at a bound or undetermined. rho_d, fr (through the peak height) and the shape of the distribution are those of step
    /// 1, rho_s, f0 and f1 those of step 2.
    pub standard_errors: NamedValues<Option<f64>>,
    /// Step 1 (theta_h slice) and step 2 (theta_d slice).
    pub steps: [StepReport; 2],
    /// Caveats about the parameters.
    pub flags: Vec<Flag>,
}

/// Quantities derived from the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Derived {
    /// Normalisation of the distribution, for models that publish one ("sgd").
    #[serde(rename = "K", default, skip_serializing_if = "Option::is_none")]
    pub k: Option<f64>,
    /// `rho_s F(0)` as step 1 estimated it.
    pub fr: f64,
    /// Peak height A that step 2 took, 1/sr.
    pub anchor: f64,
    /// The closed form of G1.
    pub g1: G1Fit,
    /// Directional albedo of the model at 0, 30, 60 and 80 degrees.
    pub albedo: [f64; 4],
    /// Smallest and largest F over theta_d.
    pub fresnel_range: [f64; 2],
}

/// The fitted closed form of Smith's G1 in both parametrisations, with its error over 1, 1.1, .., 89.9 degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct G1Fit {
    /// Depth parameter, in both forms.
    pub lambda: f64,
    /// Angle where masking sets in, radians, in both forms.
    pub theta0: f64,
    /// Exponent, in both forms.
    pub k: f64,
    /// log10 of c = ln(1 + 1/lambda) / (pi/2 - theta0)^k; c itself overflows single precision.
    pub log10_c: f64,
    /// Largest absolute difference from the integral.
    pub max_error: f64,
    /// Root mean square difference from the integral.
    pub rms_error: f64,
}

/// Convergence of one step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StepReport {
    /// The slice: theta_h (step 1) or theta_d (step 2).
    pub name: String,
    /// Method: levenberg-marquardt or convex.
    pub solver: String,
    /// Residuals.
    pub rows: usize,
    /// Half the sum of squared residuals at the solution; with the flag no_specular, of the solution before it was dropped.
    pub cost: f64,
    /// Root of the sum of squared residuals at the solution.
    pub residual_norm: f64,
    /// Iterations of the winning start.
    pub iterations: u64,
    /// Reason for termination.
    pub termination: Termination,
    /// Number of the winning start, counted from 0.
    pub start: usize,
    /// Bounds or constraints that are active at the solution.
    pub active_bounds: Vec<String>,
    /// Condition number of the column-scaled Jacobian: in step 1 over the parameters that are not at a bound, in step 2 over
    /// rho_s (f0, f1, 1) without the constraints; null where there is none.
    pub condition_number: Option<f64>,
}

/// Caveats about the parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Flag {
    /// The plane is zero around the specular peak: a colour out of gamut, a property of the data.
    ZeroPeak,
    /// The slice does not rise above its diffuse level: alpha, p and everything specular are undetermined.
    NoPeak,
    /// Step 2 found no specular part: rho_s, f0 and f1 are written as zero.
    NoSpecular,
    /// A parameter of step 1 ended at its bound.
    Step1AtBound,
    /// A constraint on the Fresnel term is active.
    FresnelConstrained,
    /// The Fresnel term leaves [0, 1] somewhere.
    FresnelOutsideUnit,
    /// rho_s is weakly determined: rho_s F is reliable; rho_s, f0 and f1 individually are not.
    RhoSWeak,
    /// The parameters of step 1 are strongly correlated: the curve is reliable, the parameters are not.
    Step1IllConditioned,
    /// A step reached its iteration limit.
    NotConverged,
    /// Fewer than half of the rows of a slice inside its cut-off have a measurement.
    FewRows,
    /// The measured peak cell lies below half of the fitted peak; step 2's peak height was limited (docs/theory.md, section 4).
    PeakMissed,
}

/// The error panel (docs/theory.md, section 6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ErrorPanel {
    /// Both angles up to this, degrees.
    pub limit_degrees: f64,
    /// Number of cells in the sample set.
    pub samples: usize,
    /// Root mean square difference weighted by the cosines, over `albedo`.
    #[serde(rename = "E")]
    pub e: [f64; 3],
    /// Root mean square difference of `ln(1 + f cos theta_i)`; a negative model value counts as zero, as in C.
    #[serde(rename = "L")]
    pub l: [f64; 3],
    /// Root mean square difference of the cube roots of `f cos theta_i`.
    #[serde(rename = "C")]
    pub c: [f64; 3],
    /// Root mean square of E, L and C over the channels.
    pub over_channels: PanelTriple<f64>,
    /// The largest measured directional albedo over 0, 5, .., 80 degrees, by which E is divided.
    pub albedo: [f64; 3],
    /// Signed relative difference of the directional albedo, model against measurement, at 10, 30, 50 and 70 degrees, per channel;
    /// null where the measurement is zero.
    pub albedo_difference: [[Option<f64>; 4]; 3],
    /// The cell with the largest relative residual, per channel.
    pub largest_relative_residual: [Option<LargestResidual>; 3],
    /// E, L and C over all valid cells above the horizon.
    pub all_cells: AllCells,
}

/// The three errors together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PanelTriple<T> {
    /// See [`ErrorPanel::e`].
    #[serde(rename = "E")]
    pub e: T,
    /// See [`ErrorPanel::l`].
    #[serde(rename = "L")]
    pub l: T,
    /// See [`ErrorPanel::c`].
    #[serde(rename = "C")]
    pub c: T,
}

/// The panel over all valid cells above the horizon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AllCells {
    /// Number of cells.
    pub samples: usize,
    /// The errors per channel.
    #[serde(flatten)]
    pub errors: PanelTriple<[f64; 3]>,
}

/// A cell and the relative residual of the model there: `|g - f| / max(f, 1e-3 / sr)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LargestResidual {
    /// The relative residual.
    pub value: f64,
    /// Bins of theta_h, theta_d, phi_d.
    pub cell: [usize; 3],
    /// Measured value, 1/sr.
    pub measured: f64,
    /// Value of the model, 1/sr.
    pub model: f64,
}

/// Both slices, measured and fitted; null where there is no measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SliceCurves {
    /// Sample angles theta_h of the first slice (theta_d = 0), radians.
    pub theta_h: Vec<f64>,
    /// Sample angles theta_d of the second slice (theta_h = 0), radians.
    pub theta_d: Vec<f64>,
    /// The measurement, 1/sr.
    pub measured: CurvePair<Option<f64>>,
    /// The fitted curve, 1/sr.
    pub fitted: CurvePair<f64>,
}

/// One curve per channel over either slice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurvePair<T> {
    /// Over theta_h, per channel.
    pub theta_h: [Vec<T>; 3],
    /// Over theta_d, per channel.
    pub theta_d: [Vec<T>; 3],
}

/// A batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "brdfit batch summary")]
pub struct SummaryDocument {
    /// Version of this layout.
    pub schema_version: u32,
    /// Program that wrote it, with its version.
    pub program: String,
    /// All options that influenced the results.
    pub options: RecordedOptions,
    /// The model, where it is not the default one ("sgd").
    #[serde(default, skip_serializing_if = "is_default")]
    pub model: ModelName,
    /// The materials in the order of their names.
    pub materials: Vec<SummaryRow>,
    /// Inputs that could not be fitted.
    pub failures: Vec<Failure>,
}

fn is_default(model: &ModelName) -> bool {
    *model == ModelName::default()
}

/// One material of a batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SummaryRow {
    /// The material's name.
    pub name: String,
    /// SHA-256 of its file.
    pub sha256: Option<String>,
    /// Parameters of R, G and B.
    pub parameters: [NamedValues<f64>; 3],
    /// Costs of step 1 and step 2 per channel.
    pub costs: [[f64; 2]; 3],
    /// E, L and C per channel, if the panel was requested.
    pub errors: Option<PanelTriple<[f64; 3]>>,
    /// Flags of all channels.
    pub flags: [Vec<Flag>; 3],
}

/// An input that could not be fitted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Failure {
    /// The file, as it was named or found.
    pub input: String,
    /// The error message.
    pub message: String,
    /// Its exit code.
    pub exit_code: u8,
}

impl From<&FitDocument> for SummaryRow {
    fn from(document: &FitDocument) -> Self {
        let channel = |c: usize| &document.channels[c];
        Self {
            name: document.input.name.clone(),
            sha256: document.input.sha256.clone(),
            parameters: [0, 1, 2].map(|c| channel(c).parameters.clone()),
            costs: [0, 1, 2].map(|c| [0, 1].map(|step: usize| channel(c).steps[step].cost)),
            errors: document.errors.as_ref().map(|panel| PanelTriple { e: panel.e, l: panel.l, c: panel.c }),
            flags: [0, 1, 2].map(|c| channel(c).flags.clone()),
        }
    }
}
