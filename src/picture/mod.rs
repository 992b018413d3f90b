//! Pictures of a walk, drawn by a software renderer.

pub mod animation;
pub mod camera;
pub mod canvas;
pub mod colour;
pub mod error;
pub mod ground_overlay;
pub mod light;
pub mod motion;
pub mod output;
pub mod paint;
pub mod raster;
pub mod render;
pub mod renderer;
pub mod scene;
pub mod stroke;
pub mod surface;
pub mod tessellate;
pub mod view;

pub use error::PictureError;
pub use scene::PictureScene;
