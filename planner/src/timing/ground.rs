//! The ground under the feet of a motion, as the zero-moment point is compared with it.

use glam::DVec3;
use surefoot_shared_types::message::Contact;

use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::area_and_centroid;
use crate::timing::support::supported_part;

/// Where the feet of a motion stand.
#[derive(Debug, Clone)]
pub struct Ground {
    /// Mean height of the centroids of the soles' supports, m.
    pub height: f64,
    /// Hull of the supported parts of the soles in world x and y.
    pub region: ConvexRegion,
}

impl Ground {
    /// The ground under these contacts.
    pub fn under(contacts: &[Contact]) -> Self {
        let corners_of = |contact: &Contact| {
            let world_from_sole = contact.world_from_sole();
            let corners = supported_part(contact).into_iter();
            corners.map(move |corner| world_from_sole * corner.extend(0.0))
        };
        let heights = contacts.iter().map(|contact| {
            let (_, centroid) = area_and_centroid(&supported_part(contact));
            (contact.world_from_sole() * centroid.extend(0.0)).z
        });
        let height = heights.sum::<f64>() / contacts.len().max(1) as f64;
        let seen_from_above = contacts.iter().flat_map(corners_of).map(DVec3::truncate);
        Self { height, region: ConvexRegion::hull(seen_from_above) }
    }
}
