//! The subset of a fit document that a comparison reads. Other programs write this subset too (docs/formats.md), so
//! every field beyond it is ignored and every optional one may be missing.

use crate::document::CurvePair;
use brdfit_measured::CHANNEL_NAMES;
use serde::Deserialize;

/// The comparable part of a fit result, whichever program wrote it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ComparableFit {
    /// The measurement that was fitted.
    pub input: ComparableInput,
    /// Options of the fit.
    #[serde(default)]
    pub options: ComparableOptions,
    /// The model's name.
    pub model: String,
    /// The fits of R, G and B.
    pub channels: Vec<ComparableChannel>,
    /// E, L and C per channel, if they were computed.
    #[serde(default)]
    pub errors: Option<ComparableErrors>,
    /// The slices.
    pub slices: ComparableSlices,
}

/// See [`crate::document::Input`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ComparableInput {
    /// The material.
    pub name: String,
    /// SHA-256 of the file, hexadecimal.
    #[serde(default)]
    pub sha256: Option<String>,
    /// Position of a sample within its cell: edge or centre.
    pub sample_position: String,
}

/// The options that decide what is minimised; an absent one is not held against the document.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct ComparableOptions {
    /// The residual of both steps.
    #[serde(default)]
    pub loss: Option<String>,
    /// The constraint on the Fresnel term. `paper` stands for `free` with the anchor `distribution`.
    #[serde(default)]
    pub constraint: Option<String>,
    /// The peak height of step 2.
    #[serde(default)]
    pub anchor: Option<String>,
    /// Whether the channels share alpha and p.
    #[serde(default)]
    pub distribution: Option<String>,
    /// Last angle of the theta_h slice that takes part, degrees.
    #[serde(default, alias = "cutoff_theta_h")]
    pub cutoff_theta_h_degrees: Option<f64>,
    /// Last angle of the theta_d slice that takes part, degrees.
    #[serde(default, alias = "cutoff_theta_d")]
    pub cutoff_theta_d_degrees: Option<f64>,
}

/// See [`crate::document::ChannelFit`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ComparableChannel {
    /// R, G or B.
    pub name: String,
    /// Step 1 (theta_h) and step 2 (theta_d).
    pub steps: Vec<ComparableStep>,
    /// Names of the flags; only `no_specular` matters here.
    #[serde(default)]
    pub flags: Vec<String>,
}

impl ComparableChannel {
    /// Whether a negligible specular part was dropped after step 2.
    pub(super) fn is_without_specular(&self) -> bool {
        self.flags.iter().any(|flag| flag == "no_specular")
    }
}

/// See [`crate::document::StepReport`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ComparableStep {
    /// theta_h or theta_d.
    pub name: String,
    /// Half the sum of squared residuals.
    pub cost: f64,
}

/// See [`crate::document::ErrorPanel`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[allow(non_snake_case)]
pub struct ComparableErrors {
    /// Cosine-weighted error per channel.
    pub E: [f64; 3],
    /// Logarithmic error per channel.
    pub L: [f64; 3],
    /// Cube root error per channel.
    pub C: [f64; 3],
}

/// See [`crate::document::SliceCurves`].
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ComparableSlices {
    /// Sample angles of the first slice, radians.
    pub theta_h: Vec<f64>,
    /// Sample angles of the second slice, radians.
    pub theta_d: Vec<f64>,
    /// The measurement, 1/sr.
    pub measured: CurvePair<Option<f64>>,
    /// The fit, 1/sr; a row without a measurement may have none.
    pub fitted: CurvePair<Option<f64>>,
}

/// Errors of comparing documents.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The text is not a fit result.
    #[error("not a fit result: {0}")]
    NotAFit(String),
    /// The fits started from different files or asked different questions.
    #[error("{what} differs, so the fits cannot be compared: {ours}, reference {reference}")]
    Incomparable {
        /// The member that differs.
        what: &'static str,
        /// Its value in our document.
        ours: String,
        /// Its value in the reference.
        reference: String,
    },
}

impl ComparableFit {
    /// Reads the comparable part of a fit result.
    ///
    /// # Errors
    /// [`CompareError::NotAFit`] if the text is not JSON, lacks a part, or has parts that do not fit together.
    pub fn from_json(text: &str) -> Result<Self, CompareError> {
        let fit: Self = serde_json::from_str(text).map_err(|error| CompareError::NotAFit(error.to_string()))?;
        fit.check()?;
        Ok(fit)
    }

    /// Whether the parts are consistent: the names of channels and steps, the lengths of the curves.
    ///
    /// # Errors
    /// [`CompareError::NotAFit`] for the first invalid member.
    pub fn check(&self) -> Result<(), CompareError> {
        let refuse = |why: String| Err(CompareError::NotAFit(why));
        if self.channels.iter().map(|channel| channel.name.as_str()).ne(CHANNEL_NAMES) {
            return refuse("its channels are not R, G and B".to_owned());
        }
        for channel in &self.channels {
            if channel.steps.iter().map(|step| step.name.as_str()).ne(["theta_h", "theta_d"]) {
                return refuse(format!("the steps of channel {} are not theta_h and theta_d", channel.name));
            }
        }
        let slices = &self.slices;
        for (name, angles, measured, fitted) in [
            ("theta_h", &slices.theta_h, &slices.measured.theta_h, &slices.fitted.theta_h),
            ("theta_d", &slices.theta_d, &slices.measured.theta_d, &slices.fitted.theta_d),
        ] {
            if angles.is_empty() || measured.iter().chain(fitted).any(|curve| curve.len() != angles.len()) {
                return refuse(format!("the curves over {name} do not have one value per angle"));
            }
        }
        Ok(())
    }

