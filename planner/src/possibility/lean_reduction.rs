//! Lean of a guide route: at each vertex the root leans no more than its edges ask for.

use crate::possibility::guide_route::GuideRoute;
use crate::possibility::leaning::Leaning;
use crate::possibility::root_vertex::{PostureId, RootVertex, UPRIGHT};
use crate::possibility::tuning::{LEAN_PASSES, POSTURE_CHANGE_COST};
use crate::possibility::vertex_candidates::StageContext;

/// Reduces the lean at the next vertex of a route, where edges still lead to it and on; `done`
/// counts the vertices in all passes. Returns `false` if all are done.
pub(crate) fn reduce_lean(route: &mut GuideRoute, context: &StageContext<'_>, done: usize) -> bool {
    let vertices = &mut route.vertices;
    let inner = vertices.len().saturating_sub(2);
    if done == LEAN_PASSES * inner {
        return false;
    }
    let index = 1 + done % inner;
    let [before, at, after] =
        [index - 1, index, index + 1].map(|index| vertices[index].root_vertex());
    vertices[index].posture = least_lean(Leaning(context), before, at, after);
    true
}

/// The posture of least lean and change at a vertex between two others, of its own, theirs and
/// the upright one, from which edges lead to both.
fn least_lean(
    leaning: Leaning<'_>,
    before: RootVertex,
    at: RootVertex,
    after: RootVertex,
) -> PostureId {
    let cost = |posture: &PostureId| {
        let crouch = leaning.crouch(*posture);
        let change = |near: RootVertex| crouch.distance(&leaning.crouch(near.posture));
        crouch.depth() + POSTURE_CHANGE_COST * (change(before) + change(after))
    };
    let leads_on = |posture: &PostureId| {
        let changed = RootVertex { posture: *posture, ..at };
        leaning.may_lean_between(before, changed) && leaning.may_lean_between(changed, after)
    };
    let least = cost(&at.posture);
    [UPRIGHT, before.posture, after.posture]
        .into_iter()
        .filter(|posture| cost(posture) < least && leads_on(posture))
        .min_by(|a, b| cost(a).total_cmp(&cost(b)))
        .unwrap_or(at.posture)
}
