//! The surface points of links, from their collision shapes or else from their looks.

use glam::DVec3;

use crate::base::input_error::InputError;
use crate::geometry::shape::Shape;
use crate::mesh::store::MeshStore;
use crate::robot::links::{ShapeChoice, build_link};
use crate::robot::mesh_path::links_without_meshes;
use crate::robot::model::LinkShape;
use crate::robot::surface_points::SurfacePoints;
use crate::robot::urdf_link::UrdfLink;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};

/// The shapes of every node.
pub(crate) struct LinkShapes {
    /// Collision shapes that can be read.
    pub(crate) collision: Vec<Vec<LinkShape>>,
    /// Shapes of looks; read only for nodes whose body has no collision shape, or balls alone.
    pub(crate) visual: Vec<Vec<LinkShape>>,
}

impl LinkShapes {
    /// Reads all shapes. Looks that cannot be read are passed over, and meshes whose files are
    /// missing if `skip_missing`.
    ///
    /// # Errors
    /// Collision shapes that cannot be read.
    pub(crate) fn read(skeleton: &Skeleton, skip_missing: bool) -> Result<Self, InputError> {
        let mut meshes = MeshStore::default();
        let mut complaints = Vec::new();
        let mut read = |node: NodeIndex, visual: bool| {
            let (urdf, link) = (skeleton.urdf, skeleton.nodes[node].urdf_link);
            let choice = ShapeChoice { exact: false, visual, may_lack_meshes: skip_missing };
            let mut found = Vec::new();
            let shapes = build_link(urdf, link, choice, &mut meshes, &mut found).shapes;
            complaints.extend(found.into_iter().filter(|_| !visual));
            shapes
        };
        let count = skeleton.nodes.len();
        let collision: Vec<_> = (0..count).map(|node| read(node, false)).collect();
        let has_flat_shape = |body| {
            let nodes = skeleton.body_nodes(body);
            nodes.iter().flat_map(|node| &collision[*node]).any(|part| !is_ball(&part.shape))
        };
        let visual = (0..count)
            .map(|node| {
                let is_bare = !has_flat_shape(skeleton.body(node));
                if is_bare { read(node, true) } else { Vec::new() }
            })
            .collect();
        if let [complaint] = &mut complaints[..] {
            hint_at_one(skeleton, complaint);
        } else if let Some(hint) = hint_at_several(skeleton).filter(|_| !complaints.is_empty()) {
            complaints.insert(0, hint);
        }
        InputError::all(complaints)?;
        Ok(Self { collision, visual })
    }

    /// The shapes that stand for a node.
    pub(crate) fn of(&self, node: NodeIndex) -> &[LinkShape] {
        if self.visual[node].is_empty() { &self.collision[node] } else { &self.visual[node] }
    }

    /// Whether a body has collision shapes or contact points.
    pub(crate) fn has_collision(&self, skeleton: &Skeleton, body: NodeIndex) -> bool {
        let has_points = |node: NodeIndex| urdf_link(skeleton, node).contact_points().count() > 0;
        let nodes = skeleton.body_nodes(body);
        nodes.into_iter().any(|node| !self.collision[node].is_empty() || has_points(node))
    }

    /// The nodes of a body whose looks stand for them.
    pub(crate) fn visual_nodes(&self, skeleton: &Skeleton, body: NodeIndex) -> Vec<NodeIndex> {
        let mut nodes = skeleton.body_nodes(body);
        nodes.retain(|node| !self.visual[*node].is_empty());
        nodes
    }

    /// The surface of all links of a body, in the body's frame; of a link without shapes its
    /// contact points.
    pub(crate) fn surface(&self, skeleton: &Skeleton, body: NodeIndex) -> SurfacePoints {
        let counts_points = |node: NodeIndex| self.of(node).is_empty();
        surface_of(skeleton, body, |node| self.of(node), counts_points)
    }

    /// The balls and contact points among the collision shapes of a body whose looks stand for it,
    /// in the body's frame: centres and radii, m.
    pub(crate) fn contact_balls(&self, skeleton: &Skeleton, body: NodeIndex) -> Vec<(DVec3, f64)> {
        let is_shown = |node: NodeIndex| !self.visual[node].is_empty();
        let shapes = |node| if is_shown(node) { &self.collision[node][..] } else { &[] };
        surface_of(skeleton, body, shapes, is_shown).balls
    }
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
