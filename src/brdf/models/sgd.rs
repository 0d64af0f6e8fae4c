//! The SGD microfacet model: the shifted gamma distribution (thesis V.3).

use crate::distributions::shifted_gamma::ShiftedGamma;
use crate::models::fresnel::Fresnel;
use crate::models::material_parameters::{ChannelError, MaterialParameters};
use crate::models::microfacet::{Microfacet, MicrofacetParameters};
use crate::models::microfacet_material::MicrofacetMaterial;
use crate::models::registry::ModelName;

/// The SGD model of one channel, `f(i, o) = [rho_d + rho_s F D G1 G1 / (cos theta_i cos theta_o)] / pi` in 1/sr (thesis
/// V.3.1: no factor 1/4). Values within 1e-11 relative of mpmath (`data-fixtures/sgd.json`).
pub type Sgd = Microfacet<ShiftedGamma, 2>;

/// Three SGD channels (R, G, B).
pub type SgdMaterial = MicrofacetMaterial<ShiftedGamma, 2>;

/// The six free parameters of one channel, all dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SgdParameters {
    /// Diffuse albedo.
    pub rho_d: f64,
    /// Specular scale; only its product with the Fresnel term has a meaning of its own.
    pub rho_s: f64,
    /// Width of the distribution, above zero: small is sharp.
    pub alpha: f64,
    /// Exponent of the distribution: large makes the peak sharper than the tail.
    pub p: f64,
    /// Constant term of the generalised Schlick Fresnel term.
    pub f0: f64,
    /// Linear term of the generalised Schlick Fresnel term.
    pub f1: f64,
}

impl SgdParameters {
    /// The Fresnel term of these parameters.
    pub fn fresnel(&self) -> Fresnel {
        Fresnel { f0: self.f0, f1: self.f1 }
    }
}

impl From<SgdParameters> for MicrofacetParameters<2> {
    fn from(SgdParameters { rho_d, rho_s, alpha, p, f0, f1 }: SgdParameters) -> Self {
        Self { rho_d, rho_s, shape: [alpha, p], f0, f1 }
    }
}

impl From<MicrofacetParameters<2>> for SgdParameters {
    fn from(MicrofacetParameters { rho_d, rho_s, shape: [alpha, p], f0, f1 }: MicrofacetParameters<2>) -> Self {
        Self { rho_d, rho_s, alpha, p, f0, f1 }
    }
}

impl TryFrom<[SgdParameters; 3]> for MaterialParameters {
    type Error = ChannelError;

    fn try_from(channels: [SgdParameters; 3]) -> Result<Self, ChannelError> {
        Self::new(ModelName::Sgd, channels.map(|channel| MicrofacetParameters::from(channel).values()))
    }
}
