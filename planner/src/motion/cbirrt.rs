//! CBiRRT: bidirectional tree search within one mode (Berenson 2009) [Grey 4.4.3].
//!
//! The search space is that of the mode: root pose, swing sole pose, free joints. Inverse
//! kinematics of the legs takes the place of constrained projection.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{
    interpolate, rotation_distance, rotation_from_scaled_axis,
};

use crate::base::random::{Random, Stream};
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::{LocalPath, Progress};
use crate::motion::swing_shapes::MotionShape;
use crate::motion::tree_pool::TreeNode;
use crate::motion::tuning::{
    DOUBLINGS_MAX, EXTENSION_WAYPOINTS_MAX, FREE_JOINT_SPREAD, GROWTH_FROM, METRES_PER_RADIAN,
    RANDOM_NODE_EVERY, ROOT_SPREAD, ROOT_TURN_SPREAD, SAMPLES_DOUBLE_EVERY, SOLE_SPREAD,
    SOLE_TURN_SPREAD, TREE_SAMPLES_LIMIT, TREE_SAMPLES_MAX,
};
use crate::motion::workspace::{Workspace, push};

/// A query for a motion within one mode.
#[derive(Debug, Clone)]
pub struct SingleModeProblem {
    /// The mode.
    pub mode: Mode,
    /// The state at the beginning of the motion.
    pub from: ModeState,
    /// The state at its end.
    pub to: ModeState,
    /// The seed, and the name of this search in the random stream.
    pub random: (u64, u64),
    /// Number of searches for this motion that failed before.
    pub failures: u32,
}

/// The search: two trees grow toward each other. They are kept for the next search.
#[derive(Debug, Clone)]
pub struct Cbirrt {
    random: Random,
    sample: u32,
    samples_max: u32,
    /// The tree that grows, 0 or 1; the trees alternate from sample to sample.
    side: usize,
    goal: ExtensionGoal,
    /// The node that becomes the parent of the next waypoint.
    parent: u32,
    /// Waypoints added toward the current goal.
    added: u32,
}

#[derive(Debug, Clone, Copy)]
enum ExtensionGoal {
    /// The next sample is to be drawn.
    Choose,
    /// Extending a tree toward the sample.
    Sample,
    /// Connecting the other tree to the tip of the first.
    Tip(u32),
}

impl Cbirrt {
    /// A search that has drawn no sample.
    pub fn new(problem: &SingleModeProblem) -> Self {
        let random = Random::new(
            problem.random.0,
            Stream::SingleMode,
            problem.random.1,
            u64::from(problem.failures),
        );
        Self {
            random,
            sample: 0,
            samples_max: samples_max(problem.failures),
            side: 0,
            goal: ExtensionGoal::Choose,
            parent: 0,
            added: 0,
        }
    }

    /// Number of samples toward which a tree was extended.
    pub fn extensions(&self) -> u32 {
        self.sample
    }

