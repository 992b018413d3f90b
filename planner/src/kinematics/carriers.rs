//! The links that move by themselves, with all that is fixed to each taken as one mass.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::RobotModel;

/// A link that moves against its parent, or the root, and what is fixed to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carrier {
    /// The link.
    pub link: usize,
    /// The carrier before it, as an index into the list; its own for the root.
    pub parent: usize,
    /// The mass of the link and of what is fixed to it, kg.
    pub mass: f64,
    /// Their centre of mass in the link's frame; the origin where they have no mass.
    pub com: DVec3,
}

/// A robot's carriers, parents first; the root is the first.
pub fn carriers(model: &RobotModel) -> Vec<Carrier> {
    let mut carriers: Vec<Carrier> = Vec::new();
    let mut places: Vec<(usize, Pose)> = Vec::new();
    for (index, link) in model.links.iter().enumerate() {
        let place = match &link.parent {
            Some(at) if at.joint.is_none() => {
                let (carrier, carrier_from_parent) = places[at.parent];
                (carrier, carrier_from_parent * at.parent_from_joint)
            }
            moving => {
                let parent = moving.as_ref().map_or(0, |at| places[at.parent].0);
                carriers.push(Carrier { link: index, parent, mass: 0.0, com: DVec3::ZERO });
                (carriers.len() - 1, Pose::IDENTITY)
            }
        };
        let carrier = &mut carriers[place.0];
        carrier.mass += link.mass;
        carrier.com += (place.1 * link.com) * link.mass;
        places.push(place);
    }
    for carrier in carriers.iter_mut().filter(|carrier| carrier.mass > 0.0) {
        carrier.com /= carrier.mass;
    }
    carriers
}
