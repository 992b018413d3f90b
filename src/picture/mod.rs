//! Pictures of a walk, drawn by a software renderer.

pub(crate) mod animation;
pub(crate) mod camera;
pub(crate) mod canvas;
pub(crate) mod caption;
pub(crate) mod colour;
pub mod error;
pub(crate) mod ground_overlay;
pub(crate) mod light;
pub(crate) mod motion;
pub(crate) mod output;
pub(crate) mod paint;
pub(crate) mod raster;
pub mod render;
pub(crate) mod renderer;
pub(crate) mod scene;
pub(crate) mod search_scene;
pub(crate) mod stroke;
pub(crate) mod surface;
pub mod tessellate;
pub(crate) mod view;

pub use error::PictureError;
pub use scene::PictureScene;
