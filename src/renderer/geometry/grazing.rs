//! Grazing views.

/// The cosine between the normal and the view counts as at least this: what divides by it stays finite at silhouettes
/// (docs/theory.md, section 11).
pub(crate) const LEAST_COSINE: f32 = 0.01;
