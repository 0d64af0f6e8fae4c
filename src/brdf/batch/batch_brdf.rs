//! Batched BRDFs for renderers: evaluation, density and sampling of many pairs of directions.

/// A BRDF for shading: see [`crate::Brdf::batch`].
///
/// Directions are unit vectors of the local frame (normal +z), one array per component, rounded to single precision and taken
/// as they are. Every entry is independent of the others and may belong to another shading point. The direction o towards the eye
/// is known, the direction i towards the light is drawn; the crate's documentation has the contract of the random numbers.
pub trait BatchBrdf: Send + Sync {
    /// Draws a direction i for each o from two numbers in [0, 1), choice and azimuth; a draw that ends below the horizon has
    /// z <= 0 and counts as a sample of value zero.
    ///
    /// # Panics
    /// If the arrays differ in length.
    fn sample(&self, o: [&[f32]; 3], u: [&[f32]; 2], i: [&mut [f32]; 3]);

    /// `f(i, o)` in 1/sr per channel and the density in 1/sr with which [`BatchBrdf::sample`] draws i for o; zeros where either is
    /// at or below the horizon.
    ///
    /// # Panics
    /// If the arrays differ in length.
    fn evaluate(&self, i: [&[f32]; 3], o: [&[f32]; 3], values: [&mut [f32]; 3], density: &mut [f32]);
}
