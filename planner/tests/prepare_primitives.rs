//! pi_S: where C_S holds, a primitive meets every constraint, and C_N holds along every plan
//! [Grey 3.1, 4.1, 4.4.5].

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test ends where a shipped file does not load; the long one reports"
)]

mod common;

use common::{Case, WALKS, hubo, preparation_for, repository, run};
use glam::{DQuat, DVec3};
use surefoot_planner::Outcome;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::collision::model::{CollisionModel, FootPhase};
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::constraints::foothold::{Foothold, double_mode, single_mode};
use surefoot_planner::constraints::mode::Mode;
use surefoot_planner::constraints::mode_state::ModeState;
use surefoot_planner::preparation::Preparation;
use surefoot_planner::preparation::{necessary, sufficient, sufficient_shift};
use surefoot_planner::primitives::level_sole::{LevelSole, PairOffset};
use surefoot_planner::primitives::{PrimitiveTrajectory, configuration};
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// The seeds of each scenario.
const SEEDS: u64 = 3;
/// Distance between two triples, m.
const SPACING: f64 = 6.0;

/// A stance placement and two of the other foot, each on its own pedestal, with obstacles around
/// them.
struct PlacementTriple {
    stance: Foothold,
    others: [Foothold; 2],
}

/// Draws placement triples and the world around them.
struct Builder<'a> {
    robot: &'a Mechanism,
    preparation: &'a Preparation,
    random: Random,
    shapes: Vec<WorldShape>,
}

impl Builder<'_> {
    fn triple(&mut self, index: usize) -> PlacementTriple {
        let limb = self.random.below(2);
        let flat = index.is_multiple_of(3);
        let origin = DVec3::new(
            SPACING * (index % 20) as f64,
            SPACING * (index / 20) as f64,
            self.random.uniform(-1.0, 1.0),
        );
        let level_sole = LevelSole { origin, yaw: self.random.uniform(-3.0, 3.0), tilt: 0.0 };
        let stance = self.foothold(limb, &level_sole, flat);
        let others = [0, 1].map(|_| {
            let offset = self.offset(limb, flat);
            let other = level_sole.at_offset(&offset, 1 - limb);
            self.foothold(1 - limb, &other, flat)
        });
        if flat {
            self.add_box(
                Pose::from_translation(origin - DVec3::Z * 0.1),
                DVec3::new(1.0, 1.0, 0.1),
            );
        }
        for _ in 0..self.random.below(4) {
            let place = DVec3::new(
                self.random.uniform(-1.2, 1.2),
                self.random.uniform(-1.2, 1.2),
                self.random.uniform(0.0, 1.8),
            );
            let half = DVec3::new(
                self.random.uniform(0.01, 0.4),
                self.random.uniform(0.01, 0.4),
                self.random.uniform(0.01, 0.4),
            );
            let turned = rotation_about(DVec3::X, self.random.uniform(-3.0, 3.0));
            self.add_box(Pose::from_parts(origin + place, turned), half);
        }
        PlacementTriple { stance, others }
    }

    /// A pair in R_S.
    fn offset(&mut self, stance: usize, flat: bool) -> PairOffset {
        let range = self.preparation.range(stance);
        let extent = range.extent().unwrap();
        loop {
            let [ahead, aside, above, turn] =
                extent.map(|[least, greatest]| self.random.uniform(least, greatest));
            let offset = PairOffset { ahead, aside, above: if flat { 0.0 } else { above }, turn };
            if range.contains(&offset) {
                return offset;
            }
        }
    }

    fn foothold(&mut self, limb: usize, level_sole: &LevelSole, flat: bool) -> Foothold {
        let direction = self.random.uniform(-3.2, 3.2);
        let tilt = if flat { 0.0 } else { self.random.uniform(0.0, self.preparation.gait().tilt) };
        let tilted: DQuat =
            rotation_about(DVec3::new(libm::cos(direction), libm::sin(direction), 0.0), tilt);
        let sole = level_sole
            .sole(&self.robot.legs[limb], tilted * rotation_about(DVec3::Z, level_sole.yaw));
        let polygon = &self.robot.soles[limb].polygon;
        if !flat {
            let corner =
                polygon.iter().fold(glam::DVec2::ZERO, |corner, vertex| corner.max(vertex.abs()));
            let half = (corner + glam::DVec2::splat(0.005)).extend(0.05);
            self.add_box(sole * Pose::from_translation(DVec3::new(0.0, 0.0, -0.05)), half);
        }
        Foothold::new(limb, sole, polygon.iter().copied().collect())
    }

    fn add_box(&mut self, world_from_shape: Pose, half_extents: DVec3) {
        let name = format!("box {}", self.shapes.len());
        self.shapes.push(WorldShape { name, world_from_shape, shape: Shape::Box { half_extents } });
    }
}

