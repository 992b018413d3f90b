//! The bounds of chapter 5 against random experiments, each with its own seed [Grey 5.4 to 5.7].
//! A rate that was counted contradicts a bound if its lower confidence limit exceeds it.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::theory::confidence::clopper_pearson;
use surefoot_planner::theory::coverage::{
    disc_radius_min, disc_radius_printed, path_distance, placement_distance,
};
use surefoot_planner::theory::disc_union::{printed_area_bounds, tube_area, union_area};
use surefoot_planner::theory::erosion::{Cylinder, Erosion};
use surefoot_planner::theory::mode_sampling::ModeSampling;
use surefoot_planner::theory::overall::{
    Overall, Samples, dependent_failure, mode_failure_bound_printed,
};
use surefoot_planner::theory::route_sampling::{RouteSampling, ball_radius_max, ball_volume};

/// Confidence level of every comparison.
const LEVEL: f64 = 0.999;

fn random(experiment: u64, seed: u64) -> Random {
    Random::new(seed, Stream::Preparation, experiment, 0)
}

/// A uniform point of a disc about the origin.
fn in_disc(random: &mut Random, radius: f64) -> DVec2 {
    let length = radius * random.uniform(0.0, 1.0).sqrt();
    length * direction(random.uniform(0.0, TAU))
}

fn direction(angle: f64) -> DVec2 {
    DVec2::new(libm::cos(angle), libm::sin(angle))
}

fn assert_bound_holds(failures: u64, trials: u64, bound: f64, what: &str) {
    let [lower, _] = clopper_pearson(failures, trials, LEVEL);
    assert!(lower <= bound, "{what}: {failures} of {trials} failed, the bound is {bound}");
}

/// A set of placements of the other foot that a foot at the origin reaches: a box in SE(2).
#[derive(Clone, Copy)]
struct ReachBox {
    x: [f64; 2],
    y: [f64; 2],
    yaw: [f64; 2],
}

type PlanarPose = (DVec2, f64);

const REACH: ReachBox = ReachBox { x: [-0.35, 0.45], y: [0.12, 0.5], yaw: [-0.45, 0.45] };

impl ReachBox {
    fn step_max(&self) -> f64 {
        DVec2::new(self.x[1], self.y[1]).length()
    }

    fn eroded(&self, by: Erosion) -> Self {
        let inward = |[lower, upper]: [f64; 2], by: f64| [lower + by, upper - by];
        Self {
            x: inward(self.x, by.distance),
            y: inward(self.y, by.distance),
            yaw: inward(self.yaw, by.yaw),
        }
    }

    fn contains(&self, (at, yaw): PlanarPose) -> bool {
        let is_in = |[lower, upper]: [f64; 2], value: f64| lower <= value && value <= upper;
        is_in(self.x, at.x) && is_in(self.y, at.y) && is_in(self.yaw, yaw)
    }

    /// Whether a foot at a placement reaches another one, mirrored for a right foot.
    fn reaches(&self, is_left: bool, (from, heading): PlanarPose, (to, yaw): PlanarPose) -> bool {
        let side = if is_left { -1.0 } else { 1.0 };
        let seen = direction(-heading).rotate(to - from);
        let turn = (yaw - heading + PI).rem_euclid(TAU) - PI;
        self.contains((DVec2::new(seen.x, side * seen.y), side * turn))
    }

    fn sample(&self, random: &mut Random) -> PlanarPose {
        let at =
            DVec2::new(random.uniform(self.x[0], self.x[1]), random.uniform(self.y[0], self.y[1]));
        (at, random.uniform(self.yaw[0], self.yaw[1]))
    }
}

fn in_cylinder(random: &mut Random, (at, yaw): PlanarPose, cylinder: Cylinder) -> PlanarPose {
    let half = 0.5 * cylinder.yaw_extent;
    (at + in_disc(random, cylinder.radius), yaw + random.uniform(-half, half))
}

/// A star-shaped simple polygon about the origin.
fn polygon(random: &mut Random) -> Vec<DVec2> {
    let vertices = 5 + random.below(9);
    let at = |index: usize, random: &mut Random| {
        let angle = (index as f64 + random.uniform(0.1, 0.9)) * TAU / vertices as f64;
        random.uniform(0.35, 1.0) * direction(angle)
    };
    (0..vertices).map(|index| at(index, random)).collect()
}

