//! Soles set down on rough ground.

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::yaw_of;

use crate::foot_placement::elements::{Element, Face};
use crate::foot_placement::posed_sole::SupportRequirement;
use crate::foot_placement::proposal::{Examined, Proposal};
use crate::foot_placement::request::Source;
use crate::foot_placement::resting_sole::{SoleToRest, rest_pose};
use crate::foot_placement::sole_support::NoSupport;
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::{PLANES_TRIED_MAX, REST_OFFSETS, WIDE_SUPPORT_SHARE};
use crate::geometry::polygon::spanned;

/// Whether the ground near the ideal is a mesh without a plane that the sole fits on.
pub(crate) fn is_rough(proposal: &Proposal<'_, '_>) -> bool {
    let surfaces = proposal.surfaces;
    let sole_area = proposal.query.sole_area();
    let mesh_face = |&(_, id): &(f64, u32)| match surfaces.element(id) {
        Element::Face(face, vertices) if face.of_mesh() => Some((face, vertices)),
        Element::Face(..) | Element::Curved(_) => None,
    };
    let features = &proposal.scratch.features;
    let is_large_enough = |(plane, _): (&Face, &[DVec3])| {
        let coplanar = features
            .iter()
            .filter_map(mesh_face)
            .filter(|(face, _)| are_coplanar(surfaces, plane, face));
        coplanar.map(|(_, vertices)| 0.5 * spanned(vertices).length()).sum::<f64>() >= sole_area
    };
    features.iter().all(|feature| mesh_face(feature).is_some())
        && !features.iter().take(PLANES_TRIED_MAX).filter_map(mesh_face).any(is_large_enough)
}

/// Soles set down near the ideal: first those with a wide support, then those with enough.
pub(crate) fn propose_on_rough_ground(proposal: &mut Proposal<'_, '_>) -> ControlFlow<()> {
    let enough = proposal.requirement(0.0);
    let wide = WIDE_SUPPORT_SHARE * proposal.query.sole_area();
    let requirement = SupportRequirement { area_min: enough.area_min.max(wide), ..enough };
    let mut others: heapless::Vec<Pose, { REST_OFFSETS.len() }> = heapless::Vec::new();
    for offset in REST_OFFSETS.iter().take(proposal.query.limits.geometric_max as usize) {
        let query = proposal.query;
        let yaw = yaw_of(query.ideal.rotation);
        let (sin, cos) = libm::sincos(yaw);
        let position = query.ideal.translation + DVec2::new(cos, sin).rotate(*offset).extend(0.0);
        let sole =
            SoleToRest { outline: query.sole.outline, position, yaw, reach_z: query.reach_z };
        let Some(pose) = rest_pose(proposal.surfaces, proposal.scratch, &sole) else { continue };
        if proposal.query.is_in_reach(&pose)
            && proposal.examine(pose, Source::Geometric, requirement)?
                == Examined::Rejected(NoSupport::AreaTooSmall)
            && proposal.scratch.contacts.area_max >= enough.area_min
        {
            others.extend([pose]);
        }
    }
    for pose in others {
        proposal.examine(pose, Source::Geometric, enough)?;
    }
    ControlFlow::Continue(())
}

/// Whether two faces lie in one plane.
fn are_coplanar(surfaces: &Surfaces, one: &Face, other: &Face) -> bool {
    one.normal.dot(other.normal) >= surfaces.coplanar_cos
        && (one.offset - other.offset).abs() <= surfaces.config().plane_distance_max
}
