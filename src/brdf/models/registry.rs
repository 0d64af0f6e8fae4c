//! The registry of models, one line each.

use crate::brdf::Brdf;
use crate::distributions::normal_distribution::NormalDistribution;
use crate::models::microfacet::{Microfacet, MicrofacetParameters, parameters_with};
use crate::models::microfacet_material::MicrofacetMaterial;
use crate::models::model::{ChannelModel, Model};
use crate::models::parameter::{Parameter, ParameterError};
use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;
use std::sync::LazyLock;

/// Declares the models by their distributions of normals and the numbers of their shape parameters.
macro_rules! models {
    ($($(#[$doc:meta])* $model:ident: $distribution:path, $parameters:literal;)*) => {
        /// The models that can be fitted, written and rendered.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum ModelName {
            $($(#[$doc])* $model,)*
        }

        impl ModelName {
            /// All of them; the first is the default.
            pub const ALL: &'static [Self] = &[$(Self::$model,)*];

            /// What can be done with the model.
            pub fn model(self) -> &'static dyn Model {
                match self {
                    $(Self::$model => {
                        static MODEL: LazyLock<MicrofacetModel<$distribution, $parameters>> =
                            LazyLock::new(MicrofacetModel::new);
                        &*MODEL
                    })*
                }
            }

            /// Calls the visitor with the model's distribution of normals.
            pub fn visit<V: DistributionVisitor>(self, visitor: V) -> V::Output {
                match self {
                    $(Self::$model => visitor.visit::<$distribution, $parameters>(),)*
                }
            }
        }
    };
}

models! {
    /// Shifted gamma distribution (Bagher, Soler and Holzschuch 2012).
    Sgd: crate::distributions::shifted_gamma::ShiftedGamma, 2;
    /// GGX distribution (Walter et al. 2007).
    Ggx: crate::distributions::ggx::Ggx, 1;
}

/// Code that is generic over the distribution of normals, to be run for the one of a model.
pub trait DistributionVisitor {
    /// What it returns.
    type Output;

    /// Runs it.
    fn visit<D: NormalDistribution<N>, const N: usize>(self) -> Self::Output;
}

impl ModelName {
    /// The name as documents and options write it.
    pub fn as_str(self) -> &'static str {
        self.model().name()
    }
}

impl Default for ModelName {
    /// The model of documents that name none.
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl fmt::Display for ModelName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// A name that no model has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected {}, found {name:?}", names())]
pub struct UnknownModel {
    /// The name.
    pub name: String,
}

/// The names of all models, quoted.
fn names() -> String {
    ModelName::ALL.iter().map(|model| format!("{:?}", model.as_str())).collect::<Vec<_>>().join(" or ")
}

impl FromStr for ModelName {
    type Err = UnknownModel;

    fn from_str(name: &str) -> Result<Self, UnknownModel> {
        let found = Self::ALL.iter().copied().find(|model| model.as_str() == name);
        found.ok_or_else(|| UnknownModel { name: name.to_owned() })
    }
}

/// The microfacet model with a distribution.
struct MicrofacetModel<D, const N: usize> {
    parameters: Vec<Parameter>,
    distribution: PhantomData<fn() -> D>,
}

impl<D: NormalDistribution<N>, const N: usize> MicrofacetModel<D, N> {
    fn new() -> Self {
        Self { parameters: parameters_with(&D::SHAPE), distribution: PhantomData }
    }
}

impl<D: NormalDistribution<N>, const N: usize> Model for MicrofacetModel<D, N> {
    fn name(&self) -> &'static str {
        D::MODEL
    }

    fn title(&self) -> &'static str {
        D::TITLE
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn channel(&self, values: &[f64]) -> Result<Box<dyn ChannelModel>, ParameterError> {
        Ok(Box::new(Microfacet::<D, N>::new(MicrofacetParameters::from_values(values))?))
    }

    fn material(&self, channels: [&[f64]; 3]) -> Result<Box<dyn Brdf>, ParameterError> {
        Ok(Box::new(MicrofacetMaterial::<D, N>::new(channels.map(MicrofacetParameters::from_values))?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_parameters_are_unique() {
        for (n, model) in ModelName::ALL.iter().enumerate() {
            assert_eq!(model.as_str().parse(), Ok(*model));
            assert!(ModelName::ALL[..n].iter().all(|other| other.as_str() != model.as_str()));
            let names: Vec<_> = model.model().parameters().iter().map(|parameter| parameter.name).collect();
            assert!((1..names.len()).all(|n| !names[..n].contains(&names[n])), "{names:?}");
        }
        let error = "phong".parse::<ModelName>().unwrap_err().to_string();
        assert_eq!(error, "expected \"sgd\" or \"ggx\", found \"phong\"");
    }
}
