//! The support of a flat rigid sole on boxes and meshes, computed on a dense grid: a reference for
//! the checker's that shares nothing with it.

use std::f64::consts::TAU;

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

/// The height of the ground over the sole plane, m, and whether it can carry.
type Ground = (f64, bool);

/// A void.
const NO_GROUND: Ground = (f64::NEG_INFINITY, false);

/// The higher one of two, the second one only where it is ground of the sole; of two as high one
/// that carries.
fn higher(best: Ground, other: Ground) -> Ground {
    let is_higher = other.0 > best.0 + 1e-12 || other.0 > best.0 - 1e-12 && other.1;
    if other.0 <= HIGH && is_higher { (other.0.max(best.0), other.1) } else { best }
}

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
    cells: Vec<Ground>,
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
        let mut ground = Self {
            low,
            columns,
            rows,
            cells: vec![NO_GROUND; columns * rows],
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
                self.cells[cell] = higher(self.cells[cell], (height, carries));
            }
        }
    }

    fn exact(&self, at: DVec2) -> Ground {
        let mut best = NO_GROUND;
        for (triangle, carries) in &self.triangles {
            let Some(height) = height_on(triangle, at) else { continue };
            best = higher(best, (height, *carries));
        }
        best
    }

    fn sides(&self) -> impl Iterator<Item = (DVec2, DVec2)> {
        self.outline.iter().copied().zip(self.outline.iter().copied().cycle().skip(1))
    }

    /// Places on the grid within the outline and along it, with the ground lowered to the lowest
    /// within `shift` (m).
    fn places(&self, shift: f64) -> Vec<Sample> {
        let mut found = self.places_on_grid(shift);
        found.extend(self.places_on_outline(shift));
        found
    }

    fn places_on_grid(&self, shift: f64) -> Vec<Sample> {
        let is_inside = |at: DVec2| self.sides().all(|(a, b)| (b - a).perp_dot(at - a) >= 0.0);
        let steps =
            |reach: i32| (-reach..=reach).flat_map(move |x| (-reach..=reach).map(move |y| (x, y)));
        let is_near = |&(x, y): &(i32, i32)| {
            DVec2::new(x.into(), y.into()).length() * SPACING <= shift + 1e-12
        };
        let near: Vec<(i32, i32)> =
            steps((shift / SPACING).floor() as i32).filter(is_near).collect();
        let all = (0..self.columns).flat_map(|column| (0..self.rows).map(move |row| (column, row)));
        let inside = all.filter(|&(column, row)| is_inside(self.at(column, row)));
        let sample = |(column, row): (usize, usize)| {
            let beside = |(x, y): (i32, i32)| {
                let (column, row) = (column as i32 + x, row as i32 + y);
                self.cells[column as usize * self.rows + row as usize]
            };
            let heights = near.iter().map(|step| beside(*step).0);
            // A foot touches a peak from its gentle side.
            let carries = steps(1).any(|step| beside(step).1);
            Sample {
                at: self.at(column, row),
                height: heights.fold(f64::INFINITY, f64::min),
                carries,
            }
        };
        inside.map(sample).collect()
    }

    fn places_on_outline(&self, shift: f64) -> Vec<Sample> {
        let places = self.sides().flat_map(|(a, b)| {
            let pieces = (a.distance(b) / SPACING).ceil() as usize;
            (0..pieces).map(move |piece| a.lerp(b, piece as f64 / pieces as f64))
        });
        let around = |at: DVec2, radius: f64, count: u32| {
            let step = TAU / f64::from(count);
            (0..count)
                .map(move |k| self.exact(at + radius * DVec2::from_angle(f64::from(k) * step)))
        };
        let sample = |at: DVec2| {
            let (height, carries) = self.exact(at);
            let lowered = around(at, shift, 24).map(|ground| ground.0);
            Sample {
                at,
                height: lowered.fold(height, f64::min),
                carries: carries || around(at, SPACING, 8).any(|ground| ground.1),
            }
        };
        places.map(sample).collect()
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
    DVec2::from_angle(TAU * k as f64 / DIRECTIONS as f64)
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
