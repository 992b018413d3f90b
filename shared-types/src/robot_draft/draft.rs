//! The draft of a robot file: every value that a URDF does not state, and where it comes from.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::base::text_file::{absolute, absolute_folder};
use crate::robot::mesh_path::links_without_meshes;
use crate::robot::model::FOOT_NAMES;
use crate::robot::tree::sort_links;
use crate::robot::urdf::{Urdf, read_urdf};
use crate::robot_draft::arms::ArmSearch;
use crate::robot_draft::body::LinkShapes;
use crate::robot_draft::estimates::{
    missing_effort, missing_inertia, missing_range, missing_velocity,
};
use crate::robot_draft::foot_choice::choose_feet;
use crate::robot_draft::foot_search::{LEG_JOINTS, LEG_JOINTS_MIN, mirrored_pairs};
use crate::robot_draft::heading::{Heading, ankle_of};
use crate::robot_draft::locks::{ARM_JOINTS_MIN, Limbs, limbs};
use crate::robot_draft::options::DraftOptions;
use crate::robot_draft::skeleton::{NodeIndex, Skeleton};
use crate::robot_draft::sole_search::{carried_by_balls, find_sole};
use crate::robot_draft::standing_posture::{DraftLeg, StandingPosture, StandingSearch};

/// Shapes of an ankle that reach down to less than this above the sole are a foot's, m.
const FOOT_SHAPE_ABOVE_MAX: f64 = 0.005;
/// Positions are written with this many parts of a rad or m.
const POSITION_PARTS: f64 = 1e5;

/// A value with where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Noted<T> {
    /// The joint or link.
    pub name: String,
    /// The value.
    pub value: T,
    /// Where it comes from.
    pub source: String,
}

/// A foot with its sole.
#[derive(Debug, Clone, PartialEq)]
pub struct DraftFoot {
    /// "left" or "right".
    pub name: &'static str,
    /// Its link.
    pub link: String,
    /// The sole frame in the link.
    pub link_from_sole: Pose,
    /// The outline of the sole, m.
    pub polygon: Vec<DVec2>,
    /// Where the sole comes from.
    pub source: String,
}

/// A robot file that can be written.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotDraft {
    /// The robot's name.
    pub name: String,
    /// Absolute path of the URDF.
    pub urdf_path: PathBuf,
    /// The root link.
    pub root: String,
    /// The heading in the root's frame, rad, where it is not 0.
    pub root_yaw: Option<Noted<f64>>,
    /// Left and right.
    pub feet: Vec<DraftFoot>,
    /// Joints that do not stand at 0.
    pub posture: Vec<Noted<f64>>,
    /// Joints that are locked.
    pub locked: Vec<Noted<f64>>,
    /// Links whose looks stand for their shapes.
    pub visual_shapes: Vec<Noted<()>>,
    /// Links that keep their meshes, since their hulls collide too often; empty in a first draft.
    pub exact_meshes: Vec<Noted<()>>,
    /// Links whose missing mesh files are passed over.
    pub missing_meshes: Vec<Noted<()>>,
    /// Absolute paths of packages that the user states, by name.
    pub packages: BTreeMap<String, String>,
    /// What the URDF does not state.
    pub estimates: DraftEstimates,
}

/// Estimates of what a URDF does not state.
#[derive(Debug, Clone, PartialEq)]
pub struct DraftEstimates {
    /// Ranges, rad.
    pub position_limits: Vec<Noted<[f64; 2]>>,
    /// Efforts, N m.
    pub effort_limits: Vec<Noted<f64>>,
    /// Speeds, rad/s.
    pub velocity_limits: Vec<Noted<f64>>,
    /// Moments of inertia, kg m2.
    pub inertias: Vec<Noted<DVec3>>,
}

impl RobotDraft {
    /// Drafts the robot file of a URDF.
    ///
    /// # Errors
    /// All that is out of order in the URDF and its meshes; feet that cannot be distinguished from
    /// others, with the candidates; legs that a walk cannot be planned for.
    pub fn from_urdf(path: &Path, options: &DraftOptions) -> Result<Self, InputError> {
        let mut complaints = Vec::new();
        let mut urdf = read_urdf(path, &mut complaints)?;
        let packages = options.packages.iter();
        urdf.package_folders = packages
            .map(|(name, folder)| {
                (name.clone(), absolute_folder(folder).to_string_lossy().into_owned())
            })
            .collect();
        let tree = sort_links(&urdf, &mut complaints);
        InputError::all(complaints)?;
        let Some(tree) = tree else {
            return Err(InputError::file(path, "its joints form no tree"));
        };
        let skeleton = Skeleton::new(&urdf, &tree);
        let shapes = LinkShapes::read(&skeleton, options.skip_missing_meshes)?;
        let neutral = skeleton.neutral();
        let poses = skeleton.poses(&neutral);
        let pairs = mirrored_pairs(&skeleton, &poses, LEG_JOINTS_MIN);
        let heading = choose_feet(&skeleton, &shapes, &poses, &pairs, options)?;
        let pairs = mirrored_pairs(&skeleton, &poses, ARM_JOINTS_MIN);
        let limbs = limbs(&skeleton, &pairs, &heading.feet);
        let parts = DraftParts { skeleton: &skeleton, shapes: &shapes, heading, limbs };
        parts.draft(neutral, &poses, options.knee_bend)
    }
}