fn is_inside(polygon: &[DVec2], point: DVec2) -> bool {
    let crosses = |index: usize| {
        let (a, b) = (polygon[index], polygon[(index + 1) % polygon.len()]);
        (a.y > point.y) != (b.y > point.y)
            && point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x
    };
    (0..polygon.len()).filter(|&index| crosses(index)).count() % 2 == 1
}

#[test]
fn lemma_1_holds_in_the_plane() {
    const CELL: f64 = 0.05;
    for seed in 0..12 {
        let mut random = random(1, seed);
        let shape = polygon(&mut random);
        let radius = random.uniform(0.08, 0.25);
        let outline: Vec<DVec2> = shape.iter().chain(&shape[..1]).copied().collect();
        for cell in 0..40 * 40 {
            let point = CELL * DVec2::new(f64::from(cell % 40) - 20.0, f64::from(cell / 40) - 20.0);
            let is_eroded = is_inside(&shape, point) && path_distance(point, &outline) >= radius;
            let is_in_all = (0..360)
                .map(|step| radius * direction(f64::from(step) * TAU / 360.0))
                .all(|shift| is_inside(&shape, point - shift));
            let is_near_border = (path_distance(point, &outline) - radius).abs() < 1e-3;
            assert!(is_eroded == is_in_all || is_near_border, "seed {seed} at {point}");
        }
    }
}

/// Placements of a set that some stance of a cylinder about the origin does not reach, and all.
fn unreached(erosion: Erosion, cylinder: Cylinder) -> (u32, u32) {
    let promised = REACH.eroded(erosion);
    let mut random = random(2, 0);
    let (mut unreached, all) = (0, 600);
    for _ in 0..all {
        let placement = promised.sample(&mut random);
        let is_reached = (0..64).all(|step| {
            let shift = cylinder.radius * direction(f64::from(step / 2) * TAU / 32.0);
            let turn = if step % 2 == 0 { 0.5 } else { -0.5 } * cylinder.yaw_extent;
            REACH.reaches(false, (shift, turn), placement)
        });
        unreached += u32::from(!is_reached);
    }
    (unreached, all)
}

#[test]
fn lemma_1_fails_under_yaw_as_printed_and_holds_with_a_larger_erosion() {
    let cylinder = Cylinder { radius: 0.05, yaw_extent: 0.4 };
    let (printed, all) = unreached(Erosion::printed(cylinder), cylinder);
    assert!(printed > all / 4, "{printed} of {all} are not reached from all of the cylinder");
    let (sufficient, _) = unreached(Erosion::sufficient(cylinder, REACH.step_max()), cylinder);
    assert_eq!(sufficient, 0);
    let without_yaw = Cylinder { yaw_extent: 0.0, ..cylinder };
    assert_eq!(Erosion::printed(without_yaw), Erosion::sufficient(without_yaw, 1.0));
}

/// A walk straight ahead over alternating placements, the first of the left foot.
fn walk(modes: usize) -> Vec<PlanarPose> {
    (0..modes)
        .map(|step| {
            let y = if step % 2 == 0 { 0.15 } else { -0.15 };
            (DVec2::new(0.06 * step as f64, y), 0.0)
        })
        .collect()
}

#[test]
fn theorem_1_any_choice_within_the_cylinders_is_a_walk() {
    let cylinder = Cylinder { radius: 0.04, yaw_extent: 0.2 };
    let erosion = Erosion::sufficient(cylinder, REACH.step_max());
    // Both ends of a step vary, so the step itself stays clear of the border by both erosions.
    let twice = Erosion { distance: erosion.distance + cylinder.radius, yaw: 2.0 * erosion.yaw };
    let (walk, mut random) = (walk(8), random(3, 0));
    for trial in 0..2_000 {
        let chosen: Vec<PlanarPose> =
            walk.iter().map(|&placement| in_cylinder(&mut random, placement, cylinder)).collect();
        for (step, pair) in chosen.windows(2).enumerate() {
            assert!(REACH.reaches(step % 2 == 0, pair[0], pair[1]), "trial {trial}, step {step}");
        }
    }
    for (step, pair) in walk.windows(2).enumerate() {
        assert!(REACH.eroded(twice).reaches(step % 2 == 0, pair[0], pair[1]));
    }
}

