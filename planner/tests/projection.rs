//! Projection onto two soles: what it finds stands there, and it finds what sampling the root's
//! pose does not.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use common::{hubo, with_split_hip};
use glam::{DQuat, DVec2, DVec3};
use surefoot_planner::body::{Body, Configuration};
use surefoot_planner::posture::{Posture, settle, unsettled};
use surefoot_planner::projection::{Ground, project};
use surefoot_planner::random::{Random, Stream};
use surefoot_planner::region::Region;
use surefoot_planner::snapshot::Snapshot;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::spatial::{rotation_about, rotation_distance, rotation_from_rpy};

const COM_MARGIN: f64 = 0.01;

/// A robot without a closed form whose ankles roll little, as those of many humanoids.
fn stiff_ankled() -> RobotModel {
    let mut model = with_split_hip(&hubo());
    for joint in model.joints.iter_mut().filter(|joint| joint.name.ends_with("ankle_roll")) {
        (joint.lower, joint.upper) = (-0.2, 0.2);
    }
    model
}

fn body(model: &RobotModel) -> Body {
    Body::new(model, &PlannerConfig::default()).unwrap()
}

fn sole_region(body: &Body, world_from_sole: &Pose) -> Region {
    Region::seen_from_above(world_from_sole, &body.sole_polygons[0])
}

/// Over the middle of the left sole, as the robot stands.
fn upright(region: &Region, body: &Body) -> Posture {
    Posture {
        world_from_root: DQuat::IDENTITY,
        reach_share: body.standing_reach_share,
        com: region.centroid(),
    }
}

fn assert_stands(body: &Body, ground: &Ground<'_>, found: &Configuration) {
    let snapshot = body.snapshot(found);
    for (limb, sole) in ground.world_from_soles.iter().enumerate() {
        let reached = body.world_from_sole(&snapshot, limb);
        assert!(reached.translation.distance(sole.translation) < 1e-8, "{reached:?} {sole:?}");
        assert!(rotation_distance(reached.rotation, sole.rotation) < 1e-7, "{reached:?} {sole:?}");
        assert!(
            body.legs[limb].joints().iter().all(|joint| joint.admits(found.q[joint.index])),
            "{:?}",
            found.q
        );
    }
    assert!(ground.region.holds(snapshot.com.truncate(), ground.com_margin), "{}", snapshot.com);
}

#[test]
fn most_pairs_of_soles_that_some_posture_reaches_are_found() {
    let body = body(&stiff_ankled());
    let mut random = Random::new(5, Stream::Preparation, 0, 0);
    let (mut found, mut settled, mut tried) = (0, 0, 0);
    while tried < 400 {
        let mut made_from =
            Configuration { world_from_root: Pose::from_translation(DVec3::Z), q: body.standing_q };
        let turns = [0.3, 0.3, 0.5].map(|half| random.uniform(-half, half));
        made_from.world_from_root.rotation = rotation_from_rpy(turns[0], turns[1], turns[2]);
        for joint in body.legs.iter().flat_map(|leg| leg.joints()) {
            let stray = random.uniform(-0.5, 0.5);
            made_from.q[joint.index] =
                (made_from.q[joint.index] + stray).clamp(joint.lower, joint.upper);
        }
        let snapshot = body.snapshot(&made_from);
        let soles = [0, 1].map(|limb| body.world_from_sole(&snapshot, limb));
        let region = sole_region(&body, &soles[0]);
        if !region.holds(snapshot.com.truncate(), COM_MARGIN) {
            continue;
        }
        tried += 1;
        settled +=
            usize::from(settle(&body, &soles, &upright(&region, &body), body.standing_q).is_ok());
        let ground = Ground { world_from_soles: &soles, region: &region, com_margin: COM_MARGIN };
        let start = unsettled(&body, &soles, &upright(&region, &body), body.standing_q);
        if let Some(configuration) = project(&body, &ground, &start, &mut Snapshot::default()) {
            found += 1;
            assert_stands(&body, &ground, &configuration);
        }
    }
    assert!(
        found > tried / 2 && found > 3 * settled,
        "{found} of {tried}, {settled} of them with the root upright"
    );
}

#[test]
fn a_sole_tilted_beyond_the_upright_robots_reach_is_touched() {
    let body = body(&stiff_ankled());
    let soles = [(0.12, 0.0), (-0.12, -0.44)]
        .map(|(y, roll)| Pose::from_parts(DVec3::Y * y, rotation_about(DVec3::X, roll)));
    let region = sole_region(&body, &soles[0]);
    let ground = Ground { world_from_soles: &soles, region: &region, com_margin: COM_MARGIN };
    assert!(
        settle(&body, &soles, &upright(&region, &body), body.standing_q).is_err(),
        "the root must lean"
    );
    let start = unsettled(&body, &soles, &upright(&region, &body), body.standing_q);
    let found = project(&body, &ground, &start, &mut Snapshot::default()).unwrap();
    assert_stands(&body, &ground, &found);
}

#[test]
fn what_is_too_far_is_not_found() {
    let body = body(&stiff_ankled());
    let soles = [1.2, -1.2].map(|y| Pose::from_translation(DVec3::Y * y));
    let region =
        Region::hull([(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)].map(DVec2::from));
    let ground = Ground { world_from_soles: &soles, region: &region, com_margin: 0.0 };
    let start = unsettled(&body, &soles, &upright(&region, &body), body.standing_q);
    assert_eq!(project(&body, &ground, &start, &mut Snapshot::default()), None);
}
