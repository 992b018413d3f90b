//! The support of a flat rigid sole on boxes and meshes, computed on a dense grid: a reference for
//! the checker's that shares nothing with it.

use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3};
use surefoot_shared_types::world::world::World;
use surefoot_shared_types::{Pose, Shape};

/// Distance between neighbouring places, m.
const SPACING: f64 = 5e-4;
/// Ground higher over the sole plane than this is no ground of the sole, m.
const HIGH: f64 = 0.02;
/// Ground lower than this is a void, m.
const LOW: f64 = -0.02;
/// Points lower than the highest by more do not touch, m.
const TOUCH_GAP: f64 = 1.5e-3;
/// The largest tilt of a resting foot, rad.
const TILT_MAX: f64 = 0.022;
/// Tilts to the side of a direction, rad.
const SIDE_TILTS: [f64; 9] = [0.0, 1.25e-4, -1.25e-4, 2.5e-4, -2.5e-4, 5e-4, -5e-4, 1e-3, -1e-3];
/// Directions of tilt.
const DIRECTIONS: usize = 240;

/// A place under a sole.
#[derive(Debug, Clone, Copy)]
struct Sample {
    at: DVec2,
    height: f64,
    carries: bool,
}

/// The ground near a sole in its frame, on a grid that extends beyond the outline by `reach`.
pub struct DenseGround {
    low: DVec2,
    columns: usize,
    rows: usize,
    heights: Vec<f64>,
    carries: Vec<bool>,
    outline: Vec<DVec2>,
    triangles: Vec<([DVec3; 3], bool)>,
}

fn triangles_of(shape: &Shape) -> Vec<[DVec3; 3]> {
    match shape {
        Shape::Mesh { vertices, triangles, .. } => {
            triangles.iter().map(|of| of.map(|index| vertices[index as usize])).collect()
        }
        Shape::Box { half_extents } => {
            let faces = (0..3).flat_map(|axis| [-1.0, 1.0].map(|side| (axis, side)));
            faces.flat_map(|(axis, side)| box_face(*half_extents, axis, side)).collect()
        }
        _ => Vec::new(),
    }
}