/// Checks waypoints one by one.
struct Checking<'a> {
    constraints: &'a Constraints,
    mode: Mode,
    here: ModeState,
    swing: Option<usize>,
    waypoints: usize,
    name: String,
}

impl Checking<'_> {
    fn follow(&mut self, mut trajectory: PrimitiveTrajectory) {
        while !trajectory.is_over() {
            if let Some((state, foot)) = trajectory.advance(self.constraints).unwrap() {
                self.take(state, foot);
            }
        }
    }

    fn take(&mut self, state: &ModeState, foot: FootPhase) {
        let robot = &self.constraints.robot;
        let mut feet = [FootPhase::Stance; 2];
        if let Some(limb) = self.swing {
            feet[limb] = foot;
        }
        let kinematic_states =
            [&self.here, state].map(|state| KinematicState::new(robot, &state.configuration));
        let checked = self.constraints.check(&self.mode, &kinematic_states[1], feet);
        assert!(checked.is_ok(), "{}: waypoint {}: {checked:?}", self.name, self.waypoints);
        let bound =
            self.constraints.collision.motion_bound(&kinematic_states[0], &kinematic_states[1]);
        let ends = [&self.here.configuration, &state.configuration];
        let between = self.constraints.check_between(
            &self.mode,
            ends,
            bound,
            feet,
            &mut KinematicState::default(),
        );
        assert!(between.is_ok(), "{}: before waypoint {}: {between:?}", self.name, self.waypoints);
        self.here = *state;
        self.waypoints += 1;
    }
}

/// Samples and checks every primitive of a triple for which C_S holds. Returns their number.
fn primitives_hold_at(
    constraints: &Constraints,
    preparation: &Preparation,
    triple: &PlacementTriple,
    name: &str,
) -> usize {
    let (robot, gait) = (&constraints.robot, preparation.gait());
    let PlacementTriple { stance, others: [from, to] } = triple;
    let mut held = 0;
    let is_free = |other: &Foothold| {
        sufficient(
            preparation,
            robot,
            &constraints.collision,
            &stance.placement(robot),
            &other.placement(robot),
        )
    };
    if is_free(from) && is_free(to) {
        let here = configuration(robot, gait, stance, from).unwrap();
        let mode = single_mode(stance);
        assert!(
            constraints
                .check(
                    &mode,
                    &KinematicState::new(robot, &here.configuration),
                    [FootPhase::Stance; 2]
                )
                .is_ok(),
            "{name}"
        );
        let mut checking = Checking {
            constraints,
            mode,
            here,
            swing: Some(from.limb),
            waypoints: 0,
            name: format!("swing {name}"),
        };
        checking.follow(PrimitiveTrajectory::swing(constraints, gait, stance, [from, to]).unwrap());
        assert!(checking.waypoints > 4);
        held += 1;
    }
    let [left, right] = if stance.limb == 0 { [stance, from] } else { [from, stance] };
    if sufficient_shift(
        preparation,
        robot,
        &constraints.collision,
        &left.placement(robot),
        &right.placement(robot),
    ) {
        let here = configuration(robot, gait, left, right).unwrap();
        let mode = double_mode(left, right);
        let mut checking = Checking {
            constraints,
            mode,
            here,
            swing: None,
            waypoints: 0,
            name: format!("shift {name}"),
        };
        checking.follow(PrimitiveTrajectory::shift(constraints, gait, [left, right]).unwrap());
        held += 1;
    }
    held
}

