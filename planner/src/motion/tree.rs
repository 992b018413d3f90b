//! Bidirectional tree search within one mode, in the mode's own coordinates (root, swing sole, free joints): the variant of
//! CBiRRT of [Grey 4.4.3] in which closed-form legs take the place of projection.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::{interpolate, rotation_distance, rotation_from_scaled_axis};

use crate::collision::FootState;
use crate::constraint::{Constraints, Rejection};
use crate::motion::single_mode::Problem;
use crate::motion::track::{State, Stretch, Swing, follow};
use crate::motion::workspace::{TreeNode, Workspace};
use crate::random::{Random, Stream};

/// Samples drawn in one search.
const SAMPLES_MAX: u32 = 160;
/// Waypoints added by one extension toward a sample.
const EXTENSION_MAX: usize = 24;
/// Metres that a radian counts in the metric: about the distance from the hip to a hand or a toe.
const METRES_PER_RADIAN: f64 = 0.35;
/// How far samples of the root leave the straight line between both ends, m.
const ROOT_SPREAD: f64 = 0.15;
/// How far samples of the root turn, rad.
const ROOT_TURN: f64 = 0.35;
/// How far samples of the swing sole leave the straight line, m.
const SOLE_SPREAD: f64 = 0.3;
/// How far samples of the swing sole turn, rad.
const SOLE_TURN: f64 = 0.5;
/// How far free joints leave the straight line, rad; only every other sample moves them.
const FREE_SPREAD: f64 = 0.6;

/// Connects two states; on success appends the waypoints after the first, the second one included, to the track.
///
/// # Errors
/// No connection within the bounds, or the last obstacle met.
pub fn connect(constraints: &Constraints, problem: &Problem, ends: [&State; 2], workspace: &mut Workspace) -> Result<(), Rejection> {
    for (tree, end) in workspace.trees.iter_mut().zip(ends) {
        tree.clear();
        tree.push(TreeNode { state: *end, parent: 0 });
    }
    let mut random = Random::new(problem.random.0, Stream::SingleMode, problem.random.1, u64::from(problem.failures));
    for sample in 0..SAMPLES_MAX {
        let growing = (sample % 2) as usize;
        let target = draw(constraints, problem, ends, &mut random);
        let Some(tip) = extend(constraints, problem, workspace, growing, &target) else { continue };
        let reached = workspace.trees[growing][tip].state;
        if let Some(met) = join(constraints, problem, workspace, 1 - growing, &reached) {
            let tips = if growing == 0 { [tip, met] } else { [met, tip] };
            return collect(workspace, tips);
        }
    }
    Err(Rejection::Discontinuous)
}

/// Grows a tree toward a target; answers the node at the tip, if any was added.
fn extend(constraints: &Constraints, problem: &Problem, workspace: &mut Workspace, tree: usize, target: &State) -> Option<usize> {
    let before = workspace.trees[tree].len();
    let near = nearest(&workspace.trees[tree], problem, target);
    grow(constraints, problem, workspace, tree, near, target, false).ok();
    (workspace.trees[tree].len() > before).then(|| workspace.trees[tree].len() - 1)
}

/// Grows a tree all the way to a state of the other; answers the node that stands there.
fn join(constraints: &Constraints, problem: &Problem, workspace: &mut Workspace, tree: usize, target: &State) -> Option<usize> {
    let near = nearest(&workspace.trees[tree], problem, target);
    grow(constraints, problem, workspace, tree, near, target, true).ok()?;
    Some(workspace.trees[tree].len() - 1)
}

