//! The part of a support that a rigid foot holds without tilting far.
//!
//! A sole rests on the highest points under it. It reaches lower ones by tilting about those, and
//! the robot tilts with it: its centre of mass moves by its height times the tilt. Where the foot
//! tilts from one point to the next along a direction, the centre of mass may be as far as the new
//! point less that motion.

use glam::{DVec2, DVec3};

use crate::geometry::polygon::{convex_hull, edges, outward_sides};

/// Directions of tilt that are examined, in addition to those across the sides of the support and
/// of the points that hold in these directions.
const DIRECTIONS: usize = 64;
/// Most directions of either kind.
const DIRECTIONS_MAX: usize = 96;
/// The largest tilt of a resting foot, rad.
const TILT_MAX: f64 = 0.02;
/// Times that the corners between these directions are examined.
const CORNER_ROUNDS_MAX: usize = 4;
/// Less than this is not cut off a corner, m.
const CORNER_CUT_MIN: f64 = 5e-4;
/// Points lower than the highest by more do not touch the foot, m.
const TOUCH_GAP_MAX: f64 = 1.5e-3;
/// Points lower than the highest by more are not those on which a foot rests, m.
const REST_GAP_MAX: f64 = 2e-4;
/// Points that differ less in height are level, m.
const LEVEL_MAX: f64 = 1e-7;
/// Points nearer to each other along a direction are one, m.
const ADVANCE_MIN: f64 = 1e-6;

/// Distance (m) from the outline of a sole up to which a side of its support lies on it.
const ON_OUTLINE_MAX: f64 = 1e-4;

/// A point of the ground under a sole, in the sole frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroundPoint {
    /// Its position, m.
    pub(crate) at: DVec3,
    /// How much lower a foot may find it that lands beside its place, m. Ground that does not carry
    /// may obstruct it as high as it is.
    pub(crate) drop: f64,
    /// Whether the ground there carries.
    pub(crate) is_carrying: bool,
}

/// Clips the support `hull` (counter-clockwise, sole frame) of a foot on `ground` to the part that
/// holds a centre of mass at `height` (m), both where the foot lands in its place and where it
/// finds the ground lower. `spare` is a buffer, the points of `ground` are changed. A level ground
/// clips nothing.
pub(crate) fn clip_to_held(
    hull: &mut Vec<DVec2>,
    spare: &mut Vec<DVec2>,
    ground: &mut [GroundPoint],
    height: f64,
) {
    let highest = top(ground);
    let is_level =
        |point: &GroundPoint| point.at.z >= highest - LEVEL_MAX && point.drop <= LEVEL_MAX;
    if ground.iter().all(is_level) {
        return;
    }
    let count = join(ground);
    let ground = &mut ground[..count];
    clip_to_touched(hull, spare, ground, height);
    // What does not carry obstructs a foot wherever it may be.
    let lowered = ground.iter_mut().filter(|point| point.is_carrying);
    lowered.for_each(|point| point.at.z -= point.drop);
    clip_to_touched(hull, spare, ground, height);
}

/// Whether a foot whose load is at `middle` (sole frame, m) tilts on `ground`: the points that it
/// touches do not surround the load. On ground of one height it does not.
pub(crate) fn tilts(ground: &[GroundPoint], middle: DVec2) -> bool {
    let lowest = top(ground) - REST_GAP_MAX;
    let touches = |point: &&GroundPoint| point.at.z >= lowest;
    if ground.iter().all(|point| touches(&point)) {
        return false;
    }
    !surround(ground.iter().filter(touches).map(|point| point.at.truncate() - middle))
}

/// Whether vectors point to all sides: no half plane has all of them.
fn surround(mut directions: impl Iterator<Item = DVec2>) -> bool {
    let Some(first) = directions.next() else { return false };
    // The cone from `right` to `left` that holds those so far.
    let (mut right, mut left) = (first, first);
    for direction in directions {
        let [from_right, from_left] = [right, left].map(|side| side.perp_dot(direction));
        match (from_right < 0.0, from_left > 0.0) {
            (false, false) if right.dot(direction) >= 0.0 || left.dot(direction) >= 0.0 => {}
            (false, true) => left = direction,
            (true, false) => right = direction,
            _ => return true,
        }
    }
    false
}

