//! The first intersection of a ray with a shape, in closed form; with a mesh by parry.

use glam::{DVec2, DVec3};
use parry3d_f64::query::{Ray, RayCast};
use surefoot_shared_types::{Pose, Shape};

use crate::geometry::bounds::Bounds;
use crate::geometry::hull::Hull;
use crate::geometry::mesh_solid::MeshSolid;
use crate::geometry::separation::face_normal;
use crate::geometry::solid::{Convex, Core, Solid};

/// The first intersection of a ray with a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hit {
    /// No intersection.
    Miss,
    /// The ray begins inside the solid.
    Inside,
    /// The surface.
    Surface {
        /// Distance along the unit direction, m.
        distance: f64,
        /// The outward unit normal there, in the world.
        normal: DVec3,
    },
}

/// A world shape, ready for rays.
#[derive(Debug, Clone)]
pub struct Target {
    world_from_shape: Pose,
    form: Form,
    /// The box around it, in the world.
    pub bounds: Bounds,
}

#[derive(Debug, Clone)]
enum Form {
    /// An intersection of half spaces, each an outward unit normal and its offset.
    HalfSpaces(Vec<(DVec3, f64)>),
    /// A capsule, or a sphere if the half length is 0.
    Capsule {
        radius: f64,
        half_length: f64,
    },
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    Mesh(Box<MeshSolid>),
}

impl Target {
    /// Whether its surface is curved.
    pub fn is_round(&self) -> bool {
        matches!(self.form, Form::Capsule { .. } | Form::Cylinder { .. })
    }

    /// The ray form of a shape.
    ///
    /// # Errors
    /// The hull or mesh is degenerate.
    pub fn new(shape: &Shape, world_from_shape: &Pose) -> Result<Self, String> {
        let solid = Solid::new(shape)?;
        let bounds = solid.local_bounds().transformed(world_from_shape);
        let form = match solid {
            Solid::Mesh(mesh) => Form::Mesh(mesh),
            Solid::Convex(Convex { core, radius }) => match core {
                Core::Box(half) => Form::HalfSpaces(box_faces(half)),
                Core::Segment(half_length) => Form::Capsule { radius, half_length },
                Core::Cylinder { radius, half_length } => Form::Cylinder { radius, half_length },
                Core::Hull(hull) => Form::HalfSpaces(hull_faces(&hull)),
                Core::Triangle(_) => return Err("a triangle has no inside".to_owned()),
            },
        };
        Ok(Self { world_from_shape: *world_from_shape, form, bounds })
    }

    /// The first intersection of a ray from `origin` along the unit `direction` (both in the
    /// world).
    pub fn cast(&self, origin: DVec3, direction: DVec3) -> Hit {
        let inverse = self.world_from_shape.inverse();
        let (origin, direction) = (inverse * origin, inverse.rotation * direction);
        let hit = match &self.form {
            Form::HalfSpaces(faces) => cast_half_spaces(faces, origin, direction),
            Form::Capsule { radius, half_length } => {
                cast_capsule(*radius, *half_length, origin, direction)
            }
            Form::Cylinder { radius, half_length } => {
                cast_cylinder(*radius, *half_length, origin, direction)
            }
            Form::Mesh(mesh) => cast_mesh(mesh, origin, direction),
        };
        match hit {
            Hit::Surface { distance, normal } => {
                Hit::Surface { distance, normal: self.world_from_shape.rotation * normal }
            }
            other => other,
        }
    }
}

fn box_faces(half: DVec3) -> Vec<(DVec3, f64)> {
    DVec3::AXES
        .into_iter()
        .flat_map(|axis| [(axis, half.dot(axis)), (-axis, half.dot(axis))])
        .collect()
}

/// The supporting planes of a hull's faces; each is pushed out until no point lies beyond it.
fn hull_faces(hull: &Hull) -> Vec<(DVec3, f64)> {
    let pushed = |(normal, _): &(DVec3, f64)| (*normal, hull.support(*normal).dot(*normal));
    hull.planes().iter().map(pushed).collect()
}