/// The parts of the robot that are found before its posture.
struct DraftParts<'a> {
    skeleton: &'a Skeleton<'a>,
    shapes: &'a LinkShapes,
    heading: Heading,
    limbs: Limbs,
}

impl DraftParts<'_> {
    fn draft(
        &self,
        neutral: Vec<f64>,
        poses: &[Pose],
        knee_bend: Option<f64>,
    ) -> Result<RobotDraft, InputError> {
        let legs = [self.leg(0, poses)?, self.leg(1, poses)?];
        let mut hanging = neutral.clone();
        let arms = ArmSearch::new(self.skeleton, self.shapes, self.heading.yaw);
        self.limbs.arms.iter().for_each(|pair| arms.clear(pair, &mut hanging));
        let search = StandingSearch { skeleton: self.skeleton, legs: &legs, yaw: self.heading.yaw };
        let standing =
            search.solve(&hanging, knee_bend).ok_or_else(|| self.no_posture(&legs, poses))?;
        let urdf = self.urdf();
        let turns = self.heading.yaw != 0.0;
        let root = self.skeleton.link_name(0).to_owned();
        let root_yaw = Noted {
            name: root.clone(),
            value: self.heading.yaw,
            source: format!("the robot looks there by {}", self.heading.source),
        };
        Ok(RobotDraft {
            name: urdf.name.clone(),
            urdf_path: absolute(&urdf.source.path),
            root,
            root_yaw: turns.then_some(root_yaw),
            feet: legs.iter().zip(FOOT_NAMES).map(|(leg, name)| self.foot(leg, name)).collect(),
            posture: self.posture(&standing, &neutral, &legs),
            locked: self.locked(&neutral),
            visual_shapes: self.visual_shapes(&legs),
            exact_meshes: Vec::new(),
            missing_meshes: self.missing_meshes(),
            packages: urdf.package_folders.clone(),
            estimates: DraftEstimates {
                position_limits: self.ranges(),
                effort_limits: self.efforts(),
                velocity_limits: self.velocities(),
                inertias: self.inertias(),
            },
        })
    }

    fn urdf(&self) -> &Urdf {
        self.skeleton.urdf
    }

    fn error(&self, element: String, message: String) -> InputError {
        InputError::element(&self.urdf().source.path, element, message)
    }

    /// The leg of a foot: its joints that are not locked, and its sole.
    fn leg(&self, limb: usize, poses: &[Pose]) -> Result<DraftLeg, InputError> {
        let (body, name) = (self.heading.feet.bodies[limb], FOOT_NAMES[limb]);
        let mut chain = self.heading.feet.chains[limb].clone();
        chain.retain(|node| !self.limbs.locked.contains_key(node));
        let link = self.skeleton.link_name(body);
        let element = || format!("{name} foot '{link}'");
        let names = |nodes: &[NodeIndex]| -> String {
            let names = nodes.iter().filter_map(|node| self.skeleton.joint_name(*node));
            names.map(String::as_str).collect::<Vec<_>>().join(", ")
        };
        if let Some(node) = chain.iter().find(|node| self.skeleton.is_mimic(**node)) {
            let message = format!(
                "its leg's joint '{}' mimics another one; legs whose joints move together are not supported",
                names(&[*node])
            );
            return Err(self.error(element(), message));
        }
        let [least, most] = LEG_JOINTS;
        if !(least..=most).contains(&chain.len()) {
            let message = format!(
                "its leg has {} moving joints ({}); {least} to {most} are needed to place a sole freely, so this robot is not supported",
                chain.len(),
                names(&chain)
            );
            return Err(self.error(element(), message));
        }
        let turn = poses[body].rotation.inverse();
        let (sin, cos) = libm::sincos(self.heading.yaw);
        let forward = turn * DVec3::new(cos, sin, 0.0);
        let surface = self.shapes.surface(self.skeleton, body);
        if !self.shapes.has_shape(self.skeleton, body) {
            let unread = self.shapes.unread_look(self.skeleton, body);
            let unread = unread.map_or(String::new(), |reason| format!(" ({reason})"));
            let message = format!(
                "has no collision shape (a sphere of radius 0 is none), nor a look that can be \
                 read{unread}; add a <collision> to the URDF: a box is enough"
            );
            return Err(self.error(element(), message));
        }
        let Some(sole) = find_sole(&surface, turn * DVec3::NEG_Z, forward) else {
            let message = "has no flat face that looks down where all joints stand at 0; a point \
                           or line foot is not supported";
            return Err(self.error(element(), message.to_owned()));
        };
        let sole = sole.below(ankle_of(self.skeleton, poses, body));
        let on_balls = carried_by_balls(&sole, &self.shapes.contact_balls(self.skeleton, body));
        Ok(DraftLeg {
            chain,
            body,
            body_from_sole: sole.link_from_sole,
            stands_on_balls: on_balls.is_some(),
            polygon: on_balls.unwrap_or(sole.polygon),
        })
    }

    /// Why the robot cannot stand: what was taken for legs hangs as arms do, or bends otherwise.
    fn no_posture(&self, legs: &[DraftLeg; 2], poses: &[Pose]) -> InputError {
        let ends = |leg: &DraftLeg| {
            let [first, last] = [leg.chain[0], leg.body];
            format!("'{}' to '{}'", self.name(first), self.skeleton.link_name(last))
        };
        let is_leg = |node| legs.iter().any(|leg| self.skeleton.is_below(node, leg.chain[0]));
        let rest = self.skeleton.centre_of_mass_of(poses, |node| !is_leg(node));
        let hangs_high = legs.iter().all(|leg| poses[leg.chain[0]].translation.z > rest.z);
        let lacks_meshes = !links_without_meshes(self.urdf()).is_empty();
        let advice = if lacks_meshes {
            "meshes are missing, perhaps those of the feet: fetch them, or name the feet with --feet"
        } else if hangs_high {
            "they hang above the centre of mass of the rest, as arms do: a URDF without legs cannot walk"
        } else {
            "write robot.toml by hand (docs/OWN_ROBOT.md)"
        };
        let message = format!(
            "no posture with bent knees places both soles level below the hips within the joints' limits; taken for legs: {} and {}; {advice}",
            ends(&legs[0]),
            ends(&legs[1])
        );
        InputError::file(&self.urdf().source.path, message)
    }

    fn foot(&self, leg: &DraftLeg, name: &'static str) -> DraftFoot {
        let links: Vec<&str> = self
            .skeleton
            .body_nodes(leg.body)
            .into_iter()
            .filter(|node| !self.shapes.of(*node).is_empty())
            .map(|node| self.skeleton.link_name(node))
            .collect();
        let visual = self.shapes.visual_nodes(self.skeleton, leg.body);
        let kind = match (visual.is_empty(), self.shapes.has_collision(self.skeleton, leg.body)) {
            (true, _) => "collision shapes",
            (false, true) if leg.stands_on_balls => "looks, between its collision balls,",
            (false, true) => "looks (its collision shapes are balls)",
            (false, false) => "looks (no collision shape)",
        };
        DraftFoot {
            name,
            link: self.skeleton.link_name(leg.body).to_owned(),
            link_from_sole: leg.body_from_sole,
            polygon: leg.polygon.clone(),
            source: format!("the lowest flat face of the {kind} of {}", links.join(", ")),
        }
    }

    fn name(&self, node: NodeIndex) -> String {
        self.skeleton.joint_name(node).cloned().unwrap_or_default()
    }

    /// A position of a joint, rounded, within its limits.
    fn rounded(&self, node: NodeIndex, position: f64) -> f64 {
        let rounded = (position * POSITION_PARTS).round() / POSITION_PARTS;
        let joint = self.skeleton.nodes[node].joint.as_ref();
        joint.map_or(rounded, |joint| rounded.clamp(joint.lower, joint.upper))
    }

    fn posture(
        &self,
        standing: &StandingPosture,
        neutral: &[f64],
        legs: &[DraftLeg; 2],
    ) -> Vec<Noted<f64>> {
        let is_leg = |node: &NodeIndex| legs.iter().any(|leg| leg.chain.contains(node));
        let noted = |node: NodeIndex| {
            let value = self.rounded(node, standing.positions[node]);
            let source = if is_leg(&node) {
                format!("solved: sole level below the hip, knee bent by {} rad", standing.knee_bend)
            } else {
                "chosen: the arm hangs clear of the body".to_owned()
            };
            Noted { name: self.name(node), value, source }
        };
        let moves = |node: &NodeIndex| {
            !self.limbs.locked.contains_key(node)
                && self.rounded(*node, standing.positions[*node])
                    != self.rounded(*node, neutral[*node])
        };
        self.skeleton.moving().filter(moves).map(noted).collect()
    }

    fn locked(&self, neutral: &[f64]) -> Vec<Noted<f64>> {
        let noted = |(node, reason): (&NodeIndex, &&str)| Noted {
            name: self.name(*node),
            value: self.rounded(*node, neutral[*node]),
            source: (*reason).to_owned(),
        };
        self.limbs.locked.iter().map(noted).collect()
    }

    fn visual_shapes(&self, legs: &[DraftLeg; 2]) -> Vec<Noted<()>> {
        let noted = |node: NodeIndex, source: &str| Noted {
            name: self.skeleton.link_name(node).to_owned(),
            value: (),
            source: source.to_owned(),
        };
        let feet = legs.iter().flat_map(|leg| {
            let has_balls = self.shapes.has_collision(self.skeleton, leg.body);
            let source = if has_balls {
                "balls as <collision> carry at points alone"
            } else {
                "the foot has no <collision>"
            };
            let nodes = self.shapes.visual_nodes(self.skeleton, leg.body);
            nodes.into_iter().map(move |node| noted(node, source))
        });
        let ankles = legs.iter().flat_map(|leg| self.ankles_in_place_of(leg));
        feet.chain(ankles.map(|node| noted(node, "its <collision> has the place of the foot's")))
            .collect()
    }

    /// The links above a foot without collision shapes whose own reach down to its sole: they hold
    /// the shapes of the foot.
    fn ankles_in_place_of(&self, leg: &DraftLeg) -> Vec<NodeIndex> {
        let is_bare = !self.shapes.has_collision(self.skeleton, leg.body);
        let above = leg.chain.last().and_then(|node| self.skeleton.nodes[*node].parent);
        let Some(body) = above.filter(|_| is_bare).map(|node| self.skeleton.body(node)) else {
            return Vec::new();
        };
        let poses = self.skeleton.poses(&vec![0.0; self.skeleton.nodes.len()]);
        let sole_from_body = (poses[leg.body] * leg.body_from_sole).inverse() * poses[body];
        let down = sole_from_body.rotation.inverse() * DVec3::NEG_Z;
        let depth = self.shapes.surface(self.skeleton, body).extent(down);
        if sole_from_body.translation.z - depth > FOOT_SHAPE_ABOVE_MAX {
            return Vec::new();
        }
        let mut nodes = self.skeleton.body_nodes(body);
        nodes.retain(|node| {
            let link = &self.urdf().links[self.skeleton.nodes[*node].urdf_link];
            !self.shapes.collision[*node].is_empty() && !link.visuals.is_empty()
        });
        nodes
    }

    /// The joints that move in a plan.
    fn planned(&self) -> impl Iterator<Item = NodeIndex> {
        let is_planned = |node: &NodeIndex| {
            !self.skeleton.is_mimic(*node) && !self.limbs.locked.contains_key(node)
        };
        self.skeleton.moving().filter(is_planned)
    }

    /// The links that go without a shape because its mesh file is missing.
    fn missing_meshes(&self) -> Vec<Noted<()>> {
        let noted = |link: usize| Noted {
            name: self.urdf().links[link].name.clone(),
            value: (),
            source: "their mesh files were not found: nothing keeps these links from colliding"
                .to_owned(),
        };
        links_without_meshes(self.urdf()).into_iter().map(noted).collect()
    }

    fn ranges(&self) -> Vec<Noted<[f64; 2]>> {
        let noted = |node: NodeIndex| {
            let value = missing_range(self.skeleton, node)?;
            let source = "estimated; the URDF states none".to_owned();
            Some(Noted { name: self.name(node), value, source })
        };
        self.planned().filter_map(noted).collect()
    }

    fn efforts(&self) -> Vec<Noted<f64>> {
        let noted = |node: NodeIndex| {
            let is_leg = self.heading.feet.chains.iter().flatten().any(|leg| *leg == node);
            let value = missing_effort(self.skeleton, node, is_leg)?;
            let source = "estimated from the robot's mass; the URDF states none".to_owned();
            Some(Noted { name: self.name(node), value: (10.0 * value).round() / 10.0, source })
        };
        self.planned().filter_map(noted).collect()
    }

    fn velocities(&self) -> Vec<Noted<f64>> {
        let noted = |node: NodeIndex| {
            let value = missing_velocity(self.skeleton, node)?;
            let source = "estimated; the URDF states none".to_owned();
            Some(Noted { name: self.name(node), value, source })
        };
        self.planned().filter_map(noted).collect()
    }

    fn inertias(&self) -> Vec<Noted<DVec3>> {
        let noted = |node: NodeIndex| {
            let value = missing_inertia(self.skeleton, self.shapes, node)?;
            let source = "estimated: a box of its mass around it; the URDF states 0".to_owned();
            Some(Noted { name: self.skeleton.link_name(node).to_owned(), value, source })
        };
        self.planned().filter_map(noted).collect()
    }
}
