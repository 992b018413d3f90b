//! Convex hulls with a fast support function: hill climbing along edges from a tabulated start.

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;

use crate::geometry::bvh::Aabb;
use crate::geometry::tuning::{DIRECTION_CELLS, SCANNED_VERTICES_MAX};

/// A convex hull.
#[derive(Debug, Clone)]
pub struct Hull {
    vertices: Vec<DVec3>,
    aabb: Aabb,
    /// Distance from the centre of the bounding box to the nearest face, m; 0 if it is not known.
    inner_radius: f64,
    /// Start of each vertex's neighbours in `neighbors`, and the end; empty if all vertices are
    /// scanned.
    starts: Vec<u32>,
    neighbors: Vec<u32>,
    /// The farthest vertex in the direction of each cell of the direction cube.
    cells: Vec<u32>,
}

/// Largest error of hill climbing, as a share of the hull's size.
const CLIMB_TOLERANCE: f64 = 1e-12;
/// Largest thickness of a flat hull, as a share of its size.
const FLATNESS: f64 = 1e-9;

impl Hull {
    /// The hull of points, or the reason why there is none.
    pub fn new(points: &[DVec3]) -> Result<Self, String> {
        if points.len() < 4 || points.iter().any(|point| !point.is_finite()) {
            return Err("fewer than four finite points".into());
        }
        let (vertices, triangles) = try_convex_hull(points).map_err(|error| error.to_string())?;
        let aabb = Aabb::of_points(points.iter().copied());
        let inner_radius = inner_radius(&vertices, &triangles, aabb.center());
        let (starts, neighbors, cells) = (Vec::new(), Vec::new(), Vec::new());
        let scan = Self { vertices, aabb, inner_radius, starts, neighbors, cells };
        let size = scan.size();
        if !is_solid(&scan.vertices, &triangles, size) {
            return Err("all points lie in one plane".into());
        }
        if !scan.covers(points, &triangles, size) {
            // A corner was lost to rounding errors: the points themselves have the same hull.
            return Ok(Self { vertices: points.to_vec(), inner_radius: 0.0, ..scan });
        }
        if scan.vertices.len() <= SCANNED_VERTICES_MAX {
            return Ok(scan);
        }
        let climb = scan.clone().with_neighbors(&triangles);
        Ok(if climb.agrees_with_scan(&triangles, size) { climb } else { scan })
    }

    /// The hull's vertices.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Bounding box.
    pub fn aabb(&self) -> Aabb {
        self.aabb
    }

    /// Distance from the centre of the bounding box to the nearest face, m; 0 if it is not known.
    pub fn inner_radius(&self) -> f64 {
        self.inner_radius
    }