/// Failures of `trials` to put a sample of each foot into each of its cylinders in a square.
fn mode_failures(sampling: ModeSampling, samples: u32, trials: u64) -> u64 {
    let (walk, side) = (walk(sampling.modes as usize), sampling.area.sqrt());
    let Cylinder { radius, yaw_extent } = sampling.cylinder;
    let mut failures = 0;
    for seed in 0..trials {
        let mut random = random(4, seed << 16 | u64::from(samples));
        let mut is_hit = vec![false; walk.len()];
        for sample in 0..2 * samples {
            let mut coordinate = || random.uniform(-0.5 * side, 0.5 * side);
            let at = DVec2::new(coordinate(), coordinate());
            let yaw = random.uniform(-PI, PI);
            for mode in (sample as usize % 2..walk.len()).step_by(2) {
                let (centre, heading) = walk[mode];
                is_hit[mode] |= at.distance_squared(centre) <= radius * radius
                    && (yaw - heading).abs() <= 0.5 * yaw_extent;
            }
        }
        failures += u64::from(is_hit.contains(&false));
    }
    failures
}

#[test]
fn equation_5_2_bounds_the_failures_of_mode_sampling() {
    let cylinder = Cylinder { radius: 0.15, yaw_extent: 0.5 };
    let sampling = ModeSampling { modes: 6.0, cylinder, area: 4.0 };
    let share = cylinder.volume() / (TAU * sampling.area);
    assert!((sampling.sample_probability() - share).abs() < 1e-15, "equation 5.3");
    let trials = 1_000;
    let rates: Vec<f64> = [500, 1_500, 2_500, 4_000]
        .map(|samples| {
            let failures = mode_failures(sampling, samples, trials);
            let bound = sampling.failure_bound(f64::from(samples));
            assert_bound_holds(failures, trials, bound, &format!("{samples} samples"));
            assert!(bound <= sampling.exponential_bound(f64::from(samples)));
            failures as f64 / trials as f64
        })
        .to_vec();
    let slope = libm::log(rates[3] / rates[2]) / 1_500.0;
    let expected = libm::log1p(-sampling.sample_probability());
    assert!((slope / expected - 1.0).abs() < 0.25, "slope {slope}, expected {expected}");
    let too_small = ModeSampling { area: 0.5 * sampling.area, ..sampling };
    let [lower, _] = clopper_pearson((rates[2] * trials as f64) as u64, trials, LEVEL);
    assert!(lower > too_small.failure_bound(2_500.0), "half the bound's base would not hold");
}

/// Failures to put a sample into each inner ball along the middle of a box of `dimensions`
/// dimensions, `clearance` metres from its sides.
fn ball_failures(sampling: RouteSampling, clearance: f64, samples: u32, trials: u64) -> u64 {
    let balls = (sampling.length / sampling.ball_radius).ceil() as usize;
    let radius_squared = sampling.ball_radius * sampling.ball_radius;
    let mut failures = 0;
    for seed in 0..trials {
        let mut random = random(5 + u64::from(sampling.dimensions), seed);
        let mut is_hit = vec![false; balls - 1];
        for _ in 0..samples {
            let along = random.uniform(-clearance, sampling.length + clearance);
            let aside: f64 = (1..sampling.dimensions)
                .map(|_| random.uniform(-clearance, clearance))
                .map(|offset| offset * offset)
                .sum();
            for (ball, is_hit) in is_hit.iter_mut().enumerate() {
                let offset = along - (ball + 1) as f64 * sampling.ball_radius;
                *is_hit |= offset * offset + aside <= radius_squared;
            }
        }
        failures += u64::from(is_hit.contains(&false));
    }
    failures
}

