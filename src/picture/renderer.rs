//! Draws the world once for a camera, and the robot over it any number of times.

use glam::DVec3;
use rayon::prelude::*;

use crate::picture::camera::Size;
use crate::picture::canvas::{Canvas, blend};
use crate::picture::colour::{Colour, Encoder, limb_colour, robot_colour, search_colours};
use crate::picture::light::Sun;
use crate::picture::output::Image;
use crate::picture::paint::{Backdrop, Finish, Haze, Paint};
use crate::picture::scene::{PictureScene, WorldKind};
use crate::picture::stroke::Stroke;
use crate::picture::surface::Surface;
use crate::picture::view::View;

/// Raster pixels a side of a picture's pixel.
const SUPERSAMPLING: usize = 2;
/// The direction of the sun relative to the camera's: right, back towards the camera, up.
const SUN: [f64; 3] = [-0.55, 0.45, 1.35];
/// The opacity of a support polygon, and of glass.
const SHEET_ALPHA: f32 = 0.22;
const GLASS_ALPHA: f32 = 0.10;

/// The robot at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Figure {
    /// The fractional waypoint.
    pub at: f64,
    /// The share of the walk behind it, 0 to 1: its colour.
    pub progress: f32,
}

/// Drawings on the ground.
#[derive(Debug, Clone, Copy)]
pub enum Ground {
    /// All footholds and the support polygons of all double supports.
    All,
    /// Footholds that are still to come pale, and only the support polygon of this waypoint.
    At(usize),
}

/// A camera's view of everything but the robot.
pub struct Renderer<'a> {
    scene: &'a PictureScene,
    view: View,
    canvas: Canvas,
    sun: Sun,
    haze: Haze,
}

impl<'a> Renderer<'a> {
    /// The sun that shines on a scene; glass throws no shadow.
    pub fn sun(scene: &PictureScene, view: &View) -> Sun {
        let [right, back, up] = SUN;
        let axes = view.camera.ground_axes();
        let mut sun =
            Sun::new((axes[0] * right - axes[1] * back + DVec3::Z * up).normalize(), &scene.sweep);
        let solid = scene.world.iter().zip(&view.glass).filter(|(_, glass)| !**glass);
        solid.for_each(|(body, _)| sun.cast(&body.surface));
        sun
    }

    /// Draws the world and the marks on a raster for pictures of `size`.
    pub fn new(scene: &'a PictureScene, view: View, sun: Sun, size: Size) -> Self {
        let mut canvas = Canvas::new(size.scaled(SUPERSAMPLING));
        for (number, (body, _)) in
            scene.world.iter().zip(&view.glass).enumerate().filter(|(_, (_, glass))| !**glass)
        {
            canvas.draw(&view.camera, &body.surface, number as u32);
        }
        let marks = scene
            .footholds
            .iter()
            .map(|foothold| &foothold.plate)
            .chain(scene.endpoints.iter().map(|end| &end.rings));
        for (number, surface) in marks.enumerate() {
            canvas.draw(&view.camera, surface, (scene.world.len() + number) as u32);
        }
        let haze = haze_around(&scene.sweep);
        Self { scene, view, canvas, sun, haze }
    }

