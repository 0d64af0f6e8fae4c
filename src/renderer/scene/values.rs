//! Checks of single values of a scene document.

use crate::scene::error::{Field, SceneError};

/// Largest number of any kind, and largest coordinate of any vertex: fourth powers stay finite in single precision.
pub(crate) const LARGEST_NUMBER: f64 = 1e9;
/// Smallest number that counts as a size or a scale above zero.
pub(crate) const SMALLEST_NUMBER: f64 = 1e-9;

pub(crate) fn wrong<T>(at: &Field, why: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::document(at, why))
}

pub(crate) fn finite(value: f64, at: &Field) -> Result<(), SceneError> {
    if value.abs() <= LARGEST_NUMBER {
        Ok(())
    } else {
        wrong(at, format!("{value:e} is not within -{LARGEST_NUMBER:e} to {LARGEST_NUMBER:e}"))
    }
}

pub(crate) fn finite3(values: [f64; 3], at: &Field) -> Result<(), SceneError> {
    values.iter().enumerate().try_for_each(|(index, &value)| finite(value, &at.element(index)))
}

pub(crate) fn positive(value: f64, at: &Field) -> Result<(), SceneError> {
    finite(value, at)?;
    if value >= SMALLEST_NUMBER { Ok(()) } else { wrong(at, format!("{value} is not at least {SMALLEST_NUMBER:e}")) }
}

pub(crate) fn range(value: f64, from: f64, to: f64, at: &Field) -> Result<(), SceneError> {
    if (from..=to).contains(&value) { Ok(()) } else { wrong(at, format!("{value} is not in {from} to {to}")) }
}

pub(crate) fn colour(values: [f64; 3], at: &Field) -> Result<(), SceneError> {
    values.iter().enumerate().try_for_each(|(index, &value)| range(value, 0.0, 1e6, &at.element(index)))
}

/// A name that is not empty and has one of `extensions`, if there are any.
pub(crate) fn file_name(name: &str, extensions: &[&str], at: &Field) -> Result<(), SceneError> {
    if name.is_empty() {
        return wrong(at, "is empty");
    }
    let extension = extension(name);
    if extensions.is_empty() || extensions.contains(&extension.as_str()) {
        Ok(())
    } else {
        wrong(at, format!("{name:?} does not end in .{}", extensions.join(" or .")))
    }
}

/// The extension of a file name in lower case.
pub(crate) fn extension(name: &str) -> String {
    std::path::Path::new(name).extension().map(|text| text.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

pub(crate) fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
