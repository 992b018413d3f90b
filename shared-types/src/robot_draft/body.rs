//! The surface points of links, from their collision shapes or else from their looks.

use glam::DVec3;

use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::geometry::shape::Shape;
use crate::mesh::store::MeshStore;
use crate::robot::links::{ShapeChoice, build_link};
use crate::robot::mesh_path::links_without_meshes;
use crate::robot::model::LinkShape;
use crate::robot::surface_points::SurfacePoints;
use crate::robot::urdf_link::UrdfLink;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// Balls that reach farther down than all else carry a foot, m.
const BALLS_BELOW_MIN: f64 = 2.5e-3;
/// Least number of them on which a foot can stand.
const BALLS_MIN: usize = 3;

/// The shapes of every node.
pub(crate) struct LinkShapes {
    /// Collision shapes that can be read.
    pub(crate) collision: Vec<Vec<LinkShape>>,
    /// Shapes of looks; read only for nodes whose body has no collision shape, or stands on balls.
    pub(crate) visual: Vec<Vec<LinkShape>>,
    /// Nodes that hold the balls on which such a body stands, beside its looks: no surface of it.
    contact_points: Vec<bool>,
    /// Why looks of nodes could not be read.
    unread: Vec<(NodeIndex, InputError)>,
}

impl LinkShapes {
    /// Reads all shapes. Looks that cannot be read are passed over, and meshes whose files are
    /// missing if `skip_missing`.
    ///
    /// # Errors
    /// Collision shapes that cannot be read.
    pub(crate) fn read(skeleton: &Skeleton, skip_missing: bool) -> Result<Self, InputError> {
        let mut meshes = MeshStore::default();
        let (mut complaints, mut unread) = (Vec::new(), Vec::new());
        let mut read = |node: NodeIndex, visual: bool| {
            let (urdf, link) = (skeleton.urdf, skeleton.nodes[node].urdf_link);
            let choice = ShapeChoice { exact: false, visual, may_lack_meshes: skip_missing };
            let mut found = Vec::new();
            let shapes = build_link(urdf, link, choice, &mut meshes, &mut found).shapes;
            if visual {
                unread.extend(found.into_iter().map(|complaint| (node, complaint)));
            } else {
                complaints.extend(found);
            }
            shapes
        };
        let count = skeleton.nodes.len();
        let collision: Vec<_> = (0..count).map(|node| read(node, false)).collect();
        let poses = skeleton.poses(&vec![0.0; count]);
        let is_bare: Vec<bool> =
            (0..count).map(|node| stands_on_balls(skeleton, &poses, &collision, node)).collect();
        let visual: Vec<_> = (0..count)
            .map(|node| if is_bare[skeleton.body(node)] { read(node, true) } else { Vec::new() })
            .collect();
        let has_looks = |body| skeleton.body_nodes(body).iter().any(|at| !visual[*at].is_empty());
        let contact_points = (0..count)
            .map(|node| {
                let has_balls = !collision[node].is_empty() && visual[node].is_empty();
                let are_balls = collision[node].iter().all(|part| is_ball(&part.shape));
                has_balls && are_balls && has_looks(skeleton.body(node))
            })
            .collect();
        if let [complaint] = &mut complaints[..] {
            hint_at_one(skeleton, complaint);
        } else if let Some(hint) = hint_at_several(skeleton).filter(|_| !complaints.is_empty()) {
            complaints.insert(0, hint);
        }
        InputError::all(complaints)?;
        Ok(Self { collision, visual, contact_points, unread })
    }

    /// The shapes that stand for a node.
    pub(crate) fn of(&self, node: NodeIndex) -> &[LinkShape] {
        match (self.contact_points[node], self.visual[node].is_empty()) {
            (true, _) => &[],
            (false, true) => &self.collision[node],
            (false, false) => &self.visual[node],
        }
    }

    /// Whether a body has a shape; points are none.
    pub(crate) fn has_shape(&self, skeleton: &Skeleton, body: NodeIndex) -> bool {
        skeleton.body_nodes(body).into_iter().any(|node| !self.of(node).is_empty())
    }

    /// Why a look of a body could not be read.
    pub(crate) fn unread_look(&self, skeleton: &Skeleton, body: NodeIndex) -> Option<&str> {
        let nodes = skeleton.body_nodes(body);
        let mut of_body = self.unread.iter().filter(|(node, _)| nodes.contains(node));
        of_body.next().map(|(_, complaint)| complaint.message.as_str())
    }

