//! The ground under the feet of a motion, as the zero-moment point is compared with it.

use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::CONTACTS_MAX;
use surefoot_shared_types::message::Contact;

use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::area_and_centroid;
use crate::timing::support::{SolePolygon, supported_part};

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
        let supports: BoundedVec<(Pose, SolePolygon), CONTACTS_MAX> = contacts
            .iter()
            .map(|contact| (contact.world_from_sole(), supported_part(contact)))
            .collect();
        let heights = supports.iter().map(|(world_from_sole, part)| {
            let (_, centroid) = area_and_centroid(part);
            (*world_from_sole * centroid.extend(0.0)).z
        });
        let height = heights.sum::<f64>() / contacts.len().max(1) as f64;
        let corners = supports.iter().flat_map(|(world_from_sole, part)| {
            part.iter().map(|corner| (*world_from_sole * corner.extend(0.0)).truncate())
        });
        Self { height, region: ConvexRegion::hull(corners) }
    }
}
