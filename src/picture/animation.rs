//! Which instants a picture shows, and from where.

use glam::DVec3;
use rayon::prelude::*;

use crate::picture::camera::{Camera, Size};
use crate::picture::caption::{write_label, write_scale, write_title};
use crate::picture::colour::Encoder;
use crate::picture::output::Image;
use crate::picture::paint::GRID;
use crate::picture::renderer::{Figure, Ground, Renderer};
use crate::picture::scene::PictureScene;
use crate::picture::view::View;

/// A still's size.
const STILL: Size = Size { width: 1280, height: 720 };
/// A moving picture's size.
const MOVING: Size = Size { width: 800, height: 450 };
/// Robots in a still, at most, and how far they stand apart at least, m.
const FIGURES_MAX: usize = 8;
const FIGURE_SPACING: f64 = 0.55;
/// How far a figure's time stands over its head, m.
const LABEL_GAP: f64 = 0.03;
/// About the size of a time, columns and rows: others keep as far from it.
const LABEL_HALF: DVec3 = DVec3::new(70.0, 24.0, 0.0);
/// Frames of a moving picture, and about how many there are for each stance.
const FRAMES_MIN: usize = 60;
const FRAMES_MAX: usize = 120;
const FRAMES_PER_STANCE: usize = 3;
/// A longer walk is followed by the camera, m.
const FIXED_VIEW_MAX: f64 = 7.0;
/// The part of a followed walk that is in view, m.
const FOLLOWED_VIEW: f64 = 4.0;

/// The robot at several instants.
pub fn still(scene: &PictureScene) -> Image {
    let view = View::of(scene, &scene.sweep, STILL);
    let sun = Renderer::sun(scene, &view);
    let progress = scene.motion.progress();
    let chosen = scene.motion.evenly_spaced(FIGURE_SPACING, FIGURES_MAX);
    let figures: Vec<Figure> = chosen
        .iter()
        .map(|&waypoint| Figure { at: waypoint as f64, progress: progress[waypoint] })
        .collect();
    let camera = view.camera.clone();
    let renderer = Renderer::new(scene, view, sun, STILL);
    let mut image = renderer.picture(&figures, Ground::All, &Encoder::new());
    if figures.len() > 1 {
        let labels: Vec<Label> =
            figures.iter().map(|figure| Label::of(scene, &camera, figure.at)).collect();
        let is_free = |label: &&Label| !labels.iter().any(|other| other.hides(label));
        for label in labels.iter().filter(is_free) {
            write_label(&mut image, &label.text, label.at);
        }
    }
    write_title(&mut image, std::slice::from_ref(&scene.title));
    write_scale(&mut image, &scale());
    image
}

/// The time of a figure, above its head.
struct Label {
    text: String,
    /// Column and row in the still.
    at: [f64; 2],
    /// 1 / distance of the figure along the view, 1/m.
    nearness: f64,
    /// The rectangle of the figure in the still, with its label: least and largest column and row.
    covers: [[f64; 2]; 2],
}

impl Label {
    fn of(scene: &PictureScene, camera: &Camera, at: f64) -> Self {
        let on_screen = |point: DVec3| camera.screen(camera.view(point), STILL);
        let bodies: Vec<(DVec3, DVec3)> =
            scene.robot_at(at).iter().map(|surface| surface.bounds()).collect();
        let top = |(low, high): &(DVec3, DVec3)| (0.5 * (low + high)).with_z(high.z + LABEL_GAP);
        let head = bodies.iter().map(top).max_by(|a, b| a.z.total_cmp(&b.z)).unwrap_or_default();
        let head = on_screen(head);
        let corners = bodies.iter().flat_map(|(low, high)| [*low, *high]).map(on_screen);
        let beside = [head + LABEL_HALF, head - LABEL_HALF];
        let [low, high] = corners
            .chain(beside)
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], point| {
                [low.min(point), high.max(point)]
            });
        Self {
            text: format!("{:.1} s", scene.motion.time_at(at)),
            at: [head.x, head.y],
            nearness: head.z,
            covers: [[low.x, low.y], [high.x, high.y]],
        }
    }

    /// Whether this figure stands before the other one's label.
    fn hides(&self, other: &Self) -> bool {
        let [low, high] = self.covers;
        let is_within = |axis: usize| (low[axis]..=high[axis]).contains(&other.at[axis]);
        self.nearness > other.nearness && is_within(0) && is_within(1)
    }
}

/// The scale: the spacing of the grid on floors.
fn scale() -> String {
    format!("grid {GRID} m")
}

/// The robot walking.
pub fn frames(scene: &PictureScene) -> Vec<Image> {
    if scene.motion.len() == 1 {
        return fixed(scene, &[0.0]);
    }
    let moments = scene
        .motion
        .evenly_timed((FRAMES_PER_STANCE * scene.stances.len()).clamp(FRAMES_MIN, FRAMES_MAX));
    let roots: Vec<DVec3> =
        moments.iter().map(|at| scene.motion.world_from_links(*at)[0].translation).collect();
    let (low, high) = roots
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    if (high - low).length() > FIXED_VIEW_MAX {
        followed(scene, &moments, &roots)
    } else {
        fixed(scene, &moments)
    }
}

fn fixed(scene: &PictureScene, moments: &[f64]) -> Vec<Image> {
    let view = View::of(scene, &scene.sweep, MOVING);
    let sun = Renderer::sun(scene, &view);
    let renderer = Renderer::new(scene, view, sun, MOVING);
    let (progress, encoder) = (scene.motion.progress(), Encoder::new());
    moments.iter().map(|&at| frame(&renderer, &progress, at, &encoder)).collect()
}

/// As [`fixed`], but the camera sees a part of the walk and moves along.
fn followed(scene: &PictureScene, moments: &[f64], roots: &[DVec3]) -> Vec<Image> {
    let begin = roots[0];
    let seen: Vec<DVec3> = scene
        .sweep
        .iter()
        .copied()
        .filter(|point| point.distance(begin) < 0.5 * FOLLOWED_VIEW + 1.0)
        .collect();
    let view = View::of(scene, &seen, MOVING);
    let sun = Renderer::sun(scene, &view);
    let (progress, encoder) = (scene.motion.progress(), Encoder::new());
    let window = moments.len() / 8;
    let draw = |index: usize| {
        let near = &roots[index.saturating_sub(window)..(index + window + 1).min(roots.len())];
        let target = near.iter().sum::<DVec3>() / near.len() as f64;
        let view = View { camera: view.camera.moved(target - begin), glass: view.glass.clone() };
        frame(&Renderer::new(scene, view, sun.clone(), MOVING), &progress, moments[index], &encoder)
    };
    (0..moments.len()).into_par_iter().map(draw).collect()
}

fn frame(renderer: &Renderer<'_>, progress: &[f32], at: f64, encoder: &Encoder) -> Image {
    let waypoint = at as usize;
    let figures = [Figure { at, progress: progress[waypoint] }];
    let mut image = renderer.picture(&figures, Ground::At(waypoint), encoder);
    let seconds = format!("{:.1} s", renderer.scene().motion.time_at(at));
    write_title(&mut image, &[renderer.scene().title.clone(), seconds]);
    write_scale(&mut image, &scale());
    image
}
