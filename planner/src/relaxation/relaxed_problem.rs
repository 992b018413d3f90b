//! The relaxed problem of one search: its bounds, its grid, and the order of its parts.

use glam::DVec3;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::JointKind;

use crate::constraints::constraints::Constraints;
use crate::foot_placement::Surfaces;
use crate::geometry::bvh::Aabb;
use crate::relaxation::ball_search::{BallSearch, Passage};
use crate::relaxation::curve_search::{CurveSearch, RootWay};
use crate::relaxation::element_search::{ElementSearch, StepBounds};
use crate::relaxation::gap_search::GapSearch;
use crate::relaxation::grid::{Disc, Grid};
use crate::relaxation::ground::{add_element, bounds_of, for_each_height};
use crate::relaxation::leg_curve::LegCurve;
use crate::relaxation::obstruction::{Blockage, Enclosure, Obstruction};
use crate::relaxation::step_search::StepSearch;
use crate::relaxation::tuning::{
    COLUMNS_MAX, COLUMNS_PER_UNIT, ELEMENTS_PER_UNIT, PART_MARGIN, QUICK_COLUMNS_MAX,
    SOLE_TILT_TAN, TOLERANCE, VISITS_PER_UNIT,
};
use crate::robot::bounding_spheres::BoundingSphere;
use crate::robot::mechanism::Mechanism;

/// What the relaxed problem reads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RelaxedWorld<'a> {
    /// The robot and the shapes of the world.
    pub constraints: &'a Constraints,
    /// The surfaces on which soles can rest.
    pub surfaces: &'a Surfaces,
    /// Upper bound of the distance between the soles of a stance, m.
    pub step_reach: f64,
}

/// The start or the goal.
#[derive(Debug, Clone, Default)]
pub(crate) struct RelaxedEnd {
    /// The soles on the ground, m.
    pub soles: BoundedVec<DVec3, 2>,
    /// The root.
    pub world_from_root: Pose,
}

/// The result of the relaxed problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum RelaxedOutcome {
    /// Nothing.
    Open,
    /// There is no plan.
    Obstructed(Obstruction),
}

/// How much of the problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extent {
    /// The steps between elements of the ground and, where these do not lead to the goal, the gap.
    Elements,
    /// All, the legs on a large grid only where a ball in the root finds no way.
    Usual,
    /// All.
    Whole,
}

/// Upper bounds of what the robot can do.
#[derive(Debug, Clone, Copy, Default)]
struct Bounds {
    /// Greatest distance of a point of a sole from its origin, m.
    sole_radius: f64,
    /// Greatest distance between the soles of a stance, m.
    step_reach: f64,
    /// Greatest distance between points that the feet of a stance touch, m.
    span: f64,
    /// A ball in the root, in its frame.
    ball: Option<BoundingSphere>,
    /// Greatest distance of its centre from a point that a foot touches, m.
    ball_reach: f64,
    /// The curve from there along a leg to the ball's centre.
    curve: Option<LegCurve>,
}

/// The part of the relaxed problem that is next.
#[derive(Debug, Clone, Copy)]
enum Part {
    /// The bounds of the ground, from an element on.
    Measure(u32, Aabb),
    /// The elements of the ground that steps reach from an end.
    Elements(usize),
    /// The voxels of the ground, from an element on.
    Rasterize(u32),
    /// The steps from the start.
    StepsFromStart,
    /// The steps from the goal, where those from the start do not reach it.
    StepsFromGoal,
    /// The gap between both, from a column on.
    Gap(usize),
    /// The reach of the legs, from a column on.
    Reach(usize),
    /// The way of the ball, from one end to the other.
    Pass(usize),
    /// The feet on the reached ground, from a column on.
    Feet(usize),
    /// The places where legs hold the root.
    Legs,
    /// The way of the root through them.
    Root,
    Over(RelaxedOutcome),
}

/// The ground of start and goal.
#[derive(Debug)]
struct Ground {
    /// The elements that steps reach from start and goal.
    elements: [ElementSearch; 2],
    /// Whether those of the start do not lead to the goal.
    is_split: bool,
    /// The voxels of the ground of the start, and of that of the goal where both are split.
    voxels: [Vec<u64>; 2],
}

