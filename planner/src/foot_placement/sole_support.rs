//! The support of a sole, why a sole has none, and why a world cannot be compiled.

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

use crate::constraints::foothold::Foothold;
use crate::robot::mechanism::Mechanism;

/// The support of a sole: the convex hull of its contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// The hull, in the sole frame, counter-clockwise, m.
    pub polygon: heapless::Vec<DVec2, POLYGON_VERTICES_MAX>,
    /// Its area, m2.
    pub area: f64,
    /// Distance from the hull's centroid to its nearest edge, m.
    pub edge_distance: f64,
    /// Shortest edge of the faces of meshes that carry and are inclined against the sole, m;
    /// infinite where there are none.
    pub corner_spacing: f64,
}

impl Support {
    /// The foothold of a robot on it.
    pub fn foothold(self, robot: &Mechanism, limb: usize, world_from_sole: Pose) -> Foothold {
        let foothold = Foothold::of(robot, limb, world_from_sole, self.polygon);
        foothold.on_corners(robot, self.corner_spacing)
    }
}

/// Why a sole has no support at a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NoSupport {
    /// The sole polygon is not a convex counter-clockwise polygon of 3 to 16 vertices, or the pose
    /// is not finite.
    InvalidSole,
    /// The sole is tilted beyond the friction cone.
    TooSteep,
    /// No surface is near the sole.
    NothingBelow,
    /// A surface stands above the sole plane within the outline.
    Penetrates,
    /// The surface in the sole's plane faces down.
    FacesDown,
    /// The contacts span too small an area.
    AreaTooSmall,
    /// The centroid of the support polygon is too near to its edge.
    CentroidNearEdge,
    /// More surface elements are under the sole than `support_elements_max`.
    TooManyElements,
}

impl NoSupport {
    /// Every reason, in the order of
    /// [`PlacementStats::rejected`](crate::foot_placement::PlacementStats::rejected).
    pub const ALL: [Self; 8] = [
        Self::InvalidSole,
        Self::TooSteep,
        Self::NothingBelow,
        Self::Penetrates,
        Self::FacesDown,
        Self::AreaTooSmall,
        Self::CentroidNearEdge,
        Self::TooManyElements,
    ];

    /// The reason as a clause for messages.
    pub fn describe(self) -> &'static str {
        match self {
            Self::InvalidSole => "the sole polygon or the pose is invalid",
            Self::TooSteep => "the ground is too steep for the friction",
            Self::NothingBelow => "no surface is below the sole",
            Self::Penetrates => "an obstacle stands where the sole is",
            Self::FacesDown => {
                "the ground faces down (its triangles may wind clockwise, seen from above)"
            }
            Self::AreaTooSmall => "the supported area of the sole is too small",
            Self::CentroidNearEdge => "the support is too narrow",
            Self::TooManyElements => "the mesh there has too many faces for the planner's bounds",
        }
    }
}

/// Why a world cannot be compiled into surfaces.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SurfacesError {
    /// A parameter is out of its range.
    #[error("foot placement parameter {field} = {value} must lie in {lower}..{upper}")]
    Config {
        /// The field of [`FootPlacementConfig`](crate::foot_placement::FootPlacementConfig).
        field: &'static str,
        /// Its value.
        value: f64,
        /// The smallest allowed value.
        lower: f64,
        /// The largest allowed value.
        upper: f64,
    },
    /// A shape cannot be compiled.
    #[error("shape '{shape}': {message}")]
    Shape {
        /// The name of the shape in the world.
        shape: String,
        /// The fault, and how to correct it.
        message: String,
    },
}
