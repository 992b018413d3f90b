//! The underside of a foot within its declared sole: where the foot is, and how high over the sole
//! plane.

use std::cell::OnceCell;

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{Foot, RobotModel};

use crate::base::comparison::{is_at_most, largest, smallest};
use crate::geometry::body::{CollisionBody, SolidPose};
use crate::geometry::bounds::Bounds;
use crate::geometry::polygon;
use crate::geometry::rays::{Hit, Target};
use crate::geometry::separation::separation;
use crate::geometry::solid::{Convex, Core, Solid};
use crate::statics::error::CheckerError;
use crate::statics::tuning::{
    EDGE_INSET, EDGE_PULL, END_TILT_MAX, FINE_SAMPLE_SPACING, NEIGHBOUR_DISTANCE, RAY_START,
    ROUND_FLATNESS, SAMPLE_SPACING, SOLE_FLATNESS,
};

/// A point of the declared sole.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SolePoint {
    /// In the sole frame, m.
    pub(crate) at: DVec2,
    /// Height of the foot's underside over the sole plane there, m; infinite where the foot is not.
    pub(crate) height: f64,
}

/// The underside of a foot.
pub(crate) struct Underside {
    /// The declared sole.
    pub(crate) outline: Vec<DVec2>,
    /// A sheared grid over the sole.
    pub(crate) coarse: Vec<SolePoint>,
    /// Points along its edges.
    pub(crate) edges: Vec<SolePoint>,
    /// The share of the sole that lies on the foot; the rest carries nothing.
    pub(crate) share_on_foot: f64,
    shapes: Vec<Target>,
    /// How far from the sole the ground is measured, m.
    reach: f64,
    fine: OnceCell<FineGrid>,
    neighbours: OnceCell<Vec<Vec<usize>>>,
}

/// A grid of points over a sole and around it, x by x.
pub(crate) struct FineGrid {
    low: DVec2,
    width: usize,
    height: usize,
    /// Height of the foot's underside over the sole plane, m; infinite where the foot is not, NaN
    /// outside the sole.
    heights: Vec<f64>,
    /// Whether a point lies beside the sole, where the foot may come to stand.
    is_beside: Vec<bool>,
    /// Points along the edges of the sole, as near to each other.
    edges: Vec<SolePoint>,
    /// How far the foot may be beside its pose, m.
    reach: f64,
    /// The steps in index from a grid point to those within `reach`, and to those within one cell
    /// more.
    near: Vec<isize>,
    farther: Vec<isize>,
}

impl Underside {
    /// Measures a foot from below that may be beside its pose by `reach` (m).
    ///
    /// # Errors
    /// A shape of the foot has no form for ray casts.
    pub(crate) fn new(model: &RobotModel, foot: &Foot, reach: f64) -> Result<Self, String> {
        let sole_from_link = foot.link_from_sole.inverse();
        let link = &model.links[foot.link];
        let shapes: Vec<Target> = link
            .shapes
            .iter()
            .map(|shape| Target::new(&shape.shape, &(sole_from_link * shape.link_from_shape)))
            .collect::<Result<_, _>>()
            .map_err(|error| format!("{}: {error}", link.name))?;
        let outline = polygon::hull(&foot.polygon);
        let point = |at: DVec2| SolePoint { at, height: height_over(&shapes, at) };
        let is_foot = |point: &SolePoint| point.height.is_finite();
        let mut coarse: Vec<SolePoint> = coarse_points(&outline).into_iter().map(point).collect();
        let on_foot = coarse.iter().filter(|point| point.height == 0.0).count();
        let share_on_foot = on_foot as f64 / coarse.len().max(1) as f64;
        coarse.retain(is_foot);
        let edges = edge_points(&outline, SAMPLE_SPACING);
        let edges = edges.into_iter().map(point).filter(is_foot).collect();
        let (fine, neighbours) = (OnceCell::new(), OnceCell::new());
        Ok(Self { outline, coarse, edges, share_on_foot, shapes, reach, fine, neighbours })
    }

    /// The share of the sole that lies between its parts on the foot, where it can carry.
    pub(crate) fn share_carrying(&self) -> f64 {
        let on_foot = self.coarse.iter().chain(&self.edges).filter(|point| point.height == 0.0);
        let between = polygon::hull(&on_foot.map(|point| point.at).collect::<Vec<_>>());
        polygon::area(&between) / polygon::area(&self.outline)
    }