impl Ground {
    /// The voxels of the ground of an end, by column.
    fn of(&self, end: usize) -> &[u64] {
        &self.voxels[usize::from(self.is_split) * end]
    }
}

/// The relaxed problem. All memory is reserved when it is made.
#[derive(Debug)]
pub(crate) struct RelaxedProblem {
    bounds: Bounds,
    ends: [RelaxedEnd; 2],
    grid: Option<Grid>,
    /// Whether there is ground beyond the grid.
    is_clipped: bool,
    extent: Extent,
    ground: Ground,
    disc: Disc,
    steps: [StepSearch; 2],
    gap: GapSearch,
    ball: BallSearch,
    curves: CurveSearch,
    part: Part,
}

impl RelaxedProblem {
    /// A problem with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            bounds: Bounds::default(),
            ends: Default::default(),
            grid: None,
            is_clipped: false,
            extent: Extent::Usual,
            ground: Ground {
                elements: [ElementSearch::new(), ElementSearch::new()],
                is_split: false,
                voxels: [vec![0; COLUMNS_MAX], vec![0; COLUMNS_MAX]],
            },
            disc: Disc::new(),
            steps: [StepSearch::new(), StepSearch::new()],
            gap: GapSearch::new(),
            ball: BallSearch::new(),
            curves: CurveSearch::new(),
            part: Part::Over(RelaxedOutcome::Open),
        }
    }

    /// Begins with a robot in a world, between two ends.
    pub fn begin(&mut self, world: &RelaxedWorld<'_>, ends: [RelaxedEnd; 2], extent: Extent) {
        (self.bounds, self.ends, self.grid) = (Bounds::of(world), ends, None);
        self.extent = extent;
        self.steps[0].has_arrived = false;
        self.part = Part::Measure(0, Aabb::EMPTY);
    }

    /// Does one unit of work. Returns what the problem shows, once it does.
    pub fn advance(&mut self, world: &RelaxedWorld<'_>) -> Option<RelaxedOutcome> {
        let part = match (self.part, self.grid) {
            (Part::Over(verdict), _) => return Some(verdict),
            (Part::Measure(first, bounds), _) => self.measure(world, first, bounds),
            (_, None) => Part::Over(RelaxedOutcome::Open),
            (Part::Elements(end), Some(_)) => self.search_elements(world, end),
            (Part::Rasterize(first), Some(grid)) => self.rasterize(world, &grid, first),
            (Part::StepsFromStart, Some(grid)) => self.step_from_start(&grid),
            (Part::StepsFromGoal, Some(grid)) => self.step_from_goal(&grid),
            (Part::Gap(column), Some(grid)) => self.compare(world, &grid, column),
            (Part::Reach(column), Some(grid)) => self.extend_reach(&grid, column),
            (Part::Pass(end), Some(grid)) => self.pass(world, &grid, end),
            (Part::Feet(column), Some(grid)) => self.add_feet(world, &grid, column),
            (Part::Legs, Some(grid)) => self.extend_legs(world, &grid),
            (Part::Root, Some(grid)) => self.pass_root(world, &grid),
        };
        self.part = part;
        match part {
            Part::Over(verdict) => Some(verdict),
            _ => None,
        }
    }

    /// The grid, and the ground that steps reach from the start, by column, once they reach the
    /// goal.
    pub fn reached(&self) -> Option<(Grid, &[u64])> {
        let steps = &self.steps[0];
        self.grid.filter(|_| steps.has_arrived).map(|grid| (grid, steps.reached.as_slice()))
    }

    /// Measures some elements. After the last, makes the grid of the whole ground or, if that is
    /// too large, of the ground around start and goal.
    fn measure(&mut self, world: &RelaxedWorld<'_>, first: u32, bounds: Aabb) -> Part {
        let bounds = bounds.union(bounds_of(world.surfaces, first, ELEMENTS_PER_UNIT));
        let next = first + ELEMENTS_PER_UNIT;
        if next < world.surfaces.element_count() {
            return Part::Measure(next, bounds);
        }
        let soles = || self.ends.iter().flat_map(|end| end.soles.iter().copied());
        let around = self.bounds.span.max(self.bounds.ball_reach) + TOLERANCE;
        let whole = bounds.union(Aabb::of_points(soles())).grown(around);
        let mut part = Aabb::of_points(soles()).grown(PART_MARGIN);
        (part.min.z, part.max.z) = (whole.min.z, whole.max.z);
        let whole_grid = Grid::covering(&whole);
        self.is_clipped = whole_grid.is_none();
        self.grid = whole_grid.or_else(|| Grid::covering(&part)).filter(|grid| grid.columns() > 0);
        match self.grid {
            None => Part::Over(RelaxedOutcome::Open),
            Some(grid) => {
                self.ground.voxels.iter_mut().for_each(|ground| ground[..grid.columns()].fill(0));
                self.begin_elements(world, 0)
            }
        }
    }

    /// Begins with the elements that steps reach from an end.
    fn begin_elements(&mut self, world: &RelaxedWorld<'_>, end: usize) -> Part {
        let bounds = self.bounds.steps();
        self.ground.elements[end].begin(world.surfaces, &self.ends[end].soles, bounds);
        Part::Elements(end)
    }

    /// Those of the goal are searched where those of the start do not lead there.
    fn search_elements(&mut self, world: &RelaxedWorld<'_>, end: usize) -> Part {
        let bounds = self.bounds.steps();
        if !self.ground.elements[end].advance(world.surfaces, bounds) {
            return Part::Elements(end);
        }
        let soles = [0, 1].map(|end| self.ends[end].soles.as_slice());
        self.ground.is_split =
            end == 1 || !self.ground.elements[0].reaches(world.surfaces, soles, bounds);
        match (self.ground.is_split, end) {
            (true, 0) => self.begin_elements(world, 1),
            (false, _) if self.extent == Extent::Elements => Part::Over(RelaxedOutcome::Open),
            _ => Part::Rasterize(0),
        }
    }

    fn rasterize(&mut self, world: &RelaxedWorld<'_>, grid: &Grid, first: u32) -> Part {
        let (mut next, mut spent) = (first, 0);
        while next < world.surfaces.element_count() && spent < ELEMENTS_PER_UNIT as usize {
            let Ground { elements, is_split, voxels } = &mut self.ground;
            for (ground, elements) in voxels.iter_mut().zip(elements) {
                if elements.contains(next) {
                    spent += add_element(world.surfaces, grid, ground, next);
                }
                if !*is_split {
                    break;
                }
            }
            next += 1;
        }
        if next < world.surfaces.element_count() {
            return Part::Rasterize(next);
        }
        if !self.disc.set(grid, self.bounds.span + TOLERANCE) {
            return Part::Over(RelaxedOutcome::Open);
        }
        let radius = self.bounds.sole_radius + TOLERANCE;
        for end in 0..2 {
            self.steps[end].begin(grid, self.ground.of(end), &self.ends[end].soles, radius);
        }
        Part::StepsFromStart
    }

    fn step_from_start(&mut self, grid: &Grid) -> Part {
        if !self.step(grid, 0) {
            return Part::StepsFromStart;
        }
        let radius = self.bounds.sole_radius + TOLERANCE;
        if !self.steps[0].reaches(grid, &self.ends[1].soles, radius) {
            return Part::StepsFromGoal;
        }
        self.steps[0].has_arrived = true;
        let Some(ball) = self.bounds.ball else { return Part::Over(RelaxedOutcome::Open) };
        self.ball.begin(grid, ball.radius);
        // The points of a leg as a curve are within the same reach.
        let leg = self.bounds.curve.map_or(0.0, |curve| curve.whole_length());
        let shows = self.disc.set(grid, self.bounds.ball_reach.max(leg) + TOLERANCE);
        if shows { Part::Reach(0) } else { Part::Over(RelaxedOutcome::Open) }
    }

    /// The gap is real if one of both searches saw all ground that it reaches.
    fn step_from_goal(&mut self, grid: &Grid) -> Part {
        if !self.step(grid, 1) {
            return Part::StepsFromGoal;
        }
        if self.is_clipped && self.steps.iter().all(|steps| steps.is_open) {
            return Part::Over(RelaxedOutcome::Open);
        }
        self.gap.begin(grid, &self.steps[0]);
        Part::Gap(0)
    }

    fn step(&mut self, grid: &Grid, end: usize) -> bool {
        self.steps[end].advance(grid, self.ground.of(end), &self.disc, self.bounds.span)
    }

    fn compare(&mut self, world: &RelaxedWorld<'_>, grid: &Grid, column: usize) -> Part {
        let [from, to] = &self.steps;
        self.gap.compare(grid, [from, to], column);
        let edge = (column + 1..grid.columns()).find(|&next| to.is_edge(grid, next));
        if let Some(next) = edge {
            return Part::Gap(next);
        }
        let gap = self.gap.gap(grid, world.surfaces, self.bounds.span);
        Part::Over(
            gap.map_or(RelaxedOutcome::Open, |gap| {
                RelaxedOutcome::Obstructed(Obstruction::Gap(gap))
            }),
        )
    }

    fn extend_reach(&mut self, grid: &Grid, first: usize) -> Part {
        let reached = &self.steps[0].reached;
        let columns = (first..grid.columns()).filter(|&column| reached[column] != 0);
        let mut last = None;
        for column in columns.take(COLUMNS_PER_UNIT) {
            self.ball.extend(grid, &self.disc, column, reached[column]);
            last = Some(column);
        }
        last.map_or_else(|| self.start_passing(grid, 1), |last| Part::Reach(last + 1))
    }

    /// Begins the way of the ball from an end: first from the goal, then from the
    /// start. A closed space around either is small.
    fn start_passing(&mut self, grid: &Grid, end: usize) -> Part {
        if !self.ball.shows(grid) {
            return self.begin_legs(grid);
        }
        let centers = [end, 1 - end].map(|end| self.ball_center(end));
        let is_inside = self.ball.start(grid, centers);
        if is_inside { Part::Pass(end) } else { Part::Over(RelaxedOutcome::Open) }
    }

    fn pass(&mut self, world: &RelaxedWorld<'_>, grid: &Grid, end: usize) -> Part {
        let is_open = |column| self.is_clipped && grid.is_near_border(column, grid.cell);
        let passage = self.ball.advance(grid, &world.constraints.collision, is_open);
        let is_whole = !(self.is_clipped && self.steps[0].is_open);
        match passage {
            None => Part::Pass(end),
            Some(Passage::Undecided) if end == 1 => self.start_passing(grid, 0),
            Some(Passage::Closed(shape, at)) if is_whole => {
                let (radius, reach) =
                    (self.bounds.ball.map_or(0.0, |ball| ball.radius), self.bounds.ball_reach);
                let blockage = Blockage { shape, at, radius, reach };
                Part::Over(RelaxedOutcome::Obstructed(Obstruction::Blockage(blockage)))
            }
            Some(Passage::Open)
                if self.extent != Extent::Whole && grid.columns() > QUICK_COLUMNS_MAX =>
            {
                Part::Over(RelaxedOutcome::Open)
            }
            Some(_) => self.begin_legs(grid),
        }
    }

    /// Begins with the curves of the legs, if the voxels suit them.
    fn begin_legs(&mut self, grid: &Grid) -> Part {
        let is_whole = !(self.is_clipped && self.steps[0].is_open);
        let curve = self.bounds.curve.filter(|_| is_whole);
        let suits = curve.is_some_and(|curve| self.curves.begin(grid, &curve));
        if suits { Part::Feet(0) } else { Part::Over(RelaxedOutcome::Open) }
    }

    /// Adds the feet on the reached ground at some columns.
    fn add_feet(&mut self, world: &RelaxedWorld<'_>, grid: &Grid, first: usize) -> Part {
        let to_foot = self.bounds.curve.map_or(0.0, |curve| curve.to_foot);
        let (mut column, mut visits) = (first, 0);
        while column < grid.columns() && visits < VISITS_PER_UNIT {
            let reached = self.steps[0].reached_around(grid, column);
            visits += u32::from(reached != 0);
            let collision = &world.constraints.collision;
            let curves = &mut self.curves;
            for_each_height(world.surfaces, grid, (column, to_foot), |heights| {
                if reached & grid.levels_in(heights[0], heights[1]) != 0 {
                    visits += curves.add_ground(grid, collision, column, heights);
                }
            });
            column += 1;
        }
        if column < grid.columns() { Part::Feet(column) } else { Part::Legs }
    }

    fn extend_legs(&mut self, world: &RelaxedWorld<'_>, grid: &Grid) -> Part {
        if !self.curves.extend_legs(grid, &world.constraints.collision, self.ball.near()) {
            return Part::Legs;
        }
        let is_inside = self.curves.start_root(grid, self.ball_center(1));
        if is_inside { Part::Root } else { Part::Over(RelaxedOutcome::Open) }
    }

    fn pass_root(&mut self, world: &RelaxedWorld<'_>, grid: &Grid) -> Part {
        let is_open = |column| self.is_clipped && grid.is_near_border(column, grid.cell);
        let target = (self.ball_center(0), self.ball.near());
        match self.curves.pass(grid, &world.constraints.collision, target, is_open) {
            None => Part::Root,
            Some(RootWay::Closed(Some((shape, at)))) => {
                let leg = self.bounds.curve.map_or(0.0, |curve| curve.whole_length());
                let enclosure = Enclosure { shape, at, leg };
                Part::Over(RelaxedOutcome::Obstructed(Obstruction::Enclosure(enclosure)))
            }
            Some(_) => Part::Over(RelaxedOutcome::Open),
        }
    }

    /// The centre of the ball in the root at an end.
    fn ball_center(&self, end: usize) -> DVec3 {
        let center = self.bounds.ball.map_or(DVec3::ZERO, |ball| ball.center);
        self.ends[end].world_from_root * center
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.ground.voxels.iter().map(|ground| size_of_val(ground.as_slice())).sum::<usize>()
            + self.ground.elements.iter().map(ElementSearch::bytes).sum::<usize>()
            + self.disc.bytes()
            + self.steps.iter().map(StepSearch::bytes).sum::<usize>()
            + self.gap.bytes()
            + self.ball.bytes()
            + self.curves.bytes()
    }
}

