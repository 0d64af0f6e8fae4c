//! Triangle meshes with normals and texture coordinates.

use std::collections::HashMap;

use crate::geometry::vec3::Vec3;
use crate::scene::error::FileError;
use crate::shapes::placement::Placement;

/// A surface of triangles; vertices have one position, one normal and one pair of texture coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    /// Unit vectors, one per vertex.
    pub(crate) normals: Vec<Vec3>,
    /// Texture coordinates, (0, 0) at the lower left of a picture, one pair per vertex.
    pub(crate) uv: Vec<[f32; 2]>,
    /// Vertices of each triangle.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A mesh from what a file holds. `normals` and `uv` may be empty: normals are computed then, texture coordinates are zero. So are the
    /// normals that have no length.
    ///
    /// # Errors
    /// No triangles, an index without vertex, lists of different lengths, numbers that are not finite.
    pub(crate) fn from_file(
        positions: Vec<Vec3>,
        normals: Vec<Vec3>,
        uv: Vec<[f32; 2]>,
        triangles: Vec<[u32; 3]>,
    ) -> Result<Self, FileError> {
        let vertices = positions.len();
        if triangles.is_empty() {
            return Err(FileError::content("holds no triangles"));
        }
        for (name, count) in [("normals", normals.len()), ("texture coordinates", uv.len())] {
            if count != 0 && count != vertices {
                return Err(FileError::content(format!("{vertices} vertices but {count} {name}")));
            }
        }
        for (index, triangle) in triangles.iter().enumerate() {
            if let Some(vertex) = triangle.iter().find(|&&vertex| vertex as usize >= vertices) {
                return Err(FileError::content(format!(
                    "triangle {index} names vertex {vertex}, but there are {vertices}"
                )));
            }
        }
        // coordinates beyond 1e18 would overflow when they are squared
        let not_finite = |v: &Vec3| !v.iter().all(|x| x.abs() <= 1e18);
        if let Some(vertex) = positions.iter().position(not_finite) {
            return Err(FileError::content(format!("the position of vertex {vertex} is not finite")));
        }
        if let Some(vertex) = normals.iter().position(not_finite) {
            return Err(FileError::content(format!("the normal of vertex {vertex} is not finite")));
        }
        if let Some(vertex) = uv.iter().position(|uv| !uv.iter().all(|x| x.is_finite())) {
            return Err(FileError::content(format!("the texture coordinates of vertex {vertex} are not finite")));
        }
        let mut mesh = Self { positions, normals, uv, triangles };
        mesh.uv.resize(vertices, [0.0; 2]);
        mesh.complete_normals();
        Ok(mesh)
    }

    /// Makes all normals unit vectors; those that are missing or have no length are computed from the triangles.
    fn complete_normals(&mut self) {
        let lengths: Vec<f32> = self.normals.iter().map(Vec3::norm).collect();
        let complete = self.normals.len() == self.positions.len() && lengths.iter().all(|&length| length > 1e-12);
        let computed = if complete { Vec::new() } else { self.smooth_normals() };
        self.normals.resize(self.positions.len(), Vec3::zeros());
        for (vertex, normal) in self.normals.iter_mut().enumerate() {
            let length = lengths.get(vertex).copied().unwrap_or(0.0);
            *normal = if length > 1e-12 { *normal / length } else { computed[vertex] };
        }
    }

    /// Normals as the mean of those of the triangles around a position, weighted by the angle there (Thürmer and Wüthrich, "Computing
    /// vertex normals from polygonal facets", 1998). Vertices at the same position, as along seams of the texture, share one.
    fn smooth_normals(&self) -> Vec<Vec3> {
        let mut first_at: HashMap<[u32; 3], usize> = HashMap::with_capacity(self.positions.len());
        let shared: Vec<usize> = (self.positions.iter().enumerate())
            .map(|(vertex, p)| *first_at.entry([p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).or_insert(vertex))
            .collect();
        let mut sums = vec![nalgebra::Vector3::<f64>::zeros(); self.positions.len()];
        for triangle in &self.triangles {
            let corners = triangle.map(|vertex| self.positions[vertex as usize].cast::<f64>());
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let Some(normal) = normal.try_normalize(0.0) else { continue };
            for corner in 0..3 {
                let (a, b) = (corners[(corner + 1) % 3] - corners[corner], corners[(corner + 2) % 3] - corners[corner]);
                let angle = libm::atan2(a.cross(&b).norm(), a.dot(&b));
                sums[shared[triangle[corner] as usize]] += normal * angle;
            }
        }
        // a vertex of no triangle with an area is never seen; its normal is any
        shared
            .iter()
            .map(|&first| sums[first].try_normalize(1e-12).map_or_else(Vec3::z, |normal| normal.cast()))
            .collect()
    }

    /// The mesh at its place in the world.
    pub(crate) fn placed(mut self, placement: &Placement) -> Self {
        for position in &mut self.positions {
            *position = placement.point(*position);
        }
        for normal in &mut self.normals {
            *normal = placement.direction(*normal);
        }
        self
    }

    /// Adds the vertices and triangles of `other`.
    pub(crate) fn append(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uv.extend(other.uv);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn why(result: Result<Mesh, FileError>) -> String {
        match result {
            Err(FileError::Content(why)) => why,
            other => panic!("{other:?}"),
        }
    }

    /// The faces of a cube as two triangles each, every face with its own vertices.
    fn cube() -> Mesh {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for axis in 0..3 {
            for sign in [-1.0f32, 1.0] {
                let first = positions.len() as u32;
                for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    let mut p = Vec3::zeros();
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, s * sign, t);
                    positions.push(p);
                }
                triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            }
        }
        Mesh::from_file(positions, vec![], vec![], triangles).unwrap()
    }

    #[test]
    fn computed_normals_of_a_cube_point_along_its_diagonals() {
        // weights by area or none would depend on how the faces are cut; those by angle do not
        let cube = cube();
        assert_eq!(cube.positions.len(), 24);
        for (position, normal) in cube.positions.iter().zip(&cube.normals) {
            assert!((position.normalize() - normal).norm() < 1e-6, "{position} {normal}");
        }
        assert_eq!(cube.uv, vec![[0.0; 2]; 24]);
    }

    #[test]
    fn normals_of_a_file_are_kept_and_those_without_length_computed() {
        let positions = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        let normals = vec![Vec3::new(0.0, 3.0, 4.0), Vec3::zeros(), Vec3::new(0.0, 0.0, 2.0)];
        let mesh = Mesh::from_file(positions, normals, vec![], vec![[0, 1, 2]]).unwrap();
        assert_eq!(mesh.normals, vec![Vec3::new(0.0, 0.6, 0.8), Vec3::z(), Vec3::z()]);
    }

    #[test]
    fn wrong_lists_are_refused() {
        let p = || vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        assert_eq!(why(Mesh::from_file(p(), vec![], vec![], vec![])), "holds no triangles");
        assert_eq!(
            why(Mesh::from_file(p(), vec![], vec![], vec![[0, 1, 2], [2, 1, 3]])),
            "triangle 1 names vertex 3, but there are 3"
        );
        assert_eq!(why(Mesh::from_file(p(), vec![Vec3::x()], vec![], vec![[0, 1, 2]])), "3 vertices but 1 normals");
        let mut holed = p();
        holed[1].y = f32::NAN;
        assert_eq!(
            why(Mesh::from_file(holed, vec![], vec![], vec![[0, 1, 2]])),
            "the position of vertex 1 is not finite"
        );
        assert_eq!(
            why(Mesh::from_file(p(), vec![], vec![[0.0, f32::INFINITY]; 3], vec![[0, 1, 2]])),
            "the texture coordinates of vertex 0 are not finite"
        );
    }
}
