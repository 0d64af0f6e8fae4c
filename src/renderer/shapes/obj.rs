//! Wavefront OBJ files.

use crate::geometry::vec3::Vec3;
use crate::scene::error::FileError;
use crate::shapes::mesh::Mesh;

/// The triangles of all objects and groups of a file; polygons are cut into fans, points and lines are left out. Its materials are not
/// read.
///
/// # Errors
/// Files that tobj cannot parse, and the errors of [`Mesh::from_file`].
pub(crate) fn read(bytes: &[u8]) -> Result<Mesh, FileError> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let mut text = bytes;
    let (models, _) = tobj::load_obj_buf(&mut text, &options, |_| Ok(Default::default()))
        .map_err(|error| FileError::content(format!("not a valid OBJ file: {error}")))?;
    let mut all = Mesh::default();
    for tobj::Model { mesh, .. } in models {
        if mesh.indices.is_empty() {
            continue;
        }
        let triples = |values: &[f32]| values.chunks_exact(3).map(Vec3::from_column_slice).collect::<Vec<_>>();
        let positions = triples(&mesh.positions);
        // where only some vertices have normals or texture coordinates, nothing says which
        let complete = |values: Vec<Vec3>| if values.len() == positions.len() { values } else { Vec::new() };
        let normals = complete(triples(&mesh.normals));
        let uv: Vec<[f32; 2]> = mesh.texcoords.chunks_exact(2).map(|uv| [uv[0], uv[1]]).collect();
        let uv = if uv.len() == positions.len() { uv } else { Vec::new() };
        let triangles = mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        all.append(Mesh::from_file(positions, normals, uv, triangles)?);
    }
    if all.triangles.is_empty() { Err(FileError::content("holds no triangles")) } else { Ok(all) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn why(text: &str) -> String {
        match read(text.as_bytes()) {
            Err(FileError::Content(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_quad_with_normals_and_texture_coordinates() {
        let text = "# a comment\no quad\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
                    usemtl nothing\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!(mesh.positions, [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| Vec3::new(x, y, 0.0)));
        assert_eq!(mesh.normals, [Vec3::z(); 4]);
        assert_eq!(mesh.uv, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn two_groups_with_negative_indices_and_without_normals() {
        let text = "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\no b\nv 0 0 1\nv 0 1 1\nv 0 0 2\nf 4 5 6\n";
        let mesh = read(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(mesh.normals, [Vec3::z(), Vec3::z(), Vec3::z(), Vec3::x(), Vec3::x(), Vec3::x()]);
    }

    #[test]
    fn wrong_files_are_refused() {
        assert_eq!(why(""), "holds no triangles");
        assert_eq!(why("v 0 0 0\nv 1 0 0\nl 1 2\n"), "holds no triangles");
        assert_eq!(
            why("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
            "not a valid OBJ file: face vertex index out of bounds"
        );
        assert_eq!(why("v 0 zero 0\n"), "not a valid OBJ file: position parse error");
        assert_eq!(why("v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"), "the position of vertex 1 is not finite");
    }
}
