//! The problem description for the peers: the robot's names, its unchecked pairs of links, and the
//! weight shift.

use serde_json::{Value, json};
use surefoot_planner::robot::configuration::Configuration;

use crate::scene::Scene;

/// The robot of a scene and the weight shift that is measured in it, null where it cannot step.
pub fn problem(scene: &mut Scene) -> Value {
    let step = scene.step();
    let model = &scene.model;
    let link = |index: usize| &model.links[index].name;
    let allowed = scene
        .constraints
        .collision
        .allowed_pairs()
        .iter()
        .map(|(a, b)| json!([link(*a), link(*b)]));
    let configuration = |at: &Configuration| {
        let (position, rotation) =
            (at.world_from_root.translation.to_array(), at.world_from_root.rotation.to_array());
        json!({ "root_xyz": position, "root_quat_xyzw": rotation, "q": at.q[..model.joints.len()] })
    };
    let shift = step.map(|step| {
        let problem = step.shift();
        let region: Vec<[f64; 2]> =
            problem.mode.region.vertices().iter().map(|vertex| vertex.to_array()).collect();
        json!({
            "from": configuration(&problem.from.configuration),
            "to": configuration(&problem.to.configuration),
            "region": region,
            "com_margin": scene.constraints.com_margin(&problem.mode),
        })
    });
    json!({
        "robot": model.name,
        "urdf": model.urdf_path,
        "joint_names": model.joints.iter().map(|joint| &joint.name).collect::<Vec<_>>(),
        "foot_links": model.feet.iter().map(|foot| link(foot.link)).collect::<Vec<_>>(),
        "allowed_pairs": allowed.collect::<Vec<_>>(),
        "standing": configuration(scene.standing()),
        "shift": shift,
    })
}