    /// Refuses a pair whose costs have no common meaning: another file, sample position, model or objective.
    ///
    /// # Errors
    /// [`CompareError::Incomparable`] for the first property that differs. A property that one of the documents leaves out
    /// is not compared.
    pub fn check_comparable(&self, reference: &Self) -> Result<(), CompareError> {
        let (a, b) = (self, reference);
        let (x, y) = (a.options.objective(), b.options.objective());
        differing("the input's sha256", a.input.sha256.as_deref(), b.input.sha256.as_deref())?;
        differing("the sample position", Some(&a.input.sample_position), Some(&b.input.sample_position))?;
        differing("the model", Some(&a.model), Some(&b.model))?;
        differing("the option loss", a.options.loss.as_ref(), b.options.loss.as_ref())?;
        differing("the option constraint", x.0, y.0)?;
        differing("the option anchor", x.1, y.1)?;
        differing("the option distribution", Some(a.options.sharing()), Some(b.options.sharing()))?;
        let cutoffs = |o: &ComparableOptions| [o.cutoff_theta_h_degrees, o.cutoff_theta_d_degrees];
        let [x, y] = [cutoffs(&a.options), cutoffs(&b.options)];
        differing("the cut-off of theta_h", x[0], y[0])?;
        differing("the cut-off of theta_d", x[1], y[1])
    }
}

impl ComparableOptions {
    /// The constraint and the anchor in the program's own names.
    fn objective(&self) -> (Option<&str>, Option<&str>) {
        match self.constraint.as_deref() {
            Some("paper") => (Some("free"), self.anchor.as_deref().or(Some("distribution"))),
            constraint => (constraint, self.anchor.as_deref()),
        }
    }

    /// Separate distributions are so much the rule that a document may leave the option out.
    fn sharing(&self) -> &str {
        self.distribution.as_deref().unwrap_or("per-channel")
    }
}

/// An error if both documents state the property and do not agree.
fn differing<T: PartialEq + std::fmt::Display>(
    what: &'static str,
    ours: Option<T>,
    reference: Option<T>,
) -> Result<(), CompareError> {
    match (ours, reference) {
        (Some(ours), Some(reference)) if ours != reference => {
            Err(CompareError::Incomparable { what, ours: ours.to_string(), reference: reference.to_string() })
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::test_document::{DOCUMENT, fit};

    fn refusal(change: impl FnOnce(&mut ComparableFit)) -> String {
        let mut ours = fit();
        change(&mut ours);
        ours.check_comparable(&fit()).unwrap_err().to_string()
    }

    #[test]
    fn different_questions_are_refused() {
        for (message, expected) in [
            (refusal(|fit| fit.input.sha256 = Some("ff00".into())), "the input's sha256 differs"),
            (refusal(|fit| fit.input.sample_position = "centre".into()), "the sample position differs"),
            (refusal(|fit| fit.model = "ggx".into()), "the model differs"),
            (refusal(|fit| fit.options.loss = Some("l2".into())), "the option loss differs"),
            (refusal(|fit| fit.options.constraint = Some("free".into())), "the option constraint differs"),
            (refusal(|fit| fit.options.distribution = Some("joint".into())), "the option distribution differs"),
            (refusal(|fit| fit.options.cutoff_theta_h_degrees = Some(60.0)), "the cut-off of theta_h differs"),
            (refusal(|fit| fit.options.cutoff_theta_d_degrees = Some(75.0)), "the cut-off of theta_d differs"),
        ] {
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn what_a_document_leaves_out_is_not_held_against_it() {
        let mut ours = fit();
        ours.input.sha256 = None;
        ours.options = ComparableOptions::default();
        ours.check_comparable(&fit()).unwrap();
        fit().check_comparable(&ours).unwrap();
    }

    #[test]
    fn paper_is_another_name_for_free_without_an_anchor() {
        let (mut ours, mut reference) = (fit(), fit());
        reference.options.constraint = Some("paper".into());
        ours.options.constraint = Some("free".into());
        ours.options.anchor = Some("distribution".into());
        ours.check_comparable(&reference).unwrap();
        ours.options.anchor = Some("peak".into());
        assert!(ours.check_comparable(&reference).unwrap_err().to_string().contains("anchor"));
    }

    #[test]
    fn what_is_no_fit_is_refused() {
        for (text, expected) in [
            ("{", "EOF"),
            ("[]", "invalid"),
            (r#"{ "materials": [] }"#, "missing field"),
            (&DOCUMENT.replace("\"R\"", "\"X\""), "not R, G and B"),
            (&DOCUMENT.replace("[0.0, 0.1, 0.5, 1.0]", "[0.0, 0.1]"), "one value per angle"),
            (&DOCUMENT.replace("[0.0, 0.5, 1.0, 1.3]", "[]"), "one value per angle"),
            (&DOCUMENT.replacen("\"theta_d\", \"cost\"", "\"x\", \"cost\"", 1), "steps of channel R"),
        ] {
            let message = ComparableFit::from_json(text).unwrap_err().to_string();
            assert!(message.starts_with("not a fit result") && message.contains(expected), "{message}");
        }
    }
}
