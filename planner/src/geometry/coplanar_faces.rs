//! Merges neighbouring coplanar triangles into convex faces, so that a triangulated floor has as
//! few faces as a box.

use glam::DVec3;

use crate::geometry::polygon::FACE_VERTICES_MAX;

/// Largest angle between the normals of one face's triangles, as 1 - cosine (about 0.03 degrees).
const NORMAL_DEVIATION_MAX: f64 = 1e-7;
/// Largest distance of a vertex from the plane of its face, m.
const PLANE_DEVIATION_MAX: f64 = 1e-5;
/// Largest inward bend of a corner that counts as straight, as the sine of the angle.
const REFLEX_SINE_MAX: f64 = 1e-6;

/// Merges neighbouring coplanar triangles while the result stays convex (greedy Hertel-Mehlhorn),
/// in a fixed order. Calls `face` with the vertex loop of each face, counter-clockwise from
/// outside. Triangles without area are dropped.
pub(crate) fn merge_coplanar(
    points: &[DVec3],
    triangles: &[[u32; 3]],
    mut face: impl FnMut(&[u32]),
) {
    let mut merger = Merger::new(points, triangles);
    for (_, _, one, other) in merger.inner_edges() {
        merger.try_merge(one, other);
    }
    for triangle in 0..triangles.len() {
        if merger.find(triangle as u32) == triangle as u32
            && merger.normals[triangle] != DVec3::ZERO
        {
            let without_straight_vertices = merger.without_straight_vertices(triangle);
            face(&without_straight_vertices);
        }
    }
}

struct Merger<'a> {
    points: &'a [DVec3],
    /// Union-find parents over triangles.
    parents: Vec<u32>,
    /// The vertex loop of each group, at its representative.
    loops: Vec<Vec<u32>>,
    /// The unit normal of each triangle, zero without area.
    normals: Vec<DVec3>,
}

impl<'a> Merger<'a> {
    fn new(points: &'a [DVec3], triangles: &[[u32; 3]]) -> Self {
        let welded = weld(points);
        let loops: Vec<Vec<u32>> =
            triangles.iter().map(|t| t.iter().map(|&i| welded[i as usize]).collect()).collect();
        let corner = |i: u32| points[i as usize];
        let normal = |l: &Vec<u32>| {
            (corner(l[1]) - corner(l[0])).cross(corner(l[2]) - corner(l[0])).normalize_or_zero()
        };
        let normals = loops.iter().map(normal).collect();
        Self { points, parents: (0..triangles.len() as u32).collect(), loops, normals }
    }

    /// The edges between two coplanar triangles: lower vertex, upper vertex, both triangles.
    fn inner_edges(&self) -> Vec<(u32, u32, u32, u32)> {
        let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * self.loops.len());
        for (triangle, corners) in self.loops.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                sides.push((a.min(b), a.max(b), triangle as u32));
            }
        }
        sides.sort_unstable();
        let shared =
            sides.windows(2).filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1));
        shared
            .map(|pair| (pair[0].0, pair[0].1, pair[0].2, pair[1].2))
            .filter(|e| self.are_coplanar(e.2, e.3))
            .collect()
    }

    fn are_coplanar(&self, one: u32, other: u32) -> bool {
        let (n, m) = (self.normals[one as usize], self.normals[other as usize]);
        n.dot(m) >= 1.0 - NORMAL_DEVIATION_MAX && n != DVec3::ZERO
    }

    fn find(&mut self, triangle: u32) -> u32 {
        let mut at = triangle;
        while self.parents[at as usize] != at {
            let grandparent = self.parents[self.parents[at as usize] as usize];
            self.parents[at as usize] = grandparent;
            at = grandparent;
        }
        at
    }

    /// Merges the groups of two triangles if the union is convex, flat and small enough.
    fn try_merge(&mut self, one: u32, other: u32) {
        let (one, other) = (self.find(one), self.find(other));
        if one == other || !self.are_coplanar(one, other) {
            return;
        }
        let Some(union) = joined(&self.loops[one as usize], &self.loops[other as usize]) else {
            return;
        };
        if union.len() <= FACE_VERTICES_MAX
            && self.is_flat_and_convex(&union, self.normals[one as usize])
        {
            self.loops[one as usize] = union;
            self.loops[other as usize] = Vec::new();
            self.parents[other as usize] = one;
        }
    }

    fn is_flat_and_convex(&self, corners: &[u32], normal: DVec3) -> bool {
        let point = |i: usize| self.points[corners[i % corners.len()] as usize];
        let n = corners.len();
        (0..n).all(|i| {
            let (before, after) = (point(i + 1) - point(i), point(i + 2) - point(i + 1));
            let bend = normal.dot(before.cross(after));
            bend >= -REFLEX_SINE_MAX * before.length() * after.length()
                && (point(i) - point(0)).dot(normal).abs() <= PLANE_DEVIATION_MAX
        })
    }

    /// A group's loop without the vertices on straight sides.
    fn without_straight_vertices(&self, group: usize) -> Vec<u32> {
        let corners = &self.loops[group];
        let n = corners.len();
        let point = |i: usize| self.points[corners[i % n] as usize];
        let is_corner = |i: &usize| {
            let (before, after) = (point(*i) - point(i + n - 1), point(i + 1) - point(*i));
            before.cross(after).length() > REFLEX_SINE_MAX * before.length() * after.length()
        };
        (0..n).filter(is_corner).map(|i| corners[i]).collect()
    }
}

