//! glTF 2.0 files, as text (.gltf) or binary (.glb).

use std::borrow::Cow;
use std::io;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Gltf, Node, Primitive, Semantic, buffer};
use nalgebra::{Matrix3, Vector4};

use crate::geometry::vec3::Vec3;
use crate::lights::error::reason;
use crate::scene::error::FileError;
use crate::shapes::mesh::Mesh;
use crate::shapes::placement::Placement;

/// Deepest nesting of nodes that is followed.
const DEEPEST: usize = 256;

/// The triangles of the default scene, or of the first, with the transforms of its nodes; lines and points are left out, and so are materials,
/// skins and morph targets.
///
/// # Errors
/// A file that contradicts the standard or uses what is not supported (strips and fans, sparse and compressed accessors, buffers from the
/// network), buffers that cannot be read, and the errors of [`Mesh::from_file`].
pub(crate) fn read(bytes: &[u8], folder: &Path) -> Result<Mesh, FileError> {
    let (document, blob) = parse(bytes).map_err(|why| FileError::content(format!("not a valid glTF file: {why}")))?;
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let data = match buffer.source() {
            buffer::Source::Bin => Cow::Borrowed(blob.as_deref().unwrap_or_default()),
            buffer::Source::Uri(uri) => Cow::Owned(fetch(uri, folder)?),
        };
        if data.len() < buffer.length() {
            let (index, length) = (buffer.index(), buffer.length());
            return Err(FileError::content(format!("buffer {index} has {} of {length} bytes", data.len())));
        }
        buffers.push(data);
    }
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| FileError::content("holds no scene"))?;
    let mut walk = Walk { buffers, seen: vec![false; document.nodes().len()], mesh: Mesh::default() };
    for node in scene.nodes() {
        walk.visit(&node, &Placement::identity(), 0)?;
    }
    if walk.mesh.triangles.is_empty() { Err(FileError::content("holds no triangles")) } else { Ok(walk.mesh) }
}

/// The document and the binary part of a file. What is wrong before the library looks would make it panic.
fn parse(bytes: &[u8]) -> Result<(Document, Option<Vec<u8>>), String> {
    if bytes.starts_with(b"glTF") {
        let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        if length.is_none_or(|length| length < 20) {
            return Err("its header is cut off".to_owned());
        }
    }
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(|error| error.to_string())?;
    let root = document.into_json();
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        return Err(format!("version {version:?} of the format; only 2.0 and its successors 2.x are known"));
    }
    let accessors = root.accessors.len();
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        if let Some(index) = primitive.attributes.values().find(|index| index.value() >= accessors) {
            return Err(format!("there is no accessor {}", index.value()));
        }
    }
    let document = Document::from_json(root).map_err(|error| error.to_string())?;
    Ok((document, blob))
}

/// The bytes behind an address: in the address itself, or in a file beside this one.
fn fetch(uri: &str, folder: &Path) -> Result<Vec<u8>, FileError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) =
            data.split_once(";base64,").ok_or_else(|| FileError::content("a data URI that is not base64"))?;
        return STANDARD.decode(text).map_err(|error| FileError::content(format!("a data URI: {error}")));
    }
    if uri.contains("://") {
        return Err(FileError::content(format!("buffer {uri:?} is not a file beside this one")));
    }
    let name = percent_encoding::percent_decode_str(uri).decode_utf8();
    let name = name.map_err(|_| FileError::content(format!("buffer {uri:?} is not UTF-8")))?;
    std::fs::read(folder.join(&*name))
        .map_err(|error| io::Error::new(error.kind(), format!("buffer {name:?}: {}", reason(&error))).into())
}

/// The way through the nodes, and what it has gathered.
struct Walk<'a> {
    buffers: Vec<Cow<'a, [u8]>>,
    seen: Vec<bool>,
    mesh: Mesh,
}

impl Walk<'_> {
    /// Adds the meshes of `node` and of those below it.
    fn visit(&mut self, node: &Node, above: &Placement, depth: usize) -> Result<(), FileError> {
        let index = node.index();
        if std::mem::replace(&mut self.seen[index], true) {
            return Err(FileError::content(format!("node {index} is used twice; the nodes must form a tree")));
        }
        if depth > DEEPEST {
            return Err(FileError::content(format!("node {index} lies more than {DEEPEST} nodes deep")));
        }
        let columns = node.transform().matrix().map(|column| Vector4::from(column).cast::<f64>().xyz());
        let here =
            Placement::affine(Matrix3::from_columns(&columns[..3]), columns[3]).and_then(|own| above.after(&own));
        // what lies below a node that flattens space has no triangles with an area
        let Some(here) = here else {
            return if node.mesh().is_some() {
                Err(FileError::content(format!("node {index} flattens its mesh")))
            } else {
                Ok(())
            };
        };
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
            if let Some(part) = triangles(&primitive, &self.buffers)? {
                self.mesh.append(part.placed(&here));
            }
        }
        node.children().try_for_each(|child| self.visit(&child, &here, depth + 1))
    }
}

