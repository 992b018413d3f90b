//! Lines of constant width on the raster.

use glam::{DVec2, DVec3};

use crate::picture::camera::{Camera, NEAR, Size};
use crate::picture::canvas::{Canvas, blend};
use crate::picture::colour::Colour;

/// How much nearer than a surface a line on it counts, as a share of the distance.
const BIAS: f32 = 1.004;

/// A line in the world.
#[derive(Debug, Clone)]
pub struct Stroke {
    /// Its points, world frame.
    pub segments: Vec<[DVec3; 2]>,
    /// Its width, raster pixels.
    pub width: f64,
    /// Its colour.
    pub colour: Colour,
    /// Its opacity where nothing stands before it.
    pub alpha: f32,
    /// Its opacity behind things.
    pub hidden_alpha: f32,
}

impl Stroke {
    /// The segments of a line through some points.
    pub fn through(points: &[DVec3]) -> Vec<[DVec3; 2]> {
        points.windows(2).map(|pair| [pair[0], pair[1]]).collect()
    }

    /// Blends the line over `colours`. Where it crosses itself it counts once.
    pub fn draw(&self, camera: &Camera, canvas: &Canvas, colours: &mut [Colour]) {
        let mut coverage = vec![0.0_f32; colours.len()];
        for segment in &self.segments {
            self.cover(camera, canvas, *segment, &mut coverage);
        }
        for (pixel, alpha) in colours.iter_mut().zip(coverage).filter(|(_, alpha)| *alpha > 0.0) {
            blend(pixel, self.colour, alpha);
        }
    }

    fn cover(&self, camera: &Camera, canvas: &Canvas, segment: [DVec3; 2], coverage: &mut [f32]) {
        let Some([a, b]) = on_screen(camera, segment, canvas.size) else { return };
        let reach = 0.5 * self.width + 1.0;
        let along = b.truncate() - a.truncate();
        let [columns, rows] = box_around(a, b, reach, canvas.size);
        for row in rows {
            for column in columns.clone() {
                let offset = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - a.truncate();
                let t = (offset.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                let inside = (reach - 0.5 - (offset - along * t).length()).clamp(0.0, 1.0) as f32;
                let index = row * canvas.size.width + column;
                let nearness = (a.z + (b.z - a.z) * t) as f32 * BIAS;
                let alpha =
                    if nearness >= canvas.nearness[index] { self.alpha } else { self.hidden_alpha };
                coverage[index] = coverage[index].max(inside * alpha);
            }
        }
    }
}

fn on_screen(camera: &Camera, segment: [DVec3; 2], size: Size) -> Option<[DVec3; 2]> {
    let [a, b] = segment.map(|point| camera.view(point));
    if a.z.max(b.z) < NEAR {
        return None;
    }
    let cut = |inside: DVec3, outside: DVec3| {
        inside.lerp(outside, ((inside.z - NEAR) / (inside.z - outside.z)).clamp(0.0, 1.0))
    };
    let a_cut = if a.z < NEAR { cut(b, a) } else { a };
    let b_cut = if b.z < NEAR { cut(a, b) } else { b };
    Some([camera.screen(a_cut, size), camera.screen(b_cut, size)])
}

fn box_around(a: DVec3, b: DVec3, reach: f64, size: Size) -> [std::ops::Range<usize>; 2] {
    let range = |low: f64, high: f64, limit: usize| {
        let clamp = |value: f64| value.clamp(0.0, limit as f64) as usize;
        clamp(libm::floor(low - reach))..clamp(libm::ceil(high + reach))
    };
    [range(a.x.min(b.x), a.x.max(b.x), size.width), range(a.y.min(b.y), a.y.max(b.y), size.height)]
}
