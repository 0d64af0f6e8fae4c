//! Batched evaluation for fixed outgoing directions, for precomputation over whole lobes.

use crate::math::direction::Direction;

/// Unit vectors in single precision, one array per component.
#[derive(Clone, Debug, Default)]
pub struct Directions {
    /// Components along x.
    pub x: Vec<f32>,
    /// Components along y.
    pub y: Vec<f32>,
    /// Components along the normal.
    pub z: Vec<f32>,
}

impl Directions {
    /// Number of directions.
    pub fn len(&self) -> usize {
        self.z.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.z.is_empty()
    }

    /// The direction at an index, in double precision and of length one again.
    ///
    /// # Panics
    /// If there is no such index.
    pub fn get(&self, index: usize) -> Direction {
        Direction::new(f64::from(self.x[index]), f64::from(self.y[index]), f64::from(self.z[index])).normalize()
    }
}

impl FromIterator<Direction> for Directions {
    fn from_iter<I: IntoIterator<Item = Direction>>(directions: I) -> Self {
        let mut all = Self::default();
        for direction in directions {
            all.x.push(direction.x as f32);
            all.y.push(direction.y as f32);
            all.z.push(direction.z as f32);
        }
        all
    }
}

/// A BRDF made ready for one set of outgoing directions: see [`crate::Brdf::towards`].
pub trait FixedOutgoing: Send + Sync {
    /// Writes `f(i, o)` in 1/sr of the three channels for the directions `first`, `first + 1`, .. into slices of equal length.
    ///
    /// # Panics
    /// If the slices differ in length or reach past the last direction.
    fn values(&self, i: &Direction, first: usize, values: [&mut [f32]; 3]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brdf::{Brdf, Lambert};
    use crate::math::direction::direction;

    #[test]
    fn any_model_is_evaluated_one_by_one() {
        let model = Lambert { albedo: [0.1, 0.2, 0.4] };
        let o: Directions = [0.1, 0.8, 2.0].map(|theta| direction(theta, 0.3)).into_iter().collect();
        let (mut r, mut g, mut b) = ([9.0; 2], [9.0; 2], [9.0; 2]);
        model.towards(&o).values(&direction(0.5, 0.0), 1, [&mut r, &mut g, &mut b]);
        assert_eq!((r[1], g[1], b[1]), (0.0, 0.0, 0.0));
        assert_eq!(b[0], (0.4 / std::f64::consts::PI) as f32);
    }
}
