//! The ground under the feet of a motion, as the zero-moment point is compared with it.

use glam::{DVec2, DVec3};
use surefoot_shared_types::message::Contact;

use crate::geometry::convex_region::ConvexRegion;

/// Where the feet of a motion stand.
#[derive(Debug, Clone)]
pub struct Ground {
    /// Mean height of the soles, m.
    pub height: f64,
    /// Hull of the supported parts of the soles in world x and y.
    pub region: ConvexRegion,
}

impl Ground {
    /// The ground under these contacts.
    pub fn under(contacts: &[Contact]) -> Self {
        let heights = contacts.iter().map(|contact| contact.position[2]);
        let vertices = contacts.iter().flat_map(|contact| {
            let world_from_sole = contact.world_from_sole();
            let polygon = &contact.polygon[..contact.polygon_len as usize];
            let seen_from_above =
                move |vertex: &[f64; 2]| world_from_sole * DVec2::from(*vertex).extend(0.0);
            polygon.iter().map(seen_from_above).map(DVec3::truncate)
        });
        Self {
            height: heights.sum::<f64>() / contacts.len().max(1) as f64,
            region: ConvexRegion::hull(vertices),
        }
    }
}