fn cast_half_spaces(faces: &[(DVec3, f64)], origin: DVec3, direction: DVec3) -> Hit {
    clip(faces, origin, direction, (f64::NEG_INFINITY, f64::INFINITY), DVec3::ZERO)
}

/// The part of a ray between two distances that lies inside all half spaces; `normal` is the
/// normal at its beginning.
fn clip(
    faces: &[(DVec3, f64)],
    origin: DVec3,
    direction: DVec3,
    (mut enter, mut leave): (f64, f64),
    mut normal: DVec3,
) -> Hit {
    for &(outward, offset) in faces {
        let (above, speed) = (outward.dot(origin) - offset, outward.dot(direction));
        if speed.abs() < 1e-15 {
            if above > 0.0 {
                return Hit::Miss;
            }
        } else if speed < 0.0 {
            if -above / speed > enter {
                (enter, normal) = (-above / speed, outward);
            }
        } else {
            leave = leave.min(-above / speed);
        }
    }
    first_hit(enter, leave, normal)
}

fn first_hit(enter: f64, leave: f64, normal: DVec3) -> Hit {
    if enter > leave || leave < 0.0 {
        Hit::Miss
    } else if enter < 0.0 {
        Hit::Inside
    } else {
        Hit::Surface { distance: enter, normal }
    }
}

/// The interval of a ray inside a sphere, or nothing.
fn sphere_interval(
    centre: DVec3,
    radius: f64,
    origin: DVec3,
    direction: DVec3,
) -> Option<(f64, f64)> {
    let offset = origin - centre;
    let middle = -offset.dot(direction);
    let nearest = (offset + middle * direction).length_squared();
    let half = radius * radius - nearest;
    (half >= 0.0).then(|| (middle - half.sqrt(), middle + half.sqrt()))
}

/// The interval of a ray inside an infinite cylinder about z, or nothing.
fn cylinder_interval(radius: f64, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
    let (o, d) = (origin.truncate(), direction.truncate());
    if d.length_squared() < 1e-24 {
        return (o.length_squared() <= radius * radius)
            .then_some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let middle = -o.dot(d) / d.length_squared();
    let half = (radius * radius - (o + middle * d).length_squared()) / d.length_squared();
    (half >= 0.0).then(|| (middle - half.sqrt(), middle + half.sqrt()))
}

fn cast_cylinder(radius: f64, half_length: f64, origin: DVec3, direction: DVec3) -> Hit {
    let Some(wall) = cylinder_interval(radius, origin, direction) else { return Hit::Miss };
    let caps = [(DVec3::Z, half_length), (-DVec3::Z, half_length)];
    let normal = if wall.0.is_finite() {
        radial_normal((origin + wall.0 * direction).truncate())
    } else {
        DVec3::ZERO
    };
    clip(&caps, origin, direction, wall, normal)
}

fn radial_normal(across: DVec2) -> DVec3 {
    across.normalize_or_zero().extend(0.0)
}

/// A capsule is the union of two spheres and a cylinder: the ray is inside it from its first entry
/// to its last exit.
fn cast_capsule(radius: f64, half_length: f64, origin: DVec3, direction: DVec3) -> Hit {
    let ends = [half_length, -half_length]
        .map(|z| sphere_interval(DVec3::new(0.0, 0.0, z), radius, origin, direction));
    let side = cylinder_interval(radius, origin, direction)
        .and_then(|(a, b)| clip_height(half_length, origin.z, direction.z, (a, b)));
    let pieces = ends.into_iter().chain([side]).flatten();
    let (enter, leave) =
        pieces.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)));
    let point = origin + enter * direction;
    let axis_point = DVec3::new(0.0, 0.0, point.z.clamp(-half_length, half_length));
    first_hit(enter, leave, (point - axis_point).normalize_or_zero())
}

