//! A measured material for renderers.

use brdfit_brdf::{BatchBrdf, Direction, HalfDifference, HalfVectorSampler, HalfVectorTable, HalfVectors, by_eights};
use std::f64::consts::FRAC_PI_2;
use wide::f32x8;

use crate::brdf::lobes::{Incident, span};
use crate::brdf::sampling::Sampling;
use crate::brdf::table::{HALF, QUARTER, Table};

/// `tan^2 theta_h` of the first bins of theta_h, and of 89 degrees: beyond, the cosine lobe draws.
const RANGE: [f64; 2] = [1e-10, 3283.0];
/// Angles theta_d, radians, over which the distribution of half vectors is averaged.
const THETA_D: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// At least this share of a value counts as part of the lobe.
const LEAST: f64 = 0.05;

/// [`BatchBrdf`] of a table: trilinear interpolation in single precision, as for lobes, and half vectors from the measured values.
pub(super) struct MeasuredShading<'a> {
    table: &'a Table,
    sampler: HalfVectorSampler,
}

impl<'a> MeasuredShading<'a> {
    pub(super) fn new(table: &'a Table, sampling: &Sampling) -> Self {
        let mean = |i: &Direction, o: &Direction| table.value(i, o).iter().sum::<f64>() / 3.0;
        // i and o equally high: f cos theta_i cos theta_o cos theta_h of what lies above the floor, per unit of tan^2 theta_h
        let density = |tan_square: f64| {
            let lobe = |theta_d: f64| {
                let theta_h = libm::atan(tan_square.sqrt());
                let (i, o) = HalfDifference { theta_h, theta_d, phi_d: FRAC_PI_2 }.to_directions();
                let (f, cos_d) = (mean(&i, &o), libm::cos(theta_d));
                (f - sampling.floor()).max(LEAST * f) * cos_d * cos_d
            };
            let secant_square = 1.0 + tan_square;
            THETA_D.map(lobe).iter().sum::<f64>() / (secant_square * secant_square * secant_square)
        };
        let share = sampling.specular();
        let normals = (share > 0.0).then(|| HalfVectorTable::new(density, RANGE[0], RANGE[1])).flatten();
        Self { table, sampler: HalfVectorSampler::new(normals, share) }
    }

    fn run<const WIDTH: usize, const SPAN: usize>(&self, pairs: [&[f32]; 6], found: [&mut [f32]; 4]) {
        by_eights(pairs, found, |[ix, iy, iz, ox, oy, oz]| {
            let above = iz.simd_gt(f32x8::ZERO) & oz.simd_gt(f32x8::ZERO);
            if above.none() {
                return [f32x8::ZERO; 4];
            }
            let (i, o) = ([ix, iy, iz], [ox, oy, oz]);
            let incident = Incident { high: i, low: [f32x8::ZERO; 3] };
            let [r, g, b] = incident
                .coordinates::<WIDTH>(o, f32x8::ZERO, self.table.offset as f32)
                .look_up::<WIDTH, SPAN>(&self.table.texels)
                .map(f32x8::new);
            [r, g, b, self.sampler.density(&HalfVectors::new(i, o), iz)].map(|found| above & found)
        });
    }
}

impl BatchBrdf for MeasuredShading<'_> {
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]) {
        self.sampler.sample_many(o, u, i);
    }

    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]) {
        let ([r, g, b], pairs) = (values, [i[0], i[1], i[2], o[0], o[1], o[2]]);
        if self.table.width == QUARTER {
            self.run::<QUARTER, { span(QUARTER) }>(pairs, [r, g, b, density]);
        } else {
            self.run::<HALF, { span(HALF) }>(pairs, [r, g, b, density]);
        }
    }
}