fn primitives_hold(model: &RobotModel, triples: usize, seed: u64) {
    let config = PlannerConfig::default();
    let preparation = preparation_for(model, &config);
    let robot = Mechanism::new(model, &config).unwrap();
    let random = Random::new(seed, Stream::Preparation, 3, 0);
    let mut builder = Builder { robot: &robot, preparation: &preparation, random, shapes: vec![] };
    let made: Vec<PlacementTriple> = (0..triples).map(|index| builder.triple(index)).collect();
    let world =
        World { mu: 0.6, shapes: std::mem::take(&mut builder.shapes), digest: Digest::default() };
    let collision = CollisionModel::new(model, &world, config.clearance).unwrap();
    let constraints = Constraints::new(robot.clone(), collision, config);
    let held: usize = made
        .iter()
        .enumerate()
        .map(|(index, triple)| {
            primitives_hold_at(&constraints, &preparation, triple, &format!("{index}"))
        })
        .sum();
    println!("{}: {held} primitives held over {triples} triples", model.name);
    assert!(held * 4 > triples, "only {held} primitives over {triples} triples");
}

/// The Hubo with ankles that roll by 0.26 rad at most, as those of many robots.
fn with_stiff_ankles() -> RobotModel {
    let mut model = hubo();
    for joint in model.joints.iter_mut().filter(|joint| joint.name.ends_with("ankle_roll")) {
        (joint.lower, joint.upper) = (-0.26, 0.26);
    }
    model.digest = Digest::of(&[b"stiff ankles"]);
    model
}

/// The Hubo as if all its boxes were hulls.
fn of_hulls() -> RobotModel {
    let mut model = hubo();
    for placed in model.links.iter_mut().flat_map(|link| &mut link.shapes) {
        if let Shape::Box { half_extents } = placed.shape {
            let sign =
                |corner: usize, axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let corner = |corner: usize| {
                half_extents * DVec3::new(sign(corner, 0), sign(corner, 1), sign(corner, 2))
            };
            placed.shape = Shape::ConvexHull { points: (0..8).map(corner).collect(), source: None };
        }
    }
    model.digest = Digest::of(&[b"hulls", &model.digest.0]);
    model
}

/// The same robot as if its URDF named the legs before the root's other children.
fn with_legs_first(model: &RobotModel) -> RobotModel {
    let legs: Vec<usize> = model
        .feet
        .iter()
        .flat_map(|foot| model.chain(foot.link))
        .map(|joint| model.joints[joint].child)
        .collect();
    let mut order: Vec<usize> = (0..model.links.len()).collect();
    order.sort_by_key(|link| (*link > 0, !legs.contains(link)));
    let now = |link: usize| order.iter().position(|&before| before == link).unwrap();
    let mut turned = model.clone();
    turned.links = order.iter().map(|&link| model.links[link].clone()).collect();
    turned
        .links
        .iter_mut()
        .filter_map(|link| link.parent.as_mut())
        .for_each(|at| at.parent = now(at.parent));
    turned.joints.iter_mut().for_each(|joint| joint.child = now(joint.child));
    turned.feet.iter_mut().for_each(|foot| foot.link = now(foot.link));
    turned.digest = Digest::of(&[b"legs first", &model.digest.0]);
    turned
}

#[test]
fn the_order_of_links_does_not_change_the_preparation() {
    let before = of_hulls();
    let turned = with_legs_first(&before);
    assert!(before.links.iter().zip(&turned.links).any(|(a, b)| a.name != b.name));
    let [before, turned] =
        [&before, &turned].map(|model| preparation_for(model, &PlannerConfig::default()));
    assert!(before.range(0).extent().is_some());
    assert_eq!(before.gait(), turned.gait());
    assert_eq!(before.expanded(), turned.expanded());
    assert_eq!(
        [0, 1].map(|stance| before.range(stance).extent()),
        [0, 1].map(|stance| turned.range(stance).extent())
    );
}

