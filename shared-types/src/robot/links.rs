//! Validates links: masses, inertias and collision shapes.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};

use crate::base::input_error::InputError;
use crate::base::text_file::{check_not_negative, check_positive};
use crate::geometry::shape::Shape;
use crate::mesh::store::MeshStore;

use crate::robot::joints::pose_from_origin;
use crate::robot::model::{Link, LinkShape};
use crate::robot::tree::TreeLink;
use crate::robot::urdf::Urdf;

/// How many folders, from the URDF's upward, are searched for a mesh.
const MESH_FOLDERS_MAX: usize = 4;

/// Builds a link without its attachment. `exact` keeps its meshes; otherwise they become convex
/// hulls.
pub(crate) fn build_link(
    urdf: &Urdf,
    index: usize,
    exact: bool,
    meshes: &mut MeshStore,
) -> Result<Link, InputError> {
    let raw = &urdf.robot.links[index];
    let input_error =
        |message: String| urdf.link_locations[index].error(format!("link '{}'", raw.name), message);
    let inertia = inertia_about_com(&raw.inertial).map_err(input_error)?;
    let folder = urdf.source.path.parent().unwrap_or(Path::new(""));
    let shapes = raw
        .collision
        .iter()
        .map(|collision| {
            let shape = shape(&collision.geometry, folder, exact, meshes)?;
            Ok(LinkShape { link_from_shape: pose_from_origin(&collision.origin), shape })
        })
        .collect::<Result<_, String>>()
        .map_err(input_error)?;
    let com = DVec3::from_array(*raw.inertial.origin.xyz);
    Ok(Link {
        name: raw.name.clone(),
        parent: None,
        mass: raw.inertial.mass.value,
        com,
        inertia,
        shapes,
    })
}

/// Refuses a moving link that has no mass, counting what is rigidly fixed to it, or that is
/// a mere point mass. Point masses occur as sensor frames; fixed to a body they do no harm.
pub(crate) fn check_moving_masses(
    urdf: &Urdf,
    tree: &[TreeLink],
    links: &[Link],
) -> Result<(), InputError> {
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
        let input_error = |message: &str| {
            Err(urdf.link_locations[tree[at].urdf_link]
                .error(format!("link '{}'", links[at].name), message))
        };
        if mass[at] <= 0.0 {
            return input_error(
                "moves but has no mass, nor has anything fixed to it; give it an <inertial> or lock its joint",
            );
        }
        if links[at].mass > 0.0 && links[at].inertia == DMat3::ZERO {
            return input_error(
                "moves but its inertia is zero, not positive definite; correct <inertia>",
            );
        }
    }
    Ok(())
}

fn inertia_about_com(inertial: &urdf_rs::Inertial) -> Result<DMat3, String> {
    let mass = inertial.mass.value;
    if mass < 0.0 {
        return Err(format!("its mass is {mass}; it must not be negative"));
    }
    let i = &inertial.inertia;
    let columns = [
        DVec3::new(i.ixx, i.ixy, i.ixz),
        DVec3::new(i.ixy, i.iyy, i.iyz),
        DVec3::new(i.ixz, i.iyz, i.izz),
    ];
    let inertia = DMat3::from_cols(columns[0], columns[1], columns[2]);
    let positive =
        i.ixx > 0.0 && i.ixx * i.iyy - i.ixy * i.ixy > 0.0 && inertia.determinant() > 0.0;
    let point_mass = inertia == DMat3::ZERO;
    if mass > 0.0 && !positive && !point_mass {
        return Err("its inertia is not positive definite; correct <inertia>".into());
    }
    let rotation = DMat3::from_quat(pose_from_origin(&inertial.origin).rotation);
    Ok(rotation * inertia * rotation.transpose())
}

fn shape(
    geometry: &urdf_rs::Geometry,
    folder: &Path,
    exact: bool,
    meshes: &mut MeshStore,
) -> Result<Shape, String> {
    match geometry {
        urdf_rs::Geometry::Box { size } => {
            check_positive("its box size", &**size)?;
            Ok(Shape::Box { half_extents: 0.5 * DVec3::from_array(**size) })
        }
        urdf_rs::Geometry::Sphere { radius } => {
            check_not_negative("its sphere radius", &[*radius])?;
            Ok(Shape::Sphere { radius: *radius })
        }
        urdf_rs::Geometry::Cylinder { radius, length } => {
            check_positive("its cylinder radius and length", &[*radius, *length])?;
            Ok(Shape::Cylinder { radius: *radius, half_length: 0.5 * length })
        }
        urdf_rs::Geometry::Capsule { radius, length } => {
            check_positive("its capsule radius and length", &[*radius, *length])?;
            Ok(Shape::Capsule { radius: *radius, half_length: 0.5 * length })
        }
        urdf_rs::Geometry::Mesh { filename, scale } => {
            let path = resolve_mesh(filename, folder).ok_or_else(|| {
                format!(
                    "mesh '{filename}' not found below {} or the folders above it",
                    folder.display()
                )
            })?;
            let scale = scale.map_or(DVec3::ONE, |scale| DVec3::from_array(*scale));
            if exact { meshes.surface(&path, scale) } else { meshes.hull(&path, scale) }
        }
    }
}

/// Finds a mesh by its URDF name. `package://`, `model://` and `file://` are taken off; what
/// remains is tried as it is and without its first folders, below the URDF's folder and the few
/// above it: packages live at unknown places.
fn resolve_mesh(name: &str, folder: &Path) -> Option<PathBuf> {
    let name = ["package://", "model://", "file://"]
        .iter()
        .find_map(|scheme| name.strip_prefix(scheme))
        .unwrap_or(name);
    let absolute = Path::new(name);
    if absolute.is_absolute() && absolute.is_file() {
        return Some(absolute.to_owned());
    }
    let parts: Vec<&str> = name.split('/').filter(|part| !part.is_empty()).collect();
    folder
        .ancestors()
        .take(MESH_FOLDERS_MAX)
        .flat_map(|base| (0..parts.len()).map(move |skipped| (base, skipped)))
        .map(|(base, skipped)| base.join(parts[skipped..].join("/")))
        .find(|candidate| candidate.is_file())
}
