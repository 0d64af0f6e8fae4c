//! What must hold for the values of a scene document, beyond their types.

use crate::scene::document::{
    AlbedoDocument, CameraDocument, LightDocument, MaterialSource, MeshDocument, ObjectDocument, SceneDocument,
    SceneMaterial,
};
use crate::scene::error::{Field, SceneError};
use brdfit_brdf::Ggx;

/// Largest width and height of an image, pixels.
const LARGEST_IMAGE: usize = 16384;
/// Largest number of any kind, and largest coordinate of any vertex: fourth powers stay finite in single precision.
pub(crate) const LARGEST_NUMBER: f64 = 1e9;
/// Smallest number that counts as a size or a scale above zero.
const SMALLEST_NUMBER: f64 = 1e-9;
/// Sine of the smallest angle between the view and up.
const PARALLEL: f64 = 1e-5;
/// Most turns of a knot.
const MOST_TURNS: u32 = 16;
/// Largest frequency of the finest octave: a tessellation resolves it.
const FINEST_FREQUENCY: f64 = 32.0;

/// Checks every value of `document`.
///
/// # Errors
/// The first value that is wrong, in the order of the document's members.
pub(crate) fn check(document: &SceneDocument) -> Result<(), SceneError> {
    let root = Field::default();
    check_camera(&document.camera, &root.member("camera"))?;
    check_light(&document.light, &root.member("light"))?;
    let materials = root.member("materials");
    if document.materials.len() >= usize::from(u16::MAX) {
        return wrong(&materials, format!("{} materials; at most {} fit", document.materials.len(), u16::MAX - 1));
    }
    for (name, material) in &document.materials {
        check_material(material, &materials.member(name))?;
    }
    let objects = root.member("objects");
    if document.objects.is_empty() {
        return wrong(&objects, "there is nothing to see; add an object");
    }
    for (index, object) in document.objects.iter().enumerate() {
        check_object(object, document, &objects.element(index))?;
    }
    Ok(())
}

fn check_camera(camera: &CameraDocument, at: &Field) -> Result<(), SceneError> {
    finite3(camera.eye, &at.member("eye"))?;
    finite3(camera.target, &at.member("target"))?;
    finite3(camera.up, &at.member("up"))?;
    let view = std::array::from_fn(|axis| camera.target[axis] - camera.eye[axis]);
    if length(view) <= SMALLEST_NUMBER.max(1e-6 * length(camera.eye)) {
        return wrong(&at.member("target"), "is where the eye is; the camera looks nowhere");
    }
    if length(camera.up) <= SMALLEST_NUMBER {
        return wrong(&at.member("up"), "has no length");
    }
    if length(cross(view, camera.up)) <= PARALLEL * length(view) * length(camera.up) {
        return wrong(&at.member("up"), "is parallel to the view from eye to target");
    }
    range(camera.vertical_fov, 0.01, 170.0, &at.member("vertical_fov"))?;
    for (name, size) in [("width", camera.width), ("height", camera.height)] {
        if !(1..=LARGEST_IMAGE).contains(&size) {
            return wrong(&at.member(name), format!("{size} is not in 1 to {LARGEST_IMAGE}"));
        }
    }
    Ok(())
}

fn check_light(light: &LightDocument, at: &Field) -> Result<(), SceneError> {
    let (at, rotation, scale) = match light {
        LightDocument::Environment { file, rotation, scale } => {
            let at = at.member("environment");
            file_name(file, &["exr", "hdr"], &at.member("file"))?;
            (at, *rotation, *scale)
        }
        LightDocument::Procedural { rotation, scale, .. } => (at.member("procedural"), *rotation, *scale),
    };
    finite(rotation, &at.member("rotation"))?;
    positive(scale, &at.member("scale"))
}

fn check_material(material: &SceneMaterial, at: &Field) -> Result<(), SceneError> {
    let source = at.member("source");
    match &material.source {
        MaterialSource::Fit(file) => file_name(file, &["json"], &source.member("fit"))?,
        MaterialSource::Measured { file, .. } => file_name(file, &[], &source.member("measured").member("file"))?,
        MaterialSource::Embedded(name) => file_name(name, &[], &source.member("embedded"))?,
        MaterialSource::Lambert(albedo) => {
            for (channel, &value) in albedo.iter().enumerate() {
                range(value, 0.0, 1.0, &source.member("lambert").element(channel))?;
            }
        }
        MaterialSource::Ggx { rho_d, rho_s, alpha } => {
            let source = source.member("ggx");
            colour(*rho_d, &source.member("rho_d"))?;
            colour(*rho_s, &source.member("rho_s"))?;
            let [least, most] = Ggx::ALPHA_RANGE;
            range(*alpha, least, most, &source.member("alpha"))?;
        }
    }
    if let Some(atlas) = &material.atlas {
        file_name(atlas, &["ktx2", "exr"], &at.member("atlas"))?;
    }
    let at = at.member("albedo");
    match &material.albedo {
        None => Ok(()),
        Some(AlbedoDocument::Texture { file, scale }) => {
            let at = at.member("texture");
            file_name(file, &["png"], &at.member("file"))?;
            positive(*scale, &at.member("scale"))
        }
        Some(AlbedoDocument::Checker { colors, scale }) => {
            let at = at.member("checker");
            for (index, &color) in colors.iter().enumerate() {
                colour(color, &at.member("colors").element(index))?;
            }
            positive(*scale, &at.member("scale"))
        }
        Some(AlbedoDocument::Constant(color)) => colour(*color, &at.member("constant")),
    }
}

