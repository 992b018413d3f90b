//! Triangle meshes, and whether a mesh encloses a solid.

use std::collections::BTreeMap;

use glam::DVec3;
use parry3d_f64::shape::TriMesh;

/// A triangle mesh with outward normals.
#[derive(Debug, Clone)]
pub struct MeshSolid {
    /// The surface.
    pub surface: TriMesh,
    /// Whether the surface encloses a solid. An open one has no inside.
    pub is_closed: bool,
}

impl MeshSolid {
    /// A mesh by its vertices (m) and triangles.
    ///
    /// # Errors
    /// parry rejects the mesh.
    pub fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Result<Self, String> {
        let surface = TriMesh::new(vertices.to_vec(), triangles.to_vec())
            .map_err(|error| format!("unusable mesh: {error}"))?;
        Ok(Self { surface, is_closed: is_closed(vertices, triangles) })
    }
}

/// Whether each edge belongs to two triangles that pass it in opposite directions. Vertices at the
/// same position are one vertex, and triangles without area have no edges.
fn is_closed(vertices: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let mut first: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let welded: Vec<usize> = vertices
        .iter()
        .enumerate()
        .map(|(index, vertex)| *first.entry(bits(*vertex)).or_insert(index))
        .collect();
    let mut edges: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for triangle in triangles {
        let [a, b, c] = triangle.map(|index| welded[index as usize]);
        if a == b || b == c || c == a {
            continue;
        }
        for edge in [[a, b], [b, c], [c, a]] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    !edges.is_empty()
        && edges.iter().all(|([a, b], count)| *count == 1 && edges.get(&[*b, *a]) == Some(&1))
}

/// The same for two points exactly if they are at the same position.
pub(super) fn bits(point: DVec3) -> [u64; 3] {
    // Adding 0 makes the two zeros equal.
    (point + 0.0).to_array().map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

    fn corners() -> Vec<DVec3> {
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]
    }

    #[test]
    fn a_tetrahedron_is_closed() {
        assert!(is_closed(&corners(), &TETRAHEDRON));
    }

    #[test]
    fn corners_listed_once_per_triangle_are_welded() {
        let vertices: Vec<DVec3> =
            TETRAHEDRON.iter().flatten().map(|&index| corners()[index as usize]).collect();
        let triangles: Vec<[u32; 3]> = (0..4).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        assert!(is_closed(&vertices, &triangles));
    }

    #[test]
    fn a_missing_a_turned_and_a_repeated_triangle_leave_it_open() {
        assert!(!is_closed(&corners(), &TETRAHEDRON[..3]));
        let mut turned = TETRAHEDRON;
        turned[2].swap(0, 1);
        assert!(!is_closed(&corners(), &turned));
        let repeated = [&TETRAHEDRON[..], &TETRAHEDRON[..1]].concat();
        assert!(!is_closed(&corners(), &repeated));
        assert!(!is_closed(&corners(), &[]));
    }

    #[test]
    fn triangles_without_area_have_no_edges() {
        for sliver in [[1, 1, 3], [3, 1, 1], [1, 3, 1], [2, 2, 2]] {
            let triangles = [&TETRAHEDRON[..], &[sliver]].concat();
            assert!(is_closed(&corners(), &triangles), "{sliver:?}");
        }
        assert!(!is_closed(&corners(), &[[1, 1, 3], [2, 2, 2]]));
    }
}
