//! The links of a URDF.

use glam::{DMat3, DQuat, DVec3};
use roxmltree::{Attribute, Node};

use crate::base::spatial::{Pose, rotation_from_rpy};
use crate::base::text_file::FileLocation;
use crate::base::text_file::check_angles;

use crate::robot::element::{Element, own_children};

/// How attributes begin by which other programs state a turn.
const TURNS: [&str; 5] = ["quat", "euler", "rot", "orient", "wxyz"];
/// How far from 1 the length of a `quat_xyzw` may be, which files write with few digits.
const QUATERNION_TOLERANCE: f64 = 1e-2;
/// What rounding does to the moments of inertia in files, as a share of the largest.
const ROUNDING: f64 = 1e-3;
/// No body has a smaller radius of gyration, m: smaller moments of inertia are rounding errors of a
/// program that meant 0.
const GYRATION_MIN: f64 = 1e-6;
/// Two shapes nearer to each other than this are in one place, m.
const SAME_PLACE_MAX: f64 = 1e-6;
/// Links up to this mass may have any inertia, kg.
pub(crate) const LIGHT_MAX: f64 = 0.1;

/// A link as it is written.
pub(crate) struct UrdfLink {
    pub(crate) name: String,
    pub(crate) location: FileLocation,
    /// kg; 0 where the file states none.
    pub(crate) mass: f64,
    /// The frame of its inertia, at its centre of mass.
    pub(crate) link_from_com: Pose,
    /// About the centre of mass, kg m2.
    pub(crate) inertia: DMat3,
    pub(crate) collisions: Vec<Collision>,
    /// The shapes of its looks that can be read.
    pub(crate) visuals: Vec<Collision>,
}

impl UrdfLink {
    /// Whether a body can have this inertia: no principal moment exceeds the sum of the other two
    /// by more than rounding, so that its second moments of mass are not negative.
    pub(crate) fn has_possible_inertia(&self) -> bool {
        let half_trace = 0.5 * moments(&self.inertia).element_sum();
        let second_moments = DMat3::from_diagonal(DVec3::splat(half_trace)) - self.inertia;
        !is_checked(self.mass, &self.inertia)
            || is_positive(&second_moments, rounding(&self.inertia))
    }

    /// The poses of spheres of radius 0 among the collision shapes: the points at which Drake lets
    /// a foot touch the ground. They have no extent, so they are no shapes.
    pub(crate) fn contact_points(&self) -> impl Iterator<Item = &Pose> {
        let points = self.collisions.iter().filter(|part| part.geometry.is_point());
        points.map(|part| &part.link_from_shape)
    }

    /// Whether a shape of the looks is a ball that shows a contact point.
    pub(crate) fn shows_contact_point(&self, part: &Collision) -> bool {
        let at = part.link_from_shape.translation;
        matches!(part.geometry, Geometry::Sphere(_))
            && self.contact_points().any(|point| point.translation.distance(at) < SAME_PLACE_MAX)
    }
}

/// A collision shape as it is written.
pub(crate) struct Collision {
    pub(crate) location: FileLocation,
    pub(crate) link_from_shape: Pose,
    pub(crate) geometry: Geometry,
}

/// The geometry of a shape, full lengths in m.
pub(crate) enum Geometry {
    Box([f64; 3]),
    Sphere(f64),
    Cylinder { radius: f64, length: f64 },
    Capsule { radius: f64, length: f64 },
    Mesh { filename: String, scale: Option<DVec3> },
}

impl Geometry {
    pub(crate) fn is_point(&self) -> bool {
        matches!(self, Self::Sphere(radius) if *radius == 0.0)
    }
}

/// Reads the link that `element` stands for.
pub(crate) fn read_link(element: &mut Element) -> UrdfLink {
    let node = element.node;
    element.check_children(node, &["inertial", "collision", "visual"]);
    let mut link = UrdfLink {
        name: node.attribute("name").unwrap_or_default().to_owned(),
        location: element.source.location(node.range().start),
        mass: 0.0,
        link_from_com: Pose::IDENTITY,
        inertia: DMat3::ZERO,
        collisions: Vec::new(),
        visuals: Vec::new(),
    };
    if let Some(inertial) = element.child(node, "inertial") {
        read_inertial(element, inertial, &mut link);
    }
    for collision in own_children(node).filter(|child| child.tag_name().name() == "collision") {
        link.collisions.extend(read_collision(element, collision));
    }
    link.visuals = read_visuals(element);
    link
}

