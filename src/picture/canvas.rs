//! The body, depth and normal of each pixel, and its colour.

use glam::DVec3;

use crate::picture::camera::{Camera, NEAR, Size};
use crate::picture::colour::Colour;
use crate::picture::raster::fill_triangle;
use crate::picture::surface::{Corner, Surface};

/// The body number of a pixel that shows nothing.
pub const NOTHING: u32 = u32::MAX;

/// A raster of the nearest surfaces.
#[derive(Debug, Clone)]
pub struct Canvas {
    /// Its size.
    pub size: Size,
    /// 1 / distance along the view, 1/m; 0 for nothing.
    pub nearness: Vec<f32>,
    /// Unit normal, towards the camera.
    pub normal: Vec<[f32; 3]>,
    /// The number that the surface was drawn with, or [`NOTHING`].
    pub body: Vec<u32>,
}

impl Canvas {
    /// An empty raster.
    pub fn new(size: Size) -> Self {
        let pixels = size.pixels();
        Self {
            size,
            nearness: vec![0.0; pixels],
            normal: vec![[0.0; 3]; pixels],
            body: vec![NOTHING; pixels],
        }
    }

    /// Draws a surface, given in the world's frame, where nothing nearer was drawn.
    pub fn draw(&mut self, camera: &Camera, surface: &Surface, body: u32) {
        let size = self.size;
        for triangle in &surface.triangles {
            let away = camera.eye() - triangle[0].position;
            let area = (triangle[1].position - triangle[0].position)
                .cross(triangle[2].position - triangle[0].position);
            let facing = if area.dot(away) < 0.0 { -1.0 } else { 1.0 };
            on_screen(camera, triangle, size, |corners, normals| {
                fill_triangle(corners, size, |index, weights, nearness| {
                    if nearness as f32 > self.nearness[index] {
                        let normal: DVec3 = (0..3).map(|i| normals[i] * weights[i]).sum();
                        self.nearness[index] = nearness as f32;
                        self.normal[index] =
                            (normal.normalize_or_zero() * facing).as_vec3().to_array();
                        self.body[index] = body;
                    }
                });
            });
        }
    }

    /// Calls `plot` for each pixel at which the surface's camera-side triangles are nearer than
    /// what was drawn.
    pub fn visit(&self, camera: &Camera, surface: &Surface, mut plot: impl FnMut(usize)) {
        for triangle in &surface.triangles {
            let area = (triangle[1].position - triangle[0].position)
                .cross(triangle[2].position - triangle[0].position);
            if area.dot(camera.eye() - triangle[0].position) <= 0.0 {
                continue;
            }
            on_screen(camera, triangle, self.size, |corners, _| {
                fill_triangle(corners, self.size, |index, _, nearness| {
                    if nearness as f32 > self.nearness[index] {
                        plot(index);
                    }
                });
            });
        }
    }
}

/// Blends `colour` over a pixel.
pub fn blend(pixel: &mut Colour, colour: Colour, alpha: f32) {
    *pixel = pixel.mix(colour, alpha);
}

/// Cuts a triangle at the near plane and calls `fill` with what remains of it on the raster.
fn on_screen(
    camera: &Camera,
    triangle: &[Corner; 3],
    size: Size,
    mut fill: impl FnMut([DVec3; 3], [DVec3; 3]),
) {
    let corners = triangle.map(|corner| (camera.view(corner.position), corner.normal));
    let mut kept = Vec::with_capacity(4);
    for i in 0..3 {
        let (here, there) = (corners[i], corners[(i + 1) % 3]);
        if here.0.z >= NEAR {
            kept.push(here);
        }
        if (here.0.z >= NEAR) != (there.0.z >= NEAR) {
            let t = (NEAR - here.0.z) / (there.0.z - here.0.z);
            kept.push((here.0.lerp(there.0, t), here.1.lerp(there.1, t)));
        }
    }
    let screen: Vec<DVec3> = kept.iter().map(|(view, _)| camera.screen(*view, size)).collect();
    for i in 1..kept.len().saturating_sub(1) {
        fill([0, i, i + 1].map(|k| screen[k]), [0, i, i + 1].map(|k| kept[k].1));
    }
}
