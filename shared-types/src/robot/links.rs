//! Validates links: masses, inertias and collision shapes.

use glam::{DMat3, DVec3};

use crate::base::input_error::InputError;
use crate::base::text_file::{check_not_negative, check_positive};
use crate::geometry::shape::Shape;
use crate::mesh::store::MeshStore;
use crate::plan_format::blocks::UrdfAdditions;

use crate::robot::mesh_path::{MeshError, find_mesh};
use crate::robot::model::{Link, LinkShape};
use crate::robot::tree::TreeLink;
use crate::robot::urdf::Urdf;
use crate::robot::urdf_link::{Collision, Geometry, LIGHT_MAX};

/// Which shapes a link gets.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ShapeChoice {
    /// Its meshes stay meshes; otherwise they become convex hulls.
    pub(crate) exact: bool,
    /// The shapes of its looks, instead of its collision shapes.
    pub(crate) visual: bool,
    /// Meshes whose files are not found are left out.
    pub(crate) may_lack_meshes: bool,
}

impl ShapeChoice {
    /// What a robot file says of a link.
    pub(crate) fn of(additions: &UrdfAdditions, link: &str, exact: bool) -> Self {
        Self {
            exact,
            visual: additions.is_visual(link),
            may_lack_meshes: additions.may_lack_meshes(link),
        }
    }
}

/// Builds a link without its attachment. Shapes that cannot be read are left out, and join
/// `complaints`.
pub(crate) fn build_link(
    urdf: &Urdf,
    index: usize,
    choice: ShapeChoice,
    meshes: &mut MeshStore,
    complaints: &mut Vec<InputError>,
) -> Link {
    let raw = &urdf.links[index];
    let stated = if choice.visual { &raw.visuals } else { &raw.collisions };
    let mut shapes = Vec::with_capacity(stated.len());
    let is_left_out = |part: &Collision| {
        if choice.visual { raw.shows_contact_point(part) } else { part.geometry.is_point() }
    };
    for collision in stated.iter().filter(|part| !is_left_out(part)) {
        match shape(&collision.geometry, urdf, choice, meshes) {
            Ok(shape) => shapes.extend(
                shape.map(|shape| LinkShape { link_from_shape: collision.link_from_shape, shape }),
            ),
            Err(message) => {
                complaints.push(collision.location.error(format!("link '{}'", raw.name), message));
            }
        }
    }
    let rotation = DMat3::from_quat(raw.link_from_com.rotation);
    Link {
        name: raw.name.clone(),
        parent: None,
        mass: raw.mass,
        com: raw.link_from_com.translation,
        inertia: rotation * raw.inertia * rotation.transpose(),
        shapes,
    }
}

/// Refuses moving links that have no mass, counting the links rigidly fixed to them, and
/// those that are mere point masses. Point masses occur as sensor frames; fixed to a body, or
/// light, they do no harm.
pub(crate) fn check_moving_masses(
    urdf: &Urdf,
    tree: &[TreeLink],
    links: &[Link],
    complaints: &mut Vec<InputError>,
) {
    let mut mass: Vec<f64> = links.iter().map(|link| link.mass).collect();
    for at in (1..links.len()).rev() {
        if let Some(attachment) =
            links[at].parent.as_ref().filter(|attachment| attachment.joint.is_none())
        {
            mass[attachment.parent] += mass[at];
        }
    }
    let moves =
        |at: usize| links[at].parent.as_ref().is_some_and(|attachment| attachment.joint.is_some());
    for at in (0..links.len()).filter(|at| moves(*at)) {
        let mut input_error = |message: &str| {
            let location = &urdf.links[tree[at].urdf_link].location;
            complaints.push(location.error(format!("link '{}'", links[at].name), message));
        };
        if mass[at] <= 0.0 {
            input_error(
                "moves but has no mass, nor has anything fixed to it; give it an <inertial> or lock its joint",
            );
        } else if links[at].mass > LIGHT_MAX && links[at].inertia == DMat3::ZERO {
            input_error("moves but its inertia is zero, not positive definite; correct <inertia>");
        }
    }
}

/// The shape of a geometry; `None` for a mesh file without triangles, or one that may be missing.
fn shape(
    geometry: &Geometry,
    urdf: &Urdf,
    choice: ShapeChoice,
    meshes: &mut MeshStore,
) -> Result<Option<Shape>, String> {
    Ok(Some(match geometry {
        Geometry::Box(size) => {
            check_positive("its box size", size)?;
            Shape::Box { half_extents: 0.5 * DVec3::from_array(*size) }
        }
        Geometry::Sphere(radius) => {
            check_not_negative("its sphere radius", &[*radius])?;
            Shape::Sphere { radius: *radius }
        }
        Geometry::Cylinder { radius, length } => {
            check_positive("its cylinder radius and length", &[*radius, *length])?;
            Shape::Cylinder { radius: *radius, half_length: 0.5 * length }
        }
        Geometry::Capsule { radius, length } => {
            check_positive("its capsule radius and length", &[*radius, *length])?;
            Shape::Capsule { radius: *radius, half_length: 0.5 * length }
        }
        Geometry::Mesh { filename, scale } => {
            let path = match find_mesh(urdf, filename) {
                Ok(path) => path,
                Err(MeshError::Missing(_)) if choice.may_lack_meshes => return Ok(None),
                Err(MeshError::Missing(message) | MeshError::Macro(message)) => {
                    return Err(message);
                }
            };
            if !meshes.has_triangles(&path)? {
                return Ok(None);
            }
            let scale = scale.unwrap_or(DVec3::ONE);
            if choice.exact { meshes.surface(&path, scale)? } else { meshes.hull(&path, scale)? }
        }
    }))
}
