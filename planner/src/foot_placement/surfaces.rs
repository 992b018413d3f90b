//! The compiled world: flat faces and curved surfaces, with a bounding volume hierarchy over both.

use glam::{DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use surefoot_shared_types::world::world::World;

use crate::foot_placement::config::{FootPlacementConfig, LeastSupport, SoleNeeds};
use crate::foot_placement::elements::{CurvedSurface, Element, Face};
use crate::foot_placement::sole_support::SurfacesError;
use crate::foot_placement::world_elements;
use crate::geometry::bvh;
use crate::geometry::polygon::closest_on_segment;

/// All surfaces that a sole can rest on or collide with, compiled once from a world.
#[derive(Debug, Clone)]
pub struct Surfaces {
    pub(crate) config: FootPlacementConfig,
    faces: Vec<Face>,
    vertices: Vec<DVec3>,
    curved_surfaces: Vec<CurvedSurface>,
    bvh: Bvh,
    /// The cosine of the steepest tilt of a supporting surface: inside the friction cone.
    pub(crate) steepest_cos: f64,
    /// The cosine of the largest angle between the normals of a sole and of a surface that supports
    /// it.
    pub(crate) carrying_cos: f64,
    /// The cosine of the largest angle between the normals of features of one plane.
    pub(crate) coplanar_cos: f64,
    /// What the soles need, once it is known.
    pub(crate) needs: Option<SoleNeeds>,
    /// For each element the sine of the greatest tilt of a sole that touches it, `None` if none
    /// can; empty until that is known.
    pub(crate) bearing: Vec<Option<f64>>,
}

impl Surfaces {
    /// Compiles a world. Allocates; queries do not.
    ///
    /// # Errors
    /// A parameter out of range, or a shape without volume (named).
    pub fn new(world: &World, config: FootPlacementConfig) -> Result<Self, SurfacesError> {
        config.validate()?;
        let elements = world_elements::elements_of(world)?;
        let steepest = (libm::atan(world.mu) - config.friction_margin).max(0.0);
        let [carrying_cos, coplanar_cos] =
            [config.normal_tilt_max, config.plane_tilt_max].map(libm::cos);
        let mut surfaces = Self {
            config,
            faces: elements.faces,
            vertices: elements.vertices,
            curved_surfaces: elements.curved_surfaces,
            bvh: Bvh::new(),
            steepest_cos: libm::cos(steepest) - 1e-12,
            carrying_cos,
            coplanar_cos,
            needs: None,
            bearing: Vec::new(),
        };
        let boxes: Vec<Aabb> =
            (0..surfaces.element_count()).map(|id| surfaces.element_box(id)).collect();
        surfaces.bvh = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Ok(surfaces)
    }

    /// Lowers what a support needs.
    pub(crate) fn relax(&mut self, least: LeastSupport) {
        self.config.relax(least);
    }

    /// The parameters of the compilation.
    pub fn config(&self) -> &FootPlacementConfig {
        &self.config
    }

    /// The number of faces and curved surfaces.
    pub fn element_count(&self) -> u32 {
        (self.faces.len() + self.curved_surfaces.len()) as u32
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        size_of_val(self.faces.as_slice())
            + size_of_val(self.vertices.as_slice())
            + size_of_val(self.curved_surfaces.as_slice())
            + self.bvh.heap_memory_size()
            + size_of_val(self.bearing.as_slice())
    }

    /// The element with this number.
    pub(crate) fn element(&self, id: u32) -> Element<'_> {
        match self.faces.get(id as usize) {
            Some(face) => Element::Face(face, self.face_vertices(face)),
            None => Element::Curved(&self.curved_surfaces[id as usize - self.faces.len()]),
        }
    }

    /// The numbers of the elements whose boxes overlap a box in the world, in a fixed order.
    pub(crate) fn elements_in<'a>(&'a self, region: &'a Aabb) -> impl Iterator<Item = u32> + 'a {
        self.bvh.intersect_aabb(region)
    }

    /// Whether a surface with this normal may support a sole.
    pub(crate) fn is_flat_enough(&self, normal: DVec3) -> bool {
        normal.z >= self.steepest_cos
    }

    /// Whether some part of the element may support a sole.
    pub(crate) fn may_carry(&self, id: u32) -> bool {
        match self.element(id) {
            Element::Face(face, _) => self.is_flat_enough(face.normal),
            Element::Curved(curved) => {
                curved.side_normal(DVec3::Z).is_some_and(|n| self.is_flat_enough(n))
            }
        }
    }

    /// Whether a sole may touch an element in some placement. Without `find_bearing` it
    /// may touch all that is flat enough.
    pub(crate) fn may_bear(&self, id: u32) -> bool {
        self.bearing.get(id as usize).map_or_else(|| self.may_carry(id), Option::is_some)
    }

    /// The horizontal distance from a point to the outline of an element seen from above, and the
    /// height of the element there, m.
    pub(crate) fn distance_and_height(&self, id: u32, from: DVec2) -> (f64, f64) {
        let near = self.nearest_point(id, from);
        ((near.truncate() - from).length(), near.z)
    }

    /// The point of an element, seen from above, that is nearest to `from`.
    pub(crate) fn nearest_point(&self, id: u32, from: DVec2) -> DVec3 {
        match self.element(id) {
            Element::Face(face, vertices) => {
                let near = nearest_on_outline(vertices, from);
                near.extend(face.height_at(near))
            }
            Element::Curved(curved) => curved.top_at(curved.nearest_on_axis(from)),
        }
    }

    /// Calls `examine` with the elements whose boxes overlap a box in the world, in a fixed order.
    pub(crate) fn for_each_in(&self, region: &bvh::Aabb, mut examine: impl FnMut(u32)) {
        let region = Aabb::new(region.min, region.max);
        self.elements_in(&region).for_each(&mut examine);
    }

    /// The bounding box of an element.
    pub(crate) fn bounds(&self, id: u32) -> bvh::Aabb {
        let around = self.element_box(id);
        bvh::Aabb { min: around.mins, max: around.maxs }
    }

    /// The radius of a curved surface, 0 for a face, m.
    pub(crate) fn radius(&self, id: u32) -> f64 {
        match self.element(id) {
            Element::Face(..) => 0.0,
            Element::Curved(curved) => curved.radius,
        }
    }

    /// The vertical component of the outward normal where an element faces up most.
    pub(crate) fn normal_z(&self, id: u32) -> f64 {
        match self.element(id) {
            Element::Face(face, _) => face.normal.z,
            Element::Curved(curved) => curved.side_normal(DVec3::Z).map_or(0.0, |n| n.z),
        }
    }

    /// The greatest slope of ground that may support a sole.
    pub(crate) fn steepest_tan(&self) -> f64 {
        libm::sqrt((1.0 - self.steepest_cos * self.steepest_cos).max(0.0)) / self.steepest_cos
    }

    fn face_vertices(&self, face: &Face) -> &[DVec3] {
        &self.vertices[face.first as usize..(face.first + face.count) as usize]
    }

    fn element_box(&self, id: u32) -> Aabb {
        match self.element(id) {
            Element::Face(_, vertices) => Aabb::from_points_ref(vertices),
            Element::Curved(curved) => {
                let reach = DVec3::splat(curved.radius);
                Aabb::new(curved.a.min(curved.b) - reach, curved.a.max(curved.b) + reach)
            }
        }
    }
}

/// The point of an upward face nearest to `from`, seen from above.
fn nearest_on_outline(vertices: &[DVec3], from: DVec2) -> DVec2 {
    let sides = || {
        (0..vertices.len())
            .map(|i| (vertices[i].truncate(), vertices[(i + 1) % vertices.len()].truncate()))
    };
    if sides().all(|(a, b)| (b - a).perp_dot(from - a) >= 0.0) {
        return from;
    }
    let near = sides().map(|(a, b)| closest_on_segment(a, b, from));
    near.min_by(|p, q| p.distance_squared(from).total_cmp(&q.distance_squared(from)))
        .unwrap_or(from)
}