#[test]
fn equation_5_4_bounds_the_failures_of_stage_p() {
    for dimensions in [2, 3, 6] {
        let (clearance, length) = (0.5, 0.75);
        let sides = libm::pow(2.0 * clearance, f64::from(dimensions - 1));
        let sampling = RouteSampling {
            length,
            ball_radius: ball_radius_max(clearance, f64::INFINITY),
            volume: (length + 2.0 * clearance) * sides,
            dimensions,
        };
        for factor in [1.0, 2.0, 3.5] {
            let samples = (factor / sampling.sample_probability()).ceil();
            let failures = ball_failures(sampling, clearance, samples as u32, 400);
            let bound = sampling.failure_bound(samples);
            assert_bound_holds(failures, 400, bound, &format!("{dimensions} dimensions"));
            assert!(bound <= sampling.exponential_bound(samples));
        }
    }
    assert!((ball_volume(6, 0.3) - libm::pow(PI, 3.0) * libm::pow(0.3, 6.0) / 6.0).abs() < 1e-15);
    assert!((ball_volume(2, 0.3) - PI * 0.09).abs() < 1e-15);
    assert!((ball_volume(3, 0.3) - 4.0 / 3.0 * PI * 0.027).abs() < 1e-15);
}

/// A random path with bends, its points `spacing` apart.
fn path(random: &mut Random, spacing: f64) -> Vec<DVec2> {
    let mut heading = random.uniform(0.0, TAU);
    let mut points = vec![DVec2::ZERO];
    for _ in 0..40 {
        heading += random.uniform(-0.5, 0.5);
        points.push(points[points.len() - 1] + spacing * direction(heading));
    }
    points
}

/// Whether the segments between random points of neighbouring balls of this radius all stay within
/// `clearance` of the path.
fn neighbours_see_each_other(ball_radius: f64, clearance: f64) -> bool {
    (0..400).all(|seed| {
        let mut random = random(20, seed);
        let path = path(&mut random, ball_radius);
        path.windows(2).all(|pair| {
            let ends = [pair[0], pair[1]].map(|centre| centre + in_disc(&mut random, ball_radius));
            let at = |step: u32| ends[0].lerp(ends[1], f64::from(step) / 8.0);
            (0..=8).all(|step| path_distance(at(step), &path) <= clearance)
        })
    })
}

#[test]
fn equation_5_5_samples_of_neighbouring_balls_see_each_other() {
    let clearance = 0.3;
    assert!(neighbours_see_each_other(ball_radius_max(clearance, f64::INFINITY), clearance));
    assert!(!neighbours_see_each_other(1.2 * clearance, clearance), "larger balls would not do");
}

/// Whether discs of this radius about one random sample per ball cover random placements within
/// `distance` of a random path, in every one of many trials.
fn discs_cover(distance: f64, ball_radius: f64, disc_radius: f64) -> bool {
    (0..300).all(|seed| {
        let mut random = random(30, seed);
        let path = path(&mut random, ball_radius);
        let placements: Vec<DVec2> = (0..30)
            .map(|_| {
                let at = path[random.below(path.len())].lerp(path[random.below(path.len())], 0.0);
                at + distance * direction(random.uniform(0.0, TAU))
            })
            .collect();
        assert!(placement_distance(&placements, 0.0, &path) <= distance + 1e-12);
        let centres: Vec<DVec2> =
            path.iter().map(|&point| point + in_disc(&mut random, ball_radius)).collect();
        let is_covered =
            |at: &DVec2| centres.iter().any(|centre| centre.distance(*at) <= disc_radius);
        placements.iter().all(is_covered)
    })
}

#[test]
fn lemma_3_discs_cover_the_cylinders_at_both_radii_and_not_below() {
    let distance = 0.4;
    let printed = disc_radius_printed(distance);
    assert!(discs_cover(distance, 0.25 * printed, printed));
    let ball_radius = 0.1;
    assert!(discs_cover(distance, ball_radius, disc_radius_min(distance, ball_radius)));
    assert!(disc_radius_min(distance, ball_radius) < printed, "weaker than printed");
    assert!(!discs_cover(distance, ball_radius, distance - ball_radius));
    let beside = placement_distance(&[DVec2::new(0.5, 0.3)], 0.1, &[DVec2::ZERO, DVec2::X]);
    assert!((beside - 0.4).abs() < 1e-12, "equation 5.7");
}

