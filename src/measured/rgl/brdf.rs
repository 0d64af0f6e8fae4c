//! The BRDF that the tables describe.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

use brdfit_brdf::{BatchBrdf, Brdf, Direction, Directions, FixedOutgoing, Symmetry, cosine_sample, direction, reflect};

use crate::brdf::sampling::Sampling;
use crate::grid::dimensions::CHANNELS;
use crate::rgl::batch::{Batch, RglLobes, RglShading};
use crate::rgl::tables::Tables;
use crate::rgl::warp::Between;

/// Share of the samples that a cosine lobe draws, so that the density is above zero wherever `f` is.
const COSINE_SHARE: f64 = 0.1;
/// The least density of half vectors that counts, per unit square over solid angle: at the pole of the map.
const LEAST_SPREAD: f64 = 1e-6;

/// A table of Dupuy & Jakob 2018 as a BRDF, as it is stored: between the measured theta_i everything is interpolated linearly,
/// and the result is **not reciprocal**.
///
/// With m the half vector, `u(theta) = sqrt(2 theta/pi)`, `u(phi) = (phi + pi)/(2 pi)`, s the uniform numbers that the
/// distribution of visible normals takes to m:
///
/// `f(i, o) = rgb(s) ndf(m) / (4 sigma(i) cos theta_o)`
///
/// **Sampling.** Nine tenths of the draws take s from the luminance and m from s, as the paper does; a cosine lobe draws the
/// rest.
#[derive(Clone, Debug)]
pub(crate) struct RglBrdf {
    tables: Tables,
    batch: Batch,
}

/// The coordinates of a pair of directions in the tables.
struct Coordinates {
    slices: Between,
    /// Of i in `sigma`.
    incident: [f64; 2],
    /// Of the half vector.
    half: [f64; 2],
    /// `dm / (du dv)` without its square: `2 pi^2 u sin theta_m`.
    spread: f64,
    cos_theta_d: f64,
}

impl RglBrdf {
    pub(crate) fn new(tables: Tables) -> Self {
        Self { batch: Batch::new(&tables), tables }
    }

    pub(crate) fn tables(&self) -> &Tables {
        &self.tables
    }

    fn slices(&self, theta_i: f64) -> Between {
        Between::of(&self.tables.theta_i, theta_i)
    }

    fn coordinates(&self, i: &Direction, o: &Direction) -> Coordinates {
        let h = (i + o).normalize();
        let (theta_i, theta_m) = (elevation(i), elevation(&h));
        let turn = (libm::atan2(h.y, h.x) - libm::atan2(i.y, i.x)) / (2.0 * PI) + 0.5;
        let u = square_root_map(theta_m);
        Coordinates {
            slices: self.slices(theta_i),
            incident: [square_root_map(theta_i), 0.5],
            half: [u, turn - turn.floor()],
            spread: (2.0 * PI * PI * u * libm::sin(theta_m)).max(LEAST_SPREAD),
            cos_theta_d: i.dot(&h),
        }
    }

    /// `f(i, o)` in 1/sr; small negative values occur where the colour was interpolated beyond the gamut.
    pub(crate) fn stored_value(&self, i: &Direction, o: &Direction) -> [f64; CHANNELS] {
        if i.z <= 0.0 || o.z <= 0.0 {
            return [0.0; CHANNELS];
        }
        let Tables { ndf, sigma, vndf, rgb, jacobian, .. } = &self.tables;
        let at = self.coordinates(i, o);
        let (s, _) = vndf.invert(at.half, at.slices);
        let whole = Between { below: 0, share: 0.0 };
        let factor = if *jacobian {
            let area = 4.0 * sigma.value(at.incident, whole, |_| 0);
            if area <= 0.0 {
                return [0.0; CHANNELS];
            }
            ndf.value(at.half, whole, |_| 0) / area
        } else {
            1.0
        };
        [0, 1, 2].map(|channel: usize| rgb.value(s, at.slices, |slice| CHANNELS * slice + channel) * factor / o.z)
    }

    /// Density of o by half vectors alone, 1/sr.
    fn half_vector_pdf(&self, i: &Direction, o: &Direction) -> f64 {
        let at = self.coordinates(i, o);
        let (s, visible) = self.tables.vndf.invert(at.half, at.slices);
        let density = visible * self.tables.luminance.pdf(s, at.slices);
        if at.cos_theta_d > 0.0 { density / (at.spread * 4.0 * at.cos_theta_d) } else { 0.0 }
    }
}

impl Brdf for RglBrdf {
    fn value(&self, i: &Direction, o: &Direction) -> [f64; 3] {
        self.stored_value(i, o)
    }

    /// Not mirror symmetric: the tables hold both sides of the plane of incidence as they were measured.
    fn symmetry(&self) -> Symmetry {
        Symmetry::Isotropic
    }

    fn sample(&self, i: &Direction, u: [f64; 3]) -> Option<Direction> {
        if u[2] < COSINE_SHARE {
            return Some(cosine_sample([u[0], u[1]]));
        }
        let slices = self.slices(elevation(i));
        let (s, _) = self.tables.luminance.sample([u[0], u[1]], slices);
        let ([x, y], _) = self.tables.vndf.sample(s, slices);
        let m = direction(x * x * FRAC_PI_2, (2.0 * y - 1.0) * PI + libm::atan2(i.y, i.x));
        let o = reflect(i, &m);
        (o.z > 0.0).then_some(o)
    }

    fn pdf(&self, i: &Direction, o: &Direction) -> f64 {
        if i.z <= 0.0 || o.z <= 0.0 {
            return 0.0;
        }
        COSINE_SHARE * o.z * FRAC_1_PI + (1.0 - COSINE_SHARE) * self.half_vector_pdf(i, o)
    }

    fn towards<'a>(&'a self, o: &'a Directions) -> Box<dyn FixedOutgoing + 'a> {
        Box::new(RglLobes { batch: &self.batch, o })
    }

    fn batch(&self) -> Box<dyn BatchBrdf + '_> {
        let mean = |i: &Direction, o: &Direction| self.stored_value(i, o).iter().sum::<f64>().max(0.0) / 3.0;
        let sampler = Sampling::new(mean).half_vectors(mean);
        Box::new(RglShading { batch: &self.batch, sampler })
    }
}

/// The angle of a unit vector with the normal, accurate near the normal too.
fn elevation(v: &Direction) -> f64 {
    libm::atan2(libm::hypot(v.x, v.y), v.z)
}

/// `u(theta)`.
fn square_root_map(theta: f64) -> f64 {
    (theta / FRAC_PI_2).sqrt()
}