/// The triangles of a primitive; `None` if it is made of points or lines.
fn triangles(primitive: &Primitive, buffers: &[Cow<[u8]>]) -> Result<Option<Mesh>, FileError> {
    match primitive.mode() {
        Mode::Triangles => {}
        Mode::TriangleStrip | Mode::TriangleFan => {
            return Err(FileError::content("triangle strips and fans are not supported"));
        }
        _ => return Ok(None),
    }
    let floats = |semantic, dimensions| -> Result<Vec<f32>, FileError> {
        let Some(accessor) = primitive.get(&semantic) else { return Ok(Vec::new()) };
        numbers(&accessor, dimensions, buffers)
    };
    let vectors = |values: Vec<f32>| values.chunks_exact(3).map(Vec3::from_column_slice).collect::<Vec<_>>();
    let positions = vectors(floats(Semantic::Positions, Dimensions::Vec3)?);
    let normals = vectors(floats(Semantic::Normals, Dimensions::Vec3)?);
    // v points down in glTF
    let uv = floats(Semantic::TexCoords(0), Dimensions::Vec2)?.chunks_exact(2).map(|uv| [uv[0], 1.0 - uv[1]]).collect();
    let indices: Vec<u32> = match primitive.indices() {
        Some(accessor) => indices(&accessor, buffers)?,
        None => (0..positions.len() as u32).collect(),
    };
    if !indices.len().is_multiple_of(3) {
        return Err(FileError::content(format!("{} indices are not a number of triangles", indices.len())));
    }
    let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    Mesh::from_file(positions, normals, uv, triangles).map(Some)
}

/// The values of an accessor of so many dimensions; integers are the fractions that they stand for.
fn numbers(accessor: &Accessor, dimensions: Dimensions, buffers: &[Cow<[u8]>]) -> Result<Vec<f32>, FileError> {
    expect(accessor, accessor.dimensions() == dimensions)?;
    let count = dimensions.multiplicity();
    match accessor.data_type() {
        DataType::F32 => items(accessor, buffers, count, |b: [u8; 4]| f32::from_le_bytes(b)),
        DataType::U16 if accessor.normalized() => {
            items(accessor, buffers, count, |b: [u8; 2]| f32::from(u16::from_le_bytes(b)) / 65535.0)
        }
        DataType::U8 if accessor.normalized() => items(accessor, buffers, count, |b: [u8; 1]| f32::from(b[0]) / 255.0),
        _ => expect(accessor, false).map(|()| Vec::new()),
    }
}

/// The values of an accessor of vertex numbers.
fn indices(accessor: &Accessor, buffers: &[Cow<[u8]>]) -> Result<Vec<u32>, FileError> {
    expect(accessor, accessor.dimensions() == Dimensions::Scalar)?;
    match accessor.data_type() {
        DataType::U32 => items(accessor, buffers, 1, u32::from_le_bytes),
        DataType::U16 => items(accessor, buffers, 1, |b: [u8; 2]| u32::from(u16::from_le_bytes(b))),
        DataType::U8 => items(accessor, buffers, 1, |b: [u8; 1]| u32::from(b[0])),
        _ => expect(accessor, false).map(|()| Vec::new()),
    }
}

fn expect(accessor: &Accessor, holds: bool) -> Result<(), FileError> {
    let index = accessor.index();
    if holds { Ok(()) } else { Err(FileError::content(format!("accessor {index} is not of a type that fits its use"))) }
}

