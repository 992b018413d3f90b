//! Triangles with normals, rounded where a surface is round and sharp where it has edges.

use std::collections::BTreeMap;

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::picture::tessellate::Triangles;

/// Faces that meet at less than this angle's cosine look rounded (about 40 degrees).
const CREASE_COS: f64 = 0.766;

/// A corner of a triangle.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    /// Where it is, m.
    pub position: DVec3,
    /// The unit normal it is lit with.
    pub normal: DVec3,
}

/// A surface that can be drawn.
#[derive(Debug, Clone)]
pub struct Surface {
    /// Triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[Corner; 3]>,
    /// The edges at which faces meet sharply, or that have one face only.
    pub creases: Vec<[DVec3; 2]>,
}

impl Surface {
    /// Computes normals and creases.
    pub fn new((vertices, faces): &Triangles) -> Self {
        let areas: Vec<DVec3> = faces
            .iter()
            .map(|&[a, b, c]| area_vector([a, b, c].map(|i| vertices[i as usize])))
            .collect();
        let units: Vec<DVec3> = areas.iter().map(|area| area.normalize_or_zero()).collect();
        let mut faces_at: Vec<Vec<u32>> = vec![Vec::new(); vertices.len()];
        for (index, face) in faces.iter().enumerate() {
            face.iter().for_each(|&vertex| faces_at[vertex as usize].push(index as u32));
        }
        let corner = |vertex: u32, face: usize| {
            let around = faces_at[vertex as usize].iter().map(|&other| other as usize);
            let alike = around.filter(|&other| units[other].dot(units[face]) > CREASE_COS);
            Corner {
                position: vertices[vertex as usize],
                normal: alike.map(|other| areas[other]).sum::<DVec3>().normalize_or(units[face]),
            }
        };
        let triangles = faces
            .iter()
            .enumerate()
            .map(|(index, face)| face.map(|vertex| corner(vertex, index)))
            .collect();
        Self { triangles, creases: creases(vertices, faces, &units) }
    }

    /// A flat convex polygon, counter-clockwise seen from the side its normal points to.
    pub fn polygon(points: &[DVec3]) -> Self {
        let faces = (1..points.len().saturating_sub(1) as u32).map(|i| [0, i, i + 1]).collect();
        Self::new(&(points.to_vec(), faces))
    }

    /// The same surface in another frame.
    pub fn transformed(&self, pose: &Pose) -> Self {
        let corner =
            |c: &Corner| Corner { position: *pose * c.position, normal: pose.rotation * c.normal };
        Self {
            triangles: self
                .triangles
                .iter()
                .map(|triangle| [0, 1, 2].map(|i| corner(&triangle[i])))
                .collect(),
            creases: self.creases.iter().map(|edge| edge.map(|point| *pose * point)).collect(),
        }
    }

    /// The smallest and largest coordinates.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let positions = self.triangles.iter().flatten().map(|corner| corner.position);
        positions.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        })
    }
}

fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

fn creases(vertices: &[DVec3], faces: &[[u32; 3]], units: &[DVec3]) -> Vec<[DVec3; 2]> {
    let mut sides: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (index, &[a, b, c]) in faces.iter().enumerate() {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            sides.entry([from.min(to), from.max(to)]).or_default().push(index);
        }
    }
    let sharp = |adjacent: &[usize]| {
        adjacent.len() != 2 || units[adjacent[0]].dot(units[adjacent[1]]) < CREASE_COS
    };
    let edges = sides.iter().filter(|(_, adjacent)| sharp(adjacent));
    edges.map(|(edge, _)| edge.map(|vertex| vertices[vertex as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::tessellate::triangles_of;
    use surefoot_shared_types::Shape;

    #[test]
    fn a_box_has_twelve_creases_and_flat_faces() {
        let surface =
            Surface::new(&triangles_of(&Shape::Box { half_extents: DVec3::ONE }, "box").unwrap());
        assert_eq!(surface.creases.len(), 12);
        assert!(
            surface
                .triangles
                .iter()
                .flatten()
                .all(|corner| corner.normal.abs().max_element() > 0.999)
        );
    }

    #[test]
    fn a_ball_has_no_crease_and_round_normals() {
        let surface = Surface::new(&triangles_of(&Shape::Sphere { radius: 2.0 }, "ball").unwrap());
        assert!(surface.creases.is_empty());
        assert!(
            surface
                .triangles
                .iter()
                .flatten()
                .all(|corner| corner.normal.dot(corner.position.normalize()) > 0.99)
        );
    }
}