impl Bounds {
    /// The longest steps.
    fn steps(&self) -> StepBounds {
        StepBounds { reach: self.step_reach, radius: self.sole_radius }
    }

    /// The bounds of a robot. A leg with a prismatic joint has no bound of its reach, so there is
    /// no ball.
    fn of(world: &RelaxedWorld<'_>) -> Self {
        let robot = &world.constraints.robot;
        let radii = robot
            .soles
            .each_ref()
            .map(|sole| sole.polygon.iter().map(|vertex| vertex.length()).fold(0.0, f64::max));
        let is_revolute = |limb: usize| {
            robot.legs[limb].joints().iter().all(|joint| joint.kind == JointKind::Revolute)
        };
        let ball = world.constraints.collision.root_ball();
        let ball = ball.filter(|_| (0..2).all(is_revolute));
        let center = ball.map_or(DVec3::ZERO, |ball| ball.center);
        Self {
            sole_radius: radii[0].max(radii[1]),
            step_reach: world.step_reach,
            span: world.step_reach + radii[0] + radii[1],
            ball,
            curve: ball.and_then(|ball| {
                let steepest_tan = world.surfaces.steepest_tan() + SOLE_TILT_TAN;
                LegCurve::of(robot, &world.constraints.collision, &ball, steepest_tan)
            }),
            ball_reach: (0..2).map(|limb| ball_reach(robot, limb, center)).fold(0.0, f64::max),
        }
    }
}

/// Upper bound of the distance of a point of the root from any point of a sole, m: along the first
/// two joints, the leg and the foot.
fn ball_reach(robot: &Mechanism, limb: usize, center: DVec3) -> f64 {
    let (leg, sole) = (&robot.legs[limb], &robot.soles[limb]);
    let first = leg.joints()[0].point;
    let ankle = leg.sole_from_ankle();
    let foot = sole.polygon.iter().map(|vertex| vertex.extend(0.0).distance(ankle));
    center.distance(first) + first.distance(leg.hip()) + leg.reach() + foot.fold(0.0, f64::max)
}
