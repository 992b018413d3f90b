//! A sun with soft shadows, and light from the sky.

use glam::{DVec2, DVec3};

use crate::picture::camera::Size;
use crate::picture::raster::fill_triangle;
use crate::picture::surface::Surface;

/// Texels along the longer side of the shadow map.
const TEXELS_MAX: usize = 2048;
/// The finest texel, m.
const TEXEL_MIN: f64 = 0.003;
/// Offset of a point along its normal before the shadow test, in texels.
const LIFT_TEXELS: f64 = 2.0;
/// The sun's strength.
const SUN: f64 = 0.68;
/// Light from above and from below.
const SKY: [f64; 2] = [0.50, 0.28];

/// The sun and its shadow map.
#[derive(Debug, Clone)]
pub struct Sun {
    right: DVec3,
    up: DVec3,
    toward: DVec3,
    corner: DVec2,
    texel: f64,
    size: Size,
    height: Vec<f32>,
}

impl Sun {
    /// A sun in the direction of the unit vector `toward` (not vertical), whose shadows are known
    /// around some points.
    pub fn new(toward: DVec3, points: &[DVec3]) -> Self {
        let right = DVec3::Z.cross(toward).normalize();
        let up = toward.cross(right);
        let flat = points.iter().map(|point| DVec2::new(right.dot(*point), up.dot(*point)));
        let (low, high) = flat.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
        let texel = ((high - low).max_element() / TEXELS_MAX as f64).max(TEXEL_MIN);
        let count = |extent: f64| (libm::ceil(extent / texel) as usize).clamp(1, TEXELS_MAX);
        let size = Size { width: count(high.x - low.x), height: count(high.y - low.y) };
        Self {
            right,
            up,
            toward,
            corner: low,
            texel,
            size,
            height: vec![f32::NEG_INFINITY; size.pixels()],
        }
    }

    /// Lets a surface, given in the world's frame, throw its shadow.
    pub fn cast(&mut self, surface: &Surface) {
        for triangle in &surface.triangles {
            let corners = triangle.map(|corner| self.texel_of(corner.position));
            fill_triangle(corners, self.size, |index, _, height| {
                self.height[index] = self.height[index].max(height as f32)
            });
        }
    }

    /// The light that a point with a unit normal receives, about 0 to 1.
    pub fn light(&self, point: DVec3, normal: DVec3) -> f32 {
        let [above, below] = SKY;
        let sky = below + (above - below) * 0.5 * (1.0 + normal.z);
        let facing = normal.dot(self.toward).max(0.0);
        let sun = if facing > 0.0 {
            facing * SUN * self.visible(point + normal * (LIFT_TEXELS * self.texel))
        } else {
            0.0
        };
        (sky + sun) as f32
    }

    /// The share of the sun that a point sees.
    fn visible(&self, point: DVec3) -> f64 {
        let at = self.texel_of(point);
        let limit = at.z + self.texel;
        let clear = |dx: i32, dy: i32| {
            let [x, y] = [at.x + 1.4 * f64::from(dx), at.y + 1.4 * f64::from(dy)];
            if x < 0.0 || y < 0.0 || x >= self.size.width as f64 || y >= self.size.height as f64 {
                return true;
            }
            f64::from(self.height[y as usize * self.size.width + x as usize]) <= limit
        };
        let taps = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        taps.filter(|&(dx, dy)| clear(dx, dy)).count() as f64 / 9.0
    }

    /// Column, row and height towards the sun (m).
    fn texel_of(&self, point: DVec3) -> DVec3 {
        let flat =
            (DVec2::new(self.right.dot(point), self.up.dot(point)) - self.corner) / self.texel;
        flat.extend(self.toward.dot(point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64, z: f64) -> Surface {
        Surface::polygon(
            &[[-half, -half], [half, -half], [half, half], [-half, half]]
                .map(|[x, y]| DVec3::new(x, y, z)),
        )
    }

    #[test]
    fn a_plate_shades_the_ground_but_not_itself() {
        let toward = DVec3::new(0.0, 0.01, 1.0).normalize();
        let mut sun = Sun::new(toward, &[DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 1.0)]);
        sun.cast(&square(0.3, 0.5));
        sun.cast(&square(0.9, 0.0));
        let dark = sun.light(DVec3::ZERO, DVec3::Z);
        let lit = sun.light(DVec3::new(0.6, 0.6, 0.0), DVec3::Z);
        assert!(dark < 0.5 * lit, "{dark} against {lit}");
        assert_eq!(lit, sun.light(DVec3::new(0.0, 0.0, 0.5), DVec3::Z));
    }
}
