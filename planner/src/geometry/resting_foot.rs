//! The part of a support that a rigid foot holds without tilting far.
//!
//! A sole rests on the highest points under it. It reaches lower ones by tilting about those, and
//! the robot tilts with it: its centre of mass moves by its height times the tilt. Where the foot
//! tilts from one point to the next along a direction, the centre of mass may be as far as the new
//! point less that motion.

use glam::{DVec2, DVec3};

use crate::geometry::polygon::{edges, outward_sides};

/// Directions of tilt that are examined first.
const DIRECTIONS: usize = 64;
/// Times that two of them are bisected in which the foot stands on different points: to 0.18
/// degrees, so that a side of 200 mm lies at most 0.3 mm off.
const BISECTIONS: u32 = 5;
/// Most sides of a support across which the tilt is examined.
const DIRECTIONS_MAX: usize = 96;
/// The largest tilt of a resting foot, rad.
const TILT_MAX: f64 = 0.02;
/// Points lower than the highest by more do not touch the foot, m: a little less than the 1.5 mm of
/// the checker, which finds the highest elsewhere.
const TOUCH_GAP_MAX: f64 = 1.4e-3;
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
    let across: heapless::Vec<DVec2, DIRECTIONS_MAX> =
        outward_sides(hull).map(|(normal, _)| normal).take(DIRECTIONS_MAX).collect();
    for direction in across {
        clip_beyond(hull, spare, direction, Reach::of(ground, direction, height).distance);
    }
    let along = |k: usize| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / DIRECTIONS as f64);
        Reach::of(ground, DVec2::new(cos, sin), height)
    };
    let mut last = along(0);
    for k in 1..=DIRECTIONS {
        let next = along(k);
        clip_beyond(hull, spare, next.direction, next.distance);
        clip_between(hull, spare, (ground, height), [&last, &next], BISECTIONS);
        last = next;
    }
}

/// Clips the support in directions between two in which the foot stands on different points: on the
/// side between these points both hold.
fn clip_between(
    hull: &mut Vec<DVec2>,
    spare: &mut Vec<DVec2>,
    (ground, height): (&[GroundPoint], f64),
    [one, other]: [&Reach; 2],
    bisections: u32,
) {
    if bisections == 0 || one.stands_on == other.stands_on {
        return;
    }
    let direction = (one.direction + other.direction).normalize_or_zero();
    let between = Reach::of(ground, direction, height);
    clip_beyond(hull, spare, direction, between.distance);
    clip_between(hull, spare, (ground, height), [one, &between], bisections - 1);
    clip_between(hull, spare, (ground, height), [&between, other], bisections - 1);
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

/// How far along a direction the foot holds a centre of mass.
struct Reach {
    direction: DVec2,
    /// In metres; minus infinity if nothing carries.
    distance: f64,
    /// The point on which the foot stands then, m.
    stands_on: DVec2,
}

impl Reach {
    fn of(ground: &[GroundPoint], direction: DVec2, height: f64) -> Self {
        let along = |point: &GroundPoint| direction.dot(point.at.truncate());
        let last = ground.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        let mut best = Self { direction, distance: f64::NEG_INFINITY, stands_on: DVec2::ZERO };
        let Some(mut pivot) = highest(ground, along) else { return best };
        if pivot.is_carrying {
            (best.distance, best.stands_on) = (along(pivot), pivot.at.truncate());
        }
        while let Some((tilt, next)) = next_pivot(ground, along, pivot) {
            if tilt > TILT_MAX || last - height * tilt <= best.distance {
                break;
            }
            let distance = along(next) - height * tilt;
            if next.is_carrying && distance > best.distance {
                (best.distance, best.stands_on) = (distance, next.at.truncate());
            }
            pivot = next;
        }
        best
    }
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
    fn a_gentle_face_beside_a_steep_one_stays_high_where_the_foot_lands_beside_its_place() {
        // The peak at x = 0 drops by 0.7 mm beside its steep face, the ground 3 mm from it on the
        // gentle one by less. Both ends are 0.3 mm lower, and drop, too.
        let mut ground = rows(&[(-0.1, -3e-4), (0.0, 0.0), (0.1, -3e-4)]);
        let is_peak = |point: &GroundPoint| point.at.x == 0.0;
        ground.iter_mut().for_each(|at| at.drop = if is_peak(at) { 7e-4 } else { 2e-4 });
        let alone = held(&ground)[1];
        let gentle = [-0.05, 0.05].map(|y| GroundPoint { drop: 5e-5, ..point(-3e-3, y, -1e-5) });
        let [_, high] = held(&[ground, gentle.to_vec()].concat());
        let wanted = 0.1 - HEIGHT * (5e-4 - 6e-5) / 0.103;
        assert!((high - wanted).abs() < 1e-12 && high < alone - 5e-4, "{high} {wanted} {alone}");
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
