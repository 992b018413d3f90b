//! A perspective camera and how it is placed so that it sees all of some points.

use glam::{DVec2, DVec3};

/// Nothing nearer than this is drawn, m.
pub const NEAR: f64 = 0.05;

/// The size of a raster, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Size {
    /// The number of pixels.
    pub fn pixels(self) -> usize {
        self.width * self.height
    }

    /// Both sides times `factor`.
    pub fn scaled(self, factor: usize) -> Self {
        Self { width: self.width * factor, height: self.height * factor }
    }
}

/// A perspective camera. View coordinates are right, up and forward, metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    tangents: DVec2,
}

impl Camera {
    /// The camera that looks along the unit vector `forward` (not vertical), has the given tangents
    /// of half its horizontal and vertical angles of view, and stands as near as it can while all
    /// points are in view.
    pub fn framing(forward: DVec3, tangents: DVec2, points: &[DVec3]) -> Self {
        let right = forward.cross(DVec3::Z).normalize();
        let mut camera =
            Self { eye: DVec3::ZERO, right, up: right.cross(forward), forward, tangents };
        let view: Vec<DVec3> = points.iter().map(|&point| camera.view(point)).collect();
        let (x, nearest_x) = fit(view.iter().map(|v| [v.x, v.z]), tangents.x);
        let (y, nearest_y) = fit(view.iter().map(|v| [v.y, v.z]), tangents.y);
        camera.eye = camera.right * x + camera.up * y + forward * nearest_x.min(nearest_y);
        camera
    }

    /// The same camera, moved.
    pub fn moved(&self, by: DVec3) -> Self {
        Self { eye: self.eye + by, ..self.clone() }
    }

    /// The same camera with the tangents of its angles of view multiplied.
    pub fn widened(&self, factor: f64) -> Self {
        Self { tangents: self.tangents * factor, ..self.clone() }
    }

    /// Where it stands.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Its right and forward directions along the ground.
    pub fn ground_axes(&self) -> [DVec3; 2] {
        [self.right, DVec3::Z.cross(self.right)]
    }

    /// A point in view coordinates.
    pub fn view(&self, point: DVec3) -> DVec3 {
        let offset = point - self.eye;
        DVec3::new(self.right.dot(offset), self.up.dot(offset), self.forward.dot(offset))
    }

    /// View coordinates, in front of the camera, on the raster: column, row and nearness (1 /
    /// distance along the view, which is affine there).
    pub fn screen(&self, view: DVec3, size: Size) -> DVec3 {
        let nearness = 1.0 / view.z;
        let x = 0.5 * (1.0 + view.x * nearness / self.tangents.x) * size.width as f64;
        let y = 0.5 * (1.0 - view.y * nearness / self.tangents.y) * size.height as f64;
        DVec3::new(x, y, nearness)
    }

    /// The world's point that a raster position with that nearness shows.
    pub fn unscreen(&self, x: f64, y: f64, nearness: f64, size: Size) -> DVec3 {
        let right = (2.0 * x / size.width as f64 - 1.0) * self.tangents.x;
        let up = (1.0 - 2.0 * y / size.height as f64) * self.tangents.y;
        self.eye + (self.forward + self.right * right + self.up * up) / nearness
    }

    /// The length that a pixel at distance 1 m spans, m.
    pub fn pixel_per_metre(&self, size: Size) -> f64 {
        2.0 * self.tangents.y / size.height as f64
    }
}

/// The sideways place and the largest forward place from which all points (sideways, forward) lie
/// within a tangent of the middle.
fn fit(points: impl Iterator<Item = [f64; 2]>, tangent: f64) -> (f64, f64) {
    let (low, high) =
        points.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [side, forward]| {
            (low.min(side + tangent * forward), high.max(side - tangent * forward))
        });
    (0.5 * (low + high), 0.5 * (low - high) / tangent)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size { width: 320, height: 180 };

    fn camera(points: &[DVec3]) -> Camera {
        Camera::framing(DVec3::new(0.3, 1.0, -0.5).normalize(), DVec2::new(0.5, 0.28125), points)
    }

    #[test]
    fn framing_shows_all_points_and_touches_the_border() {
        let points: Vec<DVec3> = (0..40)
            .map(|i| DVec3::new((i % 7) as f64, (i % 5) as f64 - 2.0, (i % 3) as f64))
            .collect();
        let camera = camera(&points);
        let screen: Vec<DVec3> =
            points.iter().map(|&p| camera.screen(camera.view(p), SIZE)).collect();
        assert!(screen.iter().all(|s| s.x > -1e-6
            && s.x < 320.0 + 1e-6
            && s.y > -1e-6
            && s.y < 180.0 + 1e-6
            && s.z > 0.0));
        assert!(
            screen
                .iter()
                .any(|s| s.x < 1e-6 || s.y < 1e-6 || s.x > 320.0 - 1e-6 || s.y > 180.0 - 1e-6)
        );
    }

    #[test]
    fn unscreen_is_the_inverse_of_screen() {
        let camera = camera(&[DVec3::ZERO, DVec3::ONE]);
        let point = DVec3::new(0.2, 0.7, -0.1);
        let screen = camera.screen(camera.view(point), SIZE);
        assert!((camera.unscreen(screen.x, screen.y, screen.z, SIZE) - point).length() < 1e-9);
    }
}
