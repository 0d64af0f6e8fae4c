//! The nearest triangle along a ray.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::{BHShape, BoundingHierarchy};
use bvh::bvh::{Bvh, BvhNode};
use nalgebra::Point3;

use crate::shapes::intersection::{Hit, Ray};
use crate::shapes::mesh::Mesh;

/// A box leaves some room for rounding: twice the bound of T. Ize, "Robust BVH ray traversal", 2013, for single precision.
const ROOM: f32 = 1.0 + 8.0 * f32::EPSILON;

/// A hierarchy of boxes over the triangles of a mesh.
#[derive(Clone, Debug)]
pub(crate) struct VisibleSurfaces {
    tree: Bvh<f32, 3>,
}

/// The box of a triangle while the hierarchy is built.
struct Leaf {
    bounds: Aabb<f32, 3>,
    node: usize,
}

impl Bounded<f32, 3> for Leaf {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for Leaf {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl VisibleSurfaces {
    /// Builds the hierarchy by the surface area heuristic, over the threads of the current pool; the same for every number of them.
    pub(crate) fn new(mesh: &Mesh) -> Self {
        let mut leaves: Vec<Leaf> = (mesh.triangles.iter())
            .map(|triangle| {
                let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
                let bounds = Aabb::with_bounds(Point3::from(a.inf(&b).inf(&c)), Point3::from(a.sup(&b).sup(&c)));
                Leaf { bounds, node: 0 }
            })
            .collect();
        Self { tree: Bvh::build_par(&mut leaves) }
    }

    /// The nearest triangle in front of the origin of `ray`, by its index, and where the ray meets it. `waiting` is working memory.
    pub(crate) fn first(&self, mesh: &Mesh, ray: &Ray, waiting: &mut Vec<(usize, f32)>) -> Option<(usize, Hit)> {
        let nodes = &self.tree.nodes;
        let mut nearest: Option<(usize, Hit)> = None;
        waiting.clear();
        if !nodes.is_empty() {
            waiting.push((0, 0.0));
        }
        while let Some((node, entry)) = waiting.pop() {
            let limit = nearest.map_or(f32::INFINITY, |(_, hit)| hit.t);
            if entry > limit {
                continue;
            }
            match &nodes[node] {
                BvhNode::Leaf { shape_index, .. } => {
                    let corners = mesh.triangles[*shape_index].map(|vertex| mesh.positions[vertex as usize]);
                    if let Some(hit) = ray.meets(corners)
                        && hit.t < limit
                    {
                        nearest = Some((*shape_index, hit));
                    }
                }
                BvhNode::Node { child_l_index, child_l_aabb, child_r_index, child_r_aabb, .. } => {
                    let left = enter(ray, child_l_aabb, limit).map(|t| (*child_l_index, t));
                    let right = enter(ray, child_r_aabb, limit).map(|t| (*child_r_index, t));
                    // the nearer one is taken next
                    match (left, right) {
                        (Some(l), Some(r)) if l.1 <= r.1 => waiting.extend([r, l]),
                        (Some(l), Some(r)) => waiting.extend([l, r]),
                        (one, other) => waiting.extend(one.or(other)),
                    }
                }
            }
        }
        nearest
    }
}

/// Distance at which the ray enters a box, if before `limit`; 0 from inside.
fn enter(ray: &Ray, bounds: &Aabb<f32, 3>, limit: f32) -> Option<f32> {
    let (mut entry, mut exit) = (0.0, limit);
    for axis in 0..3 {
        let a = (bounds.min[axis] - ray.origin[axis]) * ray.inverse[axis];
        let b = (bounds.max[axis] - ray.origin[axis]) * ray.inverse[axis];
        let (near, far) = if a < b { (a, b) } else { (b, a) };
        entry = if near > entry { near } else { entry };
        exit = if far * ROOM < exit { far * ROOM } else { exit };
    }
    (entry <= exit).then_some(entry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vec3::Vec3;
    use crate::shapes::sphere::DisplacedSphere;

    #[test]
    fn the_hierarchy_finds_what_a_search_of_all_triangles_finds() {
        let shape = DisplacedSphere { radius: 1.0, amplitude: 0.3, frequency: 2.0, octaves: 1, seed: 1 };
        let mut mesh = shape.mesh();
        let keep = mesh.triangles.len() / 100;
        mesh.triangles = mesh.triangles.iter().step_by(97).take(keep).copied().collect();
        let visibility = VisibleSurfaces::new(&mesh);
        let mut waiting = Vec::new();
        let mut found = 0;
        for k in 0..500 {
            let target = Vec3::new((k as f32 * 0.37).sin(), (k as f32 * 0.73).cos(), (k as f32 * 1.13).sin()) * 0.8;
            let origin = Vec3::new(0.5, -3.0, 1.0);
            let ray = Ray::new(origin, target - origin);
            let all = (mesh.triangles.iter().enumerate())
                .filter_map(|(index, t)| Some((index, ray.meets(t.map(|vertex| mesh.positions[vertex as usize]))?)))
                .min_by(|a, b| a.1.t.total_cmp(&b.1.t));
            let first = visibility.first(&mesh, &ray, &mut waiting);
            assert_eq!(first.map(|(_, hit)| hit.t), all.map(|(_, hit)| hit.t));
            found += usize::from(first.is_some());
        }
        assert!(found > 3, "{found}");
    }
}