    /// The greatest distance by which the foot reaches below its sole, m; not above 0 where it does
    /// not.
    fn depth_below_sole(&self) -> f64 {
        let heights = self.coarse.iter().chain(&self.edges).map(|point| point.height);
        -smallest(heights)
    }

    /// A fine grid over the sole, measured when it is first used.
    pub(crate) fn fine(&self) -> &FineGrid {
        self.fine.get_or_init(|| FineGrid::new(&self.outline, &self.shapes, self.reach))
    }

    /// The points within [`NEIGHBOUR_DISTANCE`] of each point, as indices into the grid and the
    /// points of the edges after it.
    pub(crate) fn neighbours(&self) -> &[Vec<usize>] {
        self.neighbours.get_or_init(|| {
            let all: Vec<DVec2> =
                self.coarse.iter().chain(&self.edges).map(|point| point.at).collect();
            let mut order: Vec<usize> = (0..all.len()).collect();
            order.sort_by(|&a, &b| all[a].x.total_cmp(&all[b].x));
            let around = |at: &DVec2| {
                let reach = NEIGHBOUR_DISTANCE + SAMPLE_SPACING;
                let first = order.partition_point(|&other| all[other].x < at.x - reach);
                let end = order.partition_point(|&other| all[other].x <= at.x + reach);
                let in_reach = order[first..end].iter().copied();
                let is_near = |other: &usize| all[*other].distance(*at) <= NEIGHBOUR_DISTANCE;
                let mut near: Vec<usize> = in_reach.filter(is_near).collect();
                near.sort_unstable();
                near
            };
            all.iter().map(around).collect()
        })
    }
}

impl FineGrid {
    fn new(outline: &[DVec2], shapes: &[Target], reach: f64) -> Self {
        let (low, high) = extent(outline);
        let beside = reach + FINE_SAMPLE_SPACING;
        let around = DVec2::splat(FINE_SAMPLE_SPACING * (beside / FINE_SAMPLE_SPACING).ceil());
        let count = ((high - low + 2.0 * around) / FINE_SAMPLE_SPACING).ceil() + 1.0;
        let (width, height) = (count.x as usize, count.y as usize);
        let steps = |radius| {
            let cells = cells_within(radius);
            cells.map(|(x, y)| x as isize * height as isize + y as isize).collect()
        };
        let mut grid = Self {
            low: low - around,
            width,
            height,
            heights: Vec::new(),
            is_beside: Vec::new(),
            edges: Vec::new(),
            reach,
            near: steps(reach),
            farther: steps(beside),
        };
        let sides: Vec<(DVec2, DVec2)> =
            polygon::sides(outline).map(|(a, b)| (a, (b - a).normalize_or_zero())).collect();
        for index in 0..width * height {
            let at = grid.at(index);
            let inside = smallest(sides.iter().map(|(from, along)| along.perp_dot(at - *from)));
            let is_on_sole = inside >= EDGE_INSET;
            let is_beside = || inside >= -beside && polygon::margin(outline, at) >= -beside;
            grid.heights.push(if is_on_sole { height_over(shapes, at) } else { f64::NAN });
            grid.is_beside.push(!is_on_sole && is_beside());
        }
        let edge = |at: DVec2| SolePoint { at, height: height_over(shapes, at) };
        let edges = edge_points(outline, FINE_SAMPLE_SPACING).into_iter().map(edge);
        grid.edges = edges.filter(|point| point.height.is_finite()).collect();
        grid
    }

    /// The points along the edges of the sole.
    pub(crate) fn edges(&self) -> &[SolePoint] {
        &self.edges
    }

    /// How far the foot may be beside its pose, m.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// The place of a point, m.
    pub(crate) fn at(&self, index: usize) -> DVec2 {
        self.place(index / self.height, index % self.height)
    }

    /// The point in a column and a row.
    fn place(&self, x: usize, y: usize) -> DVec2 {
        self.low + FINE_SAMPLE_SPACING * DVec2::new(x as f64, y as f64)
    }

    fn cell(&self, at: DVec2) -> (usize, usize) {
        let cell = ((at - self.low) / FINE_SAMPLE_SPACING).round().max(DVec2::ZERO);
        ((cell.x as usize).min(self.width - 1), (cell.y as usize).min(self.height - 1))
    }

    /// The index of the grid point nearest to a position.
    pub(crate) fn nearest(&self, at: DVec2) -> usize {
        let (x, y) = self.cell(at);
        x * self.height + y
    }

