//! Parametric surfaces as meshes.

use nalgebra::Vector3;

use crate::geometry::vec3::Vec3;
use crate::shapes::mesh::Mesh;

/// A grid over (u, v) in [0, 1]^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// Quads along u.
    pub(crate) columns: usize,
    /// Quads along v.
    pub(crate) rows: usize,
    /// Whether u = 1 is the same line as u = 0.
    pub(crate) closed_u: bool,
    /// Whether v = 1 is the same line as v = 0.
    pub(crate) closed_v: bool,
}

impl Patch {
    /// The mesh of `surface`, which gives position and unit normal at (u, v), with (u, v) as texture coordinates. Where the patch is closed,
    /// both sides of the seam have the same positions to the last bit. Two triangles per quad; those of the quads that end in a
    /// pole have no area on one side.
    pub(crate) fn mesh(&self, surface: impl Fn(f64, f64) -> (Vector3<f64>, Vector3<f64>)) -> Mesh {
        let mut mesh = Mesh::default();
        let place = |index: usize, quads: usize, closed: bool| {
            (if closed { index % quads } else { index }) as f64 / quads as f64
        };
        for row in 0..=self.rows {
            for column in 0..=self.columns {
                let (u, v) = (place(column, self.columns, self.closed_u), place(row, self.rows, self.closed_v));
                let (position, normal) = surface(u, v);
                mesh.positions.push(position.cast());
                mesh.normals.push(Vec3::from(normal.cast()));
                mesh.uv.push([column as f32 / self.columns as f32, row as f32 / self.rows as f32]);
            }
        }
        let vertex = |column: usize, row: usize| (row * (self.columns + 1) + column) as u32;
        for row in 0..self.rows {
            for column in 0..self.columns {
                let (a, b) = (vertex(column, row), vertex(column + 1, row));
                let (c, d) = (vertex(column + 1, row + 1), vertex(column, row + 1));
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Checks that the surface of `mesh` has no border and that its triangles and normals point the same way; the volume inside.
    pub(crate) fn closed_volume(mesh: &Mesh) -> f64 {
        let mut edges = std::collections::HashMap::new();
        let key = |vertex: u32| <[f32; 3]>::from(mesh.positions[vertex as usize]).map(|x| (x + 0.0).to_bits());
        let mut volume = 0.0;
        for &[a, b, c] in &mesh.triangles {
            let [p, q, r] = [a, b, c].map(|vertex| mesh.positions[vertex as usize].cast::<f64>());
            volume += p.dot(&q.cross(&r)) / 6.0;
            let area = (q - p).cross(&(r - p));
            for vertex in [a, b, c] {
                let normal = mesh.normals[vertex as usize];
                assert!((normal.norm() - 1.0).abs() < 1e-5);
                assert!(area.dot(&normal.cast()) >= 0.0);
            }
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (key(from), key(to));
                if from != to {
                    *edges.entry((from, to)).or_insert(0) += 1;
                    *edges.entry((to, from)).or_insert(0) -= 1;
                }
            }
        }
        assert!(edges.values().all(|&count| count == 0), "the surface has a border");
        volume
    }

    #[test]
    fn an_open_patch_is_a_grid() {
        let patch = Patch { columns: 3, rows: 2, closed_u: false, closed_v: false };
        let mesh = patch.mesh(|u, v| (Vector3::new(u, v, 0.0), Vector3::z()));
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (12, 12));
        let area: f32 = (mesh.triangles.iter())
            .map(|t| {
                let [a, b, c] = t.map(|vertex| mesh.positions[vertex as usize]);
                (b - a).cross(&(c - a)).z / 2.0
            })
            .sum();
        assert!((area - 1.0).abs() < 1e-6);
    }
}
