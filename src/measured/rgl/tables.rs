//! The tables of an isotropic material with three colour channels, each checked.

use std::f64::consts::FRAC_PI_2;

use crate::error::Reason;
use crate::grid::dimensions::CHANNELS;
use crate::rgl::container::{Field, TensorFile};
use crate::rgl::warp::{Grids, Warp};

/// Rounding of pi/2 to single precision.
const SLACK: f64 = 1e-6;

/// Content of a file.
#[derive(Clone, Debug)]
pub(crate) struct Tables {
    /// Measured angles of i with the normal, radians, increasing.
    pub(crate) theta_i: Vec<f64>,
    /// Distribution of the half vectors over (u(theta_m), u(phi_m)).
    pub(crate) ndf: Grids,
    /// Projected area of the microfacets over (u(theta_i), u(phi_i)).
    pub(crate) sigma: Grids,
    /// Distribution of the half vectors that i sees, one per theta_i.
    pub(crate) vndf: Warp,
    /// Luminance over the uniform numbers of `vndf`, one per theta_i.
    pub(crate) luminance: Warp,
    /// Colour over the uniform numbers of `vndf`: slice `3 theta_i + channel`.
    pub(crate) rgb: Grids,
    /// Whether `rgb` is to be multiplied by `ndf / (4 sigma)`.
    pub(crate) jacobian: bool,
    /// The description of the material in the file.
    pub(crate) description: String,
}

impl Tables {
    /// # Errors
    /// [`Reason::Unsupported`] for spectral and anisotropic files, [`Reason::Field`] for a field that is missing or wrong.
    pub(crate) fn new(file: &TensorFile<'_>) -> Result<Self, Reason> {
        refuse_spectra(file)?;
        refuse_anisotropy(file)?;
        let theta_i = theta_i(file)?;
        let slices = [1, theta_i.len()];
        let area = plane(file, "sigma", &[], true)?;
        let rgb = plane(file, "rgb", &[slices[0], slices[1], CHANNELS], false)?;
        let luminance = need(file, "luminance")?;
        let colours = need(file, "rgb")?;
        if luminance.shape.iter().rev().take(2).ne(colours.shape.iter().rev().take(2)) {
            let fault = format!(
                "shape {:?} does not go with {:?} of rgb; fetch the file again",
                luminance.shape, colours.shape
            );
            return Err(luminance.wrong(&fault));
        }
        Ok(Self {
            ndf: plane(file, "ndf", &[], true)?,
            sigma: area,
            vndf: density(file, "vndf", &slices)?,
            luminance: density(file, "luminance", &slices)?,
            rgb,
            jacobian: jacobian(file)?,
            description: description(file)?,
            theta_i,
        })
    }
}

/// A field that must be there.
fn need<'a, 'b>(file: &'b TensorFile<'a>, name: &str) -> Result<&'b Field<'a>, Reason> {
    file.find(name).ok_or_else(|| Reason::Field {
        name: name.to_owned(),
        fault: "is missing; check that it is an isotropic RGL file with colours".to_owned(),
    })
}

fn refuse_spectra(file: &TensorFile<'_>) -> Result<(), Reason> {
    if file.find("rgb").is_none() && (file.find("spectra").is_some() || file.find("wavelengths").is_some()) {
        let what = "holds spectra, not three colour channels".to_owned();
        return Err(Reason::Unsupported { what, advice: "take the file of the same material that ends in _rgb.bsdf" });
    }
    Ok(())
}

fn refuse_anisotropy(file: &TensorFile<'_>) -> Result<(), Reason> {
    let phi_i = need(file, "phi_i")?;
    numbers(phi_i, &|_| true, "")?;
    match phi_i.shape[..] {
        [1] => Ok(()),
        [count] if count > 1 => {
            let what = format!("holds an anisotropic material ({count} azimuths phi_i)");
            Err(Reason::Unsupported { what, advice: "brdfit takes isotropic materials only; choose another file" })
        }
        _ => Err(phi_i.wrong(&format!("shape {:?}, not [1]; fetch the file again", phi_i.shape))),
    }
}

fn theta_i(file: &TensorFile<'_>) -> Result<Vec<f64>, Reason> {
    let field = need(file, "theta_i")?;
    if !matches!(field.shape[..], [count] if count >= 2) {
        return Err(
            field.wrong(&format!("shape {:?}, not a list of two or more angles; fetch the file again", field.shape))
        );
    }
    let angles: Vec<f64> = numbers(field, &|angle| angle >= 0.0, "negative")?.into_iter().map(f64::from).collect();
    if !angles.is_sorted_by(|a, b| a < b) || angles.iter().any(|&angle| angle > FRAC_PI_2 + SLACK) {
        return Err(field.wrong("not increasing from 0 to pi/2; fetch the file again"));
    }
    Ok(angles)
}

/// The numbers of a field: finite, and `allowed`; what is not is `not_allowed`.
fn numbers(field: &Field<'_>, allowed: &dyn Fn(f32) -> bool, not_allowed: &str) -> Result<Vec<f32>, Reason> {
    let values: Vec<f32> = field.floats()?.collect();
    if let Some(n) = values.iter().position(|value| !value.is_finite()) {
        return Err(field.wrong(&format!("entry {n} is {}, not a finite number; fetch the file again", values[n])));
    }
    match values.iter().position(|&value| !allowed(value)) {
        None => Ok(values),
        Some(n) => Err(field.wrong(&format!("entry {n} is {not_allowed}: {}; fetch the file again", values[n]))),
    }
}

/// Grids of at least 2 x 2 nodes, as many as the outer axes `outer` say, not negative where `positive`.
fn plane(file: &TensorFile<'_>, name: &str, outer: &[usize], positive: bool) -> Result<Grids, Reason> {
    let field = need(file, name)?;
    match field.shape.split_last_chunk::<2>() {
        Some((found, &size)) if found == outer && size.iter().all(|&nodes| nodes >= 2) => {
            Ok(Grids::new(size, numbers(field, &|value| !positive || value >= 0.0, "negative")?))
        }
        _ => {
            let outer: String = outer.iter().map(|count| format!("{count}, ")).collect();
            let fault =
                format!("shape {:?}, not [{outer}rows, columns] of two or more; fetch the file again", field.shape);
            Err(field.wrong(&fault))
        }
    }
}

fn density(file: &TensorFile<'_>, name: &str, outer: &[usize]) -> Result<Warp, Reason> {
    let grids = plane(file, name, outer, true)?;
    Warp::new(grids).ok_or_else(|| Reason::Field {
        name: name.to_owned(),
        fault: "is zero for one of theta_i; fetch the file again".to_owned(),
    })
}

fn jacobian(file: &TensorFile<'_>) -> Result<bool, Reason> {
    let field = need(file, "jacobian")?;
    match field.bytes()? {
        &[flag @ (0 | 1)] => Ok(flag == 1),
        _ => Err(field.wrong("is not a single 0 or 1; fetch the file again")),
    }
}

/// One line of text.
fn description(file: &TensorFile<'_>) -> Result<String, Reason> {
    let Some(field) = file.find("description") else { return Ok(String::new()) };
    let text = String::from_utf8_lossy(field.bytes()?).replace(char::is_control, " ");
    Ok(text.trim().to_owned())
}
