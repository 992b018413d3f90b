//! Finds the links that need exact meshes: links whose convex hulls overlap where the meshes do
//! not. Links that overlap in nearly every posture, or at position 0, count as covers that may
//! touch. If only their hulls overlapped there, collisions between them would not be detected.

use glam::DVec3;
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry3d_f64::query::intersection_test;
use parry3d_f64::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, Cylinder, SharedShape, TriMesh};

use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;
use crate::robot::model::{Link, LinkIndex, LinkShape, RobotModel, joints_between};

/// Most moving joints between two links that may touch in any case.
const NEIGHBOURS_MAX: usize = 1;
/// Most triangles of an exact mesh. A link with more keeps its hull, because each distance to it
/// would take too long.
pub const TRIANGLES_MAX: usize = 3_000;
/// Margin of the bounding boxes of shapes, m; above any rounding error.
const SLACK: f64 = 1e-6;

/// A collision shape with its pose.
struct PlacedShape {
    world_from_shape: Pose,
    shape: SharedShape,
    bounds: Aabb,
}

/// Links whose hull overlaps another link although the exact meshes do not, with their exact
/// shapes. Tested with all joints as near to 0 as their limits allow, and in the standing posture.
/// If one of two links is enough, it is the one with fewer triangles. `exact` makes a link with
/// exact meshes; if it fails, the link keeps its hull.
pub(crate) fn misleading_hulls(
    robot: &RobotModel,
    mut exact: impl FnMut(LinkIndex) -> Option<Link>,
) -> Vec<(LinkIndex, Vec<LinkShape>)> {
    let links = &robot.links;
    let neutral: Vec<f64> =
        robot.joints.iter().map(|joint| 0.0_f64.clamp(joint.lower, joint.upper)).collect();
    let mut apart: Vec<[LinkIndex; 2]> = pairs_with_hulls(links).collect();
    let mut misleading = vec![];
    for q in [&neutral, &robot.standing_q] {
        if apart.is_empty() {
            break;
        }
        let mut test = OverlapTest::new(robot, q, &mut exact);
        let mut chosen = vec![];
        apart.retain(|&pair| {
            let overlap = test.overlap(pair, &[]);
            if overlap {
                chosen.extend(test.separating_links(pair, links));
            }
            !overlap
        });
        misleading.extend(
            chosen.into_iter().filter_map(|at| Some((at, test.surfaces[at].take()?.parts))),
        );
    }
    misleading
}

fn has_hull(link: &Link) -> bool {
    link.shapes.iter().any(|part| matches!(part.shape, Shape::ConvexHull { .. }))
}

/// The pairs of links that are not neighbours, at least one of which has a hull.
fn pairs_with_hulls(links: &[Link]) -> impl Iterator<Item = [LinkIndex; 2]> {
    let pairs = (0..links.len()).flat_map(|a| (a + 1..links.len()).map(move |b| [a, b]));
    pairs.filter(|&pair| {
        pair.iter().any(|&at| has_hull(&links[at])) && joints_between(links, pair) > NEIGHBOURS_MAX
    })
}

/// All links in one posture: their hulls, and their exact meshes once those are needed.
struct OverlapTest<F> {
    poses: Vec<Pose>,
    hulls: Vec<Vec<PlacedShape>>,
    surfaces: Vec<Option<Surface>>,
    exact: F,
}

/// A link with exact meshes; without shapes if it has too many triangles or cannot be made.
#[derive(Default)]
struct Surface {
    triangles: usize,
    parts: Vec<LinkShape>,
    shapes: Vec<PlacedShape>,
}

impl<F: FnMut(LinkIndex) -> Option<Link>> OverlapTest<F> {
    fn new(robot: &RobotModel, q: &[f64], exact: F) -> Self {
        let poses = robot.root_from_links(q);
        let hulls =
            robot.links.iter().zip(&poses).map(|(link, pose)| placed_shapes(link, pose)).collect();
        Self { poses, hulls, surfaces: robot.links.iter().map(|_| None).collect(), exact }
    }

    /// Whether two links overlap if the links of `exact` have exact meshes.
    fn overlap(&self, pair: [LinkIndex; 2], exact: &[LinkIndex]) -> bool {
        let shapes = |at: LinkIndex| {
            self.surfaces[at]
                .as_ref()
                .filter(|_| exact.contains(&at))
                .map_or(&self.hulls[at], |surface| &surface.shapes)
        };
        let [first, second] = pair.map(shapes);
        first.iter().any(|a| second.iter().any(|b| a.overlaps(b)))
    }