fn clip_height(
    half_length: f64,
    origin: f64,
    speed: f64,
    (enter, leave): (f64, f64),
) -> Option<(f64, f64)> {
    if speed.abs() < 1e-15 {
        return (origin.abs() <= half_length).then_some((enter, leave));
    }
    let (a, b) = ((-half_length - origin) / speed, (half_length - origin) / speed);
    let clipped = (enter.max(a.min(b)), leave.min(a.max(b)));
    (clipped.0 <= clipped.1).then_some(clipped)
}

/// The back of a closed mesh means that the ray begins inside; that of an open one is no surface.
fn cast_mesh(mesh: &MeshSolid, origin: DVec3, direction: DVec3) -> Hit {
    let ray = Ray::new(origin, direction);
    let Some(hit) = mesh.surface.cast_local_ray_and_get_normal(&ray, f64::MAX, false) else {
        return Hit::Miss;
    };
    let normal = face_normal(&mesh.surface, hit.subshape);
    if normal.dot(direction) > 0.0 {
        if mesh.is_closed { Hit::Inside } else { Hit::Miss }
    } else {
        Hit::Surface { distance: hit.time_of_impact, normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::randoms;

    fn cast(shape: &Shape, origin: [f64; 3], direction: [f64; 3]) -> Hit {
        let target =
            Target::new(shape, &Pose::from_translation(DVec3::new(1.0, 2.0, 3.0))).unwrap();
        target.cast(
            DVec3::from(origin) + DVec3::new(1.0, 2.0, 3.0),
            DVec3::from(direction).normalize(),
        )
    }

    fn assert_surface(hit: Hit, expected: f64, outward: [f64; 3]) {
        let Hit::Surface { distance, normal } = hit else { panic!("{hit:?}") };
        assert!(
            (distance - expected).abs() < 1e-12 && (normal - DVec3::from(outward)).length() < 1e-12,
            "{hit:?}"
        );
    }

    #[test]
    fn box_and_hull_agree() {
        let half = DVec3::new(1.0, 0.5, 0.25);
        let corner = |i: u8| {
            half * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 2.0
                - half
        };
        let solids = [
            Shape::Box { half_extents: half },
            Shape::ConvexHull { points: (0..8).map(corner).collect(), source: None },
        ];
        for solid in &solids {
            assert_surface(cast(solid, [0.9, 0.1, 1.0], [0., 0., -1.]), 0.75, [0., 0., 1.]);
            assert_eq!(cast(solid, [1.1, 0.1, 1.0], [0., 0., -1.]), Hit::Miss);
            assert_eq!(cast(solid, [0.0, 0.0, 1.0], [0., 0., 1.]), Hit::Miss);
            assert_eq!(cast(solid, [0.9, 0.1, 0.2], [0., 0., -1.]), Hit::Inside);
        }
    }

    #[test]
    fn a_lying_cylinder_and_capsule_are_round() {
        let cylinder = Shape::Cylinder { radius: 0.5, half_length: 1.0 };
        let capsule = Shape::Capsule { radius: 0.5, half_length: 1.0 };
        for shape in [&cylinder, &capsule] {
            assert_surface(cast(shape, [2.0, 0.3, 0.7], [-1., 0., 0.]), 1.6, [0.8, 0.6, 0.]);
            assert_eq!(cast(shape, [0.1, 0.3, 0.7], [-1., 0., 0.]), Hit::Inside);
            assert_eq!(cast(shape, [2.0, 0.51, 0.7], [-1., 0., 0.]), Hit::Miss);
        }
        assert_surface(cast(&cylinder, [0.3, 0.0, 2.0], [0., 0., -1.]), 1.0, [0., 0., 1.]);
        assert_surface(cast(&capsule, [0.3, 0.0, 2.0], [0., 0., -1.]), 0.6, [0.6, 0., 0.8]);
        assert_eq!(cast(&cylinder, [2.0, 0.0, 1.2], [-1., 0., 0.]), Hit::Miss);
    }

    /// How deep a point (in the shape's frame) is inside a shape; negative outside.
    fn depth(shape: &Shape, at: DVec3) -> f64 {
        match shape {
            Shape::Box { half_extents } => (*half_extents - at.abs()).min_element(),
            Shape::Capsule { radius, half_length } => {
                let nearest = at.z.clamp(-half_length, *half_length);
                radius - at.distance(DVec3::new(0.0, 0.0, nearest))
            }
            Shape::Cylinder { radius, half_length } => {
                (radius - at.truncate().length()).min(half_length - at.z.abs())
            }
            Shape::Sphere { radius } => radius - at.length(),
            Shape::ConvexHull { .. } | Shape::Mesh { .. } => unreachable!(),
        }
    }

    #[test]
    fn a_ray_meets_a_solid_where_it_first_gets_inside() {
        let mut random = randoms(17);
        let (mut hits, mut misses, mut insides) = (0, 0, 0);
        let shapes = [
            Shape::Box { half_extents: DVec3::new(0.3, 0.2, 0.1) },
            Shape::Capsule { radius: 0.1, half_length: 0.25 },
            Shape::Cylinder { radius: 0.15, half_length: 0.2 },
            Shape::Sphere { radius: 0.25 },
        ];
        for (index, shape) in (0..1600).map(|index| (index, &shapes[index % 4])) {
            let mut vector = |size: f64| {
                DVec3::new(random(-size, size), random(-size, size), random(-size, size))
            };
            let world_from_shape =
                Pose::from_parts(vector(1.0), glam::DQuat::from_scaled_axis(vector(2.0)));
            let origin = world_from_shape * vector(0.6);
            let towards = world_from_shape * vector(0.2);
            // Some rays go along an axis of the shape.
            let axis = world_from_shape.rotation * DVec3::AXES[index % 3];
            let straight = if index % 2 == 0 { axis } else { -axis };
            let direction = if index % 5 == 0 { straight } else { (towards - origin).normalize() };
            let inside = |distance: f64| {
                let at = origin + distance * direction;
                depth(shape, world_from_shape.inverse() * at)
            };
            let first = (0..3000).map(|step| 1e-3 * f64::from(step)).find(|at| inside(*at) > 0.0);
            match (Target::new(shape, &world_from_shape).unwrap().cast(origin, direction), first) {
                (Hit::Inside, Some(first)) => {
                    assert!(first < 2e-3);
                    insides += 1;
                }
                (Hit::Surface { distance, normal }, Some(first)) => {
                    assert!((distance - first).abs() < 2e-3, "{shape:?} {distance} {first}");
                    // The normal leads out as quickly as any way.
                    assert!((normal.length() - 1.0).abs() < 1e-9 && normal.dot(direction) <= 0.0);
                    let out = origin + distance * direction + 1e-5 * normal;
                    let off = depth(shape, world_from_shape.inverse() * out);
                    assert!((off + 1e-5).abs() < 1e-7, "{shape:?} {off}");
                    hits += 1;
                }
                (Hit::Miss, None) => misses += 1,
                // A ray may graze a corner between two steps.
                (Hit::Surface { distance, .. }, None) => {
                    let deepest = (0..100)
                        .map(|step| inside(distance + 2e-5 * f64::from(step)))
                        .fold(f64::MIN, f64::max);
                    assert!(deepest > -1e-9 && deepest < 1e-3, "{shape:?} {deepest}");
                }
                (hit, first) => panic!("{shape:?}: {hit:?} {first:?}"),
            }
        }
        assert!(hits > 600 && misses > 50 && insides > 20, "{hits} {misses} {insides}");
    }

    #[test]
    fn the_faces_of_a_hull_hold_all_its_points() {
        let mut random = randoms(4);
        let points: Vec<DVec3> = (0..60)
            .map(|_| DVec3::new(random(-1.0, 1.0), random(-2.0, 2.0), random(-0.5, 0.5)))
            .collect();
        for (normal, offset) in hull_faces(&Hull::new(&points, None).unwrap()) {
            let furthest = points.iter().map(|at| normal.dot(*at)).fold(f64::MIN, f64::max);
            assert!((normal.length() - 1.0).abs() < 1e-12 && (furthest - offset).abs() < 1e-12);
        }
    }
}