/// The two triangles of the face of a box to one side of an axis.
fn box_face(half_extents: DVec3, axis: usize, side: f64) -> [[DVec3; 3]; 2] {
    let corner = |u: f64, v: f64| {
        let mut at = [side; 3];
        (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (u, v);
        half_extents * DVec3::from_array(at)
    };
    let [a, b] = [corner(-1.0, -1.0), corner(side, -side)];
    let [c, d] = [corner(1.0, 1.0), corner(-side, side)];
    [[a, b, c], [a, c, d]]
}

impl DenseGround {
    /// The ground of a world under a sole.
    pub fn new(world: &World, world_from_sole: &Pose, outline: &[DVec2], reach: f64) -> Self {
        let sole_from_world = world_from_sole.inverse();
        let up = sole_from_world.rotation * DVec3::Z;
        let slope_cos = 1.0 / (1.0 + world.mu * world.mu).sqrt();
        let tilt_cos = libm::cos(5f64.to_radians());
        let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min) - reach - 2e-3;
        let high = outline.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max) + reach + 2e-3;
        let cells = ((high - low) / SPACING).ceil();
        let (columns, rows) = (cells.x as usize + 1, cells.y as usize + 1);
        let count = columns * rows;
        let mut ground = Self {
            low,
            columns,
            rows,
            heights: vec![f64::NEG_INFINITY; count],
            carries: vec![false; count],
            outline: outline.to_vec(),
            triangles: Vec::new(),
        };
        for shape in &world.shapes {
            let sole_from_shape = sole_from_world * shape.world_from_shape;
            for triangle in triangles_of(&shape.shape) {
                let triangle = triangle.map(|corner| sole_from_shape * corner);
                let [a, b, c] = triangle;
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let (from, to) = (a.min(b).min(c), a.max(b).max(c));
                let is_near = from.x <= high.x
                    && to.x >= low.x
                    && from.y <= high.y
                    && to.y >= low.y
                    && from.z <= HIGH
                    && to.z >= LOW;
                if normal.z <= 1e-6 || !is_near {
                    continue;
                }
                let carries = normal.z >= tilt_cos && normal.dot(up) >= slope_cos - 1e-9;
                ground.triangles.push((triangle, carries));
            }
        }
        for index in 0..ground.triangles.len() {
            ground.raise(index);
        }
        ground
    }

    fn at(&self, column: usize, row: usize) -> DVec2 {
        self.low + SPACING * DVec2::new(column as f64, row as f64)
    }

    fn raise(&mut self, index: usize) {
        let ([a, b, c], carries) = self.triangles[index];
        let from = ((a.min(b).min(c).truncate() - self.low) / SPACING).floor().max(DVec2::ZERO);
        let to = (a.max(b).max(c).truncate() - self.low) / SPACING;
        for column in from.x as usize..=(to.x.max(0.0) as usize).min(self.columns - 1) {
            for row in from.y as usize..=(to.y.max(0.0) as usize).min(self.rows - 1) {
                let Some(height) = height_on(&[a, b, c], self.at(column, row)) else { continue };
                let cell = column * self.rows + row;
                let is_higher = height > self.heights[cell] + 1e-12;
                if height <= HIGH && (is_higher || height > self.heights[cell] - 1e-12 && carries) {
                    self.heights[cell] = height.max(self.heights[cell]);
                    self.carries[cell] = carries;
                }
            }
        }
    }

    fn exact(&self, at: DVec2) -> (f64, bool) {
        let mut best = (f64::NEG_INFINITY, false);
        for (triangle, carries) in &self.triangles {
            let Some(height) = height_on(triangle, at) else { continue };
            if height <= HIGH && (height > best.0 + 1e-12 || height > best.0 - 1e-12 && *carries) {
                best = (height.max(best.0), *carries);
            }
        }
        best
    }

    /// Places on the grid within the outline and along it, with the ground lowered to the lowest
    /// within `shift` (m).
    fn places(&self, shift: f64) -> Vec<Sample> {
        let sides = || self.outline.iter().zip(self.outline.iter().cycle().skip(1));
        let is_inside = |at: DVec2| sides().all(|(a, b)| (*b - *a).perp_dot(at - *a) >= 0.0);
        let steps = (shift / SPACING).floor() as i32;
        let near: Vec<(i32, i32)> = (-steps..=steps)
            .flat_map(|x| (-steps..=steps).map(move |y| (x, y)))
            .filter(|&(x, y)| DVec2::new(x.into(), y.into()).length() * SPACING <= shift + 1e-12)
            .collect();
        let mut found = Vec::new();
        for column in 0..self.columns {
            for row in 0..self.rows {
                let at = self.at(column, row);
                if !is_inside(at) {
                    continue;
                }
                let mut height = f64::INFINITY;
                let mut carries = false;
                for &(x, y) in &near {
                    let index =
                        (column as i32 + x) as usize * self.rows + (row as i32 + y) as usize;
                    height = height.min(self.heights[index]);
                }
                // A foot touches a peak from its gentle side.
                for (x, y) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y))) {
                    let index =
                        (column as i32 + x) as usize * self.rows + (row as i32 + y) as usize;
                    carries |= self.carries[index];
                }
                found.push(Sample { at, height, carries });
            }
        }
        for (a, b) in sides() {
            let pieces = (a.distance(*b) / SPACING).ceil() as usize;
            for piece in 0..pieces {
                let at = a.lerp(*b, piece as f64 / pieces as f64);
                let (mut height, mut carries) = self.exact(at);
                for k in 0..8 {
                    carries |=
                        self.exact(at + SPACING * DVec2::from_angle(f64::from(k) * FRAC_PI_4)).1;
                }
                if shift > 0.0 {
                    for k in 0..24 {
                        let aside = at + shift * DVec2::from_angle(f64::from(k) * FRAC_PI_4 / 3.0);
                        height = height.min(self.exact(aside).0);
                    }
                }
                found.push(Sample { at, height, carries });
            }
        }
        found
    }

    /// The part that holds a centre of mass at `height`: where the foot is, and where it finds all
    /// ground as low as the lowest within `shift`; as offsets along each direction.
    pub fn region(&self, height: f64, shift: f64) -> DenseRegion {
        let touched = DenseRegion::of(self.places(0.0), height);
        let lowered = DenseRegion::of(self.places(shift), height);
        touched.and(&lowered)
    }
}

/// A convex region by how far it extends in each direction.
pub struct DenseRegion {
    reaches: Vec<f64>,
}

fn direction(k: usize) -> DVec2 {
    DVec2::from_angle(std::f64::consts::TAU * k as f64 / DIRECTIONS as f64)
}

