//! Orders the links of a URDF into a tree, parents first.

use std::collections::BTreeMap;

use crate::base::input_error::InputError;

use crate::robot::urdf::Urdf;
use crate::robot::urdf_joint::UrdfJoint;

/// A link in the order of the tree: depth first, children in document order.
pub(crate) struct TreeLink {
    /// Its index in the URDF.
    pub(crate) urdf_link: usize,
    /// Its parent's place in the tree order and the URDF joint between them; `None` for the root.
    pub(crate) parent: Option<(usize, usize)>,
}

/// All links of the URDF, each after its parent; `None` where joints name unknown links, a link
/// has two parents, or the joints do not form one tree, which joins `complaints`.
pub(crate) fn sort_links(urdf: &Urdf, complaints: &mut Vec<InputError>) -> Option<Vec<TreeLink>> {
    let known = complaints.len();
    let index: BTreeMap<&str, usize> =
        urdf.links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
    let mut parent_joint: Vec<Option<usize>> = vec![None; urdf.links.len()];
    let mut children: Vec<Vec<(usize, usize)>> = vec![Vec::new(); urdf.links.len()];
    for (j, joint) in urdf.joints.iter().enumerate() {
        let mut input_error = |message: String| {
            complaints.push(joint.location.error(format!("joint '{}'", joint.name), message));
        };
        let ends = [("parent", &joint.parent), ("child", &joint.child)].map(|(end, name)| {
            let link = index.get(name.as_str()).copied();
            // That a name is missing is known already.
            if link.is_none() && !name.is_empty() {
                input_error(format!("its {end} link '{name}' is not in the file"));
            }
            link
        });
        let [Some(parent), Some(child)] = ends else { continue };
        if let Some(other) = parent_joint[child] {
            input_error(format!(
                "its child link '{}' already hangs on joint '{}'",
                joint.child, urdf.joints[other].name
            ));
            continue;
        }
        parent_joint[child] = Some(j);
        children[parent].push((child, j));
    }
    let has_all_ends = complaints.len() == known && urdf.joints.iter().all(UrdfJoint::has_ends);
    if !has_all_ends {
        return None;
    }
    let root = only_root(urdf, &parent_joint, complaints)?;
    let sorted = depth_first(root, &children);
    check_all_reached(urdf, &sorted, complaints);
    (complaints.len() == known).then_some(sorted)
}

fn only_root(
    urdf: &Urdf,
    parent_joint: &[Option<usize>],
    complaints: &mut Vec<InputError>,
) -> Option<usize> {
    let mut roots = (0..parent_joint.len()).filter(|link| parent_joint[*link].is_none());
    let Some(first) = roots.next() else {
        let joint = &urdf.joints[0];
        let message = "the joints form a cycle; no link is the root";
        complaints.push(joint.location.error(format!("joint '{}'", joint.name), message));
        return None;
    };
    let mut is_only = true;
    for other in roots {
        let (name, link) = (&urdf.links[first].name, &urdf.links[other]);
        let message = format!("is a second root beside '{name}'; connect them with a joint");
        complaints.push(link.location.error(format!("link '{}'", link.name), message));
        is_only = false;
    }
    is_only.then_some(first)
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

fn check_all_reached(urdf: &Urdf, sorted: &[TreeLink], complaints: &mut Vec<InputError>) {
    let mut reached = vec![false; urdf.links.len()];
    sorted.iter().for_each(|link| reached[link.urdf_link] = true);
    if let Some(at) = reached.iter().position(|reached| !reached) {
        let link = &urdf.links[at];
        let message = "hangs on a cycle of joints, not on the root";
        complaints.push(link.location.error(format!("link '{}'", link.name), message));
    }
}
