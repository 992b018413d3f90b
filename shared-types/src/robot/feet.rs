//! Finds the feet of a robot: the link that carries each sole, and the links that are one with it.

use crate::base::closest::closest;
use crate::base::input_error::InputError;
use crate::base::spatial::Pose;

use crate::robot::merge::{absorb, moved};
use crate::robot::model::{Attachment, Foot, Link, LinkIndex, LockedJoint};
use crate::robot::sole::{check_sole, height_above_sole};
use crate::robot::spec::{FootSpec, RobotSpec};

/// Links of a foot that end at least this far above its sole are no part of what it stands on, m.
const OTHERS_ABOVE_MIN: f64 = 0.02;

/// Links whose shapes belong to a foot: they are fixed to it, and the sole needs them.
pub(crate) struct FootParts {
    foot: LinkIndex,
    parts: Vec<(LinkIndex, Pose)>,
}

impl FootParts {
    /// Makes the links one body with the foot's link, and leaves them as bare frames.
    pub(crate) fn join(&self, links: &mut [Link]) {
        for (part, foot_from_part) in &self.parts {
            let body = links[*part].take_body();
            absorb(&mut links[self.foot], body, foot_from_part);
        }
    }
}

/// The feet that a robot file describes, and those of several links.
pub(crate) fn build_feet(
    spec: &RobotSpec,
    links: &[Link],
    locked: &[LockedJoint],
    complaints: &mut Vec<InputError>,
) -> (Vec<Foot>, Vec<FootParts>) {
    let (mut feet, mut several) = (Vec::new(), Vec::new());
    for foot_spec in &spec.feet {
        match build_foot(foot_spec, links, locked) {
            Ok((foot, parts)) => {
                feet.push(foot);
                several.extend(parts);
            }
            Err(error) => complaints.push(error),
        }
    }
    (feet, several)
}

fn build_foot(
    spec: &FootSpec,
    links: &[Link],
    locked: &[LockedJoint],
) -> Result<(Foot, Option<FootParts>), InputError> {
    let Some(named) = links.iter().position(|link| link.name == spec.link) else {
        let meant = closest(&spec.link, links.iter().map(|link| link.name.as_str()));
        let meant = meant.map(|meant| format!("; did you mean '{meant}'?")).unwrap_or_default();
        let message = format!("the URDF has no link '{}'{meant}", spec.link);
        return Err(spec.location.error(format!("foot '{}'", spec.name), message));
    };
    let (link, link_from_named) = shaped_ancestor(links, named);
    let foot = Foot {
        name: spec.name.clone(),
        link,
        link_from_sole: link_from_named * spec.link_from_sole,
        polygon: spec.polygon.clone(),
    };
    let Err(error) = check_sole(&foot, &links[link], spec) else { return Ok((foot, None)) };
    let parts = fixed_parts(links, link, locked);
    if let Some(part) = part_with_sole(&foot, links, &parts, spec) {
        return Ok((part, None));
    }
    let mut whole = links[link].clone();
    for (part, foot_from_part) in &parts {
        whole.shapes.extend(moved(links[*part].shapes.clone(), foot_from_part));
    }
    if parts.is_empty() || check_sole(&foot, &whole, spec).is_err() {
        return Err(error);
    }
    Ok((foot, Some(FootParts { foot: link, parts })))
}

/// The foot on the one of its links that has all of the sole, where the others end far above it.
fn part_with_sole(
    foot: &Foot,
    links: &[Link],
    parts: &[(LinkIndex, Pose)],
    spec: &FootSpec,
) -> Option<Foot> {
    let on_part = |(link, foot_from_link): &(LinkIndex, Pose)| {
        let link_from_sole = foot_from_link.inverse() * foot.link_from_sole;
        Foot { link: *link, link_from_sole, ..foot.clone() }
    };
    let named = [(foot.link, Pose::IDENTITY)];
    let mut feet: Vec<Foot> = parts.iter().chain(&named).map(on_part).collect();
    let stands = |foot: &Foot| check_sole(foot, &links[foot.link], spec).is_ok();
    let one = feet.iter().position(stands)?;
    let part = feet.swap_remove(one);
    let is_clear = |foot: &Foot| height_above_sole(foot, &links[foot.link]) > OTHERS_ABOVE_MIN;
    feet.iter().all(is_clear).then_some(part)
}

/// The nearest link from one toward the root that has shapes and to which that one is fixed, as a
/// frame of a sole is to its foot, and the frame's pose there; the link itself where there is none.
fn shaped_ancestor(links: &[Link], link: usize) -> (usize, Pose) {
    let (mut at, mut at_from_link) = (link, Pose::IDENTITY);
    while links[at].shapes.is_empty() {
        let Some(Attachment { parent, parent_from_joint, joint: None }) = &links[at].parent else {
            return (link, Pose::IDENTITY);
        };
        (at, at_from_link) = (*parent, *parent_from_joint * at_from_link);
    }
    (at, at_from_link)
}

/// The other links with shapes that are fixed to one, directly or by way of others, and their
/// poses there. Links whose joints are locked do not count: they could move.
fn fixed_parts(links: &[Link], foot: LinkIndex, locked: &[LockedJoint]) -> Vec<(LinkIndex, Pose)> {
    let fixed_to = |at: LinkIndex| {
        let attachment = links[at].parent.as_ref()?;
        let is_locked = locked.iter().any(|locked| locked.joint.child == at);
        (attachment.joint.is_none() && !is_locked).then_some(attachment)
    };
    let (mut body, mut body_from_foot) = (foot, Pose::IDENTITY);
    while let Some(attachment) = fixed_to(body) {
        body_from_foot = attachment.parent_from_joint * body_from_foot;
        body = attachment.parent;
    }
    let foot_from_body = body_from_foot.inverse();
    let mut foot_from_links: Vec<Option<Pose>> = vec![None; links.len()];
    foot_from_links[body] = Some(foot_from_body);
    // Parents stand before their children.
    for at in body + 1..links.len() {
        foot_from_links[at] = fixed_to(at)
            .and_then(|it| foot_from_links[it.parent].map(|parent| parent * it.parent_from_joint));
    }
    let parts = foot_from_links.into_iter().enumerate();
    parts
        .filter(|(at, _)| *at != foot && !links[*at].shapes.is_empty())
        .filter_map(|(at, pose)| Some((at, pose?)))
        .collect()
}