impl DenseRegion {
    fn of(places: Vec<Sample>, height: f64) -> Self {
        let top = places.iter().map(|place| place.height).fold(f64::NEG_INFINITY, f64::max);
        let touching: Vec<Sample> =
            places.into_iter().filter(|place| place.height >= top - TOUCH_GAP).collect();
        let touching = prominent(touching);
        let tilted = |along: DVec2, side_tilt: f64| {
            let raised = |place: &Sample| Sample {
                height: place.height + side_tilt * along.perp().dot(place.at),
                ..*place
            };
            let places: Vec<Sample> = touching.iter().map(raised).collect();
            reach(&places, along, height) - height * side_tilt.abs()
        };
        let farthest = |along: DVec2| {
            SIDE_TILTS
                .map(|side_tilt| tilted(along, side_tilt))
                .into_iter()
                .fold(f64::MIN, f64::max)
        };
        let reaches = (0..DIRECTIONS).map(|k| farthest(direction(k))).collect();
        Self { reaches }
    }

    fn and(mut self, other: &Self) -> Self {
        self.reaches.iter_mut().zip(&other.reaches).for_each(|(own, other)| *own = own.min(*other));
        self
    }

    /// How far a point lies beyond the region, m; infinite where there is none.
    pub fn beyond(&self, at: DVec2) -> f64 {
        (0..DIRECTIONS)
            .map(|k| direction(k).dot(at) - self.reaches[k])
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Leaves out places that lie under the line between two others of their column or row.
fn prominent(mut places: Vec<Sample>) -> Vec<Sample> {
    for axis in [0, 1] {
        places.sort_by(|p, q| {
            let (p, q) = (p.at.to_array(), q.at.to_array());
            p[axis].total_cmp(&q[axis]).then(p[1 - axis].total_cmp(&q[1 - axis]))
        });
        let mut kept: Vec<Sample> = Vec::new();
        let mut first = 0;
        for place in places {
            let line = |p: &Sample| p.at.to_array()[axis];
            let along = |p: &Sample| p.at.to_array()[1 - axis];
            if kept.last().is_some_and(|last| line(last) != line(&place)) {
                first = kept.len();
            }
            while kept.len() >= first + 2 {
                let (from, middle) = (kept[kept.len() - 2], kept[kept.len() - 1]);
                let share = (along(&middle) - along(&from)) / (along(&place) - along(&from));
                if middle.height > from.height + share * (place.height - from.height) + 1e-9 {
                    break;
                }
                kept.pop();
            }
            kept.push(place);
        }
        places = kept;
    }
    places
}

/// How far along a direction a centre of mass may be, over all tilts: the foot goes from each
/// place that it stands on to the next one.
fn reach(places: &[Sample], along: DVec2, height: f64) -> f64 {
    let mut profile: Vec<(f64, f64, bool)> =
        places.iter().map(|place| (along.dot(place.at), place.height, place.carries)).collect();
    profile.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)));
    let mut hull: Vec<(f64, f64, bool)> = Vec::new();
    for point in profile {
        while let [.., a, b] = hull[..] {
            if (b.1 - a.1) * (point.0 - a.0) > (point.1 - a.1) * (b.0 - a.0) {
                break;
            }
            hull.pop();
        }
        hull.push(point);
    }
    let top = hull.iter().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
    let mut best = f64::NEG_INFINITY;
    for (index, point) in hull.iter().enumerate() {
        let is_after_top = hull[..=index].iter().any(|before| before.1 >= top);
        if !is_after_top {
            continue;
        }
        let tilt = match index.checked_sub(1).map(|before| hull[before]) {
            Some(before) => ((before.1 - point.1) / (point.0 - before.0)).max(0.0),
            None => 0.0,
        };
        if tilt <= TILT_MAX && point.2 {
            best = best.max(point.0 - height * tilt);
        }
    }
    best
}

fn height_on([a, b, c]: &[DVec3; 3], at: DVec2) -> Option<f64> {
    let side = |p: &DVec3, q: &DVec3| (q - p).truncate().perp_dot(at - p.truncate());
    let (u, v, w) = (side(b, c), side(c, a), side(a, b));
    (u >= -1e-13 && v >= -1e-13 && w >= -1e-13 && u + v + w > 0.0)
        .then(|| (u * a.z + v * b.z + w * c.z) / (u + v + w))
}
