//! The finish of bodies: colour, ground grid, distance haze, outlines.

use glam::DVec3;

use crate::picture::camera::{Camera, Size};
use crate::picture::canvas::{Canvas, NOTHING};
use crate::picture::colour::Colour;
use crate::picture::light::Sun;
use crate::picture::scene::WorldKind;

/// The distance between grid lines, m; every second one is stronger.
pub(crate) const GRID: f64 = 0.5;
/// Half the width of a grid line, m.
const GRID_HALF_WIDTH: f64 = 0.006;
/// Remaining shares of a colour on the outline between two bodies and on a sharp edge of one.
const OUTLINE: [f32; 2] = [0.42, 0.8];
/// Normals of neighbouring pixels below this cosine make a sharp edge.
const EDGE_COS: f32 = 0.75;

/// The material of a body.
#[derive(Debug, Clone, Copy)]
pub struct Paint {
    /// Its colour in full light.
    pub colour: Colour,
    /// Whether its upward faces carry the grid.
    pub grid: bool,
    /// Whether it fades with distance.
    pub haze: bool,
}

impl Paint {
    /// A plain colour.
    pub fn plain(colour: Colour) -> Self {
        Self { colour, grid: false, haze: false }
    }

    /// The paint of a kind of world body.
    pub fn world(kind: WorldKind) -> Self {
        let colour = Colour::srgb(match kind {
            WorldKind::Floor => 0x00E4_E6EA,
            WorldKind::Wall => 0x00D6_DEE8,
            WorldKind::Object => 0x00E3_BE86,
        });
        Self { colour, grid: kind == WorldKind::Floor, haze: true }
    }
}

/// The backdrop: the colours of the picture's top and bottom.
#[derive(Debug, Clone, Copy)]
pub struct Backdrop(Colour, Colour);

impl Backdrop {
    /// A bright sky.
    pub fn new() -> Self {
        Self(Colour::srgb(0x00DD_E8F4), Colour::srgb(0x00FB_FCFE))
    }
}

/// Where the haze begins and ends.
#[derive(Debug, Clone, Copy)]
pub struct Haze {
    /// The middle of the walk.
    pub centre: DVec3,
    /// Full sight up to this distance from it, m.
    pub near: f64,
    /// Nothing to be seen from here on, m.
    pub far: f64,
}

/// Everything that decides a pixel's colour.
pub struct Finish<'a> {
    /// The pixels' bodies.
    pub canvas: &'a Canvas,
    /// From where.
    pub camera: &'a Camera,
    /// In which light.
    pub sun: &'a Sun,
    /// The paints by body number.
    pub paints: &'a [Paint],
    /// The haze.
    pub haze: Haze,
    /// The colour behind all surfaces, and of the haze.
    pub backdrop: Backdrop,
}

impl Finish<'_> {
    /// The colour of a pixel.
    pub fn colour(&self, index: usize) -> Colour {
        let size = self.canvas.size;
        let [column, row] = [index % size.width, index / size.width];
        let behind = self.backdrop.0.mix(self.backdrop.1, row as f32 / size.height as f32);
        let body = self.canvas.body[index];
        if body == NOTHING {
            return behind;
        }
        let paint = &self.paints[body as usize];
        let nearness = f64::from(self.canvas.nearness[index]);
        let point = self.camera.unscreen(column as f64 + 0.5, row as f64 + 0.5, nearness, size);
        let normal = DVec3::from(self.canvas.normal[index].map(f64::from));
        let grid = if paint.grid && normal.z > 0.7 {
            grid(point, self.camera.pixel_per_metre(size) / nearness)
        } else {
            1.0
        };
        let colour =
            paint.colour * (grid * self.sun.light(point, normal) * self.outline(column, row));
        if paint.haze { colour.mix(behind, self.haze.at(point)) } else { colour }
    }

    /// Remaining share of the colour after outlines.
    fn outline(&self, column: usize, row: usize) -> f32 {
        let Size { width, height } = self.canvas.size;
        let here = row * width + column;
        let mut remains = 1.0_f32;
        let sides = [
            (column > 0, here.wrapping_sub(1)),
            (column + 1 < width, here + 1),
            (row > 0, here.wrapping_sub(width)),
            (row + 1 < height, here + width),
        ];
        for (_, there) in sides.into_iter().filter(|(inside, _)| *inside) {
            let canvas = self.canvas;
            if canvas.body[there] != canvas.body[here] {
                if canvas.nearness[there] <= canvas.nearness[here] {
                    remains = remains.min(OUTLINE[0]);
                }
            } else if (0..3).map(|i| canvas.normal[here][i] * canvas.normal[there][i]).sum::<f32>()
                < EDGE_COS
            {
                remains = remains.min(OUTLINE[1]);
            }
        }
        remains
    }
}

impl Haze {
    fn at(&self, point: DVec3) -> f32 {
        let t =
            ((point.distance(self.centre) - self.near) / (self.far - self.near)).clamp(0.0, 1.0);
        (t * t * (3.0 - 2.0 * t)) as f32
    }
}

/// Remaining share of the ground's colour under the grid; `pixel` is a pixel's width there, m.
fn grid(point: DVec3, pixel: f64) -> f32 {
    let strength = |period: f64, depth: f64| {
        let distance = |v: f64| (v - period * libm::floor(v / period + 0.5)).abs();
        let nearest = distance(point.x).min(distance(point.y));
        let reach = GRID_HALF_WIDTH.max(0.7 * pixel);
        let cover =
            ((reach - nearest) / pixel + 0.5).clamp(0.0, 1.0) * (GRID_HALF_WIDTH / reach).sqrt();
        1.0 - depth * cover * (1.0 - pixel / (0.2 * period)).clamp(0.0, 1.0)
    };
    (strength(GRID, 0.12) * strength(2.0 * GRID, 0.10)) as f32
}
