//! Orders the links of a URDF into a tree, parents first.

use std::collections::BTreeMap;

use crate::base::input_error::InputError;

use crate::robot::urdf::Urdf;

/// A link in the order of the tree: depth first, children in document order.
pub(crate) struct TreeLink {
    /// Its index in the URDF.
    pub(crate) urdf_link: usize,
    /// Its parent's place in the tree order and the URDF joint between them; `None` for the root.
    pub(crate) parent: Option<(usize, usize)>,
}

/// All links of the URDF, each after its parent.
///
/// # Errors
/// When a joint names an unknown link, a link has two parents, or the joints do not form one tree.
pub(crate) fn sort_links(urdf: &Urdf) -> Result<Vec<TreeLink>, InputError> {
    let index: BTreeMap<&str, usize> =
        urdf.robot.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
    let mut parent_joint: Vec<Option<usize>> = vec![None; urdf.robot.links.len()];
    let mut children: Vec<Vec<(usize, usize)>> = vec![Vec::new(); urdf.robot.links.len()];
    for (j, joint) in urdf.robot.joints.iter().enumerate() {
        let input_error = |message: String| {
            Err(urdf.joint_facts[j].location.error(format!("joint '{}'", joint.name), message))
        };
        let Some(&parent) = index.get(joint.parent.link.as_str()) else {
            return input_error(format!(
                "its parent link '{}' is not in the file",
                joint.parent.link
            ));
        };
        let Some(&child) = index.get(joint.child.link.as_str()) else {
            return input_error(format!(
                "its child link '{}' is not in the file",
                joint.child.link
            ));
        };
        if let Some(other) = parent_joint[child] {
            return input_error(format!(
                "its child link '{}' already hangs on joint '{}'",
                joint.child.link, urdf.robot.joints[other].name
            ));
        }
        parent_joint[child] = Some(j);
        children[parent].push((child, j));
    }
    let root = only_root(urdf, &parent_joint)?;
    let sorted = depth_first(root, &children);
    check_all_reached(urdf, &sorted)?;
    Ok(sorted)
}

fn only_root(urdf: &Urdf, parent_joint: &[Option<usize>]) -> Result<usize, InputError> {
    let mut roots = (0..parent_joint.len()).filter(|link| parent_joint[*link].is_none());
    let name = |link: usize| &urdf.robot.links[link].name;
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        (Some(first), Some(second)) => Err(urdf.link_locations[second].error(
            format!("link '{}'", name(second)),
            format!("is a second root beside '{}'; connect them with a joint", name(first)),
        )),
        (None, _) => Err(urdf.joint_facts[0].location.error(
            format!("joint '{}'", urdf.robot.joints[0].name),
            "the joints form a cycle; no link is the root",
        )),
    }
}

fn depth_first(root: usize, children: &[Vec<(usize, usize)>]) -> Vec<TreeLink> {
    let mut sorted: Vec<TreeLink> = Vec::with_capacity(children.len());
    let mut stack = vec![TreeLink { urdf_link: root, parent: None }];
    while let Some(link) = stack.pop() {
        let at = sorted.len();
        stack.extend(
            children[link.urdf_link]
                .iter()
                .rev()
                .map(|(child, joint)| TreeLink { urdf_link: *child, parent: Some((at, *joint)) }),
        );
        sorted.push(link);
    }
    sorted
}

fn check_all_reached(urdf: &Urdf, sorted: &[TreeLink]) -> Result<(), InputError> {
    let mut reached = vec![false; urdf.robot.links.len()];
    sorted.iter().for_each(|link| reached[link.urdf_link] = true);
    match reached.iter().position(|reached| !reached) {
        None => Ok(()),
        Some(link) => {
            let name = &urdf.robot.links[link].name;
            Err(urdf.link_locations[link]
                .error(format!("link '{name}'"), "hangs on a cycle of joints, not on the root"))
        }
    }
}