#[test]
fn equations_5_10_to_5_13_are_in_order() {
    let mut random = random(40, 0);
    for _ in 0..5_000 {
        let [a, b] = [0, 1].map(|_| random.uniform(0.0, 1.0));
        assert!(dependent_failure(a, b) <= a + b && dependent_failure(a, b) >= a.max(b) - 1e-15);
        let ball_radius = random.uniform(0.01, 0.5);
        let route = RouteSampling {
            length: random.uniform(0.5, 10.0),
            ball_radius,
            volume: random.uniform(1.0, 100.0),
            dimensions: 6,
        };
        let cylinder =
            Cylinder { radius: random.uniform(0.01, 0.3), yaw_extent: random.uniform(0.01, 1.0) };
        let modes = ModeSampling { modes: 12.0, cylinder, area: random.uniform(1.0, 30.0) };
        let samples =
            Samples { route: random.uniform(1.0, 1e5), placements: random.uniform(1.0, 1e5) };
        let overall = Overall { route, modes };
        let exponentials =
            route.exponential_bound(samples.route) + modes.exponential_bound(samples.placements);
        let slack = 1.0 + 1e-12;
        assert!(overall.failure_bound(samples) <= slack * exponentials, "equation 5.12");
        assert!(exponentials <= slack * overall.exponential_bound(samples), "equation 5.13");
    }
}

#[test]
fn the_printed_chain_before_5_14_is_reversed_and_the_tube_holds() {
    let (length, clearance, disc_radius) = (4.0, 0.1, 1.5);
    let ball_radius = ball_radius_max(clearance, disc_radius);
    let [first, second] = printed_area_bounds(length, ball_radius, disc_radius);
    assert!(first > 7.0 * second, "{first} is printed as no more than {second}");
    let equal = printed_area_bounds(length, 0.25 * disc_radius, disc_radius);
    assert!((equal[0] - equal[1]).abs() < 1e-9, "equal where epsilon is rho / 4");
    let centres: Vec<DVec2> =
        (0..=80).map(|step| DVec2::new(length * f64::from(step) / 80.0, 0.0)).collect();
    let (area, tube) = (union_area(&centres, disc_radius, 0.02), tube_area(length, disc_radius));
    // The grid is exact to a tenth of a percent here.
    assert!(area <= 1.001 * tube && area > 0.97 * tube, "area {area}, tube {tube}");
    assert!(3.9 * tube < second, "the tube is four times tighter than the printed end");
    let cylinder = Cylinder { radius: 0.1, yaw_extent: 0.4 };
    let by_tube = ModeSampling { modes: 10.0, cylinder, area: tube };
    let printed = mode_failure_bound_printed(10.0, cylinder, (length, disc_radius), 50_000.0);
    assert!(by_tube.failure_bound(50_000.0) < 0.1 * printed);
}

#[test]
fn a_tube_covers_the_discs_of_every_random_route() {
    for seed in 0..20 {
        let mut random = random(50, seed);
        let (points, radius) = (path(&mut random, 0.1), random.uniform(0.2, 1.0));
        let length = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        assert!(union_area(&points, radius, 0.02) <= tube_area(length, radius), "seed {seed}");
    }
}

/// w-RPG for a point that walks over stones around a corner: E is an L of two corridors, a stone
/// stands wherever the walk needs one, and a foot is a point.
struct Corner {
    clearance: f64,
    disc_radius: f64,
    stones: Vec<DVec2>,
    stone_radius: f64,
    path: [DVec2; 3],
}

impl Corner {
    fn new() -> Self {
        let path = [DVec2::ZERO, DVec2::new(1.2, 0.0), DVec2::new(1.2, 1.2)];
        let stones = (1..6).map(|step| {
            let along = 0.4 * f64::from(step);
            if along < 1.2 { DVec2::new(along, 0.1) } else { DVec2::new(1.1, along - 1.2) }
        });
        let stones = stones.collect();
        Self { clearance: 0.3, disc_radius: 0.6, stones, stone_radius: 0.12, path }
    }

