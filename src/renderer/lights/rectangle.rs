//! A one-sided rectangular light of constant radiance.

use std::sync::Arc;

use brdfit_brdf::by_eights;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use wide::f32x8;

use crate::geometry::spherical_rectangle::SeenRectangle;
use crate::geometry::vec3::Vec3;
use crate::lights::light_set::NearLight;
use crate::lights::lighting::{Arriving, Lighting, Receivers, Seen};
use crate::scene::error::{Field, SceneError};
use crate::scene::values::{LARGEST_NUMBER, SMALLEST_NUMBER, cross, dot, finite3, length, range, wrong};

/// Largest cosine of the angle between the edges.
const RIGHT_ANGLE: f64 = 1e-5;
/// Below this solid angle, steradians, places are drawn uniformly on the area: single precision does not resolve differences of
/// the solid angle there, and the density of the area hardly varies over it unless the light is seen at a grazing angle.
const LEAST_SOLID_ANGLE: f32 = 1e-2;
/// Places stay this far from the edges, in units of the distance to the receiver, so that rounding on the way to a direction and back
/// does not carry them over.
const INSET: f32 = 2e-7;
/// Bandwidth of the emission at a distance x from the nearest edge: this over x. Of a plain square as the estimator of the atlas reads
/// it, 0.30 to 0.42 near the edges.
const EDGE_BANDWIDTH: f32 = 0.35;

/// A rectangle of constant radiance in all directions, emitted on the side that `edges[0] x edges[1]` points to. The
/// camera sees it; its back is black and opaque.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RectangleDocument {
    /// One corner.
    pub corner: [f64; 3],
    /// From this corner along both sides, at right angles.
    pub edges: [[f64; 3]; 2],
    /// Radiance per channel, at least 0: W/(sr m^2) where the unit of length is the metre.
    pub radiance: [f64; 3],
}

impl RectangleDocument {
    /// Checks the values.
    pub(crate) fn check(&self, at: &Field) -> Result<(), SceneError> {
        finite3(self.corner, &at.member("corner"))?;
        let edges = at.member("edges");
        for (index, &edge) in self.edges.iter().enumerate() {
            let at = edges.element(index);
            finite3(edge, &at)?;
            if length(edge) < SMALLEST_NUMBER {
                return wrong(&at, "has no length");
            }
        }
        let [a, b] = self.edges;
        let cos = dot(a, b) / (length(a) * length(b));
        if cos.abs() > RIGHT_ANGLE {
            let angle = libm::acos(cos.clamp(-1.0, 1.0)).to_degrees();
            return wrong(&edges, format!("make an angle of {angle:.3} degrees instead of 90"));
        }
        let radiance = at.member("radiance");
        let channels = self.radiance.iter().enumerate();
        channels.into_iter().try_for_each(|(n, &value)| range(value, 0.0, LARGEST_NUMBER, &radiance.element(n)))
    }

    /// The light of a document that has been checked.
    pub(crate) fn light(&self) -> NearLight {
        let lengths = self.edges.map(length);
        let unit = |k: usize| self.edges[k].map(|x| x / lengths[k]);
        let (right, normal) = (unit(0), cross(unit(0), unit(1)));
        let size = length(normal);
        let normal = normal.map(|x| x / size);
        let single = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
        NearLight(Arc::new(Rectangle {
            corner: single(self.corner),
            axes: [single(right), single(cross(normal, right)), single(normal)],
            lengths: lengths.map(|x| x as f32),
            radiance: self.radiance.map(|x| x as f32),
        }))
    }
}

/// The light of a [`RectangleDocument`].
#[derive(Clone, Debug, PartialEq)]
struct Rectangle {
    corner: Vec3,
    /// Unit vectors along both edges, and the normal of the side that emits.
    axes: [Vec3; 3],
    /// World units.
    lengths: [f32; 2],
    /// Linear R, G, B.
    radiance: [f32; 3],
}

/// Where eight rays meet the plane of a rectangle from the side that emits.
struct Hits {
    /// Of the receivers: along both edges from the corner, above the plane.
    from: [f32x8; 3],
    /// Along the rays.
    distance: f32x8,
    /// Along both edges.
    place: [f32x8; 2],
    /// Cosine of the angle between the ray and the normal.
    cos: f32x8,
    /// All bits where a ray meets the rectangle.
    inside: f32x8,
}

impl Rectangle {
    /// Components along both edges and along the normal.
    #[inline(always)]
    fn local(&self, [x, y, z]: [f32x8; 3]) -> [f32x8; 3] {
        self.axes.map(|axis| x * axis.x + y * axis.y + z * axis.z)
    }

    #[inline(always)]
    fn relative_to_corner(&self, [x, y, z]: [f32x8; 3]) -> [f32x8; 3] {
        self.local([x - self.corner.x, y - self.corner.y, z - self.corner.z])
    }

