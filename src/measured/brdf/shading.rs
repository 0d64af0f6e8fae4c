//! A measured material as a batched BRDF for renderers.

use brdfit_brdf::{BatchBrdf, HalfVectorSampler, HalfVectors, by_eights};
use wide::f32x8;

use crate::brdf::lobes::{Incident, span};
use crate::brdf::table::{HALF, QUARTER, Table};

/// [`BatchBrdf`] of a table: trilinear interpolation in single precision, as for lobes, and half vectors from the measured values.
pub(super) struct MeasuredShading<'a> {
    pub(super) table: &'a Table,
    pub(super) sampler: HalfVectorSampler,
}

impl MeasuredShading<'_> {
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
