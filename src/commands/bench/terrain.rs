//! Rolling rubble as one triangle mesh of any size: how cost grows with the size of the world.
//!
//! Square plates, each level with itself but tilted and shifted against its neighbours, follow a
//! gentle wave; strips of steep triangles join them. More triangles make a larger field of the same
//! rubble, so that the same walk over its middle has the same ground at every size. Around
//! both stances the ground is flat.

use glam::{DVec2, DVec3};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// Where a walk over the middle starts and ends, in the world, m; both stances head along x.
pub const STANCES: [DVec3; 2] = [DVec3::new(-2.5, 0.0, 0.0), DVec3::new(2.5, 0.0, 0.0)];
/// Side of a grid square, two triangles, m.
pub const CELL: f64 = 0.1;
/// Grid squares from one plate to the next; one of them is the strip between both.
pub const PITCH: usize = 4;

/// The seed of every field.
const SEED: u64 = 1;
/// The wave's height, m, and its angular frequencies along x and y, rad/m.
const WAVE: (f64, DVec2) = (0.08, DVec2::new(1.3, 1.7));
/// How far a plate lies above or below the wave, m.
const SHIFT: f64 = 0.03;
/// Slope of a plate along x or y.
const SLOPE: f64 = 0.1;
/// How far from a stance the ground is flat, m.
const FLAT: f64 = 0.8;

/// A field of `2 * n * m` triangles, `n` by `m` squares as nearly square as possible, the longer
/// side along x, its middle at the origin. An odd number of triangles is rounded down; there are at
/// least two.
pub fn mesh_terrain(triangles: usize) -> World {
    let squares = squares_of((triangles / 2).max(1));
    let half = 0.5 * CELL * DVec2::new(squares[0] as f64, squares[1] as f64);
    let columns = squares[1] + 1;
    let vertex = |i: usize, j: usize| {
        let at = CELL * DVec2::new(i as f64, j as f64) - half;
        at.extend(height_at(i, j, half))
    };
    let vertices = (0..=squares[0]).flat_map(|i| (0..columns).map(move |j| vertex(i, j))).collect();
    let corner = |i: usize, j: usize| (i * columns + j) as u32;
    let halves = |(i, j): (usize, usize)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..squares[0])
        .flat_map(|i| (0..squares[1]).map(move |j| (i, j)))
        .flat_map(halves)
        .collect();
    world_of(vertices, triangles)
}

/// The two factors of a number that are nearest to each other, the larger first.
fn squares_of(count: usize) -> [usize; 2] {
    let side = (1..=count)
        .take_while(|n| n * n <= count)
        .filter(|n| count.is_multiple_of(*n))
        .last()
        .unwrap_or(1);
    [count / side, side]
}

/// The height of a grid point.
fn height_at(i: usize, j: usize, half: DVec2) -> f64 {
    let [plate_i, plate_j] = [i / PITCH, j / PITCH];
    let middle = |plate: usize| CELL * ((plate * PITCH) as f64 + 0.5 * (PITCH - 1) as f64);
    let plate = DVec2::new(middle(plate_i), middle(plate_j)) - half;
    if STANCES.iter().any(|stance| (plate - stance.truncate()).abs().max_element() <= FLAT) {
        return 0.0;
    }
    // Named by its place about the middle, so that a larger field continues a smaller one where
    // their grids agree.
    let name = |x: f64| libm::round(x / CELL * 2.0) as i64 as u64 & 0xFFFF_FFFF;
    let mut random = Random::new(SEED, Stream::Preparation, name(plate.x) << 32 | name(plate.y), 0);
    let shift = random.uniform(-SHIFT, SHIFT);
    let slope = DVec2::new(random.uniform(-SLOPE, SLOPE), random.uniform(-SLOPE, SLOPE));
    let (wave, frequency) = WAVE;
    let rolling = wave * libm::sin(frequency.x * plate.x) * libm::sin(frequency.y * plate.y);
    let from_middle = CELL * DVec2::new(i as f64, j as f64) - half - plate;
    rolling + shift + slope.dot(from_middle)
}

fn world_of(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> World {
    let numbers: Vec<u8> =
        vertices.iter().flat_map(|v| v.to_array()).flat_map(f64::to_le_bytes).collect();
    let digest = Digest::of(&[b"mesh_terrain", &numbers]);
    let source = None;
    let shape = Shape::Mesh { vertices, triangles, source };
    World {
        mu: 0.6,
        shapes: vec![WorldShape {
            name: "terrain".into(),
            world_from_shape: Pose::IDENTITY,
            shape,
        }],
        digest,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(world: &World) -> (&[DVec3], &[[u32; 3]]) {
        match &world.shapes[0].shape {
            Shape::Mesh { vertices, triangles, .. } => (vertices, triangles),
            other => panic!("{other:?} is no mesh"),
        }
    }

    #[test]
    fn a_field_has_the_triangles_asked_for_and_is_nearly_square() {
        for triangles in [10_000, 100_000] {
            let world = mesh_terrain(triangles);
            let (vertices, faces) = mesh(&world);
            assert_eq!(faces.len(), triangles);
            let extent =
                |pick: fn(&DVec3) -> f64| 2.0 * vertices.iter().map(pick).fold(f64::MIN, f64::max);
            let (length, width) = (extent(|v| v.x), extent(|v| v.y));
            assert!((length * width - CELL * CELL * triangles as f64 / 2.0).abs() < 1e-6);
            assert!(width <= length && length <= 2.0 * width, "{length} by {width}");
            assert!(
                STANCES.iter().all(|stance| stance.x.abs() + 0.5 < 0.5 * length),
                "the stances lie on it"
            );
        }
    }

    #[test]
    fn plates_are_flat_mildly_sloped_and_differ() {
        let world = mesh_terrain(10_000);
        let (vertices, faces) = mesh(&world);
        let normal = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|i| vertices[i as usize]);
            (b - a).cross(c - a).normalize()
        };
        let columns = 51;
        let on_plate = |face: &[u32; 3]| {
            let place = face.map(|i| (i as usize / columns, i as usize % columns));
            place
                .iter()
                .all(|&(i, j)| (i / PITCH, j / PITCH) == (place[0].0 / PITCH, place[0].1 / PITCH))
        };
        let steepest = faces
            .iter()
            .filter(|face| on_plate(face))
            .map(|face| libm::acos(normal(face).z))
            .fold(0.0, f64::max);
        assert!((0.1..0.15).contains(&steepest), "{steepest} rad");
        assert!(
            faces.iter().any(|face| !on_plate(face) && normal(face).z < 0.95),
            "between plates it is steep"
        );
    }

    #[test]
    fn the_stances_lie_on_flat_ground() {
        let world = mesh_terrain(10_000);
        let (vertices, _) = mesh(&world);
        for stance in STANCES {
            let near = vertices
                .iter()
                .filter(|v| (v.truncate() - stance.truncate()).abs().max_element() < 0.5);
            assert!(near.clone().count() > 80 && near.clone().all(|v| v.z == 0.0));
        }
    }

    #[test]
    fn a_field_can_be_made_again_and_differs_from_another() {
        assert_eq!(mesh_terrain(10_000), mesh_terrain(10_000));
        assert_ne!(mesh_terrain(10_000).digest, mesh_terrain(20_000).digest);
    }
}