    #[inline(always)]
    fn seen_from(&self, [x, y, height]: [f32x8; 3]) -> SeenRectangle {
        let [width, depth] = self.lengths;
        SeenRectangle::new(height, [-x, width - x], [-y, depth - y])
    }

    #[inline(always)]
    fn hits(&self, position: [f32x8; 3], direction: [f32x8; 3]) -> Hits {
        let from = self.relative_to_corner(position);
        let [along, across, up] = self.local(direction);
        let front = from[2].simd_gt(f32x8::ZERO) & up.simd_lt(f32x8::ZERO);
        let distance = from[2] / -up;
        let place = [from[0] + distance * along, from[1] + distance * across];
        let within = |k: usize| place[k].simd_ge(f32x8::ZERO) & place[k].simd_le(f32x8::splat(self.lengths[k]));
        Hits { from, distance, place, cos: -up, inside: front & within(0) & within(1) }
    }

    /// Directions to places on the rectangle.
    #[inline(always)]
    fn eight_samples(&self, position: [f32x8; 3], u: [f32x8; 2]) -> [f32x8; 3] {
        let from = self.relative_to_corner(position);
        let seen = self.seen_from(from);
        let solid_angle = seen.solid_angle();
        let by_angle = seen.place(solid_angle, u);
        let by_angle = [by_angle[0] + from[0], by_angle[1] + from[1]];
        let is_large = solid_angle.simd_ge(f32x8::splat(LEAST_SOLID_ANGLE));
        let mut local = [f32x8::ZERO, f32x8::ZERO, -from[2]];
        for k in 0..2 {
            let length = f32x8::splat(self.lengths[k]);
            let place = is_large.select(by_angle[k], u[k] * length);
            let offset = place - from[k];
            let distance = (offset * offset + from[2] * from[2]).sqrt();
            // seen at a grazing angle, rounding moves the place by the more
            let inset = (distance * distance / from[2].fast_max(f32x8::splat(f32::MIN_POSITIVE)) * INSET)
                .fast_min(length * 0.25);
            local[k] = place.fast_max(inset).fast_min(length - inset) - from[k];
        }
        let [right, upwards, normal] = self.axes;
        let inverse = 1.0 / (local[0] * local[0] + local[1] * local[1] + local[2] * local[2]).sqrt();
        // from behind and from the plane itself: along the normal, where there is nothing
        let front = from[2].simd_gt(f32x8::ZERO);
        std::array::from_fn(|axis| {
            let towards = local[0] * right[axis] + local[1] * upwards[axis] + local[2] * normal[axis];
            front.select(towards * inverse, f32x8::splat(normal[axis]))
        })
    }

    /// Density and distance.
    #[inline(always)]
    fn eight_densities(&self, position: [f32x8; 3], direction: [f32x8; 3]) -> [f32x8; 2] {
        let Hits { from, distance, cos, inside, .. } = self.hits(position, direction);
        if !inside.any() {
            return [f32x8::ZERO, f32x8::splat(f32::INFINITY)];
        }
        let solid_angle = self.seen_from(from).solid_angle();
        let of_area = distance * distance / (cos * (self.lengths[0] * self.lengths[1]));
        let is_large = solid_angle.simd_ge(f32x8::splat(LEAST_SOLID_ANGLE));
        let density = is_large.select(1.0 / solid_angle, of_area);
        [inside.select(density, f32x8::ZERO), inside.select(distance, f32x8::splat(f32::INFINITY))]
    }

    #[inline(always)]
    fn eight_bandwidths(&self, position: [f32x8; 3], direction: [f32x8; 3]) -> f32x8 {
        let Hits { distance, place, cos, inside, .. } = self.hits(position, direction);
        let [a, b] = [0, 1].map(|k| place[k].fast_min(self.lengths[k] - place[k]));
        let bandwidth = distance * EDGE_BANDWIDTH / (a.fast_min(b).fast_max(f32x8::ZERO) * cos);
        inside.select(bandwidth, f32x8::ZERO)
    }
}

impl Lighting for Rectangle {
    fn sample(&self, receivers: Receivers<'_>, [u, v]: [&[f32]; 2], directions: [&mut [f32]; 3]) {
        let [x, y, z] = receivers.position;
        by_eights([x, y, z, u, v], directions, |[x, y, z, u, v]| self.eight_samples([x, y, z], [u, v]));
    }

    fn evaluate(&self, receivers: Receivers<'_>, [i, j, k]: [&[f32]; 3], arriving: Arriving<'_>) {
        let [x, y, z] = receivers.position;
        let Arriving { radiance, density, distance } = arriving;
        by_eights([x, y, z, i, j, k], [density, &mut *distance], |[x, y, z, i, j, k]| {
            self.eight_densities([x, y, z], [i, j, k])
        });
        for (values, radiance) in radiance.into_iter().zip(self.radiance) {
            for (value, &distance) in values.iter_mut().zip(&*distance) {
                *value = if distance < f32::INFINITY { radiance } else { 0.0 };
            }
        }
    }

