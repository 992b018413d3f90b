//! Which links collide as a robot bends its knees and shifts its weight.

use std::collections::BTreeMap;

use glam::DVec3;
use surefoot_planner::collision::model::{CollisionModel, Hit};
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::robot::configuration::Configuration;
use surefoot_planner::robot::kinematic_state::KinematicState;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;

/// How far the root is lowered, as shares of the legs' length.
const LOWERED: [f64; 4] = [0.0, 0.02, 0.04, 0.06];
/// How far it goes from the middle to a foot.
const SHIFTS: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];
/// Below this share of colliding postures walks are found as well as without, percent.
pub(crate) const PERCENT_MIN: f64 = 40.0;

/// The links that [`most_often`] collide, where they do so in more than a few postures.
pub(crate) fn frequent(constraints: &Constraints) -> Option<(String, f64)> {
    most_often(constraints).filter(|(_, percent)| *percent >= PERCENT_MIN)
}

/// The links that collide most often, and in which share of the postures of [`percents`]; `None`
/// where none do.
pub(crate) fn most_often(constraints: &Constraints) -> Option<(String, f64)> {
    let Constraints { robot, collision, .. } = constraints;
    let named = percents(robot, collision).into_iter().map(|([a, b], percent)| {
        let hit = Hit::SelfPair { a, b };
        (collision.describe(hit), percent)
    });
    named.max_by(|a, b| a.1.total_cmp(&b.1).then_with(|| a.0.cmp(&b.0)))
}

/// The pairs of links that collide as the robot stands with its feet where they are, lower and to
/// the sides, and the share of such postures in which they do, in percent.
pub(crate) fn percents(robot: &Mechanism, collision: &CollisionModel) -> BTreeMap<[usize; 2], f64> {
    let soles = [0, 1].map(|limb| robot.legs[limb].root_from_sole(&robot.standing_q));
    let [left, right] = soles.map(|sole| sole.translation);
    let (aside, middle) = (0.5 * (left - right), 0.5 * (left + right));
    let mut count = 0.0;
    let mut hits: BTreeMap<[usize; 2], f64> = BTreeMap::new();
    for (lowered, shift) in LOWERED.into_iter().flat_map(|z| SHIFTS.map(|shift| (z, shift))) {
        let away = DVec3::new(shift * aside.x, shift * aside.y, lowered * middle.z);
        let mut configuration =
            Configuration { world_from_root: Pose::from_translation(away), q: robot.standing_q };
        if !robot.place_soles(&mut configuration, &soles) {
            continue;
        }
        count += 1.0;
        for pair in collision.self_hits(&KinematicState::new(robot, &configuration)) {
            *hits.entry(pair).or_default() += 1.0;
        }
    }
    hits.values_mut().for_each(|hits| *hits *= 100.0 / count);
    hits
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::Path;

    use surefoot_planner::collision::model::CollisionModel;
    use surefoot_planner::robot::mechanism::Mechanism;
    use surefoot_shared_types::Shape;
    use surefoot_shared_types::config::PlannerConfig;
    use surefoot_shared_types::robot::load::load_robot;
    use surefoot_shared_types::robot::model::{LinkShape, RobotModel};

    use super::*;
    use crate::commands::robot::trial::level_ground;

    pub(crate) fn constraints_of(model: &RobotModel) -> Constraints {
        let config = PlannerConfig::default();
        let robot = Mechanism::new(model, &config).unwrap();
        let collision = CollisionModel::new(model, &level_ground(), config.clearance).unwrap();
        Constraints::new(robot, collision, config)
    }

    fn found(model: &RobotModel) -> Option<(String, f64)> {
        frequent(&constraints_of(model))
    }

    fn hubo() -> RobotModel {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots/hubo/robot.toml");
        load_robot(&file).unwrap()
    }

    /// A robot with a ball on its right shin, which clears the toes by 3 mm as the robot stands.
    pub(crate) fn hubo_with_a_ball() -> RobotModel {
        let mut model = hubo();
        let robot = Mechanism::new(&model, &PlannerConfig::default()).unwrap();
        let at_rest = Configuration { world_from_root: Pose::IDENTITY, q: robot.standing_q };
        let state = KinematicState::new(&robot, &at_rest);
        let link = |name: &str| model.links.iter().position(|link| link.name == name).unwrap();
        let shin = link("right_shin");
        let [root_from_shin, root_from_foot] =
            [shin, link("right_foot")].map(|link| state.world_from_link(&robot, link));
        // The top of the foot's box is 0.08 m below the ankle.
        let at = root_from_shin.inverse() * (root_from_foot * DVec3::new(0.1, 0.0, -0.057));
        let ball = Shape::Sphere { radius: 0.02 };
        let link_from_shape = Pose::from_translation(at);
        model.links[shin].shapes.push(LinkShape { link_from_shape, shape: ball });
        model
    }

    #[test]
    fn a_shin_that_meets_its_foot_as_the_knee_bends_is_named() {
        assert_eq!(found(&hubo()), None);
        let (links, percent) = found(&hubo_with_a_ball()).unwrap();
        assert_eq!(links, "link 'right_shin' collides with link 'right_foot'");
        assert!((50.0..100.0).contains(&percent), "{percent} %");
    }
}
