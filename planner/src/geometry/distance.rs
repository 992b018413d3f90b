//! Distances of points, segments, triangles and boxes in closed form. A box is centred on the
//! origin along the axes of its frame.
//!
//! A sphere is a point with a radius and a capsule a segment with a radius: callers compare the
//! distances of such cores with the sum of radii and clearance.

use glam::{DAffine3, DMat3, DVec3};
use surefoot_shared_types::Pose;

/// A segment from `start` to `start + delta`.
#[derive(Debug, Clone, Copy)]
pub struct LineSegment {
    /// One end.
    pub start: DVec3,
    /// From that end to the other.
    pub delta: DVec3,
}

impl LineSegment {
    /// The segment along z about the origin of a frame.
    pub fn along_z(frame: &Pose, half_length: f64) -> Self {
        let half = frame.rotation * DVec3::new(0.0, 0.0, half_length);
        Self { start: frame.translation - half, delta: 2.0 * half }
    }

    /// Whether its length is 0.
    pub fn is_point(&self) -> bool {
        self.delta == DVec3::ZERO
    }

    /// The segment after a transformation by `frame`.
    pub fn placed(&self, frame: &DAffine3) -> Self {
        Self { start: frame.transform_point3(self.start), delta: frame.matrix3 * self.delta }
    }
}

/// Whether a value is greater than a bound. `false` if one is NaN, so that
/// `!exceeds(distance, margin)` counts as a hit then.
pub fn exceeds(value: f64, bound: f64) -> bool {
    value > bound
}

/// Squared distance of a point from a solid box.
pub fn point_box_distance_squared(point: DVec3, half_extents: DVec3) -> f64 {
    (point.abs() - half_extents).max(DVec3::ZERO).length_squared()
}

/// Squared distance of a segment from a solid box: the minimum of a convex, piecewise quadratic
/// function whose pieces end where the segment crosses a face's plane.
pub fn segment_box_distance_squared(segment: LineSegment, half_extents: DVec3) -> f64 {
    let LineSegment { start, delta } = segment;
    let slope = |t: f64| {
        let point = start + delta * t;
        (point - point.clamp(-half_extents, half_extents)).dot(delta)
    };
    if slope(0.0) >= 0.0 {
        return point_box_distance_squared(start, half_extents);
    }
    if slope(1.0) <= 0.0 {
        return point_box_distance_squared(start + delta, half_extents);
    }
    let (mut falling, mut rising) = (0.0, 1.0);
    for axis in 0..3 {
        for face in [-half_extents[axis], half_extents[axis]] {
            let t = (face - start[axis]) / delta[axis];
            if t > falling && t < rising {
                if slope(t) < 0.0 { falling = t } else { rising = t }
            }
        }
    }
    let (low, high) = (slope(falling), slope(rising));
    let t = falling + (rising - falling) * (low / (low - high));
    point_box_distance_squared(start + delta * t, half_extents)
}

/// Squared distance of two segments (Ericson, Real-Time Collision Detection, 5.1.9). Either may be
/// a point.
pub fn segment_segment_distance_squared(a: LineSegment, b: LineSegment) -> f64 {
    let between = a.start - b.start;
    let (aa, bb, ab) = (a.delta.length_squared(), b.delta.length_squared(), a.delta.dot(b.delta));
    let (on_a, on_b) = (a.delta.dot(between), b.delta.dot(between));
    let ratio = |numerator: f64, denominator: f64| {
        if denominator > 0.0 { (numerator / denominator).clamp(0.0, 1.0) } else { 0.0 }
    };
    let first_guess = ratio(ab * on_b - on_a * bb, aa * bb - ab * ab);
    let t = ratio(ab * first_guess + on_b, bb);
    let s = ratio(ab * t - on_a, aa);
    let t = ratio(ab * s + on_b, bb);
    (between + a.delta * s - b.delta * t).length_squared()
}