fn check_object(object: &ObjectDocument, document: &SceneDocument, at: &Field) -> Result<(), SceneError> {
    check_mesh(&object.mesh, &at.member("mesh"))?;
    if !document.materials.contains_key(&object.material) {
        let names: Vec<&str> = document.materials.keys().map(String::as_str).collect();
        let there = match names.as_slice() {
            [] => "there are no materials".to_owned(),
            [name] => format!("the only material is {name}"),
            names => format!("the materials are {}", names.join(", ")),
        };
        return wrong(&at.member("material"), format!("no material {:?}; {there}", object.material));
    }
    positive(object.scale, &at.member("scale"))?;
    finite3(object.rotate, &at.member("rotate"))?;
    finite3(object.translate, &at.member("translate"))
}

fn check_mesh(mesh: &MeshDocument, at: &Field) -> Result<(), SceneError> {
    match mesh {
        MeshDocument::Sphere { radius } => positive(*radius, &at.member("sphere").member("radius")),
        MeshDocument::Torus { radius, tube } => tube_within(*radius, *tube, 1.0, &at.member("torus")),
        MeshDocument::TorusKnot { p, q, radius, tube } => {
            let at = at.member("torus_knot");
            for (name, turns) in [("p", *p), ("q", *q)] {
                if !(1..=MOST_TURNS).contains(&turns) {
                    return wrong(&at.member(name), format!("{turns} is not in 1 to {MOST_TURNS}"));
                }
            }
            if let Some(divisor) = (2..=*p).find(|divisor| p % divisor == 0 && q % divisor == 0) {
                return wrong(
                    &at.member("q"),
                    format!("p and q have the common divisor {divisor}; the knot would meet itself"),
                );
            }
            tube_within(*radius, *tube, 0.5, &at)
        }
        MeshDocument::DisplacedSphere { radius, amplitude, frequency, octaves, .. } => {
            let at = at.member("displaced_sphere");
            positive(*radius, &at.member("radius"))?;
            range(*amplitude, 0.0, 0.9, &at.member("amplitude"))?;
            positive(*frequency, &at.member("frequency"))?;
            if !(1..=8).contains(octaves) {
                return wrong(&at.member("octaves"), format!("{octaves} is not in 1 to 8"));
            }
            let finest = *frequency * f64::from(1u32 << (octaves - 1));
            if finest > FINEST_FREQUENCY {
                return wrong(
                    &at.member("frequency"),
                    format!("the finest octave has {finest}, more than {FINEST_FREQUENCY}"),
                );
            }
            Ok(())
        }
        MeshDocument::Plane { size } => positive(*size, &at.member("plane").member("size")),
        MeshDocument::File { path, .. } => file_name(path, &["obj", "gltf", "glb"], &at.member("file").member("path")),
    }
}

fn tube_within(radius: f64, tube: f64, part: f64, at: &Field) -> Result<(), SceneError> {
    positive(radius, &at.member("radius"))?;
    positive(tube, &at.member("tube"))?;
    if tube < part * radius {
        Ok(())
    } else {
        wrong(&at.member("tube"), format!("{tube} is not below {}; the surface would meet itself", part * radius))
    }
}

fn wrong<T>(at: &Field, why: impl Into<String>) -> Result<T, SceneError> {
    Err(SceneError::document(at, why))
}

fn finite(value: f64, at: &Field) -> Result<(), SceneError> {
    if value.abs() <= LARGEST_NUMBER {
        Ok(())
    } else {
        wrong(at, format!("{value:e} is not within -{LARGEST_NUMBER:e} to {LARGEST_NUMBER:e}"))
    }
}

fn finite3(values: [f64; 3], at: &Field) -> Result<(), SceneError> {
    values.iter().enumerate().try_for_each(|(index, &value)| finite(value, &at.element(index)))
}

fn positive(value: f64, at: &Field) -> Result<(), SceneError> {
    finite(value, at)?;
    if value >= SMALLEST_NUMBER { Ok(()) } else { wrong(at, format!("{value} is not at least {SMALLEST_NUMBER:e}")) }
}

fn range(value: f64, from: f64, to: f64, at: &Field) -> Result<(), SceneError> {
    if (from..=to).contains(&value) { Ok(()) } else { wrong(at, format!("{value} is not in {from} to {to}")) }
}

fn colour(values: [f64; 3], at: &Field) -> Result<(), SceneError> {
    values.iter().enumerate().try_for_each(|(index, &value)| range(value, 0.0, 1e6, &at.element(index)))
}

/// A name that is not empty and has one of `extensions`, if there are any.
fn file_name(name: &str, extensions: &[&str], at: &Field) -> Result<(), SceneError> {
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

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