    /// Whether the foot is over a point of the sole.
    pub(crate) fn is_foot(&self, index: usize) -> bool {
        self.heights[index].is_finite()
    }

    /// The number of grid points.
    pub(crate) fn len(&self) -> usize {
        self.heights.len()
    }

    /// How far around a sample the ground is measured that the foot may miss, m: a little where the
    /// underside is flat, since ground farther away is near as well then or out of reach.
    pub(crate) fn width_around(&self) -> f64 {
        let is_flat = self.heights.iter().all(|height| !height.is_finite() || *height == 0.0);
        0.5 * SAMPLE_SPACING + if is_flat { 0.0 } else { self.reach }
    }

    /// The indices of all points of the foot within `width` (m) of one of `near` along both axes,
    /// in order.
    pub(crate) fn around(&self, near: impl Iterator<Item = DVec2>, width: f64) -> Vec<usize> {
        let mut is_wanted = vec![false; self.heights.len()];
        for at in near {
            let (first, last) = (self.cell(at - width), self.cell(at + width));
            for x in first.0..=last.0 {
                let row = x * self.height;
                is_wanted[row + first.1..=row + last.1].fill(true);
            }
        }
        let is_foot = |index: &usize| is_wanted[*index] && self.heights[*index].is_finite();
        (0..self.heights.len()).filter(is_foot).collect()
    }

    /// The point with this index; beside the sole at the height of the sole plane.
    pub(crate) fn point(&self, index: usize) -> SolePoint {
        let height = if self.is_beside[index] { 0.0 } else { self.heights[index] };
        SolePoint { at: self.at(index), height }
    }

    /// The indices of all points beside the sole near which one of `places`, grid points on it, may
    /// come to lie, in order.
    pub(crate) fn beside(&self, places: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut is_wanted = vec![false; self.heights.len()];
        for index in places {
            steps_from(&self.farther, index).for_each(|near| is_wanted[near] = true);
        }
        (0..self.heights.len()).filter(|&index| is_wanted[index] && self.is_beside[index]).collect()
    }

    /// The indices of all grid points where a position on the sole may come to lie.
    pub(crate) fn within(&self, at: DVec2) -> impl Iterator<Item = usize> + '_ {
        let (first, last) = (self.cell(at - self.reach), self.cell(at + self.reach));
        let cells = (first.0..=last.0).flat_map(move |x| (first.1..=last.1).map(move |y| (x, y)));
        let is_near = move |(x, y): &(usize, usize)| self.place(*x, *y).distance(at) <= self.reach;
        cells.filter(is_near).map(|(x, y)| x * self.height + y)
    }

    /// As [`Self::within`], of a grid point on the sole or next to it.
    pub(crate) fn within_point(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        steps_from(&self.near, index)
    }

    /// The corners of the hull of the points near a grid point, as ways from it.
    pub(crate) fn outermost_offsets(&self) -> Vec<DVec2> {
        polygon::hull(&cells_within(self.reach).map(way).collect::<Vec<_>>())
    }

    /// The indices of the grid points after this one along x and y, if they are on the grid.
    pub(crate) fn next(&self, index: usize) -> impl Iterator<Item = usize> {
        let along_y = (index % self.height + 1 < self.height).then_some(index + 1);
        let along_x = index + self.height;
        [Some(along_x).filter(|next| *next < self.heights.len()), along_y].into_iter().flatten()
    }
}

/// The way along this many cells of the fine grid, m.
fn way((x, y): (i32, i32)) -> DVec2 {
    FINE_SAMPLE_SPACING * DVec2::new(x.into(), y.into())
}

/// The grid points within `radius` (m) of one, counted in cells from it.
fn cells_within(radius: f64) -> impl Iterator<Item = (i32, i32)> {
    let most = (radius / FINE_SAMPLE_SPACING).floor() as i32;
    let cells = (-most..=most).flat_map(move |x| (-most..=most).map(move |y| (x, y)));
    cells.filter(move |&cell| way(cell).length() <= radius)
}

fn steps_from(steps: &[isize], index: usize) -> impl Iterator<Item = usize> + '_ {
    steps.iter().map(move |&step| index.wrapping_add_signed(step))
}

