//! Built-in lights, functions of the direction: no file is needed for tests and demonstrations.

use crate::geometry::vec3::Vec3;
use crate::lights::octahedral::light::Light;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The built-in lights. Radiance is of the order of 1; no feature is finer than the texels of a 512 x 512 light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Procedural {
    /// A blue sky with soft clouds, a sun of 3 degrees radius at 40 degrees above the horizon, and earth below.
    Sky,
    /// A dim room with four softboxes.
    Studio,
    /// A dark room with thin bright strip lights.
    Strips,
    /// Radiance 1 from all directions.
    Uniform,
}

impl Procedural {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Sky, Self::Studio, Self::Strips, Self::Uniform];

    /// Radiance from a unit direction, linear RGB.
    pub fn radiance(self, d: Vec3) -> [f32; 3] {
        match self {
            Self::Sky => sky(d),
            Self::Studio => studio(d),
            Self::Strips => strips(d),
            Self::Uniform => [1.0; 3],
        }
    }

    /// The light with `n x n` texels.
    ///
    /// # Panics
    /// If `n` is not a power of two from 4 to [`Light::LARGEST_SIZE`].
    pub fn light(self, n: usize) -> Light {
        Light::from_fn(n, |d| self.radiance(d)).expect("radiance is finite and not negative")
    }
}

/// The direction to the sun of [`Procedural::Sky`].
fn sun() -> Vec3 {
    towards(40.0, -50.0)
}

fn sky(d: Vec3) -> [f32; 3] {
    let horizon = [0.80, 0.88, 0.98];
    let zenith = [0.16, 0.33, 0.78];
    let to_sun = d.dot(&sun()).clamp(-1.0, 1.0);
    let height = d.z.max(0.0);
    let mut above = mix(horizon, zenith, libm::powf(height, 0.45));
    let cover = clouds(d) * smooth(0.04, 0.25, height);
    let lit = 1.05 + 0.5 * libm::powf(to_sun.max(0.0), 8.0);
    above = mix(above, [lit, 0.98 * lit, 0.95 * lit], cover);
    let angle = libm::acosf(to_sun).to_degrees();
    let halo = 1.2 * libm::expf(-angle / 9.0) + 0.35 * libm::expf(-angle / 30.0);
    let disc = 110.0 * (1.0 - smooth(2.6, 3.4, angle));
    above = add(above, [1.0, 0.90, 0.72], halo);
    above = add(above, [1.0, 0.93, 0.80], disc);
    let ground = mix([0.34, 0.31, 0.27], [0.17, 0.15, 0.12], smooth(0.0, 0.7, -d.z));
    mix(ground, above, smooth(-0.025, 0.025, d.z))
}

fn studio(d: Vec3) -> [f32; 3] {
    let room = mix([0.05, 0.048, 0.045], [0.15, 0.155, 0.17], smooth(-0.9, 0.9, d.z));
    let boxes = [
        // a large warm key light, a cool fill light, one overhead and a rim light
        (towards(42.0, -35.0), [0.42, 0.32], [9.0, 8.3, 7.2]),
        (towards(22.0, 68.0), [0.20, 0.50], [2.6, 3.0, 3.6]),
        (towards(86.0, 10.0), [0.35, 0.35], [3.2, 3.2, 3.2]),
        (towards(28.0, 178.0), [0.55, 0.10], [7.5, 7.8, 8.4]),
    ];
    boxes.into_iter().fold(room, |sum, (centre, half, colour)| add(sum, colour, rectangle(d, centre, half, 0.0, 0.06)))
}

fn strips(d: Vec3) -> [f32; 3] {
    let room = [0.020, 0.021, 0.024];
    let lights = [
        (towards(35.0, -60.0), [0.022, 0.70], 0.0, [34.0, 31.0, 27.0]),
        (towards(35.0, -42.0), [0.022, 0.70], 0.0, [34.0, 31.0, 27.0]),
        (towards(48.0, 25.0), [0.60, 0.020], 0.35, [26.0, 28.0, 31.0]),
        (towards(20.0, 80.0), [0.018, 0.55], -0.5, [30.0, 32.0, 36.0]),
        (towards(62.0, 150.0), [0.55, 0.022], 0.0, [27.0, 27.0, 27.0]),
        (towards(25.0, -135.0), [0.020, 0.60], 0.3, [36.0, 32.0, 26.0]),
    ];
    lights
        .into_iter()
        .fold(room, |sum, (centre, half, turn, colour)| add(sum, colour, rectangle(d, centre, half, turn, 0.008)))
}

