//! A microfacet model of one colour channel, for any distribution of normals.

use crate::distributions::normal_distribution::NormalDistribution;
use crate::masking::curve::G1Curve;
use crate::masking::masking::Masking;
use crate::math::direction::sine;
use crate::models::configuration::Configuration;
use crate::models::fresnel::Fresnel;
use crate::models::model::{CellRow, ChannelModel, FourCells, GridModel};
use crate::models::parameter::{Parameter, ParameterError, Transform};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};
use std::sync::LazyLock;
use wide::f64x4;

/// The parameters of one channel, all dimensionless: `N` of them belong to the distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MicrofacetParameters<const N: usize> {
    /// Diffuse albedo.
    pub rho_d: f64,
    /// Specular scale; only its product with the Fresnel term has a meaning of its own.
    pub rho_s: f64,
    /// The distribution's parameters in the order of [`NormalDistribution::SHAPE`].
    pub shape: [f64; N],
    /// Constant term of the generalised Schlick Fresnel term.
    pub f0: f64,
    /// Linear term of the generalised Schlick Fresnel term.
    pub f1: f64,
}

impl<const N: usize> MicrofacetParameters<N> {
    /// The Fresnel term of these parameters.
    pub fn fresnel(&self) -> Fresnel {
        Fresnel { f0: self.f0, f1: self.f1 }
    }

    /// From values in the order of [`crate::Model::parameters`]: rho_d, rho_s, the shape, f0, f1.
    ///
    /// # Panics
    /// Unless there are `N + 4`.
    pub fn from_values(values: &[f64]) -> Self {
        assert_eq!(values.len(), N + 4, "the number of parameters");
        Self {
            rho_d: values[0],
            rho_s: values[1],
            shape: std::array::from_fn(|n| values[2 + n]),
            f0: values[N + 2],
            f1: values[N + 3],
        }
    }

    /// The inverse of [`Self::from_values`].
    pub fn values(&self) -> Vec<f64> {
        let shape = self.shape.iter().copied();
        [self.rho_d, self.rho_s].into_iter().chain(shape).chain([self.f0, self.f1]).collect()
    }
}

/// The parameters of the model with a distribution, in the order of [`MicrofacetParameters::values`].
pub(crate) fn parameters_with(shape: &[Parameter]) -> Vec<Parameter> {
    let of = |name, symbol, meaning| Parameter {
        name,
        symbol,
        meaning,
        unit: "",
        transform: Transform::Identity,
        range: [f64::NEG_INFINITY, f64::INFINITY],
    };
    let diffuse = Parameter {
        transform: Transform::Logarithm,
        range: DIFFUSE_RANGE,
        ..of("rho_d", ("ρ", "d"), "Diffuse albedo.")
    };
    let scale = "Specular scale; only its product with the Fresnel term has a meaning of its own.";
    let mut all = vec![diffuse, of("rho_s", ("ρ", "s"), scale)];
    all.extend(shape);
    all.push(of("f0", ("F", "0"), "Constant term of the generalised Schlick Fresnel term."));
    all.push(of("f1", ("F", "1"), "Linear term of the generalised Schlick Fresnel term."));
    all
}

/// Bounds of the diffuse albedo in the fit.
const DIFFUSE_RANGE: [f64; 2] = [1e-6, 10.0];

/// The microfacet model of one channel with Smith's exact masking of either direction:
///
/// `f(i, o) = rho_d / pi + rho_s F(theta_d) D(theta_h) G1(theta_i) G1(theta_o) / (c cos theta_i cos theta_o)`
///
/// in 1/sr, zero where either direction is at or below the horizon; `c` is [`NormalDistribution::DIVISOR`]. Cook and
/// Torrance's form (1982) with the normalisation of Walter et al. (2007, eq. 20) for `c = 4`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacet<D, const N: usize> {
    parameters: MicrofacetParameters<N>,
    distribution: D,
}