/// All numbers of an accessor, `components` of N bytes per element, decoded one by one.
fn items<const N: usize, T>(
    accessor: &Accessor,
    buffers: &[Cow<[u8]>],
    components: usize,
    decode: impl Fn([u8; N]) -> T,
) -> Result<Vec<T>, FileError> {
    let index = accessor.index();
    let (Some(view), None) = (accessor.view(), accessor.sparse()) else {
        return Err(FileError::content(format!("accessor {index} is sparse or has no data, which is not supported")));
    };
    let outside = || FileError::content(format!("accessor {index} reaches beyond its buffer"));
    let data = (view.offset().checked_add(view.length()))
        .and_then(|end| buffers[view.buffer().index()].get(view.offset()..end))
        .ok_or_else(outside)?;
    let size = components * N;
    let stride = view.stride().unwrap_or(size);
    if accessor.count() > data.len() {
        return Err(outside());
    }
    let mut values = Vec::with_capacity(accessor.count() * components);
    for element in 0..accessor.count() {
        let start =
            stride.checked_mul(element).and_then(|start| start.checked_add(accessor.offset())).ok_or_else(outside)?;
        let bytes = start.checked_add(size).and_then(|end| data.get(start..end)).ok_or_else(outside)?;
        values.extend(bytes.as_chunks::<N>().0.iter().map(|&bytes| decode(bytes)));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// One triangle, (0, 0, 0), (1, 0, 0), (0, 1, 0), with texture coordinates and 16-bit indices, under a node that moves it.
    fn bytes() -> Vec<u8> {
        let floats: [f32; 15] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 1., 1., 1., 0., 0.];
        let mut bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        bytes.extend([0u16, 1, 2].iter().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    fn document() -> Value {
        json!({
            "asset": { "version": "2.0" },
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "translation": [5.0, 0.0, 0.0], "children": [1] }, { "mesh": 0, "scale": [2.0, 1.0, 1.0] }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
                { "bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC2" },
                { "bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR" }
            ],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 60 },
                { "buffer": 0, "byteOffset": 60, "byteLength": 6 }
            ],
            "buffers": [{ "byteLength": 66, "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes())) }]
        })
    }

    fn read_json(document: &Value) -> Result<Mesh, FileError> {
        read(document.to_string().as_bytes(), Path::new("."))
    }

    fn why(change: impl Fn(&mut Value)) -> String {
        let mut document = document();
        change(&mut document);
        match read_json(&document) {
            Err(FileError::Content(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    fn assert_is_the_triangle(mesh: &Mesh) {
        assert_eq!(mesh.positions, [Vec3::new(5.0, 0.0, 0.0), Vec3::new(7.0, 0.0, 0.0), Vec3::new(5.0, 1.0, 0.0)]);
        assert_eq!(mesh.normals, [Vec3::z(); 3]);
        assert_eq!(mesh.uv, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn embedded_separate_and_binary_buffers_are_read() {
        assert_is_the_triangle(&read_json(&document()).unwrap());

        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a b.bin"), bytes()).unwrap();
        let mut separate = document();
        separate["buffers"][0]["uri"] = json!("a%20b.bin");
        assert_is_the_triangle(&read(separate.to_string().as_bytes(), folder.path()).unwrap());

        let mut inside = document();
        inside["buffers"][0].as_object_mut().unwrap().remove("uri");
        let mut text = inside.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut data = bytes();
        data.resize(data.len().next_multiple_of(4), 0);
        let mut glb = b"glTF".to_vec();
        for number in [2, (12 + 8 + text.len() + 8 + data.len()) as u32, text.len() as u32] {
            glb.extend(number.to_le_bytes());
        }
        glb.extend(b"JSON");
        glb.extend(text);
        glb.extend((data.len() as u32).to_le_bytes());
        glb.extend(b"BIN\0");
        glb.extend(data);
        assert_is_the_triangle(&read(&glb, folder.path()).unwrap());
    }

    #[test]
    fn wrong_files_are_refused() {
        assert_eq!(why(|d| d["buffers"][0]["byteLength"] = json!(100)), "buffer 0 has 66 of 100 bytes");
        assert_eq!(why(|d| d["accessors"][2]["count"] = json!(6)), "accessor 2 reaches beyond its buffer");
        assert_eq!(
            why(|d| d["bufferViews"][0]["byteLength"] = json!(u64::MAX)),
            "accessor 0 reaches beyond its buffer"
        );
        assert_eq!(why(|d| d["accessors"][0]["type"] = json!("VEC2")), "accessor 0 is not of a type that fits its use");
        assert_eq!(
            why(|d| d["accessors"][2]["componentType"] = json!(5126)),
            "accessor 2 is not of a type that fits its use"
        );
        assert_eq!(why(|d| d["accessors"][2]["count"] = json!(2)), "2 indices are not a number of triangles");
        assert_eq!(
            why(|d| d["meshes"][0]["primitives"][0]["mode"] = json!(5)),
            "triangle strips and fans are not supported"
        );
        assert_eq!(why(|d| d["meshes"][0]["primitives"][0]["mode"] = json!(1)), "holds no triangles");
        assert_eq!(why(|d| d["scenes"] = json!([])), "holds no scene");
        assert_eq!(why(|d| d["nodes"][1]["scale"] = json!([0, 1, 1])), "node 1 flattens its mesh");
        assert_eq!(why(|d| d["nodes"][1]["children"] = json!([0])), "node 0 is used twice; the nodes must form a tree");
        assert_eq!(
            why(|d| d["buffers"][0]["uri"] = json!("https://example.org/a.bin")),
            "buffer \"https://example.org/a.bin\" is not a file beside this one"
        );
        assert_eq!(
            why(|d| d["asset"]["version"] = json!("1.0")),
            "not a valid glTF file: version \"1.0\" of the format; only 2.0 and its successors 2.x are known"
        );
        assert!(why(|d| d["accessors"] = json!([])).starts_with("not a valid glTF file: there is no accessor "));
        assert!(matches!(read(b"{", Path::new(".")), Err(FileError::Content(_))));
        let mut elsewhere = document();
        elsewhere["buffers"][0]["uri"] = json!("none.bin");
        let error = read_json(&elsewhere).unwrap_err();
        assert!(
            matches!(&error, FileError::Io(why) if why.to_string() == "buffer \"none.bin\": no such file"),
            "{error:?}"
        );
        assert!(matches!(read(b"glTF\x02\0\0\0", Path::new(".")), Err(FileError::Content(_))));
    }
}
