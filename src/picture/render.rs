//! Pictures of a planned walk: a still with the robot at several instants (PNG) and the robot
//! walking (APNG).
//!
//! The pictures are drawn by a small rasteriser of our own, so that they need neither a display nor
//! a graphics card and are the same bytes everywhere. A [`PictureScene`] holds the surfaces of a
//! plan, its robot and its world (`tessellate`, `surface`, `motion`, `ground_overlay`); `view`
//! places the camera and finds the walls that hide the robot; `renderer` draws the world once and
//! the robot on it (`raster`, `canvas`), colours the pixels (`light`, `paint`, `stroke`); `output`
//! writes the file.

use crate::picture::animation;
use crate::picture::output;
use std::path::Path;

use crate::picture::error::PictureError;
use crate::picture::scene::PictureScene;

/// Draws a picture; the file's extension decides which: `.png` a still, `.apng` a moving one.
///
/// # Errors
/// [`PictureError::Extension`] for any other extension, [`PictureError::Write`] if the file cannot
/// be written.
pub fn render(scene: &PictureScene, out: &Path) -> Result<(), PictureError> {
    match kind_of(out)? {
        Kind::Still => render_png(scene, out),
        Kind::Moving => render_apng(scene, out),
    }
}

/// Whether a path has one of the two extensions, so that a long run need not fail at its end.
///
/// # Errors
/// [`PictureError::Extension`].
pub fn check_extension(out: &Path) -> Result<(), PictureError> {
    kind_of(out).map(drop)
}

/// Draws the robot at several instants of the walk, 1280 x 720 pixels.
///
/// # Errors
/// [`PictureError::Write`] if the file cannot be written.
pub fn render_png(scene: &PictureScene, out: &Path) -> Result<(), PictureError> {
    output::write_png(&animation::still(scene), out)
}

/// Draws the robot walking from start to goal, 800 x 450 pixels, endlessly repeated.
///
/// # Errors
/// [`PictureError::Write`] if the file cannot be written.
pub fn render_apng(scene: &PictureScene, out: &Path) -> Result<(), PictureError> {
    output::write_apng(&animation::frames(scene), out)
}

enum Kind {
    Still,
    Moving,
}

fn kind_of(out: &Path) -> Result<Kind, PictureError> {
    match out.extension().map(|extension| extension.to_ascii_lowercase()) {
        Some(extension) if extension == "png" => Ok(Kind::Still),
        Some(extension) if extension == "apng" => Ok(Kind::Moving),
        _ => Err(PictureError::Extension { path: out.to_owned() }),
    }
}