    /// `0.35 r / (x cos theta_y)`, r the distance to the light, x that of the place there to the nearest edge, theta_y the angle with
    /// its normal: above what a lobe passes where an edge lies inside the lobe. 0 beside the light.
    fn bandwidth(&self, receivers: Receivers<'_>, [i, j, k]: [&[f32]; 3], bandwidth: &mut [f32]) {
        let [x, y, z] = receivers.position;
        by_eights([x, y, z, i, j, k], [bandwidth], |[x, y, z, i, j, k]| [self.eight_bandwidths([x, y, z], [i, j, k])]);
    }

    fn seen(&self, eye: Vec3, direction: Vec3) -> Option<Seen> {
        let [right, upwards, normal] = &self.axes;
        let from = eye - self.corner;
        let (height, up) = (from.dot(normal), direction.dot(normal));
        let distance = -height / up;
        if !(distance > 0.0 && distance < f32::INFINITY) {
            return None;
        }
        let hit = from + direction * distance;
        let within = |axis: &Vec3, length: f32| (0.0..=length).contains(&hit.dot(axis));
        let radiance = if height > 0.0 { self.radiance } else { [0.0; 3] };
        (within(right, self.lengths[0]) && within(upwards, self.lengths[1])).then_some(Seen { distance, radiance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::{SIGNIFICANCE, independent, p_value};

    const BINS: usize = 12;
    /// Places along a side of a bin at which the density is summed.
    const FINE: usize = 16;

    /// 2 x 1 around the point (0, 0, 3), turned, emitting downwards.
    const CORNER: [f32; 3] = [-1.1, -0.2, 3.0];
    const ALONG: [[f32; 2]; 2] = [[0.8, 0.6], [0.6, -0.8]];

    fn rectangle() -> Arc<dyn Lighting> {
        let edge = |length: f64, k: usize| [ALONG[k][0], ALONG[k][1], 0.0].map(|x| f64::from(x) * length);
        let document = RectangleDocument {
            corner: CORNER.map(f64::from),
            edges: [edge(2.0, 0), edge(1.0, 1)],
            radiance: [3.0, 2.0, 1.0],
        };
        document.check(&Field::default()).unwrap();
        document.light().0
    }

    /// The point of the world at a place of the rectangle's frame: along both edges from the corner, and in front.
    fn world([x, y, height]: [f32; 3]) -> [f32; 3] {
        let at = |k: usize| CORNER[k] + ALONG[0][k] * x + ALONG[1][k] * y;
        [at(0), at(1), CORNER[2] - height]
    }

    /// Above the middle from near to far, beside, at a grazing angle; solid angles from nearly 2 pi to 1e-4.
    const RECEIVERS: [[f32; 3]; 9] = [
        [1.0, 0.5, 0.02],
        [1.0, 0.5, 0.5],
        [0.1, 0.9, 0.3],
        [1.0, 0.5, 4.0],
        [3.5, 0.5, 1.0],
        [2.2, -0.3, 0.05],
        [1.0, 0.5, 18.0],
        [6.0, 5.0, 0.4],
        [1.0, 0.5, 140.0],
    ];

    fn slices(lanes: &[[f32; 1]; 3]) -> [&[f32]; 3] {
        lanes.each_ref().map(|lane| lane.as_slice())
    }

    fn evaluate(light: &dyn Lighting, position: [f32; 3], direction: [f32; 3]) -> ([f32; 3], f32, f32) {
        let (position, direction) = (position.map(|x| [x]), direction.map(|x| [x]));
        let [mut r, mut g, mut b, mut density, mut distance] = [[0.0]; 5];
        let arriving = Arriving { radiance: [&mut r, &mut g, &mut b], density: &mut density, distance: &mut distance };
        light.evaluate(Receivers { position: slices(&position) }, slices(&direction), arriving);
        ([r[0], g[0], b[0]], density[0], distance[0])
    }

    fn sample(light: &dyn Lighting, position: [f32; 3], u: [f32; 2]) -> [f32; 3] {
        let position = position.map(|x| [x]);
        let [mut x, mut y, mut z] = [[0.0]; 3];
        let receivers = Receivers { position: slices(&position) };
        light.sample(receivers, [&[u[0]], &[u[1]]], [&mut x, &mut y, &mut z]);
        [x[0], y[0], z[0]]
    }

    /// Unit direction, and the solid angle per area times the distance squared.
    fn towards(from: [f32; 3], to: [f32; 3]) -> ([f32; 3], f64) {
        let d = Vec3::from(to).cast::<f64>() - Vec3::from(from).cast::<f64>();
        let r = d.norm();
        let d = d / r;
        (d.cast::<f32>().into(), d.z / (r * r))
    }

    #[test]
    fn samples_follow_the_density_which_integrates_to_one() {
        let light = rectangle();
        for place in RECEIVERS {
            let position = world(place);
            let (nx, ny) = (2 * BINS * FINE, BINS * FINE);
            let mut expected = vec![0.0; 2 * BINS * BINS];
            for k in 0..nx * ny {
                let (column, row) = (k % nx, k / nx);
                let at = [(column as f32 + 0.5) * 2.0 / nx as f32, (row as f32 + 0.5) / ny as f32];
                let (direction, angle) = towards(position, world([at[0], at[1], 0.0]));
                let (_, density, distance) = evaluate(light.as_ref(), position, direction);
                assert!(distance.is_finite(), "{place:?}: missed {at:?}");
                let bin = row / FINE * 2 * BINS + column / FINE;
                expected[bin] += f64::from(density) * angle * 2.0 / (nx * ny) as f64;
            }
            let integral: f64 = expected.iter().sum();
            // the midpoint rule; coarse where the receiver nearly touches the light
            let tolerance = if place[2] < 0.1 { 0.03 } else { 1e-3 };
            assert!((integral - 1.0).abs() < tolerance, "{place:?}: {integral}");
            if tolerance > 1e-3 {
                expected.iter_mut().for_each(|mass| *mass /= integral);
            }
            let draws = 100_000;
            let mut counts = vec![0; expected.len()];
            for n in 0..draws {
                let direction = sample(light.as_ref(), position, independent(n));
                let (radiance, density, distance) = evaluate(light.as_ref(), position, direction);
                assert!(radiance == [3.0, 2.0, 1.0] && density > 0.0, "{place:?}: {direction:?} misses the light");
                let hit = [0, 1].map(|k| position[k] + distance * direction[k] - CORNER[k]);
                let [column, row] = ALONG.map(|[a, b]| ((a * hit[0] + b * hit[1]) * BINS as f32) as usize);
                counts[row.min(BINS - 1) * 2 * BINS + column.min(2 * BINS - 1)] += 1;
            }
            let p = p_value(&counts, &expected, draws.into());
            assert!(p > SIGNIFICANCE, "{place:?}: p = {p}");
        }
    }

    #[test]
    fn nothing_arrives_behind_or_in_the_plane() {
        let light = rectangle();
        for height in [0.0, -1e-6, -0.5] {
            for (x, y) in [(1.0, 0.5), (4.0, 0.5), (2.0, 1.0), (0.0, 0.0)] {
                let position = world([x, y, height]);
                for n in 0..64 {
                    let drawn = sample(light.as_ref(), position, independent(n));
                    assert!((Vec3::from(drawn).norm() - 1.0).abs() < 1e-5);
                    let (to_light, _) = towards(position, world([1.3, 0.2, 0.0]));
                    for direction in [drawn, to_light, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]] {
                        let (radiance, density, distance) = evaluate(light.as_ref(), position, direction);
                        assert_eq!((radiance, density, distance), ([0.0; 3], 0.0, f32::INFINITY), "{position:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_camera_sees_the_front_and_a_black_back() {
        let light = rectangle();
        let eye = |height: f32| Vec3::from(world([1.0, 0.5, height]));
        assert_eq!(light.seen(eye(2.0), Vec3::z()), Some(Seen { distance: 2.0, radiance: [3.0, 2.0, 1.0] }));
        assert_eq!(light.seen(eye(-2.0), -Vec3::z()), Some(Seen { distance: 2.0, radiance: [0.0; 3] }));
        assert_eq!(light.seen(eye(2.0), -Vec3::z()), None);
        assert_eq!(light.seen(Vec3::from(world([2.1, 0.5, 2.0])), Vec3::z()), None);
        assert_eq!(light.seen(eye(0.0), Vec3::x()), None);
    }

    /// Where an edge lies within the lobe, the bandwidth is above what the lobe passes; it falls away from the edge.
    #[test]
    fn bandwidth_grows_towards_the_edges() {
        let light = rectangle();
        let position = world([1.0, 0.5, 2.0]);
        let at = |x: f32| {
            let direction = towards(position, world([x, 0.5, 0.0])).0.map(|x| [x]);
            let position = position.map(|x| [x]);
            let mut bandwidth = [0.0];
            light.bandwidth(Receivers { position: slices(&position) }, slices(&direction), &mut bandwidth);
            bandwidth[0]
        };
        // the middle: half a unit to the edge at a distance of 2
        assert!((at(1.0) - 0.35 * 2.0 / 0.5).abs() < 1e-4, "{}", at(1.0));
        assert!(at(1.9) > at(1.7) && at(1.999) > 500.0 && at(2.1) == 0.0);
    }
}
