//! The memory that queries work in, allocated once.

use glam::{DVec2, DVec3};

use crate::foot_placement::bounded::{Bounded, BoundedHeap};
use crate::foot_placement::config::FootPlacementConfig;
use crate::foot_placement::plane_features::{Candidate, Footprint, Plane};
use crate::foot_placement::tuning::GATHERING_FACTOR;
use crate::geometry::polygon::{CLIP_VERTICES_MAX, ClipBuffer};
use crate::geometry::resting_foot::GroundPoint;

/// Memory of one caller's queries. No query allocates beyond it. One per thread, for any number of
/// [`Surfaces`](crate::foot_placement::Surfaces).
#[derive(Debug)]
pub struct Scratch {
    pub(crate) clip: ClipBuffer,
    pub(crate) contacts: Contacts,
    /// The gathered features: distance from the ideal (m) and element number, nearest first.
    pub(crate) features: Bounded<(f64, u32)>,
    pub(crate) planes: Planes,
    pub(crate) candidates: Candidates,
    /// Points on the features within reach, for Algorithm 1, in the world.
    pub(crate) intersection_points: Bounded<DVec3>,
    /// The ground under a sole that is set down, in the sole frame.
    pub(crate) ground: Bounded<DVec3>,
}

/// The contacts of the sole that is examined.
#[derive(Debug)]
pub(crate) struct Contacts {
    /// Contact points in the sole frame, m.
    pub points: Bounded<DVec2>,
    /// Their convex hull.
    pub hull: Vec<DVec2>,
    /// Another polygon while the hull is clipped.
    pub spare: Vec<DVec2>,
    /// The ground at and near these points, in the sole frame, m.
    pub ground: Bounded<GroundPoint>,
    /// Whether some contact belongs to a mesh: where the ground ends there only the whole support
    /// shows.
    pub has_open_edges: bool,
    /// Whether some contact belongs to a face.
    pub has_face: bool,
    /// Whether some contact belongs to a curved surface.
    pub has_line: bool,
    /// Upper bound of the area of their support, m2.
    pub area_max: f64,
    /// Shortest edge of the faces of meshes that carry and are inclined against the sole, m;
    /// infinite where there are none.
    pub corner_spacing: f64,
    /// Whether the sole tilts: it does not rest on the highest ground under it.
    pub is_tilting: bool,
    /// The point of the last rejected support that stands furthest above the sole plane, in the
    /// world.
    pub intrusion: Option<DVec3>,
    /// The height of the highest ground under the sole over its plane, m, where that is too far
    /// from it.
    pub height_off: Option<f64>,
}

/// The planes that a sole may lie in near the ideal.
#[derive(Debug)]
pub(crate) struct Planes {
    /// The planes, nearest first.
    pub nearest: Bounded<Plane>,
    /// How many of them have their candidates listed.
    pub listed: usize,
    /// The features seen in the plane that is listed.
    pub footprints: Bounded<Footprint>,
}

/// Placements to examine.
#[derive(Debug)]
pub(crate) struct Candidates {
    /// Best first, as far as requested.
    pub best: Bounded<Candidate>,
    /// Listed candidates that come after.
    pub waiting: BoundedHeap<Candidate>,
    /// Candidates with less area than required at first, by index in `best`.
    pub deferred: Bounded<u32>,
}

impl Scratch {
    /// Allocates the memory that queries with this configuration need.
    pub fn new(config: &FootPlacementConfig) -> Self {
        Self {
            clip: ClipBuffer::new(),
            contacts: Contacts {
                points: Bounded::new(config.contact_points_max),
                hull: Vec::with_capacity(config.contact_points_max + 8),
                spare: Vec::with_capacity(config.contact_points_max + 8),
                ground: Bounded::new(config.ground_points_max),
                has_open_edges: false,
                has_face: false,
                has_line: false,
                area_max: 0.0,
                corner_spacing: f64::INFINITY,
                is_tilting: false,
                intrusion: None,
                height_off: None,
            },
            features: Bounded::new(GATHERING_FACTOR * config.features_max),
            planes: Planes {
                nearest: Bounded::new(config.planes_max),
                listed: 0,
                footprints: Bounded::new(config.features_max),
            },
            candidates: Candidates {
                best: Bounded::new(config.candidates_max),
                waiting: BoundedHeap::new(config.candidates_max),
                deferred: Bounded::new(config.candidates_max),
            },
            intersection_points: Bounded::new(config.intersection_points_max),
            ground: Bounded::new(config.ground_points_max),
        }
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        2 * CLIP_VERTICES_MAX * size_of::<DVec3>()
            + self.contacts.points.heap_bytes()
            + (self.contacts.hull.capacity() + self.contacts.spare.capacity()) * size_of::<DVec2>()
            + self.contacts.ground.heap_bytes()
            + self.features.heap_bytes()
            + self.planes.nearest.heap_bytes()
            + self.planes.footprints.heap_bytes()
            + self.candidates.best.heap_bytes()
            + self.candidates.waiting.heap_bytes()
            + self.candidates.deferred.heap_bytes()
            + self.intersection_points.heap_bytes()
            + self.ground.heap_bytes()
    }

    /// Items that were left out because their list was full, since this scratch was made.
    pub fn dropped(&self) -> u64 {
        self.contacts.points.dropped()
            + self.contacts.ground.dropped()
            + self.features.dropped()
            + self.planes.nearest.dropped()
            + self.planes.footprints.dropped()
            + self.candidates.best.dropped()
            + self.candidates.waiting.dropped()
            + self.intersection_points.dropped()
            + self.ground.dropped()
    }
}
