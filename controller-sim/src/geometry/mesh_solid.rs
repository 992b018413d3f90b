//! Triangle meshes, and whether a mesh encloses a solid.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use parry3d_f64::shape::TriMesh;

/// A triangle mesh with outward normals.
#[derive(Debug, Clone)]
pub struct MeshSolid {
    /// The surface.
    pub surface: TriMesh,
    /// Whether the surface encloses solids. An open one has no inside.
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

/// Whether the triangles pass each edge as often in one direction as in the other, and none is
/// there from both sides. Vertices at the same position are one vertex, a triangle that is stored
/// twice counts once, and triangles without area have no edges.
fn is_closed(vertices: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let faces = faces(vertices, triangles);
    let mut edges: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for [a, b, c] in &faces {
        for edge in [[*a, *b], [*b, *c], [*c, *a]] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    let is_two_sided = |[a, b, c]: &[usize; 3]| faces.contains(&[*a, *c, *b]);
    !faces.is_empty()
        && !faces.iter().any(is_two_sided)
        && edges.iter().all(|([a, b], count)| edges.get(&[*b, *a]) == Some(count))
}

/// The triangles with an area, each once, beginning at the vertex that the list has first.
fn faces(vertices: &[DVec3], triangles: &[[u32; 3]]) -> BTreeSet<[usize; 3]> {
    let mut first: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let welded: Vec<usize> = vertices
        .iter()
        .enumerate()
        .map(|(index, vertex)| *first.entry(bits(*vertex)).or_insert(index))
        .collect();
    let corners = triangles.iter().map(|triangle| triangle.map(|index| welded[index as usize]));
    let with_area = corners.filter(|[a, b, c]| a != b && b != c && c != a);
    with_area
        .map(|[a, b, c]| {
            let least = a.min(b).min(c);
            if least == a {
                [a, b, c]
            } else if least == b {
                [b, c, a]
            } else {
                [c, a, b]
            }
        })
        .collect()
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
    fn a_missing_and_a_turned_triangle_leave_it_open() {
        assert!(!is_closed(&corners(), &TETRAHEDRON[..3]));
        let mut turned = TETRAHEDRON;
        turned[2].swap(0, 1);
        assert!(!is_closed(&corners(), &turned));
        assert!(!is_closed(&corners(), &[]));
    }

    #[test]
    fn triangles_that_are_stored_twice_count_once() {
        let [[a, b, c], ..] = TETRAHEDRON;
        for again in [[a, b, c], [b, c, a], [c, a, b]] {
            assert!(is_closed(&corners(), &[&TETRAHEDRON[..], &[again]].concat()), "{again:?}");
        }
        let twice: Vec<DVec3> = corners().into_iter().chain(corners()).collect();
        let copy = TETRAHEDRON.map(|triangle| triangle.map(|index| index + 4));
        assert!(is_closed(&twice, &[TETRAHEDRON, copy].concat()));
        assert!(!is_closed(&twice, &[&TETRAHEDRON[1..], &copy[1..]].concat()));
        let three_quarters = [&TETRAHEDRON[1..], &[[2, 1, 3]]].concat();
        assert!(!is_closed(&corners(), &three_quarters));
    }

    #[test]
    fn a_sheet_with_two_sides_has_no_inside() {
        let [[a, b, c], [d, e, f], ..] = TETRAHEDRON;
        assert!(!is_closed(&corners(), &[[a, b, c], [c, b, a]]));
        assert!(!is_closed(&corners(), &[[a, b, c], [d, e, f], [c, b, a], [f, e, d]]));
        assert!(!is_closed(&corners(), &[&TETRAHEDRON[..], &[[c, b, a]]].concat()));
    }

    #[test]
    fn solids_that_touch_along_an_edge_are_closed() {
        let points = [corners(), vec![-DVec3::X, -DVec3::Y]].concat();
        let second = [[0, 5, 4], [0, 4, 3], [4, 5, 3], [0, 3, 5]];
        assert!(is_closed(&points, &second));
        assert!(is_closed(&points, &[TETRAHEDRON, second].concat()));
        assert!(!is_closed(&points, &[&TETRAHEDRON[..], &second[..3]].concat()));
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