    /// Spends one work unit. Returns `true` once the trees are connected: `workspace.path` then
    /// holds the waypoints after the first end, the second end included.
    ///
    /// # Errors
    /// The rejection of the last extension, once all samples are spent without a connection.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        problem: &SingleModeProblem,
        ends: &[ModeState; 2],
        workspace: &mut Workspace,
    ) -> Result<bool, Rejection> {
        if !workspace.local_planner.is_active() {
            root_trees(ends, workspace);
            self.choose(constraints, problem, ends, workspace);
            return Ok(false);
        }
        let progress = workspace.local_planner.advance(constraints, &problem.mode);
        let extended = progress.and_then(|progress| match progress {
            Progress::ShorterStep => Ok(progress),
            _ => self.add(workspace).map(|()| progress),
        });
        match (self.goal, extended) {
            (_, Ok(Progress::ShorterStep)) => Ok(false),
            (ExtensionGoal::Tip(tip), Ok(Progress::Reached)) => {
                self.join_paths(tip, workspace).map(|()| true)
            }
            (ExtensionGoal::Tip(_), Ok(_)) => Ok(false),
            (ExtensionGoal::Tip(_), Err(rejection)) => self.next_sample(rejection, workspace),
            (_, Ok(Progress::Waypoint)) if self.added < EXTENSION_WAYPOINTS_MAX => Ok(false),
            (_, Err(rejection)) if self.added == 0 => self.next_sample(rejection, workspace),
            _ => {
                self.connect_to_tip(constraints, problem, workspace);
                Ok(false)
            }
        }
    }

    /// Draws a sample and begins to extend a tree toward it.
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

    /// Begins to extend the other tree toward the tip of this one.
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

    /// Begins to extend the tree from its node nearest to the target.
    fn begin_extension(
        &mut self,
        constraints: &Constraints,
        problem: &SingleModeProblem,
        target: &ModeState,
        goal: ExtensionGoal,
        workspace: &mut Workspace,
    ) {
        let tree = &workspace.trees[self.side];
        let is_random = matches!(goal, ExtensionGoal::Sample)
            && box_scale(problem.failures) > 1.0
            && self.random.below(RANDOM_NODE_EVERY) == 0;
        let near =
            if is_random { self.random.below(tree.len()) } else { nearest(tree, problem, target) };
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

    /// Adds the state that was reached as a node.
    fn add(&mut self, workspace: &mut Workspace) -> Result<(), Rejection> {
        let tree = &mut workspace.trees[self.side];
        push(tree, TreeNode { state: *workspace.local_planner.state(), parent: self.parent })?;
        self.parent = (tree.len() - 1) as u32;
        self.added += 1;
        Ok(())
    }

    /// Continues with the next sample after a rejection.
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

    /// Writes the path from the root of the first tree over both tips, which are the same state, to
    /// the root of the second tree.
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

/// Adds the root to each tree that is empty. A tree that is full begins anew.
fn root_trees(ends: &[ModeState; 2], workspace: &mut Workspace) {
    for (tree, end) in workspace.trees.iter_mut().zip(ends) {
        if tree.len() == tree.capacity() {
            tree.clear();
        }
        if tree.is_empty() {
            tree.push(TreeNode { state: *end, parent: 0 });
        }
    }
}

/// The nodes from `node` to the root, the root excluded.
fn path_to_root(tree: &[TreeNode], node: u32) -> impl Iterator<Item = &TreeNode> {
    let above =
        |&at: &u32| (at != 0).then(|| tree[at as usize].parent).filter(|&parent| parent != 0);
    std::iter::successors(Some(node).filter(|&at| at != 0), above).map(|at| &tree[at as usize])
}

/// The node nearest to a target in the metric of the search; the first of several. Rotations are
/// compared only if the translations alone are nearer than the best node.
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

/// The metric of the search, m: the sum of the distances of root and swing sole, where `apart` is
/// the distance of two poses.
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

/// Distance of two positions, m.
fn shift(x: &Pose, y: &Pose) -> f64 {
    x.translation.distance(y.translation)
}

/// Distance of two poses, m; a radian counts [`METRES_PER_RADIAN`].
fn shift_and_turn(x: &Pose, y: &Pose) -> f64 {
    shift(x, y) + METRES_PER_RADIAN * rotation_distance(x.rotation, y.rotation)
}

/// The number of samples of a search after this many failed ones.
fn samples_max(failures: u32) -> u32 {
    let first = TREE_SAMPLES_MAX[(failures as usize).min(TREE_SAMPLES_MAX.len() - 1)];
    let doublings = (failures / SAMPLES_DOUBLE_EVERY).min(u32::BITS / 2);
    (first << doublings).min(TREE_SAMPLES_LIMIT)
}

/// By how much the boxes of the samples are larger after this many failed searches.
fn box_scale(failures: u32) -> f64 {
    let grown = failures.saturating_sub(GROWTH_FROM) % (DOUBLINGS_MAX + 1);
    f64::from(1u32 << grown)
}

/// A random state near the straight line between both ends.
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
    let scale = box_scale(problem.failures);
    let [root_spread, sole_spread] =
        [ROOT_SPREAD, SOLE_SPREAD].map(|spread| scale * spread * constraints.robot.legs[0].reach());
    let is_raised = problem.mode.swing().is_some() && scale == 1.0;
    let raise = if is_raised { root_spread } else { 0.0 };
    state.configuration.world_from_root =
        sample_near(&root, root_spread, raise, scale * ROOT_TURN_SPREAD, random);
    if let Some(limb) = problem.mode.swing() {
        let sole =
            interpolate(&ends[0].world_from_soles[limb], &ends[1].world_from_soles[limb], share);
        state.world_from_soles[limb] =
            sample_near(&sole, sole_spread, 0.5 * sole_spread, scale * SOLE_TURN_SPREAD, random);
    }
    let moves_free = random.below(2) == 1;
    for joint in &constraints.robot.free_joints {
        let [from, to] = ends.map(|end| end.configuration.q[joint.index]);
        let between = from + share * (to - from);
        state.configuration.q[joint.index] = if moves_free && joint.is_sampled {
            free_position(between, scale, [joint.lower, joint.upper], random)
        } else {
            between.clamp(joint.lower, joint.upper)
        };
    }
    state
}

/// A random position of a free joint near another, within its limits. With a grown box all
/// positions that are both near and within the limits are equally likely.
fn free_position(between: f64, scale: f64, [lower, upper]: [f64; 2], random: &mut Random) -> f64 {
    let spread = scale * FREE_JOINT_SPREAD;
    if scale > 1.0 {
        return random.uniform((between - spread).max(lower), (between + spread).min(upper));
    }
    (between + random.uniform(-spread, spread)).clamp(lower, upper)
}

/// A random pose within a box of half width `spread` about a pose that is raised by `raise` (m),
/// turned by at most `turn` about each axis (rad).
fn sample_near(pose: &Pose, spread: f64, raise: f64, turn: f64, random: &mut Random) -> Pose {
    let mut vector =
        |half: f64| DVec3::from_array(std::array::from_fn(|_| random.uniform(-half, half)));
    let offset = vector(spread) + DVec3::Z * raise;
    let rotation = rotation_from_scaled_axis(vector(turn)) * pose.rotation;
    Pose::from_parts(pose.translation + offset, rotation.normalize())
}