/// For each point the index of the first point with the same coordinates.
fn weld(points: &[DVec3]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    let key = |i: u32| points[i as usize];
    order.sort_unstable_by(|&i, &j| {
        let (p, q) = (key(i), key(j));
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)).then(p.z.total_cmp(&q.z)).then(i.cmp(&j))
    });
    let mut welded: Vec<u32> = (0..points.len() as u32).collect();
    for pair in order.windows(2) {
        if key(pair[0]) == key(pair[1]) {
            welded[pair[1] as usize] = welded[pair[0] as usize];
        }
    }
    welded
}

/// The outline of two loops that share a side (in opposite directions); `None` if they share none,
/// or enclose a hole.
fn joined(one: &[u32], other: &[u32]) -> Option<Vec<u32>> {
    let (n, m) = (one.len(), other.len());
    let side = |l: &[u32], i: usize| (l[i % l.len()], l[(i + 1) % l.len()]);
    let reversed = |(a, b): (u32, u32)| (b, a);
    let (i, j) = (0..n)
        .flat_map(|i| (0..m).map(move |j| (i, j)))
        .find(|&(i, j)| side(one, i) == reversed(side(other, j)))?;
    let from_one = (1..=n).map(|k| one[(i + k) % n]);
    let from_other = (2..m).map(|k| other[(j + k) % m]);
    let mut outline: Vec<u32> = from_one.chain(from_other).collect();
    remove_spikes(&mut outline);
    let mut sorted = outline.clone();
    sorted.sort_unstable();
    (outline.len() >= 3 && sorted.windows(2).all(|pair| pair[0] != pair[1])).then_some(outline)
}

/// Removes spikes, where an outline returns along the same side: further sides that both loops
/// share.
fn remove_spikes(outline: &mut Vec<u32>) {
    let mut i = 0;
    while outline.len() > 3 && i < outline.len() {
        let n = outline.len();
        if outline[(i + n - 1) % n] == outline[(i + 1) % n] {
            outline.remove(i);
            outline.remove(i % outline.len());
            i = 0;
        } else {
            i += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faces_of(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
        let mut faces = Vec::new();
        merge_coplanar(points, triangles, |face| faces.push(face.to_vec()));
        faces
    }

    /// A grid of `n` by `n` squares, two triangles each, with every triangle's vertices its own (as
    /// in STL).
    fn grid(n: u32, height: impl Fn(u32, u32) -> f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        let at = |x: u32, y: u32| DVec3::new(f64::from(x), f64::from(y), height(x, y));
        for (x, y) in (0..n).flat_map(|x| (0..n).map(move |y| (x, y))) {
            for corners in
                [[(x, y), (x + 1, y), (x + 1, y + 1)], [(x, y), (x + 1, y + 1), (x, y + 1)]]
            {
                let first = points.len() as u32;
                points.extend(corners.map(|(x, y)| at(x, y)));
                triangles.push([first, first + 1, first + 2]);
            }
        }
        (points, triangles)
    }

    fn area(points: &[DVec3], face: &[u32]) -> f64 {
        let p = |i: usize| points[face[i] as usize];
        (1..face.len() - 1).map(|i| (p(i) - p(0)).cross(p(i + 1) - p(0)).z).sum::<f64>() * 0.5
    }

    #[test]
    fn two_triangles_become_a_square() {
        let (points, triangles) = grid(1, |_, _| 0.0);
        let faces = faces_of(&points, &triangles);
        assert_eq!((faces.len(), faces[0].len()), (1, 4));
    }

    #[test]
    fn a_flat_grid_keeps_its_area_in_few_convex_faces() {
        let (points, triangles) = grid(8, |_, _| 0.0);
        let faces = faces_of(&points, &triangles);
        assert!(faces.len() <= 32, "{} faces", faces.len());
        assert!((faces.iter().map(|f| area(&points, f)).sum::<f64>() - 64.0).abs() < 1e-9);
    }

    #[test]
    fn bent_neighbours_stay_apart() {
        let (points, triangles) = grid(3, |x, y| libm::sin(f64::from(7 * x + 31 * y * y)));
        assert_eq!(faces_of(&points, &triangles).len(), 18);
    }

    #[test]
    fn triangles_without_area_vanish() {
        assert!(faces_of(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X], &[[0, 1, 2]]).is_empty());
        assert!(faces_of(&[DVec3::ZERO, DVec3::X], &[[0, 1, 1]]).is_empty());
    }
}