/// The shapes of a link's looks. Looks are no input unless a robot file takes them as shapes, so
/// that one that cannot be read is passed over.
fn read_visuals(element: &Element) -> Vec<Collision> {
    let mut ignored = Vec::new();
    let Element { source, node, .. } = *element;
    let mut quiet = Element { source, node, complaints: &mut ignored };
    let visuals = own_children(node).filter(|child| child.tag_name().name() == "visual");
    visuals.filter_map(|visual| read_collision(&mut quiet, visual)).collect()
}

/// The pose that an `<origin>` in `of` states.
pub(crate) fn read_origin<'a, 'input>(
    element: &mut Element<'a, 'input>,
    of: Node<'a, 'input>,
) -> Pose {
    let Some(origin) = element.child(of, "origin") else { return Pose::IDENTITY };
    element.check_attributes(origin, &["xyz", "rpy", "quat_xyzw"]);
    check_turn(element, origin);
    let xyz = element.numbers(origin, "xyz").unwrap_or([0.0; 3]);
    let rpy: Option<[f64; 3]> = element.numbers(origin, "rpy");
    if let Some(message) = rpy.and_then(|rpy| check_angles("rpy", &rpy).err()) {
        element.input_error(origin, format!("<origin> {message}"));
    }
    let rotation = match (element.numbers(origin, "quat_xyzw"), rpy) {
        (Some(_), Some(_)) => {
            element.input_error(origin, "<origin> has both rpy and quat_xyzw; keep one");
            DQuat::IDENTITY
        }
        (None, rpy) => {
            let [roll, pitch, yaw] = rpy.unwrap_or([0.0; 3]);
            rotation_from_rpy(roll, pitch, yaw)
        }
        (Some(quaternion), None) => {
            let length = DQuat::from_array(quaternion).length();
            if (length - 1.0).abs() > QUATERNION_TOLERANCE {
                let message = format!("<origin quat_xyzw> has length {length}; it must be 1");
                element.input_error(origin, message);
                return Pose::IDENTITY;
            }
            DQuat::from_array(quaternion).normalize()
        }
    };
    Pose::from_parts(DVec3::from_array(xyz), rotation)
}

/// Refuses a turn by another name: in its place none would be taken.
fn check_turn<'a, 'input>(element: &mut Element<'a, 'input>, origin: Node<'a, 'input>) {
    let is_turn = |name: &str| {
        let name = name.to_ascii_lowercase();
        TURNS.iter().any(|turn| name.starts_with(turn)) && name != "quat_xyzw"
    };
    let own = |attribute: &Attribute| attribute.namespace().is_none();
    if let Some(other) = origin.attributes().filter(own).find(|it| is_turn(it.name())) {
        let message = format!("<origin {}=...> is unknown; write rpy or quat_xyzw", other.name());
        element.input_error(origin, message);
    }
}

fn read_inertial<'a, 'input>(
    element: &mut Element<'a, 'input>,
    inertial: Node<'a, 'input>,
    link: &mut UrdfLink,
) {
    element.check_children(inertial, &["origin", "mass", "inertia"]);
    link.link_from_com = read_origin(element, inertial);
    // What cannot be read is no reason for further complaints.
    (link.mass, link.inertia) = (1.0, DMat3::IDENTITY);
    match element.child(inertial, "mass") {
        None => element.input_error(inertial, "its <inertial> has no <mass>; state it"),
        Some(mass) => {
            element.check_attributes(mass, &["value"]);
            if let Some([value]) = element.required(mass, "value") {
                if value < 0.0 {
                    element
                        .input_error(mass, format!("its mass is {value}; it must not be negative"));
                } else {
                    link.mass = value;
                }
            }
        }
    }
    let Some(inertia) = element.child(inertial, "inertia") else {
        element.input_error(inertial, "its <inertial> has no <inertia>; state it");
        return;
    };
    const MOMENTS: [&str; 6] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"];
    check_inertia_attributes(element, inertia, MOMENTS);
    let moments = MOMENTS.map(|moment| element.required::<1>(inertia, moment).map(|[it]| it));
    if let [Some(ixx), Some(ixy), Some(ixz), Some(iyy), Some(iyz), Some(izz)] = moments {
        link.inertia = DMat3::from_cols(
            DVec3::new(ixx, ixy, ixz),
            DVec3::new(ixy, iyy, iyz),
            DVec3::new(ixz, iyz, izz),
        );
        let moment_min = link.mass * GYRATION_MIN * GYRATION_MIN;
        if link.inertia.to_cols_array().iter().all(|moment| moment.abs() < moment_min) {
            link.inertia = DMat3::ZERO;
        }
        if let Err(message) = check_inertia(link.mass, &link.inertia) {
            element.input_error(inertia, message);
        }
    }
}

