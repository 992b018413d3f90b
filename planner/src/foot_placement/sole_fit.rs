//! Shifts of a sole in a plane that bring it onto a face, wholly or as far as possible.

use glam::DVec2;

use crate::geometry::polygon::{HalfPlane, edges, inward_normal};

/// Distance outside a half-plane up to which a point counts as inside, m.
const FEASIBLE_SLACK: f64 = 1e-9;
/// Most sides of a face for which the nearest whole placement is computed exactly.
const SIDES_MAX: usize = 24;

/// The least and the greatest coordinate of points along a direction, m.
pub(crate) fn extent(points: impl Iterator<Item = DVec2>, direction: DVec2) -> [f64; 2] {
    points
        .map(|p| p.dot(direction))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, u], x| [l.min(x), u.max(x)])
}

/// The unit direction across the narrowest extent of an outline, perpendicular to one of its sides.
pub(crate) fn narrowest_direction(outline: &[DVec2]) -> Option<DVec2> {
    let width = |direction: DVec2| {
        let [lower, upper] = extent(outline.iter().copied(), direction);
        upper - lower
    };
    let across = edges(outline).map(|(a, b)| inward_normal(a, b)).filter(|n| *n != DVec2::ZERO);
    across.min_by(|&m, &n| width(m).total_cmp(&width(n)))
}

/// The smallest translation that brings the turned outline `sole` wholly onto `face`, `margin` (m)
/// from its edges, or `None` if the face is too small or has too many sides. Both are in the plane
/// frame, m.
pub(crate) fn shift_onto(face: &[DVec2], sole: &[DVec2], margin: f64) -> Option<DVec2> {
    let mut planes: heapless::Vec<HalfPlane, SIDES_MAX> = heapless::Vec::new();
    for (a, b) in edges(face) {
        let normal = inward_normal(a, b);
        let [lowest, highest] = extent(sole.iter().copied(), normal);
        let width = extent(face.iter().copied(), normal)[1] - normal.dot(a);
        if highest - lowest > width - margin {
            return None;
        }
        planes.push(HalfPlane { normal, offset: normal.dot(a) + margin - lowest }).ok()?;
    }
    nearest_to_origin(&planes)
}

/// The point of an intersection of half-planes nearest to the origin.
fn nearest_to_origin(planes: &[HalfPlane]) -> Option<DVec2> {
    let is_inside = |p: DVec2| planes.iter().all(|h| h.normal.dot(p) >= h.offset - FEASIBLE_SLACK);
    if is_inside(DVec2::ZERO) {
        return Some(DVec2::ZERO);
    }
    let on_sides = planes.iter().map(|h| h.normal * h.offset);
    let nearer = |a: &DVec2, b: &DVec2| a.length_squared().total_cmp(&b.length_squared());
    if let Some(point) = on_sides.filter(|&p| is_inside(p)).min_by(nearer) {
        return Some(point);
    }
    let pairs = (0..planes.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs
        .filter_map(|(i, j)| crossing(&planes[i], &planes[j]))
        .filter(|&p| is_inside(p))
        .min_by(nearer)
}

/// The point on both boundaries.
fn crossing(one: &HalfPlane, other: &HalfPlane) -> Option<DVec2> {
    let determinant = one.normal.perp_dot(other.normal);
    let x = one.offset * other.normal.y - other.offset * one.normal.y;
    let y = one.normal.x * other.offset - other.normal.x * one.offset;
    (determinant.abs() > 1e-9).then(|| DVec2::new(x, y) / determinant)
}

/// The smallest translation that brings the sole's extent into the face's, `margin` from its ends,
/// if it fits.
pub(crate) fn shift_within(face: [f64; 2], sole: [f64; 2], margin: f64) -> Option<f64> {
    let (lowest, highest) = (face[0] + margin - sole[0], face[1] - margin - sole[1]);
    (lowest <= highest).then(|| 0f64.clamp(lowest, highest))
}

/// The translation that centres the sole's extent on the face's.
pub(crate) fn shift_to_centre(face: [f64; 2], sole: [f64; 2]) -> f64 {
    0.5 * (face[0] + face[1] - sole[0] - sole[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARGIN: f64 = 0.01;

    fn rectangle(x: [f64; 2], y: [f64; 2]) -> [DVec2; 4] {
        [
            DVec2::new(x[0], y[0]),
            DVec2::new(x[1], y[0]),
            DVec2::new(x[1], y[1]),
            DVec2::new(x[0], y[1]),
        ]
    }

    #[test]
    fn the_shift_onto_a_face_is_the_smallest_one() {
        let sole = rectangle([-0.1, 0.1], [-0.05, 0.05]);
        assert_eq!(
            shift_onto(&rectangle([-1.0, 1.0], [-1.0, 1.0]), &sole, MARGIN),
            Some(DVec2::ZERO)
        );
        let shift = shift_onto(&rectangle([0.0, 1.0], [-1.0, 1.0]), &sole, MARGIN).unwrap();
        assert!((shift - DVec2::new(0.1 + MARGIN, 0.0)).length() < 1e-12);
        let shift = shift_onto(&rectangle([0.0, 1.0], [0.2, 1.0]), &sole, MARGIN).unwrap();
        assert!((shift - DVec2::new(0.1 + MARGIN, 0.25 + MARGIN)).length() < 1e-12);
        assert_eq!(shift_onto(&rectangle([0.0, 0.15], [0.2, 1.0]), &sole, MARGIN), None);
    }

    #[test]
    fn extents_are_shifted_inside_or_centred() {
        assert_eq!(shift_within([0.0, 1.0], [0.4, 0.6], MARGIN), Some(0.0));
        assert!(
            (shift_within([0.5, 1.0], [0.4, 0.6], MARGIN).unwrap() - (0.1 + MARGIN)).abs() < 1e-12
        );
        assert_eq!(shift_within([1.0, 1.1], [-0.5, 0.5], MARGIN), None);
        assert_eq!(shift_to_centre([1.0, 1.1], [-0.5, 0.5]), 1.05);
    }

    #[test]
    fn the_narrow_side_of_a_beam_is_across_it() {
        let across = narrowest_direction(&rectangle([0.0, 0.05], [-1.0, 1.0])).unwrap();
        assert!(across.x.abs() > 0.999);
    }
}