/// The height of the lowest shape over the sole plane, by a ray from below it; 0 where it is flat
/// within [`SOLE_FLATNESS`], and within [`ROUND_FLATNESS`] where it is round.
fn height_over(shapes: &[Target], at: DVec2) -> f64 {
    let height = |shape: &Target| match shape.cast(at.extend(-RAY_START), DVec3::Z) {
        Hit::Miss => f64::INFINITY,
        Hit::Inside => -RAY_START,
        Hit::Surface { distance, normal } => {
            let height = distance - RAY_START;
            let is_round = shape.is_round() && normal.truncate().length() > END_TILT_MAX;
            let flatness = if is_round { ROUND_FLATNESS } else { SOLE_FLATNESS };
            if is_at_most(height.abs(), flatness) { 0.0 } else { height }
        }
    };
    let lowest = smallest(shapes.iter().map(height));
    if is_at_most(lowest, 2.0 * RAY_START) { lowest } else { f64::INFINITY }
}

/// A grid over the sole, each row of it shifted so that no straight bar of a few millimetres lies
/// between all rays.
fn coarse_points(sole: &[DVec2]) -> Vec<DVec2> {
    let (low, high) = extent(sole);
    let count = ((high - low) / SAMPLE_SPACING).ceil();
    let cells = (0..count.y as usize).flat_map(|y| (0..count.x as usize).map(move |x| (x, y)));
    cells
        .map(|(x, y)| {
            let shift = DVec2::new((2 * y % 5) as f64 / 5.0, (2 * x % 5) as f64 / 5.0);
            low + SAMPLE_SPACING * (DVec2::new(x as f64, y as f64) + shift)
        })
        .filter(|&at| polygon::margin(sole, at) >= EDGE_INSET)
        .collect()
}

fn edge_points(sole: &[DVec2], spacing: f64) -> Vec<DVec2> {
    let middle = sole.iter().sum::<DVec2>() / sole.len() as f64;
    let edges = polygon::sides(sole).flat_map(|(a, b)| {
        let pieces = ((b - a).length() / spacing).ceil().max(1.0) as usize;
        (0..pieces).map(move |piece| a + (b - a) * (piece as f64 / pieces as f64))
    });
    edges.map(|at| middle + (at - middle) * (1.0 - EDGE_PULL)).collect()
}

fn extent(sole: &[DVec2]) -> (DVec2, DVec2) {
    sole.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
        (low.min(*at), high.max(*at))
    })
}

/// Whether each declared sole lies on its foot's own collision shapes within `tolerance` (m), so
/// that no robot file declares a sole larger than its foot, or above the foot's lowest parts. Parts
/// of a sole over which the foot is hollow carry nothing.
///
/// # Errors
/// A vertex of a sole that is farther from the shapes, or a foot that reaches farther below.
pub(crate) fn check_soles(
    model: &RobotModel,
    bodies: &[CollisionBody],
    undersides: &[Underside],
    tolerance: f64,
) -> Result<(), CheckerError> {
    let millimetres = |distance: f64| (1e3 * distance).min(1e6).ceil() as u64;
    for (foot, underside) in model.feet.iter().zip(undersides) {
        let off = largest(foot.polygon.iter().map(|at| distance_to_foot(foot, *at, bodies)));
        if !is_at_most(off, tolerance) {
            let (foot, millimetres) = (foot.name.clone(), millimetres(off));
            return Err(CheckerError::SoleOffFoot { foot, millimetres });
        }
        let below = underside.depth_below_sole();
        if !is_at_most(below, tolerance) {
            let (foot, millimetres) = (foot.name.clone(), millimetres(below));
            return Err(CheckerError::FootBelowSole { foot, millimetres });
        }
    }
    Ok(())
}

/// The distance of a point of a sole to the surface of its foot, or its depth in the foot, m.
fn distance_to_foot(foot: &Foot, at: DVec2, bodies: &[CollisionBody]) -> f64 {
    let vertex = Solid::Convex(Convex { core: Core::Segment(0.0), radius: 0.0 });
    let point = foot.link_from_sole * at.extend(0.0);
    let placed = SolidPose {
        world_from_solid: Pose::from_translation(point),
        bounds: Bounds { low: point, high: point },
    };
    smallest(bodies.iter().filter(|body| body.link == Some(foot.link)).map(|body| {
        let on_link = SolidPose::new(body, &Pose::IDENTITY);
        let solids = ((&body.solid, &on_link), (&vertex, &placed));
        separation(solids.0, solids.1, DVec3::Z, 1.0).distance.abs()
    }))
}

#[cfg(test)]
mod tests;
