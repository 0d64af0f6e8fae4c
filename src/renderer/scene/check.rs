//! Validation of the values of a scene document beyond their types.

use crate::scene::document::{
    AlbedoDocument, CameraDocument, MaterialSource, MeshDocument, ObjectDocument, SceneDocument, SceneMaterial,
};
use crate::scene::error::{Field, SceneError};
use crate::scene::values::{SMALLEST_NUMBER, colour, cross, file_name, finite3, length, positive, range, wrong};
use brdfit_brdf::Ggx;

/// Largest width and height of an image, pixels.
const LARGEST_IMAGE: usize = 16384;
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
    check_lights(document, &root)?;
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

/// `light` or `lights`.
fn check_lights(document: &SceneDocument, root: &Field) -> Result<(), SceneError> {
    let (light, at) = (root.member("light"), root.member("lights"));
    let lights = match (&document.light, &document.lights) {
        (Some(only), None) => return only.check(&light),
        (None, Some(lights)) => lights,
        (Some(_), Some(_)) => return wrong(&at, "cannot stand beside light; put all lights into the list"),
        (None, None) => return wrong(root, "there is neither light nor lights; add one of the two"),
    };
    if lights.is_empty() {
        return wrong(&at, "is empty; add a light");
    }
    let mut distant = false;
    for (index, described) in lights.iter().enumerate() {
        let at = at.element(index);
        described.check(&at)?;
        if described.is_distant() && std::mem::replace(&mut distant, true) {
            return wrong(&at, "is a second environment or procedural light; at most one can be used");
        }
    }
    Ok(())
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