    fn is_free(&self, at: DVec2) -> bool {
        let reach = self.clearance;
        let is_in_first = (-reach..=1.2 + reach).contains(&at.x) && at.y.abs() <= reach;
        let is_in_second = (at.x - 1.2).abs() <= reach && (-reach..=1.2 + reach).contains(&at.y);
        is_in_first || is_in_second
    }

    fn volume(&self) -> f64 {
        let (width, length) = (2.0 * self.clearance, 1.2 + 2.0 * self.clearance);
        2.0 * width * length - width * width
    }

    fn sample(&self, random: &mut Random) -> DVec2 {
        loop {
            let at = DVec2::new(random.uniform(-0.3, 1.5), random.uniform(-0.3, 1.5));
            if self.is_free(at) {
                return at;
            }
        }
    }

    fn sees(&self, [from, to]: [DVec2; 2]) -> bool {
        (0..=20).all(|step| self.is_free(from.lerp(to, f64::from(step) / 20.0)))
    }

    /// The vertices that are connected with the start, the goal among them; none if it is not.
    fn route(&self, random: &mut Random, samples: u32) -> Option<Vec<DVec2>> {
        let mut vertices = vec![self.path[0], self.path[2]];
        vertices.extend((0..samples).map(|_| self.sample(random)));
        let mut is_reached = vec![false; vertices.len()];
        let mut open = vec![0];
        is_reached[0] = true;
        while let Some(from) = open.pop() {
            for to in 0..vertices.len() {
                if !is_reached[to] && self.sees([vertices[from], vertices[to]]) {
                    is_reached[to] = true;
                    open.push(to);
                }
            }
        }
        let reached = vertices.iter().zip(&is_reached).filter(|(_, reached)| **reached);
        is_reached[1].then(|| reached.map(|(vertex, _)| *vertex).collect())
    }

    /// Whether the method finds a walk.
    fn succeeds(&self, seed: u64, samples: [u32; 2]) -> bool {
        let mut random = random(60, seed);
        let Some(centres) = self.route(&mut random, samples[0]) else { return false };
        let mut is_hit = vec![false; self.stones.len()];
        let mut left = samples[1];
        while left > 0 {
            let at = DVec2::new(random.uniform(-0.9, 2.1), random.uniform(-0.9, 2.1));
            if centres.iter().any(|centre| centre.distance(at) <= self.disc_radius) {
                left -= 1;
                for (stone, is_hit) in self.stones.iter().zip(&mut is_hit) {
                    *is_hit |= stone.distance(at) <= self.stone_radius;
                }
            }
        }
        !is_hit.contains(&false)
    }
}

#[test]
fn theorem_3_bounds_w_rpg_from_end_to_end() {
    let corner = Corner::new();
    let ball_radius = ball_radius_max(corner.clearance, corner.disc_radius);
    let route = RouteSampling { length: 2.4, ball_radius, volume: corner.volume(), dimensions: 2 };
    let distance = placement_distance(&corner.stones, corner.stone_radius, &corner.path);
    assert!(corner.disc_radius >= disc_radius_printed(distance), "the discs cover the stones");
    // The largest area that discs about free vertices may have.
    let (low, high) = (-0.9, 2.1);
    let area = (high - low) * (high - low);
    let cylinder = Cylinder { radius: corner.stone_radius, yaw_extent: TAU };
    let modes = ModeSampling { modes: corner.stones.len() as f64, cylinder, area };
    let trials = 300;
    let mut rates = vec![];
    for placements in [150, 450, 900] {
        let samples = [220, placements];
        let failures = (0..trials).filter(|&seed| !corner.succeeds(seed, samples)).count() as u64;
        let bound = Overall { route, modes }.failure_bound(Samples {
            route: f64::from(samples[0]),
            placements: f64::from(samples[1]),
        });
        assert_bound_holds(failures, trials, bound, &format!("{samples:?}"));
        rates.push(failures);
    }
    assert!(rates[0] > rates[1] && rates[1] >= rates[2], "{rates:?}");
    let without_route = (0..trials).filter(|&seed| !corner.succeeds(seed, [1, 900])).count();
    assert!(without_route as u64 > rates[2], "stage P decides with one sample");
}