impl<D: NormalDistribution<N>, const N: usize> Microfacet<D, N> {
    /// The model with these parameters.
    ///
    /// # Errors
    /// If a parameter is not finite, rho_d is negative, or the distribution rejects its shape.
    pub fn new(parameters: impl Into<MicrofacetParameters<N>>) -> Result<Self, ParameterError> {
        let parameters: MicrofacetParameters<N> = parameters.into();
        let MicrofacetParameters { rho_d, rho_s, shape, f0, f1 } = parameters;
        ParameterError::unless(rho_d >= 0.0, "rho_d", rho_d, "finite and not negative")?;
        ParameterError::unless(true, "rho_s", rho_s, "finite")?;
        ParameterError::unless(true, "f0", f0, "finite")?;
        ParameterError::unless(true, "f1", f1, "finite")?;
        Ok(Self { parameters, distribution: D::from_shape(shape)? })
    }

    /// The parameters.
    pub fn parameters(&self) -> &MicrofacetParameters<N> {
        &self.parameters
    }

    /// The distribution of normals.
    pub fn distribution(&self) -> &D {
        &self.distribution
    }

    /// `f` in 1/sr above the horizon from its factors: `D`, `F` and either `G1 / cos theta`.
    #[inline]
    pub(crate) fn combine(&self, d: f64, fresnel: f64, g1_over_cos: [f64; 2]) -> f64 {
        let lobe = d * (g1_over_cos[0] * g1_over_cos[1]) * (1.0 / D::DIVISOR);
        self.parameters.rho_d * FRAC_1_PI + self.parameters.rho_s * fresnel * lobe
    }

    /// `f` in 1/sr; zero where either direction is at or below the horizon.
    pub fn value(&self, at: &Configuration) -> f64 {
        if at.cos_theta_i <= 0.0 || at.cos_theta_o <= 0.0 {
            return 0.0;
        }
        let masked = |cos: f64| self.distribution.g1_from(cos, sine(cos)) / cos;
        let fresnel = self.parameters.fresnel().value(at.cos_theta_d);
        let d = self.distribution.d_at_tan_square(at.tan_square_h);
        self.combine(d, fresnel, [masked(at.cos_theta_i), masked(at.cos_theta_o)])
    }

    /// `f` in 1/sr and its derivatives with respect to the parameters, in the order of [`MicrofacetParameters::values`].
    ///
    /// # Panics
    /// Unless `gradient` holds `N + 4` numbers.
    pub fn value_and_gradient(&self, at: &Configuration, gradient: &mut [f64]) -> f64 {
        assert_eq!(gradient.len(), N + 4, "the number of derivatives");
        gradient.fill(0.0);
        if at.cos_theta_i <= 0.0 || at.cos_theta_o <= 0.0 {
            return 0.0;
        }
        let MicrofacetParameters { rho_d, rho_s, .. } = self.parameters;
        let fresnel = self.parameters.fresnel().value(at.cos_theta_d);
        let (by_f0, by_f1) = Fresnel::derivatives(at.cos_theta_d);
        let [(g_i, g_i_slopes), (g_o, g_o_slopes)] =
            [at.cos_theta_i, at.cos_theta_o].map(|cos| self.distribution.g1_with_slopes(libm::acos(cos.min(1.0))));
        let d = self.distribution.d_at_tan_square(at.tan_square_h);
        let lobe = d * g_i * g_o / (at.cos_theta_i * at.cos_theta_o) * (1.0 / D::DIVISOR);
        let d_slopes = self.distribution.ln_slopes(at.tan_square_h);
        gradient[0] = FRAC_1_PI;
        gradient[1] = fresnel * lobe;
        for n in 0..N {
            // d ln(D G1 G1)
            gradient[2 + n] = rho_s * fresnel * lobe * (d_slopes[n] + g_i_slopes[n] / g_i + g_o_slopes[n] / g_o);
        }
        gradient[N + 2] = rho_s * lobe * by_f0;
        gradient[N + 3] = rho_s * lobe * by_f1;
        rho_d * FRAC_1_PI + rho_s * fresnel * lobe
    }