#[test]
fn a_robot_with_stiff_ankles_has_a_range_of_steps_on_a_floor_too() {
    let model = with_stiff_ankles();
    let preparation = preparation_for(&model, &PlannerConfig::default());
    for stance in 0..2 {
        let range = preparation.range(stance);
        let step = |ahead: f64, aside: f64| PairOffset { ahead, aside, above: 0.0, turn: 0.0 };
        assert!(
            [-0.1, 0.0, 0.1].iter().all(|&ahead| range.contains(&step(ahead, 0.2))),
            "stance {stance}: {:?}",
            range.extent()
        );
    }
}

#[test]
fn primitives_hold_wherever_c_s_holds() {
    primitives_hold(&hubo(), 200, 1);
    primitives_hold(&with_stiff_ankles(), 200, 1);
}

/// Four thousand triples of the shipped robot, or six hundred of each of other robots:
/// `SUREFOOT_ROBOTS=a/robot.toml:b/robot.toml cargo test --release -p surefoot-planner`
/// `--test prepare_primitives -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn thousands_of_primitives_hold() {
    let Ok(others) = std::env::var("SUREFOOT_ROBOTS") else {
        return (2..4).for_each(|seed| primitives_hold(&hubo(), 2_000, seed));
    };
    others.split(':').for_each(|path| primitives_hold(&load_robot(path.as_ref()).unwrap(), 600, 2));
}

/// The shipped scenarios that are planned quickly; in a build without optimisation, a few of them.
fn walked() -> Vec<String> {
    if cfg!(debug_assertions) {
        return WALKS.map(str::to_owned).into();
    }
    let files = std::fs::read_dir(repository().join("configs/scenarios")).unwrap();
    let names =
        files.map(|file| file.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned());
    let is_quick = |name: &String| {
        let slow = ["no_way", "gauntlet", "pass_under_low", "detour_", "cinder_blocks_steep"];
        !slow.iter().any(|start| name.starts_with(start))
    };
    names.filter(is_quick).collect()
}

/// The first configuration of the plan of a scenario that violates C_N or R, if any.
fn first_denial(case: &Case, preparation: &Preparation) -> Option<String> {
    let mut planner = case.planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found, "{}", case.scenario.name);
    let Constraints { robot, collision, .. } = planner.constraints();
    planner.chunks().iter().flat_map(|chunk| chunk.waypoints()).enumerate().find_map(
        |(index, waypoint)| {
            let world_from_root = waypoint.world_from_root();
            let label = necessary(preparation, robot, collision, &world_from_root);
            let kinematic_state =
                KinematicState::new(robot, &Configuration { world_from_root, q: waypoint.q });
            let may_reach = |limb: usize| {
                let root_from_sole =
                    world_from_root.inverse() * kinematic_state.world_from_sole(robot, limb);
                preparation.may_reach(limb, root_from_sole.translation)
            };
            let reached = [0, 1].map(may_reach);
            (!label.holds() || reached != [true; 2])
                .then(|| format!("waypoint {index}: {label:?}, {reached:?}"))
        },
    )
}

#[test]
fn c_n_and_r_hold_along_every_plan() {
    let names = walked();
    assert!(names.len() >= WALKS.len(), "{names:?}");
    for (name, seed) in names.iter().flat_map(|name| (1..=SEEDS).map(move |seed| (name, seed))) {
        let case = Case::shipped(name).with_seed(seed);
        let preparation = preparation_for(&case.model, &case.scenario.planner);
        assert_eq!(first_denial(&case, &preparation), None, "{name}, seed {seed}");
    }
}

#[test]
fn c_n_fails_in_a_wall_and_high_above_the_ground() {
    let model = hubo();
    let config = PlannerConfig::default();
    let preparation = preparation_for(&model, &config);
    let case = Case::shipped("flat_walk").with_box([3.0, 0.0, 1.0], [0.1, 0.8, 1.0]);
    let robot = Mechanism::new(&model, &config).unwrap();
    let collision = CollisionModel::new(&model, &case.world, config.clearance).unwrap();
    let at = |x: f64, z: f64| {
        necessary(&preparation, &robot, &collision, &Pose::from_translation(DVec3::new(x, 0.0, z)))
    };
    assert!(at(1.0, 0.8).holds() && at(1.0, 0.8).may_stand == [true; 2]);
    assert!(!at(3.0, 0.8).holds() && !at(1.0, 2.0).holds());
}
