//! Bidirectional tree search within one mode, in the mode's own coordinates (root, swing sole, free
//! joints): the variant of CBiRRT of [Grey 4.4.3] in which closed-form legs take the place of
//! projection.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{
    interpolate, rotation_distance, rotation_from_scaled_axis,
};

use crate::base::random::{Random, Stream};
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::{LocalPath, Progress};
use crate::motion::single_mode::SingleModeProblem;
use crate::motion::swing_shapes::MotionShape;
use crate::motion::tree_pool::TreeNode;
use crate::motion::workspace::{Workspace, push};

/// Samples drawn in the first search between two states, and in each later one; the trees are kept
/// for the next one. Few at first: most that is found at all is found soon, and another sequence
/// may be easier.
const SAMPLES_MAX: [u32; 2] = [36, 64];
/// Waypoints added by one extension toward a sample.
const EXTENSION_MAX: u32 = 24;
/// Metres that a radian counts in the metric: about the distance from the hip to a hand or a toe.
pub const METRES_PER_RADIAN: f64 = 0.35;
/// How far samples of the root leave the straight line between both ends, as a share of the leg's
/// reach; with a foot in the air they lie about a line that is as far above it, since a robot that
/// stands up has room for that foot.
const ROOT_SPREAD: f64 = 0.2;
/// How far samples of the root turn, rad.
const ROOT_TURN: f64 = 0.25;
/// How far samples of the swing sole leave the straight line, as a share of the leg's reach. Most
/// are out of reach, and lead the foot well around what is in its way.
const SOLE_SPREAD: f64 = 0.75;
/// How far samples of the swing sole turn, rad.
const SOLE_TURN: f64 = 0.5;
/// How far free joints leave the straight line, rad; only every other sample moves them.
const FREE_SPREAD: f64 = 0.6;

/// The growth of two trees toward one another.
#[derive(Debug, Clone)]
pub struct Cbirrt {
    random: Random,
    sample: u32,
    samples_max: u32,
    /// The tree that grows: after each sample it is the other's turn.
    side: usize,
    goal: ExtensionGoal,
    /// The node that the next waypoint hangs on.
    parent: u32,
    /// Waypoints added toward this aim.
    added: u32,
}

#[derive(Debug, Clone, Copy)]
enum ExtensionGoal {
    /// Choosing a sample.
    Choose,
    /// Growing toward the sample.
    Sample,
    /// Growing the other tree toward the tip of the first.
    Tip(u32),
}

impl Cbirrt {
    /// Begins.
    pub fn new(problem: &SingleModeProblem) -> Self {
        let random = Random::new(
            problem.random.0,
            Stream::SingleMode,
            problem.random.1,
            u64::from(problem.failures),
        );
        let samples_max = SAMPLES_MAX[(problem.failures as usize).min(SAMPLES_MAX.len() - 1)];
        Self {
            random,
            sample: 0,
            samples_max,
            side: 0,
            goal: ExtensionGoal::Choose,
            parent: 0,
            added: 0,
        }
    }

    /// How often it tried to extend a tree.
    pub fn extensions(&self) -> u32 {
        self.sample
    }