    /// Directional albedo at theta_i in radians: the integral of `f cos theta_o` over the outgoing hemisphere.
    ///
    /// The diffuse part is exact; the specular part is integrated over the half vector by the distribution's own rule in
    /// `tan^2 theta_h` and the midpoint rule with 32 azimuths. `masking` is the distribution's. Within 1e-4 absolute of an
    /// independent quadrature (`data-fixtures/albedo.json`, `ggx.json`).
    pub fn directional_albedo(&self, masking: &D::Masking, theta_i: f64) -> f64 {
        const AZIMUTHS: u32 = 32;
        static COSINES: LazyLock<Vec<f64>> = LazyLock::new(|| {
            (0..AZIMUTHS).map(|n| libm::cos(PI * (f64::from(n) + 0.5) / f64::from(AZIMUTHS))).collect()
        });
        let cos_i = libm::cos(theta_i);
        if !(0.0..FRAC_PI_2).contains(&theta_i) {
            return 0.0;
        }
        let sin_i = libm::sin(theta_i);
        let fresnel = self.parameters.fresnel();
        let mut specular = 0.0;
        for (x, weight) in self.distribution.quadrature() {
            let cos_h = 1.0 / (1.0 + x).sqrt();
            let sin_h = x.sqrt() * cos_h;
            if weight < 1e-10 {
                continue;
            }
            let mut ring = 0.0;
            for cos_phi in COSINES.iter() {
                let cos_d = cos_i * cos_h + sin_i * sin_h * cos_phi;
                let cos_o = 2.0 * cos_d * cos_h - cos_i;
                if cos_d <= 0.0 || cos_o <= 0.0 {
                    continue;
                }
                let sin_o = sine(cos_o);
                let g1 = if sin_o > 0.0 {
                    cos_o * masking.g1_over_cos(cos_o, sin_o, G1Curve::position(cos_o, sin_o))
                } else {
                    1.0
                };
                ring += fresnel.value(cos_d) * g1 * cos_d;
            }
            specular += weight / cos_h * ring / f64::from(AZIMUTHS);
        }
        self.parameters.rho_d
            + 4.0 * self.parameters.rho_s * self.distribution.g1(theta_i) / (D::DIVISOR * cos_i) * specular
    }
}

impl<D: NormalDistribution<N>, const N: usize> ChannelModel for Microfacet<D, N> {
    fn value(&self, at: &Configuration) -> f64 {
        self.value(at)
    }

    fn values_and_gradients(&self, cells: &[Configuration], values: &mut [f64], gradients: &mut [f64]) {
        assert_eq!(values.len(), cells.len(), "one value per cell");
        let rows = gradients.chunks_exact_mut(N + 4);
        assert_eq!(rows.len(), cells.len(), "one gradient per cell");
        for ((at, value), gradient) in cells.iter().zip(values).zip(rows) {
            *value = self.value_and_gradient(at, gradient);
        }
    }

    fn on_grid(&self, theta_h: &[f64], theta_d: &[f64]) -> Box<dyn GridModel> {
        let MicrofacetParameters { rho_d, rho_s, .. } = self.parameters;
        let lobe = |&theta: &f64| rho_s * self.distribution.d_at(theta) * (1.0 / D::DIVISOR);
        Box::new(MicrofacetOnGrid {
            diffuse: rho_d * FRAC_1_PI,
            lobe: theta_h.iter().map(lobe).collect(),
            fresnel: theta_d.iter().map(|&theta| self.parameters.fresnel().value(libm::cos(theta))).collect(),
            masking: self.distribution.masking(),
        })
    }

    fn directional_albedo(&self, theta_i: f64) -> f64 {
        self.directional_albedo(&self.distribution.masking(), theta_i)
    }
}