    /// What it draws.
    pub fn scene(&self) -> &'a PictureScene {
        self.scene
    }

    /// The picture with the robot at some instants.
    pub fn picture(&self, figures: &[Figure], ground: Ground, encoder: &Encoder) -> Image {
        let mut canvas = self.canvas.clone();
        let mut sun = self.sun.clone();
        let mut paints = self.paints(ground);
        for figure in figures {
            for (surface, body) in self.scene.robot_at(figure.at).iter().zip(&self.scene.robot) {
                canvas.draw(&self.view.camera, surface, paints.len() as u32);
                sun.cast(surface);
                paints.push(Paint::plain(
                    body.limb.map_or_else(|| robot_colour(figure.progress), limb_colour),
                ));
            }
        }
        let finish = Finish {
            canvas: &canvas,
            camera: &self.view.camera,
            sun: &sun,
            paints: &paints,
            haze: self.haze,
            backdrop: Backdrop::new(),
        };
        let mut colours: Vec<Colour> =
            (0..canvas.size.pixels()).into_par_iter().map(|index| finish.colour(index)).collect();
        self.draw_support(ground, &canvas, &mut colours);
        let camera = &self.view.camera;
        self.line(Stroke::through(&self.scene.com_path), Colour::srgb(0x001B_2430), [0.95, 0.40])
            .draw(camera, &canvas, &mut colours);
        let [tree, route] = search_colours();
        let scene = self.scene;
        self.line(scene.tree.clone(), tree, [0.7, 0.25]).draw(camera, &canvas, &mut colours);
        let route_line = Stroke::through(&scene.route);
        self.line(route_line, route, [1.0, 0.5]).draw(camera, &canvas, &mut colours);
        self.draw_glass(&canvas, &mut colours);
        shrink(&colours, canvas.size, encoder)
    }

    /// The paints of world, footholds and endpoints, in the order in which they were drawn.
    fn paints(&self, ground: Ground) -> Vec<Paint> {
        let world = self.scene.world.iter().map(|body| Paint::world(body.kind));
        let footholds = self.scene.footholds.iter().map(|foothold| {
            let colour = limb_colour(foothold.limb);
            let ahead = matches!(ground, Ground::At(now) if foothold.first > now);
            Paint::plain(if ahead { colour.mix(Colour::srgb(0x00F2_F2F4), 0.65) } else { colour })
        });
        let endpoints = self.scene.endpoints.iter().map(|end| Paint::plain(end.colour));
        world.chain(footholds).chain(endpoints).collect()
    }

    fn draw_support(&self, ground: Ground, canvas: &Canvas, colours: &mut [Colour]) {
        let gold = Colour::srgb(0x00F2_B01E);
        let shown = self.scene.stances.iter().filter(|stance| match ground {
            Ground::All => stance.feet > 1,
            Ground::At(now) => {
                stance.first <= now && (now < stance.last || now + 1 == self.scene.motion.len())
            }
        });
        for stance in shown {
            let sheet = Surface::polygon(&stance.polygon);
            canvas.visit(&self.view.camera, &sheet, |index| {
                blend(&mut colours[index], gold, SHEET_ALPHA)
            });
            let rim = stance
                .polygon
                .iter()
                .zip(stance.polygon.iter().cycle().skip(1))
                .map(|(a, b)| [*a, *b])
                .collect();
            self.line(rim, Colour::srgb(0x00C9_8400), [0.75, 0.0]).draw(
                &self.view.camera,
                canvas,
                colours,
            );
        }
    }

    fn draw_glass(&self, canvas: &Canvas, colours: &mut [Colour]) {
        let glass = self.scene.world.iter().zip(&self.view.glass).filter(|(_, glass)| **glass);
        for (body, _) in glass {
            let tint = Paint::world(if body.kind == WorldKind::Floor {
                WorldKind::Wall
            } else {
                body.kind
            })
            .colour
                * 0.6;
            canvas.visit(&self.view.camera, &body.surface, |index| {
                blend(&mut colours[index], tint, GLASS_ALPHA)
            });
            self.line(body.surface.creases.clone(), tint * 0.6, [0.55, 0.10]).draw(
                &self.view.camera,
                canvas,
                colours,
            );
        }
    }

    fn line(
        &self,
        segments: Vec<[DVec3; 2]>,
        colour: Colour,
        [alpha, hidden_alpha]: [f32; 2],
    ) -> Stroke {
        let width = 1.0 + self.canvas.size.height as f64 / 720.0;
        Stroke { segments, width, colour, alpha, hidden_alpha }
    }
}

fn haze_around(points: &[DVec3]) -> Haze {
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let radius = 0.5 * (high - low).length();
    Haze { centre: 0.5 * (low + high), near: 1.2 * radius + 0.6, far: 2.6 * radius + 3.0 }
}

/// Averages each square of raster pixels and encodes it.
fn shrink(colours: &[Colour], size: Size, encoder: &Encoder) -> Image {
    let small = Size { width: size.width / SUPERSAMPLING, height: size.height / SUPERSAMPLING };
    let mut bytes = Vec::with_capacity(3 * small.pixels());
    for row in 0..small.height {
        for column in 0..small.width {
            let first = SUPERSAMPLING * (row * size.width + column);
            let square = (0..SUPERSAMPLING)
                .flat_map(|y| (0..SUPERSAMPLING).map(move |x| first + y * size.width + x));
            let sum = square.map(|index| colours[index]).fold(Colour([0.0; 3]), |a, b| a + b);
            bytes.extend(encoder.bytes(sum * (1.0 / (SUPERSAMPLING * SUPERSAMPLING) as f32)));
        }
    }
    Image { size: small, bytes }
}
