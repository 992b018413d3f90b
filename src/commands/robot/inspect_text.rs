//! The text and the JSON of `surefoot robot inspect`.

use serde_json::{Value, json};
use surefoot_controller_sim::geometry::polygon::area;
use surefoot_shared_types::robot::model::{Joint, JointKind, RobotModel};

use crate::input::stance_measures::standing_height;

/// Pairs on one line of the text.
const PAIRS_PER_LINE: usize = 3;

/// A robot as it is read, as text.
pub(crate) fn text(model: &RobotModel, allowed: &[[String; 2]]) -> String {
    let mut lines = vec![
        format!("{} ({})", model.name, model.urdf_path.display()),
        format!(
            "  root      '{}', {:.3} m above the soles, which are {:.3} m apart; {:.2} kg in all",
            model.links[0].name,
            standing_height(model),
            model.stance_width(),
            model.mass()
        ),
    ];
    lines.extend((0..model.feet.len()).map(|limb| foot_line(model, limb)));
    lines.push(format!(
        "  joints    {}, in the order of every plan: limits, effort, velocity, standing position",
        model.joints.len()
    ));
    let width = model.joints.iter().map(|joint| joint.name.len()).max().unwrap_or(0);
    lines.extend(model.joints.iter().enumerate().map(|(at, joint)| {
        format!("    {at:>2} {:<width$} {}", joint.name, joint_columns(model, at, joint))
    }));
    lines.push(format!("  locked    {}", model.locked_joints.len()));
    lines.extend(
        model
            .locked_joints
            .iter()
            .map(|locked| format!("    {} at {:.4}", locked.joint.name, locked.position)),
    );
    let missing = &model.additions.missing_meshes;
    if !missing.is_empty() {
        lines.push(format!("  missing   mesh files that may be left out: {}", missing.join(", ")));
    }
    lines.push(format!("  may touch {} pairs of links", allowed.len()));
    lines.extend(allowed.chunks(PAIRS_PER_LINE).map(|row| {
        let pairs: Vec<String> = row.iter().map(|[a, b]| format!("{a} - {b}")).collect();
        format!("    {}", pairs.join(", "))
    }));
    lines.join("\n")
}

fn foot_line(model: &RobotModel, limb: usize) -> String {
    let foot = &model.feet[limb];
    let at = foot.link_from_sole.translation;
    format!(
        "  {:<9} link '{}', leg of {} joints, sole of {} corners and {:.1} cm2 at [{:.4}, {:.4}, {:.4}]",
        foot.name,
        model.links[foot.link].name,
        model.leg(limb).len(),
        foot.polygon.len(),
        1e4 * area(&foot.polygon),
        at.x,
        at.y,
        at.z
    )
}

fn joint_columns(model: &RobotModel, at: usize, joint: &Joint) -> String {
    let [angle, effort] = units(joint.kind);
    format!(
        "{:>8.3} ..{:>7.3} {angle:<3} {:>8.1} {effort:<3} {:>6.1} {angle}/s {:>8.4}",
        joint.lower, joint.upper, joint.effort, joint.velocity, model.standing_q[at]
    )
}

fn units(kind: JointKind) -> [&'static str; 2] {
    match kind {
        JointKind::Revolute => ["rad", "N m"],
        JointKind::Prismatic => ["m", "N"],
    }
}

/// A robot as it is read, as one JSON object.
pub(crate) fn json(model: &RobotModel, allowed: &[[String; 2]]) -> String {
    let joint = |(at, joint): (usize, &Joint)| {
        json!({
            "name": joint.name,
            "kind": if joint.kind == JointKind::Revolute { "revolute" } else { "prismatic" },
            "lower": joint.lower,
            "upper": joint.upper,
            "effort": joint.effort,
            "velocity": joint.velocity,
            "acceleration": joint.acceleration(),
            "standing": model.standing_q[at],
        })
    };
    let feet = model.feet.iter().enumerate().map(|(limb, foot)| {
        let leg = model.leg(limb);
        let names: Vec<&str> = leg.iter().map(|at| model.joints[*at].name.as_str()).collect();
        json!({
            "name": foot.name,
            "link": model.links[foot.link].name,
            "leg": names,
            "sole_xyz": foot.link_from_sole.translation.to_array(),
            "sole_quat_xyzw": foot.link_from_sole.rotation.to_array(),
            "polygon": foot.polygon.iter().map(|corner| corner.to_array()).collect::<Vec<_>>(),
        })
    });
    let locked = model
        .locked_joints
        .iter()
        .map(|locked| json!({ "name": locked.joint.name, "position": locked.position }));
    json!({
        "name": model.name,
        "urdf": model.urdf_path,
        "digest": model.digest.to_string(),
        "root": model.links[0].name,
        "mass": model.mass(),
        "standing_height": standing_height(model),
        "stance_width": model.stance_width(),
        "joints": model.joints.iter().enumerate().map(joint).collect::<Vec<Value>>(),
        "feet": feet.collect::<Vec<Value>>(),
        "locked": locked.collect::<Vec<Value>>(),
        "missing_meshes": model.additions.missing_meshes,
        "allowed_pairs": allowed,
    })
    .to_string()
}
