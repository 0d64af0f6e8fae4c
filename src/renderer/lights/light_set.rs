//! All lights of a scene, and the division of samples among them.

use std::sync::Arc;

use crate::geometry::vec3::Vec3;
use crate::lights::bandwidth::LightBandwidth;
use crate::lights::environment::Environment;
use crate::lights::lighting::{Lighting, Receivers, Seen};
use crate::lights::octahedral::light::Light;

/// The lights of a scene: an environment or none, and any number of lights at a finite distance. Their radiances add up.
#[derive(Clone, Debug, Default)]
pub struct LightSet {
    environment: Option<Arc<Environment>>,
    near: Vec<Arc<dyn Lighting>>,
}

/// A light at a finite distance, as a scene's document describes it.
#[derive(Clone, Debug)]
pub struct NearLight(pub(crate) Arc<dyn Lighting>);

/// Filtering of light look-ups.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LookUp {
    /// Unfiltered: the estimate is unbiased.
    Exact,
    /// Those that have averages over cones by these, at the size of what one sample stands for (filtered importance sampling).
    Filtered,
}

/// The samples of a point, of all techniques together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Samples {
    /// Number of samples to divide.
    pub(crate) total: u32,
    pub(crate) look_up: LookUp,
    /// No light that is drawn from takes fewer, which may add some to the total.
    pub(crate) least_per_light: u32,
}

impl From<Light> for LightSet {
    /// An environment alone.
    fn from(light: Light) -> Self {
        Self::new(Some(light), Vec::new())
    }
}

impl LightSet {
    /// The set of an environment or none and any number of near lights; analyses the bandwidth of the environment.
    #[must_use]
    pub fn new(environment: Option<Light>, near: Vec<NearLight>) -> Self {
        Self {
            environment: environment.map(|light| Arc::new(Environment::new(light))),
            near: near.into_iter().map(|light| light.0).collect(),
        }
    }

    /// The image of the environment and its bandwidth, where there is one.
    #[must_use]
    pub fn environment(&self) -> Option<(&Light, &LightBandwidth)> {
        self.environment.as_deref().map(|environment| (&environment.light, &environment.bandwidth))
    }

    /// Radiance along a camera ray that meets no surface: the nearest light at a finite distance, else, `with_environment`, the
    /// environment. `None` where there is neither.
    #[must_use]
    pub fn seen(&self, eye: Vec3, direction: Vec3, with_environment: bool) -> Option<[f32; 3]> {
        let distant = || self.environment.as_ref().filter(|_| with_environment)?.seen(eye, direction);
        self.nearest(eye, direction).or_else(distant).map(|seen| seen.radiance)
    }

    /// The nearest light at a finite distance that a ray of the camera meets.
    pub(crate) fn nearest(&self, eye: Vec3, direction: Vec3) -> Option<Seen> {
        let seen = self.near.iter().filter_map(|light| light.seen(eye, direction));
        seen.reduce(|nearest, other| if other.distance < nearest.distance { other } else { nearest })
    }

    /// The largest bandwidth of all lights for one receiver and direction, cycles per radian.
    pub(crate) fn bandwidth(&self, position: Vec3, direction: Vec3) -> f32 {
        let lanes = |v: &Vec3| [[v.x], [v.y], [v.z]];
        let (position, direction) = (lanes(&position), lanes(&direction));
        let receivers = Receivers { position: slices(&position) };
        let of = |light: &dyn Lighting| {
            let mut bandwidth = [0.0];
            light.bandwidth(receivers, slices(&direction), &mut bandwidth);
            bandwidth[0]
        };
        self.iter().map(of).fold(0.0, f32::max)
    }