/// The height of the highest point, m.
fn top(ground: &[GroundPoint]) -> f64 {
    ground.iter().map(|point| point.at.z).fold(f64::NEG_INFINITY, f64::max)
}

/// Clips the support to the part that is held by the points which a foot may touch. The order of
/// the points changes.
fn clip_to_touched(
    hull: &mut Vec<DVec2>,
    spare: &mut Vec<DVec2>,
    ground: &mut [GroundPoint],
    height: f64,
) {
    let ground = touched(ground);
    let around = (0..DIRECTIONS).map(|k| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / DIRECTIONS as f64);
        DVec2::new(cos, sin)
    });
    let directions: heapless::Vec<DVec2, DIRECTIONS_MAX> =
        around.chain(outward_sides(hull).map(|(normal, _)| normal)).take(DIRECTIONS_MAX).collect();
    let mut held: heapless::Vec<DVec2, DIRECTIONS_MAX> = heapless::Vec::new();
    for &direction in &directions {
        let (reach, at) = reach(ground, direction, height);
        held.extend(reach.is_finite().then_some(at));
        clip_beyond(hull, spare, direction, reach);
    }
    convex_hull(&mut held, spare);
    let between: heapless::Vec<DVec2, DIRECTIONS_MAX> =
        outward_sides(spare).map(|(normal, _)| normal).take(DIRECTIONS_MAX).collect();
    for direction in between {
        clip_beyond(hull, spare, direction, reach(ground, direction, height).0);
    }
    for _ in 0..CORNER_ROUNDS_MAX {
        if !cut_corners(hull, spare, ground, height) {
            break;
        }
    }
}

/// Clips the support across its corners, in the middle between the directions of their sides.
/// Whether something of it was cut off.
fn cut_corners(
    hull: &mut Vec<DVec2>,
    spare: &mut Vec<DVec2>,
    ground: &[GroundPoint],
    height: f64,
) -> bool {
    let sides: heapless::Vec<DVec2, DIRECTIONS_MAX> =
        outward_sides(hull).map(|(normal, _)| normal).take(DIRECTIONS_MAX).collect();
    let mut is_cut = false;
    for (before, after) in edges(&sides) {
        let direction = (before + after).normalize_or_zero();
        let (reach, _) = reach(ground, direction, height);
        let corner = hull.iter().map(|at| direction.dot(*at)).fold(f64::NEG_INFINITY, f64::max);
        if reach < corner - CORNER_CUT_MIN {
            clip_beyond(hull, spare, direction, reach);
            is_cut = true;
        }
    }
    is_cut
}

/// Moves the points that are near enough to the highest to the front.
fn touched(ground: &mut [GroundPoint]) -> &[GroundPoint] {
    let lowest = top(ground) - TOUCH_GAP_MAX;
    let mut count = 0;
    for index in 0..ground.len() {
        if ground[index].at.z >= lowest {
            ground.swap(count, index);
            count += 1;
        }
    }
    &ground[..count]
}

/// Keeps the part of a support (counter-clockwise, sole frame) that is `inset` (m) inside the edges
/// of the ground: the sides beyond which a corner of the sole lies, all of them without `corners`.
/// `spare` is a buffer.
pub(crate) fn keep_from_ground_edges(
    hull: &mut Vec<DVec2>,
    spare: &mut Vec<DVec2>,
    corners: Option<impl Iterator<Item = DVec2> + Clone>,
    inset: f64,
) {
    let extends_beyond = |(normal, offset): &(DVec2, f64)| {
        let is_beyond = |corner: DVec2| normal.dot(corner) > offset + ON_OUTLINE_MAX;
        corners.as_ref().is_none_or(|corners| corners.clone().any(is_beyond))
    };
    let edges: heapless::Vec<(DVec2, f64), DIRECTIONS_MAX> =
        outward_sides(hull).filter(extends_beyond).take(DIRECTIONS_MAX).collect();
    for (normal, offset) in edges {
        clip_beyond(hull, spare, normal, offset - inset);
    }
}

