//! Where a foot can stand, on arbitrary geometry [Grey 4.1.2, 4.2].
//!
//! [`Surfaces`] is compiled once from a world: every planar face (coplanar triangles merged), every
//! line and cap of a curved shape, and a bounding volume hierarchy over them. [`Surfaces::support`]
//! computes what supports a sole at a pose; [`Surfaces::propose`] finds poses that carry: set
//! down where the ground is rough, read off the geometry elsewhere, and by the thesis's Algorithm 1
//! after; [`Surfaces::propose_nests`] finds those that only a second face holds. Both work in a
//! [`Scratch`] of the caller and never touch the heap.
//!
//! What is deliberately absent: curved surfaces carry along a line or at a point only, never a
//! strip; steep walls never carry; a solid that swallows the whole foot shows no surface near the
//! sole, so the caller's collision test (`is_free`) must reject it.

use glam::{DMat3, DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

/// What carries a sole: the convex hull of its contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Support {
    /// The hull, in the sole frame, counter-clockwise, m.
    pub polygon: heapless::Vec<DVec2, POLYGON_VERTICES_MAX>,
    /// Its area, m2.
    pub area: f64,
    /// From the hull's centroid to its nearest edge, m.
    pub edge_distance: f64,
}

/// Why a sole finds no support at a pose.
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
    /// More surface elements under the sole than `support_elements_max`.
    TooManyElements,
}

impl NoSupport {
    /// Every reason, in the order of [`PlacementStats::rejected`].
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

    /// The reason for a person.
    pub fn describe(self) -> &'static str {
        match self {
            Self::InvalidSole => "the sole polygon or the pose is invalid",
            Self::TooSteep => "it is too steep for the friction",
            Self::NothingBelow => "there is nothing to stand on",
            Self::Penetrates => "something stands in the sole's place",
            Self::FacesDown => {
                "the ground there faces down (do its triangles wind clockwise, seen from above?)"
            }
            Self::AreaTooSmall => "too little of the sole is carried",
            Self::CentroidNearEdge => "what carries it is too narrow",
            Self::TooManyElements => "the mesh there is too fine for planner bounds",
        }
    }
}

/// Why a world cannot be compiled into surfaces.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SurfacesError {
    /// A parameter is out of its range.
    #[error("foot placement parameter {field} = {value} must lie in {lower}..{upper}")]
    Config {
        /// The field of [`FootPlacementConfig`].
        field: &'static str,
        /// Its value.
        value: f64,
        /// The smallest allowed value.
        lower: f64,
        /// The largest allowed value.
        upper: f64,
    },
    /// A shape is broken.
    #[error("shape '{shape}': {message}")]
    Shape {
        /// The name of the shape in the world.
        shape: String,
        /// What is wrong and what to do.
        message: String,
    },
}

/// The pose at `position` whose z axis is `normal` (pointing up) and whose x axis, seen from above,
/// heads for `yaw`.
pub(crate) fn pose_on_plane(position: DVec3, normal: DVec3, yaw: f64) -> Pose {
    let (sin, cos) = libm::sincos(yaw);
    let heading = DVec3::new(cos, sin, 0.0);
    let x = (heading * normal.z - DVec3::Z * heading.dot(normal)).normalize();
    Pose::from_parts(
        position,
        DQuat::from_mat3(&DMat3::from_cols(x, normal.cross(x), normal)).normalize(),
    )
}