    /// The lights in the order of their techniques: the environment, then the others as they were given.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &dyn Lighting> {
        let environment = self.environment.iter().map(|light| light.as_ref() as &dyn Lighting);
        environment.chain(self.near.iter().map(AsRef::as_ref))
    }

    /// Techniques of sampling: the BRDF, then one per light.
    pub(crate) fn techniques(&self) -> usize {
        1 + self.iter().count()
    }

    /// Number of samples of a technique: the BRDF half of them, rounded up; the lights that are drawn from share the rest, even up to
    /// one, those ahead first. A light that is looked up by averages is not drawn from, and leaves its share to the BRDF.
    pub(crate) fn count(&self, technique: usize, samples: Samples) -> u32 {
        let lights = self.iter().count() as u32;
        let of_lights = samples.total / 2;
        let share = |light: u32| of_lights / lights + u32::from(light < of_lights % lights);
        let drawn = |light: &dyn Lighting| samples.look_up == LookUp::Exact || light.prefiltered().is_none();
        match technique {
            0 => {
                let left = (0..).zip(self.iter()).filter(|(_, light)| !drawn(*light)).map(|(n, _)| share(n));
                samples.total - if lights == 0 { 0 } else { of_lights - left.sum::<u32>() }
            }
            _ => match self.iter().nth(technique - 1) {
                Some(light) if drawn(light) => share(technique as u32 - 1).max(samples.least_per_light),
                _ => 0,
            },
        }
    }

    /// The samples of all techniques together.
    pub(crate) fn total(&self, samples: Samples) -> u32 {
        (0..self.techniques()).map(|technique| self.count(technique, samples)).sum()
    }
}

fn slices(lanes: &[[f32; 1]; 3]) -> [&[f32]; 3] {
    lanes.each_ref().map(|lane| lane.as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::document::LightDocument;

    fn lamps(count: usize) -> Vec<NearLight> {
        let json = r#"{"rect": {"corner": [0, 0, 1], "edges": [[1, 0, 0], [0, 1, 0]], "radiance": [1, 1, 1]}}"#;
        let document: LightDocument = serde_json::from_str(json).unwrap();
        (0..count).map(|_| document.near().unwrap()).collect()
    }

    fn sky() -> Light {
        Light::from_fn(16, |_| [1.0; 3]).unwrap()
    }

    fn counts(lights: &LightSet, total: u32, look_up: LookUp, least_per_light: u32) -> Vec<u32> {
        let samples = Samples { total, look_up, least_per_light };
        let counts: Vec<u32> = (0..lights.techniques()).map(|technique| lights.count(technique, samples)).collect();
        assert_eq!(counts.iter().sum::<u32>(), lights.total(samples));
        counts
    }

    #[test]
    fn half_goes_to_the_brdf_and_the_lights_share_the_rest() {
        let alone = LightSet::from(sky());
        for (total, exact) in [(1, [1, 0]), (4, [2, 2]), (7, [4, 3]), (16, [8, 8])] {
            assert_eq!(counts(&alone, total, LookUp::Exact, 0), exact);
            assert_eq!(counts(&alone, total, LookUp::Filtered, 0), [total, 0]);
        }
        let three = LightSet::new(Some(sky()), lamps(2));
        assert_eq!(counts(&three, 16, LookUp::Exact, 0), [8, 3, 3, 2]);
        assert_eq!(counts(&three, 5, LookUp::Exact, 0), [3, 1, 1, 0]);
        // the environment leaves its share to the BRDF, the lamps keep theirs
        assert_eq!(counts(&three, 16, LookUp::Filtered, 0), [11, 0, 3, 2]);
        // without averages there is nothing to look up otherwise
        let lamps_alone = LightSet::new(None, lamps(2));
        assert_eq!(counts(&lamps_alone, 9, LookUp::Filtered, 0), counts(&lamps_alone, 9, LookUp::Exact, 0));
        assert_eq!(counts(&LightSet::default(), 9, LookUp::Exact, 0), [9]);
    }

    #[test]
    fn the_pilot_knows_a_variance_of_every_light() {
        let many = LightSet::new(Some(sky()), lamps(9));
        assert!(counts(&many, 16, LookUp::Exact, 2).iter().all(|&count| count >= 2));
        // with one light the least is what there is anyway
        let alone = LightSet::from(sky());
        for total in 4..40 {
            assert_eq!(counts(&alone, total, LookUp::Exact, 2), counts(&alone, total, LookUp::Exact, 0));
        }
    }
}