/// Moves the distinct places of the points to the front and returns their number. A corner of
/// several faces carries if one of them does: a foot touches a peak from its gentlest side. A foot
/// that lands beside it may land on the steepest of them.
fn join(ground: &mut [GroundPoint]) -> usize {
    let by_place = |a: &GroundPoint, b: &GroundPoint| {
        let axes = [0, 1, 2].map(|axis| a.at[axis].total_cmp(&b.at[axis]));
        let place = axes[0].then(axes[1]).then(axes[2]);
        place.then(b.is_carrying.cmp(&a.is_carrying)).then(a.drop.total_cmp(&b.drop))
    };
    ground.sort_unstable_by(by_place);
    let mut count = 0;
    for index in 0..ground.len() {
        if count == 0 || ground[count - 1].at != ground[index].at {
            ground[count] = ground[index];
            count += 1;
        } else {
            ground[count - 1].drop = ground[count - 1].drop.max(ground[index].drop);
        }
    }
    count
}

/// How far along a direction the foot holds a centre of mass, m, and such a place; minus infinity
/// if nothing carries.
fn reach(ground: &[GroundPoint], direction: DVec2, height: f64) -> (f64, DVec2) {
    let along = |point: &GroundPoint| direction.dot(point.at.truncate());
    let last = ground.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
    let mut best = (f64::NEG_INFINITY, DVec2::ZERO);
    let Some(mut pivot) = highest(ground, along) else { return best };
    if pivot.is_carrying {
        best = (along(pivot), pivot.at.truncate());
    }
    while let Some((tilt, next)) = next_pivot(ground, along, pivot) {
        if tilt > TILT_MAX || last - height * tilt <= best.0 {
            break;
        }
        let reach = along(next) - height * tilt;
        if next.is_carrying && reach > best.0 {
            best = (reach, next.at.truncate() - height * tilt * direction);
        }
        pivot = next;
    }
    best
}

/// The highest point; of several the furthest, and one that carries before others.
fn highest(ground: &[GroundPoint], along: impl Fn(&GroundPoint) -> f64) -> Option<&GroundPoint> {
    let highest = top(ground);
    let level = ground.iter().filter(|point| point.at.z >= highest - LEVEL_MAX);
    level.max_by(|a, b| along(a).total_cmp(&along(b)).then(a.is_carrying.cmp(&b.is_carrying)))
}

/// The point that a foot touches next when it tilts about `pivot`, and the tilt from level, rad.
fn next_pivot<'a>(
    ground: &'a [GroundPoint],
    along: impl Fn(&GroundPoint) -> f64,
    pivot: &GroundPoint,
) -> Option<(f64, &'a GroundPoint)> {
    let beyond = ground.iter().filter_map(|point| {
        let advance = along(point) - along(pivot);
        (advance > ADVANCE_MIN).then(|| ((pivot.at.z - point.at.z) / advance, point))
    });
    beyond.min_by(|(a, p), (b, q)| {
        let carrying_first = || q.is_carrying.cmp(&p.is_carrying);
        a.total_cmp(b).then_with(|| along(q).total_cmp(&along(p))).then_with(carrying_first)
    })
}

