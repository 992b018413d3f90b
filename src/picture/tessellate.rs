//! Shapes as triangles.

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;
use surefoot_shared_types::Shape;

use crate::picture::error::PictureError;

/// Points around a body of revolution.
const TURN_SEGMENTS: usize = 32;
/// Segments from a ball's pole to its equator.
const QUARTER_SEGMENTS: usize = 8;

/// Vertices, and triangles counter-clockwise seen from outside.
pub type Triangles = (Vec<DVec3>, Vec<[u32; 3]>);

/// Triangles of a shape, in its own frame. `name` is for the error, should its hull have no volume.
pub fn triangles_of(shape: &Shape, name: &str) -> Result<Triangles, PictureError> {
    Ok(match shape {
        Shape::Box { half_extents } => box_triangles(*half_extents),
        Shape::Sphere { radius } => capsule_triangles(*radius, 0.0),
        Shape::Cylinder { radius, half_length } => revolve(&[
            [0.0, -half_length],
            [*radius, -half_length],
            [*radius, *half_length],
            [0.0, *half_length],
        ]),
        Shape::Capsule { radius, half_length } => capsule_triangles(*radius, *half_length),
        Shape::ConvexHull { points, .. } => try_convex_hull(points).map_err(|error| {
            PictureError::Hull { name: name.to_owned(), reason: error.to_string() }
        })?,
        Shape::Mesh { vertices, triangles, .. } => weld(vertices, triangles),
    })
}

fn box_triangles(half: DVec3) -> Triangles {
    let corner = |i: usize| {
        half * DVec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }))
    };
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

fn capsule_triangles(radius: f64, half_length: f64) -> Triangles {
    let arc = |from: usize, z: f64| {
        (from..=from + QUARTER_SEGMENTS).map(move |i| {
            let (sin, cos) =
                libm::sincos(std::f64::consts::FRAC_PI_2 * i as f64 / QUARTER_SEGMENTS as f64);
            [radius * sin, z - radius * cos]
        })
    };
    let mut profile: Vec<[f64; 2]> = arc(0, -half_length).collect();
    profile.extend(arc(QUARTER_SEGMENTS, half_length).skip(usize::from(half_length == 0.0)));
    revolve(&profile)
}

/// Turns a profile of (radius, z), listed upwards, about the z axis. Its ends lie on the axis.
fn revolve(profile: &[[f64; 2]]) -> Triangles {
    let ring = |&[radius, z]: &[f64; 2]| {
        (0..TURN_SEGMENTS).map(move |i| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / TURN_SEGMENTS as f64);
            DVec3::new(radius * cos, radius * sin, z)
        })
    };
    let inner = &profile[1..profile.len() - 1];
    let mut vertices: Vec<DVec3> = inner.iter().flat_map(ring).collect();
    let bottom = vertices.len() as u32;
    let top = bottom + 1;
    vertices.extend([profile[0], profile[profile.len() - 1]].map(|[_, z]| DVec3::new(0.0, 0.0, z)));
    let at = |row: usize, i: usize| (row * TURN_SEGMENTS + i % TURN_SEGMENTS) as u32;
    let last = inner.len() - 1;
    let mut triangles = Vec::new();
    for i in 0..TURN_SEGMENTS {
        triangles.push([bottom, at(0, i + 1), at(0, i)]);
        triangles.extend((0..last).flat_map(|row| {
            let [a, b, c, d] = [at(row, i), at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)];
            [[a, b, c], [a, c, d]]
        }));
        triangles.push([top, at(last, i), at(last, i + 1)]);
    }
    (vertices, triangles)
}

/// Merges vertices at the same place, as STL files repeat them, and drops triangles that thereby
/// vanish.
fn weld(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Triangles {
    let mut order: Vec<u32> = (0..vertices.len() as u32).collect();
    let key = |i: u32| vertices[i as usize].to_array().map(|c| (c + 0.0).to_bits());
    order.sort_by_key(|&i| key(i));
    let mut welded = Vec::new();
    let mut index = vec![0; vertices.len()];
    let mut before = None;
    for i in order {
        if before != Some(key(i)) {
            before = Some(key(i));
            welded.push(vertices[i as usize]);
        }
        index[i as usize] = welded.len() as u32 - 1;
    }
    let triangles = triangles.iter().map(|t| t.map(|i| index[i as usize]));
    (welded, triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume((vertices, triangles): &Triangles) -> f64 {
        let v = |i: u32| vertices[i as usize];
        triangles.iter().map(|&[a, b, c]| v(a).dot(v(b).cross(v(c))) / 6.0).sum()
    }

    #[test]
    fn triangles_enclose_the_volume_outwards() {
        let pi = std::f64::consts::PI;
        let cases = [
            (Shape::Box { half_extents: DVec3::new(1.0, 2.0, 3.0) }, 48.0),
            (Shape::Sphere { radius: 1.0 }, 4.0 / 3.0 * pi),
            (Shape::Cylinder { radius: 1.0, half_length: 2.0 }, 4.0 * pi),
            (Shape::Capsule { radius: 1.0, half_length: 2.0 }, 16.0 / 3.0 * pi),
            (Shape::ConvexHull { points: box_triangles(DVec3::ONE).0, source: None }, 8.0),
        ];
        for (shape, wanted) in cases {
            let got = volume(&triangles_of(&shape, "it").unwrap());
            assert!(got > 0.97 * wanted && got < 1.0001 * wanted, "{shape:?}: {got} for {wanted}");
        }
    }

    #[test]
    fn a_flat_hull_is_an_error_that_names_it() {
        let points = vec![DVec3::X, DVec3::Y];
        let error = triangles_of(&Shape::ConvexHull { points, source: None }, "plank").unwrap_err();
        assert!(error.to_string().contains("plank"));
    }

    #[test]
    fn weld_merges_repeated_vertices() {
        let (vertices, triangles) =
            weld(&[DVec3::X, DVec3::Y, DVec3::Z, DVec3::X], &[[0, 1, 2], [3, 1, 2], [0, 3, 1]]);
        assert_eq!(vertices.len(), 3);
        assert_eq!(triangles.len(), 2);
        assert_eq!(triangles[0], triangles[1]);
    }
}