/// Squared distance of a point from a triangle (Ericson, 5.1.5).
pub fn point_triangle_distance_squared(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    if let Some(height_squared) = height_over_triangle_squared(point, [a, b, c]) {
        return height_squared;
    }
    let to_edge = |start: DVec3, end: DVec3| {
        let (edge, to_point) = (end - start, point - start);
        let length_squared = edge.length_squared();
        let t = if length_squared > 0.0 {
            (to_point.dot(edge) / length_squared).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (to_point - edge * t).length_squared()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// Squared height of a point above or below a triangle; `None` if its projection lies outside or
/// the triangle has no area.
fn height_over_triangle_squared(point: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let length_squared = normal.length_squared();
    let is_left_of =
        |start: DVec3, end: DVec3| normal.dot((end - start).cross(point - start)) >= 0.0;
    let is_over = length_squared > 0.0 && is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a);
    let height = normal.dot(point - a);
    is_over.then(|| height * height / length_squared)
}

/// Squared distance of a segment from a triangle; 0 if it crosses the triangle.
pub fn segment_triangle_distance_squared(segment: LineSegment, triangle: [DVec3; 3]) -> f64 {
    let [a, b, c] = triangle;
    let end = segment.start + segment.delta;
    if segment_crosses_triangle(segment, triangle) {
        return 0.0;
    }
    let to_edge = |start: DVec3, end: DVec3| {
        segment_segment_distance_squared(segment, LineSegment { start, delta: end - start })
    };
    let edges = to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a));
    let ends = [segment.start, end]
        .map(|point| height_over_triangle_squared(point, triangle).unwrap_or(f64::INFINITY));
    edges.min(ends[0]).min(ends[1])
}

fn segment_crosses_triangle(segment: LineSegment, [a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    let (above, below) =
        (normal.dot(segment.start - a), normal.dot(segment.start + segment.delta - a));
    if above * below > 0.0 || above == below {
        return false;
    }
    let crossing = segment.start + segment.delta * (above / (above - below));
    height_over_triangle_squared(crossing, [a, b, c]).is_some()
}

/// The largest distance between two boxes along any of the 15 separating axes: a lower bound of
/// their distance, and negative or 0 exactly if they overlap. `a_from_b` and `center` are the
/// orientation and the centre of the second box in the first one's frame.
pub fn box_box_separation(a: DVec3, b: DVec3, a_from_b: &DMat3, center: DVec3) -> f64 {
    let absolute =
        DMat3::from_cols(a_from_b.x_axis.abs(), a_from_b.y_axis.abs(), a_from_b.z_axis.abs());
    let along_a = (center.abs() - a - absolute * b).max_element();
    let in_b = DVec3::new(
        a_from_b.x_axis.dot(center),
        a_from_b.y_axis.dot(center),
        a_from_b.z_axis.dot(center),
    );
    let reach = DVec3::new(absolute.x_axis.dot(a), absolute.y_axis.dot(a), absolute.z_axis.dot(a));
    let along_b = (in_b.abs() - b - reach).max_element();
    let mut separation = along_a.max(along_b);
    for i in 0..3 {
        for j in 0..3 {
            separation = separation.max(edge_separation(a, b, a_from_b, &absolute, center, i, j));
        }
    }
    separation
}

/// The distance along the cross product of the first box's axis `i` and the second box's axis `j`;
/// minus infinity for parallel axes, which the face normals cover.
fn edge_separation(
    a: DVec3,
    b: DVec3,
    a_from_b: &DMat3,
    absolute: &DMat3,
    center: DVec3,
    i: usize,
    j: usize,
) -> f64 {
    let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
    let column = a_from_b.col(j);
    let length_squared = column[i1] * column[i1] + column[i2] * column[i2];
    if length_squared < PARALLEL_SINE_SQUARED {
        return f64::NEG_INFINITY;
    }
    let apart = (center[i2] * column[i1] - center[i1] * column[i2]).abs();
    let reach_a = a[i1] * absolute.col(j)[i2] + a[i2] * absolute.col(j)[i1];
    let reach_b = b[j1] * absolute.col(j2)[i] + b[j2] * absolute.col(j1)[i];
    (apart - reach_a - reach_b) / length_squared.sqrt()
}

/// Largest squared sine between parallel edges.
const PARALLEL_SINE_SQUARED: f64 = 1e-10;
