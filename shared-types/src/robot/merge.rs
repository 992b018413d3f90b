//! Makes one link of links that are fixed to each other, where a robot has too many.

use glam::{DMat3, DVec3};

use crate::base::limits::LINKS_KEPT_MAX;
use crate::base::spatial::Pose;

use crate::robot::model::{Attachment, Link, LinkIndex, LinkShape, RobotModel};

/// Merges links into the ones that they are fixed to: bare frames first, then, if there are still
/// more than [`LINKS_KEPT_MAX`], bodies. The links of feet and of locked joints stay.
pub(crate) fn merge_fixed_links(robot: &mut RobotModel) {
    let is_bare = |link: &Link| link.mass == 0.0 && link.shapes.is_empty();
    if robot.links.len() > LINKS_KEPT_MAX {
        merge(robot, is_bare);
    }
    if robot.links.len() > LINKS_KEPT_MAX {
        merge(robot, |_| true);
    }
}

fn merge(robot: &mut RobotModel, may_go: impl Fn(&Link) -> bool) {
    // Children stand after their parents, so that what hangs on a link is settled before it.
    for at in (1..robot.links.len()).rev() {
        let is_foot = robot.feet.iter().any(|foot| foot.link == at);
        let is_locked = robot.locked_joints.iter().any(|locked| locked.joint.child == at);
        let Some(Attachment { parent, parent_from_joint, joint: None }) =
            robot.links[at].parent.clone()
        else {
            continue;
        };
        if !is_foot && !is_locked && may_go(&robot.links[at]) {
            let link = robot.links.remove(at);
            absorb(&mut robot.links[parent], link, &parent_from_joint);
            rehang(robot, at, parent, &parent_from_joint);
        }
    }
}

/// Adds the mass and shapes of a link that stands fixed at `parent_from_link`.
pub(crate) fn absorb(parent: &mut Link, link: Link, parent_from_link: &Pose) {
    parent.shapes.extend(moved(link.shapes, parent_from_link));
    let mass = parent.mass + link.mass;
    if link.mass == 0.0 || mass == 0.0 {
        return;
    }
    let turn = DMat3::from_quat(parent_from_link.rotation);
    let link_com = *parent_from_link * link.com;
    let com = (parent.mass * parent.com + link.mass * link_com) / mass;
    let inertia = turn * link.inertia * turn.transpose();
    parent.inertia = moved_inertia(parent.inertia, parent.mass, parent.com - com)
        + moved_inertia(inertia, link.mass, link_com - com);
    (parent.mass, parent.com) = (mass, com);
}

/// The shapes of a link in the frame of its parent.
pub(crate) fn moved(
    shapes: Vec<LinkShape>,
    parent_from_link: &Pose,
) -> impl Iterator<Item = LinkShape> {
    let parent_from_link = *parent_from_link;
    shapes.into_iter().map(move |part| LinkShape {
        link_from_shape: parent_from_link * part.link_from_shape,
        shape: part.shape,
    })
}

/// The inertia about a point from which the centre of mass is `away` (Steiner).
fn moved_inertia(inertia: DMat3, mass: f64, away: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(away * away.x, away * away.y, away * away.z);
    inertia + (DMat3::from_diagonal(DVec3::splat(away.length_squared())) - outer) * mass
}

/// Lets all that hung on the removed link hang on its parent, and counts links anew.
fn rehang(robot: &mut RobotModel, removed: LinkIndex, parent: LinkIndex, parent_from: &Pose) {
    let moved = |at: LinkIndex| if at > removed { at - 1 } else { at };
    let mut rehung = Vec::new();
    for (at, link) in robot.links.iter_mut().enumerate() {
        let Some(attachment) = &mut link.parent else { continue };
        if attachment.parent == removed {
            attachment.parent = parent;
            attachment.parent_from_joint = *parent_from * attachment.parent_from_joint;
            rehung.push(at);
        } else {
            attachment.parent = moved(attachment.parent);
        }
    }
    robot.joints.iter_mut().for_each(|joint| joint.child = moved(joint.child));
    robot.feet.iter_mut().for_each(|foot| foot.link = moved(foot.link));
    for locked in &mut robot.locked_joints {
        locked.joint.child = moved(locked.joint.child);
        if rehung.contains(&locked.joint.child) {
            locked.parent_from_joint = *parent_from * locked.parent_from_joint;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_halves_of_a_rod_weigh_as_much_and_turn_as_hard_as_the_rod() {
        // Of a thin rod of mass 2 and length 2 along x.
        let half = |x: f64| Link {
            name: String::new(),
            parent: None,
            mass: 1.0,
            com: DVec3::X * x,
            inertia: DMat3::from_diagonal(DVec3::new(0.0, 1.0 / 12.0, 1.0 / 12.0)),
            shapes: vec![],
        };
        let mut rod = half(-0.5);
        // The other half lies along its own y, in a frame turned by a quarter.
        let turn = crate::base::spatial::rotation_from_rpy(0.0, 0.0, -std::f64::consts::FRAC_PI_2);
        let mut other = half(0.0);
        other.com = DVec3::new(0.0, 0.5, 0.0);
        other.inertia = DMat3::from_diagonal(DVec3::new(1.0 / 12.0, 0.0, 1.0 / 12.0));
        absorb(&mut rod, other, &Pose::from_rotation(turn));
        assert!(rod.mass == 2.0 && rod.com.length() < 1e-12, "{}", rod.com);
        let whole = DMat3::from_diagonal(DVec3::new(0.0, 2.0 / 3.0, 2.0 / 3.0));
        assert!((rod.inertia - whole).abs_diff_eq(DMat3::ZERO, 1e-12), "{}", rod.inertia);
    }
}
