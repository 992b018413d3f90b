//! Convex hulls: their furthest point in a direction, and the depth of a point inside.

use std::collections::BTreeSet;

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;
use surefoot_shared_types::geometry::shape::MeshSource;

use crate::base::comparison::{is_at_most, is_below, smallest};
use crate::geometry::bounds::Bounds;
use crate::geometry::mesh_solid::bits;

/// How far a point may be outside of its hull, m: rounding.
const OUTSIDE_MAX: f64 = 1e-6;
/// Points in a leaf of the tree.
const LEAF_POINTS: usize = 4;

/// The convex hull of some points.
#[derive(Debug, Clone)]
pub struct Hull {
    /// Its vertices, m, sorted so that each box of the tree holds successive ones.
    points: Vec<DVec3>,
    triangles: Vec<[DVec3; 3]>,
    /// The outward unit normal of each face and its distance from the origin, m.
    planes: Vec<(DVec3, f64)>,
    tree: Vec<Node>,
}

/// A box around successive vertices.
#[derive(Debug, Clone)]
struct Node {
    bounds: Bounds,
    first: usize,
    end: usize,
    /// Its two parts, as indices of nodes; none in a leaf.
    parts: Option<[usize; 2]>,
}

impl Hull {
    /// The hull of points (m), verified by what holds of every hull. Of a mesh file the loader may
    /// have left out points inside; it is verified with all vertices of the file.
    ///
    /// # Errors
    /// The points span no volume, the file cannot be read, or the hull is wrong.
    pub fn new(points: &[DVec3], source: Option<&MeshSource>) -> Result<Self, String> {
        let hull = Self::unverified(points)?;
        match source {
            Some(source) => hull.verify(&source.vertices()?)?,
            None => hull.verify(points)?,
        }
        Ok(hull)
    }

    fn unverified(points: &[DVec3]) -> Result<Self, String> {
        let (mut points, triangles) =
            try_convex_hull(points).map_err(|error| format!("no convex hull: {error}"))?;
        let corners = |triangle: &[u32; 3]| triangle.map(|index| points[index as usize]);
        let triangles: Vec<[DVec3; 3]> = triangles.iter().map(corners).collect();
        let planes = triangles.iter().filter_map(plane).collect();
        let mut tree = Vec::new();
        let end = points.len();
        split(&mut points, (0, end), &mut tree);
        Ok(Self { points, triangles, planes, tree })
    }

    /// Whether this is the hull of these points, however it was made: its surface is closed, it
    /// contains each point, and its corners are among them, so that it is no larger than their
    /// hull.
    fn verify(&self, given: &[DVec3]) -> Result<(), String> {
        let given_bits: BTreeSet<[u64; 3]> = given.iter().copied().map(bits).collect();
        let mut edges: BTreeSet<[[u64; 3]; 2]> = BTreeSet::new();
        for [a, b, c] in &self.triangles {
            for (from, to) in [(*a, *b), (*b, *c), (*c, *a)] {
                if !given_bits.contains(&bits(from)) {
                    return Err(format!(
                        "its convex hull has a corner at {from}, where it has none"
                    ));
                }
                edges.insert([bits(from), bits(to)]);
            }
        }
        if edges.len() != 3 * self.triangles.len()
            || edges.iter().any(|[from, to]| !edges.contains(&[*to, *from]))
        {
            return Err("its convex hull is not closed".to_owned());
        }
        let is_outside = |point: &&DVec3| !is_at_most(-OUTSIDE_MAX, self.depth(**point));
        match given.iter().find(is_outside) {
            Some(point) => Err(format!("its convex hull leaves out its point {point}")),
            None => Ok(()),
        }
    }

    /// Its vertices, m.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The outward unit normal of each face and its distance from the origin, m.
    pub fn planes(&self) -> &[(DVec3, f64)] {
        &self.planes
    }

    /// The triangles of its surface, m.
    pub fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// The vertex furthest along a direction.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
        self.improve(0, direction, &mut best);
        best.1
    }

    /// The distance of a point inside to the surface, m; negative outside.
    pub fn depth(&self, point: DVec3) -> f64 {
        smallest(self.planes.iter().map(|(normal, distance)| distance - normal.dot(point)))
    }

    /// Replaces `best` by the furthest vertex of a node, if that is further.
    fn improve(&self, node: usize, direction: DVec3, best: &mut (f64, DVec3)) {
        let node = &self.tree[node];
        let Some(parts) = node.parts else {
            for point in &self.points[node.first..node.end] {
                let reach = point.dot(direction);
                if reach > best.0 {
                    *best = (reach, *point);
                }
            }
            return;
        };
        let reaches = parts.map(|part| self.tree[part].bounds.reach(direction));
        let order = if is_below(reaches[0], reaches[1]) { [1, 0] } else { [0, 1] };
        for side in order {
            if reaches[side] > best.0 {
                self.improve(parts[side], direction, best);
            }
        }
    }
}

fn plane(&[a, b, c]: &[DVec3; 3]) -> Option<(DVec3, f64)> {
    let normal = (b - a).cross(c - a).try_normalize()?;
    Some((normal, normal.dot(a).max(normal.dot(b)).max(normal.dot(c))))
}