fn grow(
    constraints: &Constraints,
    problem: &Problem,
    workspace: &mut Workspace,
    tree: usize,
    near: usize,
    target: &State,
    exact: bool,
) -> Result<(), Rejection> {
    let nodes = &mut workspace.trees[tree];
    let from = nodes[near].state;
    let stretch = Stretch { mode: &problem.mode, from: &from, to: target, exact, swing: Swing::Straight, swing_foot: FootState::Free };
    let mut parent = near as u32;
    let mut added = 0;
    let mut work = 0;
    let ending = follow(constraints, &stretch, &mut work, &mut |state| {
        let fits = nodes.len() < nodes.capacity();
        if fits {
            nodes.push(TreeNode { state: *state, parent });
            parent = (nodes.len() - 1) as u32;
            added += 1;
        }
        fits && (exact || added < EXTENSION_MAX)
    });
    workspace.work += work;
    ending.inspect_err(|&rejection| workspace.count(rejection))
}

/// The node nearest to a target in the search's metric; the first of several.
pub fn nearest(nodes: &[TreeNode], problem: &Problem, target: &State) -> usize {
    let distance = |node: &TreeNode| distance(problem, &node.state, target);
    let mut best = (0, f64::INFINITY);
    for (index, node) in nodes.iter().enumerate() {
        let d = distance(node);
        if d < best.1 {
            best = (index, d);
        }
    }
    best.0
}

fn distance(problem: &Problem, a: &State, b: &State) -> f64 {
    let pose = |x: &Pose, y: &Pose| x.translation.distance(y.translation) + METRES_PER_RADIAN * rotation_distance(x.rotation, y.rotation);
    let root = pose(&a.configuration.world_from_root, &b.configuration.world_from_root);
    let sole = problem.mode.swing().map_or(0.0, |limb| pose(&a.world_from_soles[limb], &b.world_from_soles[limb]));
    root + sole
}

/// A random target about the straight line between both ends.
fn draw(constraints: &Constraints, problem: &Problem, ends: [&State; 2], random: &mut Random) -> State {
    let share = random.uniform(0.0, 1.0);
    let mut state = *ends[0];
    let roots = ends.map(|end| end.configuration.world_from_root);
    let root = interpolate(&roots[0], &roots[1], share);
    state.configuration.world_from_root = scatter(&root, ROOT_SPREAD, 0.0, ROOT_TURN, random);
    if let Some(limb) = problem.mode.swing() {
        let sole = interpolate(&ends[0].world_from_soles[limb], &ends[1].world_from_soles[limb], share);
        state.world_from_soles[limb] = scatter(&sole, SOLE_SPREAD, 0.5 * SOLE_SPREAD, SOLE_TURN, random);
    }
    let moves_free = random.below(2) == 1;
    for joint in &constraints.body.free_joints {
        let [from, to] = ends.map(|end| end.configuration.q[joint.index]);
        let stray = if moves_free { random.uniform(-FREE_SPREAD, FREE_SPREAD) } else { 0.0 };
        state.configuration.q[joint.index] = (from + share * (to - from) + stray).clamp(joint.lower, joint.upper);
    }
    state
}

fn scatter(pose: &Pose, spread: f64, raise: f64, turn: f64, random: &mut Random) -> Pose {
    let mut vector = |half: f64| DVec3::from_array(std::array::from_fn(|_| random.uniform(-half, half)));
    let offset = vector(spread) + DVec3::Z * raise;
    let rotation = rotation_from_scaled_axis(vector(turn)) * pose.rotation;
    Pose::from_parts(pose.translation + offset, rotation.normalize())
}

/// Appends the way from the first tree's root over both tips to the second tree's root. Both tips are the same state.
fn collect(workspace: &mut Workspace, tips: [usize; 2]) -> Result<(), Rejection> {
    let Workspace { track, trees, .. } = workspace;
    let begins = track.len();
    let mut at = tips[0];
    while at != 0 {
        if track.len() == track.capacity() {
            return Err(Rejection::Discontinuous);
        }
        track.push(trees[0][at].state.configuration);
        at = trees[0][at].parent as usize;
    }
    track[begins..].reverse();
    let mut at = tips[1];
    while at != 0 {
        at = trees[1][at].parent as usize;
        if track.len() == track.capacity() {
            return Err(Rejection::Discontinuous);
        }
        track.push(trees[1][at].state.configuration);
    }
    Ok(())
}