/// Keeps the part of a convex polygon with `direction . point <= reach`.
fn clip_beyond(hull: &mut Vec<DVec2>, spare: &mut Vec<DVec2>, direction: DVec2, reach: f64) {
    spare.clear();
    for (a, b) in edges(hull) {
        let (inside_a, inside_b) = (reach - direction.dot(a), reach - direction.dot(b));
        if inside_a >= 0.0 {
            spare.push(a);
        }
        if (inside_a >= 0.0) != (inside_b >= 0.0) {
            spare.push(a + (b - a) * (inside_a / (inside_a - inside_b)));
        }
    }
    std::mem::swap(hull, spare);
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHT: f64 = 0.8;

    fn point(x: f64, y: f64, z: f64) -> GroundPoint {
        GroundPoint { at: DVec3::new(x, y, z), drop: 0.0, is_carrying: true }
    }

    /// The extent along x of the held part of a sole of 0.2 m by 0.1 m.
    fn held(ground: &[GroundPoint]) -> [f64; 2] {
        let mut ground = ground.to_vec();
        let mut hull =
            [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)].map(DVec2::from).to_vec();
        clip_to_held(&mut hull, &mut Vec::new(), &mut ground, HEIGHT);
        hull.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at.x), high.max(at.x)]
        })
    }

    fn rows(heights: &[(f64, f64)]) -> Vec<GroundPoint> {
        heights.iter().flat_map(|&(x, z)| [-0.05, 0.05].map(|y| point(x, y, z))).collect()
    }

    #[test]
    fn level_ground_holds_the_whole_support() {
        assert_eq!(held(&rows(&[(-0.1, 3e-4), (0.1, 3e-4)])), [-0.1, 0.1]);
    }

    #[test]
    fn a_lower_edge_holds_less_by_the_height_times_the_tilt() {
        // From x = 0 the ground falls by 0.5 mm over 0.1 m: a tilt of 5 mrad.
        let [low, high] = held(&rows(&[(-0.1, 0.0), (0.0, 0.0), (0.1, -5e-4)]));
        assert!((low + 0.1).abs() < 1e-12, "{low}");
        assert!((high - (0.1 - HEIGHT * 5e-3)).abs() < 1e-12, "{high}");
    }

    #[test]
    fn a_ridge_holds_itself_only_if_the_ground_beside_it_is_steep() {
        let [low, high] = held(&rows(&[(-0.1, -3e-3), (-0.01, 0.0), (0.01, 0.0), (0.1, -3e-3)]));
        assert!((low + 0.01).abs() < 1e-12 && (high - 0.01).abs() < 1e-12, "{low} {high}");
    }

    #[test]
    fn a_rib_tips_the_foot_and_one_that_cannot_carry_leaves_nothing() {
        let mut ground = rows(&[(-0.1, -4e-4), (0.0, 0.0), (0.1, -4e-4)]);
        let [low, high] = held(&ground);
        let wanted = 0.1 - HEIGHT * 4e-3;
        assert!((low + wanted).abs() < 1e-12 && (high - wanted).abs() < 1e-12, "{low} {high}");
        ground.iter_mut().filter(|at| at.at.x == 0.0).for_each(|rib| rib.is_carrying = false);
        assert_eq!(held(&ground), [f64::INFINITY, f64::NEG_INFINITY]);
    }

    #[test]
    fn a_support_keeps_from_the_edges_of_the_ground_and_not_from_those_of_the_sole() {
        let outline = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)].map(DVec2::from);
        let kept = |support: &[DVec2]| {
            let mut hull = support.to_vec();
            keep_from_ground_edges(&mut hull, &mut Vec::new(), Some(outline.iter().copied()), 4e-3);
            hull
        };
        assert_eq!(kept(&outline), outline);
        let half =
            kept(&[(-0.1, -0.05), (0.02, -0.05), (0.02, 0.05), (-0.1, 0.05)].map(DVec2::from));
        let last = half.iter().map(|corner| corner.x).fold(f64::NEG_INFINITY, f64::max);
        assert_eq!(half.len(), 4);
        assert!((last - 0.016).abs() < 1e-12, "{last}");
        let strip = [(-3e-3, -0.05), (3e-3, -0.05), (3e-3, 0.05), (-3e-3, 0.05)].map(DVec2::from);
        assert!(kept(&strip).is_empty());
    }

    #[test]
    fn a_corner_of_several_faces_lies_as_low_as_beside_the_steepest() {
        let level = rows(&[(-0.1, 0.0), (0.1, 0.0)]);
        let lower = |drop: f64| move |point: &GroundPoint| GroundPoint { drop, ..*point };
        let beside = level.iter().filter(|point| point.at.x > 0.0).map(lower(5e-4));
        let [_, high] = held(&level.iter().copied().chain(beside).collect::<Vec<_>>());
        assert!((high - (0.1 - HEIGHT * 2.5e-3)).abs() < 1e-12, "{high}");
    }

    #[test]
    fn a_point_out_of_touch_holds_nothing() {
        let [low, high] = held(&rows(&[(-0.1, 0.0), (0.0, 0.0), (0.1, -1.6e-3)]));
        assert!((low + 0.1).abs() < 1e-12 && high.abs() < 1e-12, "{low} {high}");
    }

    #[test]
    fn a_foot_that_lands_beside_its_place_finds_all_but_obstacles_lower() {
        // In its place, the foot stands on the row at x = 0.08; beside it, on the steep tip.
        let mut ground = rows(&[(-0.1, 0.0), (0.08, -4e-4), (0.1, -1e-3)]);
        let wanted = 0.08 - HEIGHT * 4e-4 / 0.18;
        ground.iter_mut().filter(|at| at.at.x > 0.09).for_each(|tip| tip.is_carrying = false);
        assert!((held(&ground)[1] - wanted).abs() < 1e-12);
        ground.iter_mut().filter(|at| at.at.x > 0.0).for_each(|at| at.drop = 7e-4);
        assert!((held(&ground)[1] + 0.1).abs() < 1e-12, "{:?}", held(&ground));
    }

    #[test]
    fn a_peak_carries_if_one_of_its_faces_does() {
        let mut ground = rows(&[(-0.1, 0.0), (0.0, 0.0), (0.1, -1e-3)]);
        let wanted = held(&ground);
        for point in ground.clone() {
            ground.push(GroundPoint { is_carrying: false, ..point });
        }
        assert_eq!(held(&ground), wanted);
        let steep = GroundPoint { is_carrying: false, ..point(0.05, 0.0, 0.0) };
        let [_, high] = held(&[ground, vec![steep]].concat());
        assert!(high < wanted[1], "{high} {wanted:?}");
    }

    #[test]
    fn a_foot_tilts_where_what_it_touches_lies_on_one_side() {
        // Its sides are 0.2 m and 0.1 m long; it touches where it is highest.
        let plane = |slope: DVec2| -> Vec<GroundPoint> {
            let corners = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)];
            let height = |x: f64, y: f64| slope.dot(DVec2::new(x, y));
            corners.map(|(x, y)| point(x, y, height(x, y))).to_vec()
        };
        assert!(!tilts(&plane(DVec2::ZERO), DVec2::ZERO));
        assert!(tilts(&plane(DVec2::new(5e-3, 0.0)), DVec2::ZERO), "it touches an edge");
        assert!(tilts(&plane(DVec2::new(5e-3, 3e-3)), DVec2::ZERO), "it touches a corner");
        let on_three = |x: f64| {
            let feet = [point(-0.1, 0.0, 0.0), point(x, -0.05, 0.0), point(x, 0.05, -1e-4)];
            [&feet[..], &plane(DVec2::ZERO).into_iter().map(lower).collect::<Vec<_>>()].concat()
        };
        assert!(!tilts(&on_three(0.02), DVec2::ZERO));
        assert!(tilts(&on_three(-0.02), DVec2::ZERO), "the load is beside the three");
        assert!(!tilts(&on_three(-0.02), DVec2::new(-0.05, 0.0)));
    }

    fn lower(point: GroundPoint) -> GroundPoint {
        GroundPoint { at: point.at - 1e-3 * DVec3::Z, ..point }
    }

    #[test]
    fn directions_surround_if_no_half_plane_has_all_of_them() {
        let towards = |angles: &[f64]| {
            let unit = |angle: &f64| {
                let (sin, cos) = libm::sincos(angle.to_radians());
                DVec2::new(cos, sin)
            };
            let forward = surround(angles.iter().map(unit));
            assert_eq!(forward, surround(angles.iter().rev().map(unit)), "{angles:?}");
            forward
        };
        assert!(!towards(&[]) && !towards(&[10.0]) && !towards(&[10.0, 10.0, 150.0]));
        assert!(!towards(&[0.0, 90.0, 170.0, 45.0]));
        assert!(towards(&[0.0, 120.0, 240.0]) && towards(&[10.0, 100.0, 189.0, 300.0]));
        assert!(!towards(&[200.0, 350.0, 270.0]));
        assert!(towards(&[200.0, 350.0, 270.0, 90.0]));
    }
}