    /// The fewest of two links that need exact meshes so that the two do not overlap; empty if
    /// exact meshes do not suffice.
    fn separating_links(&mut self, pair: [LinkIndex; 2], links: &[Link]) -> Vec<LinkIndex> {
        let mut hulls = pair.to_vec();
        hulls.retain(|&at| has_hull(&links[at]) && !self.surface(at).shapes.is_empty());
        hulls.sort_by_key(|&at| self.surface(at).triangles);
        let singles = hulls.iter().map(|&at| vec![at]);
        let choices: Vec<Vec<LinkIndex>> =
            singles.chain([hulls.clone()]).filter(|choice| !choice.is_empty()).collect();
        choices.into_iter().find(|choice| !self.overlap(pair, choice)).unwrap_or_default()
    }

    fn surface(&mut self, at: LinkIndex) -> &Surface {
        let Self { poses, surfaces, exact, .. } = self;
        surfaces[at].get_or_insert_with(|| {
            let small_enough = exact(at)
                .map(|link| (triangles_of(&link), link))
                .filter(|(triangles, _)| *triangles <= TRIANGLES_MAX);
            small_enough.map_or_else(Surface::default, |(triangles, link)| {
                let shapes = placed_shapes(&link, &poses[at]);
                Surface { triangles, parts: link.shapes, shapes }
            })
        })
    }
}

/// The triangles of a link's exact meshes.
pub fn triangles_of(link: &Link) -> usize {
    let triangles = |part: &LinkShape| {
        if let Shape::Mesh { triangles, .. } = &part.shape { triangles.len() } else { 0 }
    };
    link.shapes.iter().map(triangles).sum()
}

fn placed_shapes(link: &Link, world_from_link: &Pose) -> Vec<PlacedShape> {
    let place = |part: &LinkShape| {
        let (world_from_shape, shape) =
            (*world_from_link * part.link_from_shape, solid(&part.shape)?);
        let bounds = shape.compute_aabb(&world_from_shape).loosened(SLACK);
        Some(PlacedShape { world_from_shape, shape, bounds })
    };
    link.shapes.iter().filter_map(place).collect()
}

impl PlacedShape {
    fn overlaps(&self, other: &Self) -> bool {
        let test = || {
            intersection_test(
                &self.world_from_shape,
                &*self.shape,
                &other.world_from_shape,
                &*other.shape,
            )
        };
        self.bounds.intersects(&other.bounds) && test().is_ok_and(|test| test.intersecting)
    }
}