    /// Spends one unit of work; `true` once the trees meet: then the path holds the waypoints
    /// after the first end, the second one included.
    ///
    /// # Errors
    /// No connection with the last sample.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        problem: &SingleModeProblem,
        ends: &[ModeState; 2],
        workspace: &mut Workspace,
    ) -> Result<bool, Rejection> {
        if !workspace.local_planner.is_active() {
            root_trees(ends, workspace);
            if workspace.trees.iter().any(|tree| tree.len() == tree.capacity()) {
                return Err(Rejection::Discontinuous);
            }
            self.choose(constraints, problem, ends, workspace);
            return Ok(false);
        }
        let progress = workspace.local_planner.advance(constraints, &problem.mode);
        let grown = progress.and_then(|progress| match progress {
            Progress::ShorterStep => Ok(progress),
            _ => self.add(workspace).map(|()| progress),
        });
        match (self.goal, grown) {
            (_, Ok(Progress::ShorterStep)) => Ok(false),
            (ExtensionGoal::Tip(tip), Ok(Progress::Reached)) => {
                self.join_paths(tip, workspace).map(|()| true)
            }
            (ExtensionGoal::Tip(_), Ok(_)) => Ok(false),
            (ExtensionGoal::Tip(_), Err(rejection)) => self.next_sample(rejection, workspace),
            (_, Ok(Progress::Waypoint)) if self.added < EXTENSION_MAX => Ok(false),
            (_, Err(rejection)) if self.added == 0 => self.next_sample(rejection, workspace),
            _ => {
                self.connect_to_tip(constraints, problem, workspace);
                Ok(false)
            }
        }
    }

    fn choose(
        &mut self,
        constraints: &Constraints,
        problem: &SingleModeProblem,
        ends: &[ModeState; 2],
        workspace: &mut Workspace,
    ) {
        self.side = (self.sample % 2) as usize;
        let target = sample_target(constraints, problem, ends, &mut self.random);
        self.begin_extension(constraints, problem, &target, ExtensionGoal::Sample, workspace);
    }

    fn connect_to_tip(
        &mut self,
        constraints: &Constraints,
        problem: &SingleModeProblem,
        workspace: &mut Workspace,
    ) {
        let tip = self.parent;
        let target = workspace.trees[self.side][tip as usize].state;
        self.side = 1 - self.side;
        self.begin_extension(constraints, problem, &target, ExtensionGoal::Tip(tip), workspace);
    }

    fn begin_extension(
        &mut self,
        constraints: &Constraints,
        problem: &SingleModeProblem,
        target: &ModeState,
        goal: ExtensionGoal,
        workspace: &mut Workspace,
    ) {
        let tree = &workspace.trees[self.side];
        let near = nearest(tree, problem, target);
        (self.goal, self.parent, self.added) = (goal, near as u32, 0);
        let exact = matches!(goal, ExtensionGoal::Tip(_));
        let local_path = LocalPath {
            from: tree[near].state,
            to: *target,
            exact,
            shape: MotionShape::STRAIGHT,
            swing_foot: FootPhase::Swing,
        };
        workspace.local_planner.begin(constraints, &local_path);
    }

    fn add(&mut self, workspace: &mut Workspace) -> Result<(), Rejection> {
        let tree = &mut workspace.trees[self.side];
        push(tree, TreeNode { state: *workspace.local_planner.here(), parent: self.parent })?;
        self.parent = (tree.len() - 1) as u32;
        self.added += 1;
        Ok(())
    }

    fn next_sample(
        &mut self,
        rejection: Rejection,
        workspace: &mut Workspace,
    ) -> Result<bool, Rejection> {
        workspace.count(rejection);
        workspace.local_planner.stop();
        self.goal = ExtensionGoal::Choose;
        self.sample += 1;
        if self.sample < self.samples_max { Ok(false) } else { Err(rejection) }
    }

    /// Writes the way from the first tree's root over both tips, which are the same state, to the
    /// second tree's root.
    fn join_paths(&self, tip: u32, workspace: &mut Workspace) -> Result<(), Rejection> {
        let Workspace { path, trees, .. } = workspace;
        let tips = if self.side == 1 { [tip, self.parent] } else { [self.parent, tip] };
        path.clear();
        for node in path_to_root(&trees[0], tips[0]) {
            push(path, node.state.configuration)?;
        }
        path.reverse();
        for node in path_to_root(&trees[1], tips[1]).skip(1) {
            push(path, node.state.configuration)?;
        }
        push(path, trees[1][0].state.configuration)
    }
}

/// Roots each tree that is still empty at its end.
fn root_trees(ends: &[ModeState; 2], workspace: &mut Workspace) {
    for (tree, end) in workspace.trees.iter_mut().zip(ends) {
        if tree.is_empty() {
            tree.push(TreeNode { state: *end, parent: 0 });
        }
    }
}