/// The direction at an elevation above the horizon and an azimuth from +x towards +y, degrees.
fn towards(elevation: f32, azimuth: f32) -> Vec3 {
    let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
    let flat = libm::cosf(elevation);
    Vec3::new(flat * libm::cosf(azimuth), flat * libm::sinf(azimuth), libm::sinf(elevation))
}

/// 1 inside of a rectangle on the plane at distance 1 along `centre`, 0 outside, over an edge of a width: half sizes along the
/// horizon and upwards, turned by an angle in its plane.
fn rectangle(d: Vec3, centre: Vec3, half: [f32; 2], turn: f32, edge: f32) -> f32 {
    let depth = d.dot(&centre);
    if depth <= 0.0 {
        return 0.0;
    }
    let along = Vec3::z().cross(&centre).normalize();
    let upwards = centre.cross(&along);
    let (x, y) = (d.dot(&along) / depth, d.dot(&upwards) / depth);
    let (sin, cos) = (libm::sinf(turn), libm::cosf(turn));
    let inside = |x: f32, half: f32| 1.0 - smooth(half - 0.5 * edge, half + 0.5 * edge, x.abs());
    inside(cos * x + sin * y, half[0]) * inside(cos * y - sin * x, half[1])
}

/// Cover of the sky by clouds in [0, 1]: noise on a plane overhead.
fn clouds(d: Vec3) -> f32 {
    if d.z <= 0.02 {
        return 0.0;
    }
    let (x, y) = (1.6 * d.x / (d.z + 0.15), 1.6 * d.y / (d.z + 0.15));
    let octaves = [(1.0, 0.5), (2.1, 0.27), (4.3, 0.15), (8.9, 0.08)];
    let sum: f32 = octaves.into_iter().map(|(scale, weight)| weight * noise(x * scale, y * scale)).sum();
    0.9 * smooth(0.48, 0.80, sum)
}

/// Smooth noise in [0, 1] with one random value at each point of the integer grid.
fn noise(x: f32, y: f32) -> f32 {
    let (column, row) = (x.floor(), y.floor());
    let at = |x: f32, y: f32| {
        let hash = crate::geometry::sobol::seed([(column + x) as i32 as u32, (row + y) as i32 as u32], 0, 0);
        (hash >> 8) as f32 / 16_777_216.0
    };
    let [s, t] = [x - column, y - row].map(|x| x * x * x * (x * (x * 6.0 - 15.0) + 10.0));
    let [upper, lower] = [0.0, 1.0].map(|y| at(0.0, y) + (at(1.0, y) - at(0.0, y)) * s);
    upper + (lower - upper) * t
}

/// 0 below, 1 above, a smooth cubic step between.
fn smooth(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn mix(a: [f32; 3], b: [f32; 3], t: f32) -> [f32; 3] {
    std::array::from_fn(|k| a[k] + (b[k] - a[k]) * t)
}

fn add(a: [f32; 3], b: [f32; 3], weight: f32) -> [f32; 3] {
    std::array::from_fn(|k| a[k] + b[k] * weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light that arrives, over pi: what a white diffuse surface that faces upwards shows.
    fn from_above(light: &Light) -> f64 {
        let n = light.size();
        let term = |k: usize| {
            let d =
                crate::geometry::octahedral::square_to_direction([k % n, k / n].map(|x| (x as f32 + 0.5) / n as f32));
            f64::from(light.texel(0, k % n, k / n)[1] * d.z.max(0.0) * light.solid_angle(d))
        };
        (0..n * n).map(term).sum::<f64>() / std::f64::consts::PI
    }

    #[test]
    fn lights_are_of_moderate_strength() {
        for (kind, low, high) in [
            (Procedural::Sky, 0.5, 2.5),
            (Procedural::Studio, 0.4, 2.5),
            (Procedural::Strips, 0.2, 2.5),
            (Procedural::Uniform, 0.999, 1.001),
        ] {
            let shown = from_above(&kind.light(256));
            assert!((low..high).contains(&shown), "{kind:?}: {shown}");
        }
    }

    #[test]
    fn the_sun_is_where_it_is_said() {
        assert!(sky(sun())[1] > 100.0);
        let aside = (sun() + Vec3::z() * 0.1).normalize();
        assert!(sky(aside)[1] < 5.0);
    }

    #[test]
    fn names_are_lower_case() {
        let name = |kind: Procedural| serde_json::to_string(&kind).expect("a name");
        assert_eq!(Procedural::ALL.map(name), ["\"sky\"", "\"studio\"", "\"strips\"", "\"uniform\""]);
    }
}