/// The shape for Parry's overlap tests; `None` if Parry cannot represent it.
pub(crate) fn solid(shape: &Shape) -> Option<SharedShape> {
    Some(match shape {
        Shape::Box { half_extents } => SharedShape::new(Cuboid::new(*half_extents)),
        Shape::Sphere { radius } => SharedShape::new(Ball::new(*radius)),
        // Parry's cylinders lie along y.
        Shape::Cylinder { radius, half_length } => {
            let (vertices, _) = Cylinder::new(*half_length, *radius).to_trimesh(32);
            let turned: Vec<DVec3> =
                vertices.iter().map(|vertex| DVec3::new(vertex.x, vertex.z, vertex.y)).collect();
            SharedShape::new(ConvexPolyhedron::from_convex_hull(&turned)?)
        }
        Shape::Capsule { radius, half_length } => SharedShape::new(Capsule::new(
            DVec3::NEG_Z * *half_length,
            DVec3::Z * *half_length,
            *radius,
        )),
        Shape::ConvexHull { points, .. } => {
            SharedShape::new(ConvexPolyhedron::from_convex_hull(points)?)
        }
        Shape::Mesh { vertices, triangles, .. } => {
            SharedShape::new(TriMesh::new(vertices.clone(), triangles.clone()).ok()?)
        }
    })
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;
    use crate::geometry::shape::MeshSource;
    use crate::robot::model::{Joint, JointKind};

    /// Vertices and triangles of a trough along y from z = 0 upward: 2 wide inside, 1 high, walls
    /// 0.1 thick.
    fn trough() -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let outline = [
            [-1.1, 0.0],
            [1.1, 0.0],
            [1.1, 1.0],
            [1.0, 1.0],
            [1.0, 0.1],
            [-1.0, 0.1],
            [-1.0, 1.0],
            [-1.1, 1.0],
        ];
        let ring = |y: f64| outline.map(|[x, z]| DVec3::new(x, y, z));
        let vertices = [ring(-1.0), ring(1.0)].concat();
        let sides = (0..8_u32).flat_map(|at| {
            let next = (at + 1) % 8;
            [[at, next, at + 8], [next, next + 8, at + 8]]
        });
        (vertices, sides.collect())
    }

    fn link(parent: Option<LinkIndex>, shape: Option<Shape>) -> Link {
        let attachment = |parent| crate::robot::model::Attachment {
            parent,
            parent_from_joint: Pose::IDENTITY,
            joint: Some(parent),
        };
        let shapes = shape.map(|shape| LinkShape { link_from_shape: Pose::IDENTITY, shape });
        Link {
            name: String::new(),
            parent: parent.map(attachment),
            mass: 1.0,
            com: DVec3::ZERO,
            inertia: DMat3::IDENTITY,
            shapes: shapes.into_iter().collect(),
        }
    }

    fn joint(child: LinkIndex) -> Joint {
        let (kind, axis, limits) = (JointKind::Revolute, DVec3::Z, [-1.0, 1.0]);
        Joint {
            name: String::new(),
            kind,
            axis,
            child,
            lower: limits[0],
            upper: limits[1],
            effort: 1.0,
            velocity: 1.0,
            stated_acceleration: None,
        }
    }

    /// The links that need exact meshes in a chain of a trough, a link without shapes and a sphere
    /// that slides upward. At joint position 0 the sphere is `above` the middle of the trough; in
    /// the standing posture it is in the middle.
    fn misleading_around(radius: f64, above: f64) -> Vec<LinkIndex> {
        let (vertices, triangles) = trough();
        let hull = Shape::ConvexHull { points: vertices.clone(), source: None };
        let mut sphere = link(Some(1), Some(Shape::Sphere { radius }));
        sphere.shapes[0].link_from_shape =
            Pose::from_translation(DVec3::new(0.0, 0.0, 0.55 + above));
        let slide = Joint { kind: JointKind::Prismatic, lower: -9.0, upper: 9.0, ..joint(2) };
        let robot = RobotModel {
            name: String::new(),
            urdf_path: "trough.urdf".into(),
            robot_path: None,
            mesh_paths: vec![],
            links: vec![link(None, Some(hull)), link(Some(0), None), sphere.clone()],
            joints: vec![joint(1), slide],
            standing_q: vec![0.0, -above],
            feet: vec![],
            locked_joints: vec![],
            additions: Default::default(),
            allowed_overlaps: Vec::new(),
            digest: Default::default(),
        };
        let source = Some(MeshSource { path: "trough.obj".into(), scale: DVec3::ONE });
        let mesh = Shape::Mesh { vertices, triangles, source };
        let exact = |at: LinkIndex| {
            Some(if at == 0 { link(None, Some(mesh.clone())) } else { sphere.clone() })
        };
        misleading_hulls(&robot, exact).into_iter().map(|(at, _)| at).collect()
    }

    #[test]
    fn a_hull_that_overlaps_where_its_mesh_does_not_is_misleading() {
        assert_eq!(misleading_around(0.3, 0.0), [0]);
    }

    #[test]
    fn a_hull_is_not_misleading_where_its_mesh_overlaps_too() {
        assert!(misleading_around(0.5, 0.0).is_empty());
    }

    #[test]
    fn the_standing_posture_is_tested_too() {
        assert_eq!((misleading_around(0.3, 5.0), misleading_around(0.5, 5.0)), (vec![0], vec![]));
    }

    #[test]
    fn a_fixed_link_adds_no_joint_to_the_chain() {
        let mut links =
            [link(None, None), link(Some(0), None), link(Some(1), None), link(Some(0), None)];
        assert_eq!(
            [
                joints_between(&links, [0, 2]),
                joints_between(&links, [3, 2]),
                joints_between(&links, [1, 1])
            ],
            [2, 3, 0]
        );
        links[2].parent.as_mut().unwrap().joint = None;
        assert_eq!(joints_between(&links, [3, 2]), 2);
    }
}
