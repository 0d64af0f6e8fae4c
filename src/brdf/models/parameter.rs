//! Descriptions of the parameters of models.

/// One parameter of a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name in documents.
    pub name: &'static str,
    /// Its symbol: a letter with an index, `("ρ", "d")`, the index empty where there is none.
    pub symbol: (&'static str, &'static str),
    /// Its meaning in one sentence, the description in the schema.
    pub meaning: &'static str,
    /// Its unit; empty for a number without dimension.
    pub unit: &'static str,
    /// Relation of the unknown of the fit to the parameter.
    pub transform: Transform,
    /// Between which values the fit searches.
    pub range: [f64; 2],
}

/// Relation of an unknown of the fit to a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transform {
    /// It is the parameter.
    Identity,
    /// Its natural logarithm.
    Logarithm,
}

impl Transform {
    /// The unknown of a parameter.
    pub fn unknown(self, parameter: f64) -> f64 {
        match self {
            Self::Identity => parameter,
            Self::Logarithm => libm::log(parameter),
        }
    }

    /// The parameter of an unknown.
    pub fn parameter(self, unknown: f64) -> f64 {
        match self {
            Self::Identity => unknown,
            Self::Logarithm => libm::exp(unknown),
        }
    }

    /// The derivative of the parameter with respect to its unknown, at the parameter.
    pub fn slope(self, parameter: f64) -> f64 {
        match self {
            Self::Identity => 1.0,
            Self::Logarithm => parameter,
        }
    }
}

/// Parameters with which a model cannot be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is outside of the model's domain: {domain}")]
pub struct ParameterError {
    /// The parameter.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// Its domain.
    pub domain: &'static str,
}

impl ParameterError {
    /// An error unless the value is finite and `inside`.
    pub(crate) fn unless(
        inside: bool,
        name: &'static str,
        value: f64,
        domain: &'static str,
    ) -> Result<(), ParameterError> {
        if inside && value.is_finite() { Ok(()) } else { Err(Self { name, value, domain }) }
    }
}