/// Sorts a range of points into boxes and returns the index of the box around them.
fn split(points: &mut [DVec3], (first, end): (usize, usize), tree: &mut Vec<Node>) -> usize {
    let bounds = Bounds::of_points(points[first..end].iter().copied());
    let index = tree.len();
    tree.push(Node { bounds, first, end, parts: None });
    if end - first > LEAF_POINTS {
        let extent = bounds.high - bounds.low;
        let axis =
            (0..3).fold(0, |best, axis| if extent[axis] > extent[best] { axis } else { best });
        points[first..end].sort_by(|a, b| a[axis].total_cmp(&b[axis]));
        let middle = usize::midpoint(first, end);
        let low = split(points, (first, middle), tree);
        let high = split(points, (middle, end), tree);
        tree[index].parts = Some([low, high]);
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points on a sphere of radius 1, by Fibonacci's spiral.
    fn ball(count: usize) -> Vec<DVec3> {
        let point = |index: usize| {
            let z = 1.0 - 2.0 * (index as f64 + 0.5) / count as f64;
            let (sin, cos) = libm::sincos(2.399_963 * index as f64);
            DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + z * DVec3::Z
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn the_support_is_the_furthest_of_all_points() {
        for count in [4, 5, 17, 300] {
            let points = ball(count);
            let hull = Hull::new(&points, None).unwrap();
            for direction in ball(200) {
                let reach = |point: DVec3| point.dot(direction);
                let furthest = points.iter().copied().map(reach).fold(f64::NEG_INFINITY, f64::max);
                assert_eq!(reach(hull.support(direction)), furthest);
            }
        }
    }

    #[test]
    fn a_wrong_hull_is_refused() {
        let points = ball(60);
        let right = Hull::unverified(&points).unwrap();
        right.verify(&points).unwrap();
        let refusal = |hull: Hull, points: &[DVec3]| hull.verify(points).expect_err("is wrong");
        let fewer = Hull::unverified(&points[1..]).unwrap();
        assert!(refusal(fewer, &points).contains("leaves out"));
        let more = Hull::unverified(&[&points[..], &[2.0 * DVec3::X]].concat()).unwrap();
        assert!(refusal(more, &points).contains("corner at"));
        let moved = |hull: &Hull| hull.triangles.iter().map(|t| t.map(|at| 1.001 * at)).collect();
        let larger = Hull { triangles: moved(&right), ..right.clone() };
        assert!(refusal(larger, &points).contains("corner at"));
        let mut open = right.clone();
        open.triangles.pop();
        assert!(refusal(open, &points).contains("not closed"));
        let mut turned = right.clone();
        turned.triangles[3].swap(0, 1);
        assert!(refusal(turned, &points).contains("not closed"));
        let mut shifted = right.clone();
        shifted.planes[5].1 -= 1e-3;
        assert!(refusal(shifted, &points).contains("leaves out"));
        let mut unknown = right;
        unknown.planes[5].1 = f64::NAN;
        assert!(refusal(unknown, &points).contains("leaves out"));
    }

    #[test]
    fn the_hull_of_a_mesh_file_is_verified_with_the_vertices_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ball.obj");
        let write = |vertices: &[DVec3]| {
            let mut text: String =
                vertices.iter().map(|at| format!("v {} {} {}\n", at.x, at.y, at.z)).collect();
            text += &(3..=vertices.len())
                .map(|at| format!("f 1 {} {at}\n", at - 1))
                .collect::<String>();
            std::fs::write(&path, text).unwrap();
        };
        let source = MeshSource { path: path.clone(), scale: DVec3::new(2.0, 1.0, -0.5) };
        // Half of the points lie inside; the loader keeps the others.
        let inner = ball(40).into_iter().map(|at| 0.5 * at);
        let all: Vec<DVec3> = ball(40).into_iter().chain(inner).collect();
        write(&all);
        let read = source.vertices().unwrap();
        Hull::new(&read[..40], Some(&source)).unwrap();
        let refusal = |points: &[DVec3]| Hull::new(points, Some(&source)).expect_err("is wrong");
        assert!(refusal(&read[1..40]).contains("leaves out"));
        assert!(refusal(&[&read[..40], &[3.0 * DVec3::X]].concat()).contains("corner at"));
        std::fs::remove_file(&path).unwrap();
        assert!(refusal(&read[..40]).contains("ball.obj"));
    }

    #[test]
    fn the_depth_is_the_distance_to_the_nearest_face() {
        let corner =
            |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let cube = Hull::new(&(0..8).map(corner).collect::<Vec<_>>(), None).unwrap();
        for (at, depth) in [([0.5; 3], 0.5), ([0.5, 0.1, 0.5], 0.1), ([0.5, 0.5, 1.2], -0.2)] {
            assert!((cube.depth(at.into()) - depth).abs() < 1e-12);
        }
    }

    #[test]
    fn the_boxes_of_the_tree_divide_the_points_along_their_longest_side() {
        let long: Vec<DVec3> =
            ball(300).into_iter().map(|at| at * DVec3::new(1.0, 9.0, 2.0)).collect();
        let hull = Hull::new(&long, None).unwrap();
        assert!(hull.points().iter().all(|point| long.contains(point)));
        assert_eq!(hull.triangles().len(), 2 * hull.points().len() - 4, "Euler's formula");
        for node in &hull.tree {
            let points = &hull.points[node.first..node.end];
            assert_eq!(node.bounds, Bounds::of_points(points.iter().copied()));
            let Some(parts) = node.parts else {
                assert!(points.len() <= LEAF_POINTS);
                continue;
            };
            assert!(points.len() > LEAF_POINTS);
            let extent = node.bounds.high - node.bounds.low;
            let [low, high] = parts.map(|part| hull.tree[part].bounds);
            let axis = (0..3).find(|axis| extent[*axis] == extent.max_element()).unwrap();
            assert!(low.high[axis] <= high.low[axis] + 1e-12);
        }
    }
}