    /// Whether a body has collision shapes or contact points.
    pub(crate) fn has_collision(&self, skeleton: &Skeleton, body: NodeIndex) -> bool {
        let has_points = |node: NodeIndex| urdf_link(skeleton, node).contact_points().count() > 0;
        let nodes = skeleton.body_nodes(body);
        nodes.into_iter().any(|node| !self.collision[node].is_empty() || has_points(node))
    }

    /// The nodes of a body whose looks, if any, stand for them.
    pub(crate) fn visual_nodes(&self, skeleton: &Skeleton, body: NodeIndex) -> Vec<NodeIndex> {
        let mut nodes = skeleton.body_nodes(body);
        nodes.retain(|node| self.is_visual(*node));
        nodes
    }

    fn is_visual(&self, node: NodeIndex) -> bool {
        self.contact_points[node] || !self.visual[node].is_empty()
    }

    /// The surface of all links of a body, in the body's frame; of a link without shapes its
    /// contact points.
    pub(crate) fn surface(&self, skeleton: &Skeleton, body: NodeIndex) -> SurfacePoints {
        let counts_points =
            |node: NodeIndex| self.of(node).is_empty() && !self.contact_points[node];
        surface_of(skeleton, body, |node| self.of(node), counts_points)
    }

    /// The balls and contact points among the collision shapes of a body whose looks stand for it,
    /// in the body's frame: centres and radii, m.
    pub(crate) fn contact_balls(&self, skeleton: &Skeleton, body: NodeIndex) -> Vec<(DVec3, f64)> {
        let is_shown = |node: NodeIndex| self.is_visual(node);
        let shapes = |node| if is_shown(node) { &self.collision[node][..] } else { &[] };
        surface_of(skeleton, body, shapes, is_shown).balls
    }
}

/// Whether a body has no collision shapes but balls, or stands on such where all joints are at 0.
fn stands_on_balls(
    skeleton: &Skeleton,
    poses: &[Pose],
    collision: &[Vec<LinkShape>],
    body: NodeIndex,
) -> bool {
    let [mut balls, mut others] = [SurfacePoints::default(), SurfacePoints::default()];
    for node in skeleton.body_nodes(body) {
        let body_from_link = poses[body].inverse() * poses[node];
        for part in &collision[node] {
            let surface = if is_ball(&part.shape) { &mut balls } else { &mut others };
            surface.add(&part.shape, &(body_from_link * part.link_from_shape));
        }
    }
    let down = poses[body].rotation.inverse() * DVec3::NEG_Z;
    let is_lower = || balls.extent(down) > others.extent(down) + BALLS_BELOW_MIN;
    others.is_empty() || (balls.balls.len() >= BALLS_MIN && is_lower())
}

/// The surface of shapes of a body's links, in the body's frame, and the contact points of the
/// links where they count.
fn surface_of<'s>(
    skeleton: &Skeleton,
    body: NodeIndex,
    shapes: impl Fn(NodeIndex) -> &'s [LinkShape],
    counts_points: impl Fn(NodeIndex) -> bool,
) -> SurfacePoints {
    let poses = skeleton.poses(&vec![0.0; skeleton.nodes.len()]);
    let body_from_root = poses[body].inverse();
    let mut surface = SurfacePoints::default();
    for node in skeleton.body_nodes(body) {
        let body_from_link = body_from_root * poses[node];
        for part in shapes(node) {
            surface.add(&part.shape, &(body_from_link * part.link_from_shape));
        }
        let points = urdf_link(skeleton, node).contact_points().filter(|_| counts_points(node));
        surface.balls.extend(points.map(|at| (body_from_link * at.translation, 0.0)));
    }
    surface
}

/// Says how to go on where the only complaint is a missing mesh file.
fn hint_at_one(skeleton: &Skeleton, complaint: &mut InputError) {
    if !links_without_meshes(skeleton.urdf).is_empty() {
        complaint.message += ", or add --skip-missing-meshes to go on without this shape";
    }
}

/// How to go on where mesh files are missing.
fn hint_at_several(skeleton: &Skeleton) -> Option<InputError> {
    let path = &skeleton.urdf.source.path;
    let count = links_without_meshes(skeleton.urdf).len();
    let message = format!(
        "mesh files of {count} of its {} links are missing; with --skip-missing-meshes these links get no shape, and nothing keeps them from colliding",
        skeleton.nodes.len()
    );
    (count > 0).then(|| InputError::file(path, message))
}

fn urdf_link<'a>(skeleton: &'a Skeleton, node: NodeIndex) -> &'a UrdfLink {
    &skeleton.urdf.links[skeleton.nodes[node].urdf_link]
}

fn is_ball(shape: &Shape) -> bool {
    matches!(shape, Shape::Sphere { .. })
}