/// One channel, tabulated along theta_h and theta_d of a grid.
#[derive(Clone, Debug)]
struct MicrofacetOnGrid<M> {
    diffuse: f64,
    /// `rho_s D / c` per theta_h.
    lobe: Vec<f64>,
    /// `F` per theta_d.
    fresnel: Vec<f64>,
    masking: M,
}

impl<M: Masking> GridModel for MicrofacetOnGrid<M> {
    fn value(&self, row: CellRow, cosines: (f64, f64), positions: [f64; 2]) -> f64 {
        let specular = self.lobe[row.theta_h] * self.fresnel[row.theta_d];
        if specular == 0.0 {
            return self.diffuse;
        }
        let (cos_i, cos_o) = cosines;
        let masking = self.masking.g1_over_cos(cos_i, above_zero(cos_i), positions[0])
            * self.masking.g1_over_cos(cos_o, above_zero(cos_o), positions[1]);
        self.diffuse + specular * masking
    }

    fn values(&self, row: CellRow, cells: &[FourCells], values: &mut [[f64; 4]]) {
        assert_eq!(cells.len(), values.len(), "one block of values per block of cells");
        let specular = self.lobe[row.theta_h] * self.fresnel[row.theta_d];
        if specular == 0.0 {
            return values.fill([self.diffuse; 4]);
        }
        for (cells, values) in cells.iter().zip(values) {
            let [i, o] = [0, 1].map(|n: usize| {
                let cos = f64x4::from(cells.cosines[n]);
                let sin = ((1.0 - cos) * (cos + 1.0)).max(f64x4::splat(1e-300)).sqrt();
                self.masking.four_cos_over_g1(cos, sin, cells.positions.map(|position| position[n]))
            });
            *values = (specular / (i * o) + self.diffuse).to_array();
        }
    }
}

/// The sine that belongs to a cosine, above zero.
fn above_zero(cos: f64) -> f64 {
    ((1.0 - cos) * (1.0 + cos)).max(1e-300).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::direction::HalfDifference;
    use crate::models::sgd::{Sgd, SgdParameters};

    const METAL: SgdParameters = SgdParameters { rho_d: 0.03, rho_s: 0.6, alpha: 0.03, p: 0.45, f0: 0.24, f1: 0.18 };

    #[test]
    fn reciprocity_and_the_horizon() {
        let sgd = Sgd::new(METAL).unwrap();
        let angles = HalfDifference { theta_h: 0.2, theta_d: 0.9, phi_d: 0.7 };
        let swapped = HalfDifference { phi_d: 0.7 + PI, ..angles };
        let (a, b) = (sgd.value(&angles.into()), sgd.value(&swapped.into()));
        assert!((a / b - 1.0).abs() < 1e-12);
        let below = HalfDifference { theta_h: 1.2, theta_d: 0.9, phi_d: 0.1 };
        assert_eq!(sgd.value(&below.into()), 0.0);
    }

    #[test]
    fn a_diffuse_channel_has_the_albedo_rho_d() {
        let sgd = Sgd::new(SgdParameters { rho_d: 0.4, rho_s: 0.0, ..METAL }).unwrap();
        for theta in [0.0, 0.7, 1.4] {
            assert!((ChannelModel::directional_albedo(&sgd, theta) - 0.4).abs() < 1e-15);
        }
    }

    #[test]
    fn parameters_outside_of_the_domain_are_named() {
        let refused = |parameters: SgdParameters| Sgd::new(parameters).unwrap_err().name;
        assert_eq!(refused(SgdParameters { alpha: 0.0, ..METAL }), "alpha");
        assert_eq!(refused(SgdParameters { alpha: f64::NAN, ..METAL }), "alpha");
        assert_eq!(refused(SgdParameters { p: 1e9, ..METAL }), "p");
        assert_eq!(refused(SgdParameters { rho_d: -1.0, ..METAL }), "rho_d");
        assert_eq!(refused(SgdParameters { f1: f64::INFINITY, ..METAL }), "f1");
    }
}