/// The nodes from one up to the root, that one included and the root left out.
fn path_to_root(tree: &[TreeNode], node: u32) -> impl Iterator<Item = &TreeNode> {
    let above =
        |&at: &u32| (at != 0).then(|| tree[at as usize].parent).filter(|&parent| parent != 0);
    std::iter::successors(Some(node).filter(|&at| at != 0), above).map(|at| &tree[at as usize])
}

/// The node nearest to a target in the search's metric; the first of several. Turns are looked at
/// only where the shifts alone do not make a node too far.
pub fn nearest(nodes: &[TreeNode], problem: &SingleModeProblem, target: &ModeState) -> usize {
    let mut best = (0, f64::INFINITY);
    for (index, node) in nodes.iter().enumerate() {
        if distance(problem, &node.state, target, shift) >= best.1 {
            continue;
        }
        let d = distance(problem, &node.state, target, shift_and_turn);
        if d < best.1 {
            best = (index, d);
        }
    }
    best.0
}

/// The metric of the search, m: how far the root and the swing sole are apart, as `apart` says of
/// poses.
fn distance(
    problem: &SingleModeProblem,
    a: &ModeState,
    b: &ModeState,
    apart: impl Fn(&Pose, &Pose) -> f64,
) -> f64 {
    let root = apart(&a.configuration.world_from_root, &b.configuration.world_from_root);
    root + problem
        .mode
        .swing()
        .map_or(0.0, |limb| apart(&a.world_from_soles[limb], &b.world_from_soles[limb]))
}

fn shift(x: &Pose, y: &Pose) -> f64 {
    x.translation.distance(y.translation)
}

fn shift_and_turn(x: &Pose, y: &Pose) -> f64 {
    shift(x, y) + METRES_PER_RADIAN * rotation_distance(x.rotation, y.rotation)
}

/// A random target about the straight line between both ends.
fn sample_target(
    constraints: &Constraints,
    problem: &SingleModeProblem,
    ends: &[ModeState; 2],
    random: &mut Random,
) -> ModeState {
    let share = random.uniform(0.0, 1.0);
    let mut state = ends[0];
    let roots = ends.map(|end| end.configuration.world_from_root);
    let root = interpolate(&roots[0], &roots[1], share);
    let [root_spread, sole_spread] =
        [ROOT_SPREAD, SOLE_SPREAD].map(|spread| spread * constraints.robot.legs[0].reach());
    let raise = if problem.mode.swing().is_some() { root_spread } else { 0.0 };
    state.configuration.world_from_root = sample_near(&root, root_spread, raise, ROOT_TURN, random);
    if let Some(limb) = problem.mode.swing() {
        let sole =
            interpolate(&ends[0].world_from_soles[limb], &ends[1].world_from_soles[limb], share);
        state.world_from_soles[limb] =
            sample_near(&sole, sole_spread, 0.5 * sole_spread, SOLE_TURN, random);
    }
    let moves_free = random.below(2) == 1;
    for joint in &constraints.robot.free_joints {
        let [from, to] = ends.map(|end| end.configuration.q[joint.index]);
        let offset = if moves_free && joint.is_sampled {
            random.uniform(-FREE_SPREAD, FREE_SPREAD)
        } else {
            0.0
        };
        state.configuration.q[joint.index] =
            (from + share * (to - from) + offset).clamp(joint.lower, joint.upper);
    }
    state
}

fn sample_near(pose: &Pose, spread: f64, raise: f64, turn: f64, random: &mut Random) -> Pose {
    let mut vector =
        |half: f64| DVec3::from_array(std::array::from_fn(|_| random.uniform(-half, half)));
    let offset = vector(spread) + DVec3::Z * raise;
    let rotation = rotation_from_scaled_axis(vector(turn)) * pose.rotation;
    Pose::from_parts(pose.translation + offset, rotation.normalize())
}