    /// The farthest vertex along `direction`.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        if self.starts.is_empty() {
            self.vertices[self.scan(direction)]
        } else {
            self.vertices[self.climb(direction)]
        }
    }

    /// Heap memory, bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.vertices.as_slice())
            + 4 * (self.starts.len() + self.neighbors.len() + self.cells.len())
    }

    fn scan(&self, direction: DVec3) -> usize {
        let mut best = (0, f64::NEG_INFINITY);
        for (index, vertex) in self.vertices.iter().enumerate() {
            let along = vertex.dot(direction);
            if along > best.1 {
                best = (index, along);
            }
        }
        best.0
    }

    fn climb(&self, direction: DVec3) -> usize {
        let mut at = self.cells[cell_of(direction)] as usize;
        let mut height = self.vertices[at].dot(direction);
        loop {
            let from = at;
            let range = self.starts[from] as usize..self.starts[from + 1] as usize;
            for &neighbor in &self.neighbors[range] {
                let along = self.vertices[neighbor as usize].dot(direction);
                if along > height {
                    (at, height) = (neighbor as usize, along);
                }
            }
            if at == from {
                return at;
            }
        }
    }

    fn size(&self) -> f64 {
        self.vertices.iter().map(|vertex| (*vertex - self.vertices[0]).length()).fold(0.0, f64::max)
    }

    fn covers(&self, points: &[DVec3], triangles: &[[u32; 3]], size: f64) -> bool {
        let corner = |index: u32| self.vertices[index as usize];
        triangles.iter().all(|&[a, b, c]| {
            let normal = (corner(b) - corner(a)).cross(corner(c) - corner(a)).normalize_or_zero();
            points.iter().all(|point| normal.dot(*point - corner(a)) <= FLATNESS * size)
        })
    }

    fn with_neighbors(mut self, triangles: &[[u32; 3]]) -> Self {
        let mut edges: Vec<(u32, u32)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let start_of =
            |vertex: usize| edges.partition_point(|&(from, _)| (from as usize) < vertex) as u32;
        self.starts = (0..=self.vertices.len()).map(start_of).collect();
        self.neighbors = edges.iter().map(|&(_, to)| to).collect();
        self.cells = (0..6 * DIRECTION_CELLS * DIRECTION_CELLS)
            .map(|cell| self.scan(direction_of(cell)) as u32)
            .collect();
        self
    }

    /// Whether hill climbing agrees with a scan along all vertices, faces and cells.
    fn agrees_with_scan(&self, triangles: &[[u32; 3]], size: f64) -> bool {
        let corner = |index: u32| self.vertices[index as usize];
        let normals = triangles.iter().map(|&[a, b, c]| {
            (corner(b) - corner(a)).cross(corner(c) - corner(a)).normalize_or_zero()
        });
        let middle = self.vertices.iter().sum::<DVec3>() / self.vertices.len() as f64;
        let outward = self.vertices.iter().map(|vertex| (*vertex - middle).normalize_or_zero());
        let cells = (0..6 * DIRECTION_CELLS * DIRECTION_CELLS).map(direction_of);
        normals.chain(outward).chain(cells).flat_map(|direction| [direction, -direction]).all(
            |direction| {
                let difference =
                    self.vertices[self.scan(direction)] - self.vertices[self.climb(direction)];
                difference.dot(direction) <= CLIMB_TOLERANCE * size * direction.length()
            },
        )
    }
}

fn is_solid(vertices: &[DVec3], triangles: &[[u32; 3]], size: f64) -> bool {
    let corner = |index: u32| vertices[index as usize] - vertices[0];
    let volume: f64 =
        triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum();
    volume.is_finite() && volume > FLATNESS * size * size * size
}

/// Distance from a point to the nearest of the planes of a hull's triangles, m; 0 if it lies
/// outside of one.
fn inner_radius(vertices: &[DVec3], triangles: &[[u32; 3]], center: DVec3) -> f64 {
    let corner = |index: u32| vertices[index as usize];
    let depths = triangles.iter().filter_map(|&[a, b, c]| {
        let normal = (corner(b) - corner(a)).cross(corner(c) - corner(a)).try_normalize()?;
        Some(normal.dot(corner(a) - center))
    });
    let depth = depths.fold(f64::INFINITY, f64::min);
    if depth.is_finite() { depth.max(0.0) } else { 0.0 }
}

/// The cell of the direction cube that contains a direction.
fn cell_of(direction: DVec3) -> usize {
    let axis = direction.abs().max_position();
    let length = direction[axis].abs();
    if length == 0.0 {
        return 0;
    }
    let cell = |value: f64| {
        (((value / length + 1.0) * 0.5 * DIRECTION_CELLS as f64) as usize).min(DIRECTION_CELLS - 1)
    };
    let face = 2 * axis + usize::from(direction[axis] < 0.0);
    (face * DIRECTION_CELLS + cell(direction[(axis + 1) % 3])) * DIRECTION_CELLS
        + cell(direction[(axis + 2) % 3])
}

/// The direction of a cell's centre.
fn direction_of(cell: usize) -> DVec3 {
    let (face, u, v) = (
        cell / (DIRECTION_CELLS * DIRECTION_CELLS),
        cell / DIRECTION_CELLS % DIRECTION_CELLS,
        cell % DIRECTION_CELLS,
    );
    let axis = face / 2;
    let middle = |index: usize| (2 * index + 1) as f64 / DIRECTION_CELLS as f64 - 1.0;
    let mut direction = DVec3::ZERO;
    direction[axis] = if face % 2 == 0 { 1.0 } else { -1.0 };
    direction[(axis + 1) % 3] = middle(u);
    direction[(axis + 2) % 3] = middle(v);
    direction
}