/// Complains of attributes that are no moments. Those below the diagonal are allowed where they
/// repeat the ones above.
fn check_inertia_attributes<'a, 'input>(
    element: &mut Element<'a, 'input>,
    inertia: Node<'a, 'input>,
    moments: [&str; 6],
) {
    const MIRRORED: [[&str; 2]; 3] = [["iyx", "ixy"], ["izx", "ixz"], ["izy", "iyz"]];
    let known: Vec<&str> = moments.into_iter().chain(MIRRORED.map(|[below, _]| below)).collect();
    element.check_attributes(inertia, &known);
    for [below, above] in MIRRORED {
        let value = |name: &str| inertia.attribute(name).map(|it| it.trim().parse::<f64>().ok());
        if value(below).is_some_and(|it| it.is_none() || Some(it) != value(above)) {
            let message = format!("{below} of its <inertia> differs from {above}");
            element.input_error(inertia, message);
        }
    }
}

fn read_collision<'a, 'input>(
    element: &mut Element<'a, 'input>,
    collision: Node<'a, 'input>,
) -> Option<Collision> {
    element.check_children(collision, &["origin", "geometry"]);
    let link_from_shape = read_origin(element, collision);
    let Some(geometry) = element.child(collision, "geometry") else {
        element.input_error(collision, "its <collision> has no <geometry>; state one or remove it");
        return None;
    };
    let shapes: Vec<Node> = own_children(geometry).collect();
    let [shape] = shapes[..] else {
        let message = format!("its <geometry> holds {} shapes; one belongs there", shapes.len());
        element.input_error(geometry, message);
        return None;
    };
    let location = element.source.location(shape.range().start);
    Some(Collision { location, link_from_shape, geometry: read_geometry(element, shape)? })
}

fn read_geometry<'a, 'input>(
    element: &mut Element<'a, 'input>,
    shape: Node<'a, 'input>,
) -> Option<Geometry> {
    let known: &[&str] = match shape.tag_name().name() {
        "box" => &["size"],
        "sphere" => &["radius"],
        "cylinder" | "capsule" => &["radius", "length"],
        "mesh" => &["filename", "scale"],
        tag => {
            let message = format!(
                "has the geometry <{tag}>; only box, sphere, cylinder, capsule and mesh are read"
            );
            element.input_error(shape, message);
            return None;
        }
    };
    element.check_attributes(shape, known);
    let tag = shape.tag_name().name();
    if tag == "box" {
        return element.required(shape, "size").map(Geometry::Box);
    }
    if tag == "mesh" {
        let filename = shape.attribute("filename").unwrap_or_default().trim();
        if filename.is_empty() {
            element.input_error(shape, "its <mesh> has no filename");
            return None;
        }
        let scale = element.numbers(shape, "scale").map(DVec3::from_array);
        return Some(Geometry::Mesh { filename: filename.to_owned(), scale });
    }
    let [radius] = element.required(shape, "radius")?;
    if tag == "sphere" {
        return Some(Geometry::Sphere(radius));
    }
    let [length] = element.required(shape, "length")?;
    Some(if tag == "cylinder" {
        Geometry::Cylinder { radius, length }
    } else {
        Geometry::Capsule { radius, length }
    })
}

/// Refuses an inertia that no body has. One that is singular by rounding, or of a light
/// body, is taken: a quasi-static motion does not depend on it.
fn check_inertia(mass: f64, inertia: &DMat3) -> Result<(), String> {
    if is_checked(mass, inertia) && !is_positive(inertia, rounding(inertia)) {
        return Err("its inertia is not positive definite; correct <inertia>".into());
    }
    Ok(())
}

fn is_checked(mass: f64, inertia: &DMat3) -> bool {
    mass > LIGHT_MAX && *inertia != DMat3::ZERO
}

/// The moments along the axes.
fn moments(inertia: &DMat3) -> DVec3 {
    DVec3::new(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z)
}

/// What rounding does to an inertia.
fn rounding(inertia: &DMat3) -> f64 {
    ROUNDING * moments(inertia).abs().max_element()
}

/// Whether a symmetric matrix is positive definite with `rounding` added to its diagonal.
fn is_positive(matrix: &DMat3, rounding: f64) -> bool {
    let rounded = *matrix + DMat3::from_diagonal(DVec3::splat(rounding));
    let minor = rounded.x_axis.x * rounded.y_axis.y - rounded.x_axis.y * rounded.x_axis.y;
    rounded.x_axis.x > 0.0 && minor > 0.0 && rounded.determinant() > 0.0
}
