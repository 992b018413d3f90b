//! What a robot file or a plan's robot block says beside the URDF, in one form for both.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::{DQuat, DVec2};

use crate::base::input_error::InputError;
use crate::base::limits::POLYGON_VERTICES_MAX;
use crate::base::spatial::Pose;
use crate::base::text_file::{FileLocation, check_numbers};
use crate::geometry::convex_hull::{convex_polygon, polygon_area};
use crate::plan_format::blocks::UrdfAdditions;
use crate::robot::model::AllowedOverlap;

/// The smallest area of a sole, m2.
const SOLE_AREA_MIN: f64 = 1e-6;
/// How far a sole's outline may lie within its convex hull, by rounding, m.
const CONCAVE_MAX: f64 = 1e-4;
/// How far a sole may reach from its frame, m.
const SOLE_REACH_MAX: f64 = 1.0;

/// All that is not in the URDF.
pub(crate) struct RobotSpec {
    /// The robot file, if there is one.
    pub(crate) path: Option<PathBuf>,
    /// Path of the URDF.
    pub(crate) urdf_path: PathBuf,
    /// The URDF's root link, if the file states it.
    pub(crate) root: Option<(String, FileLocation)>,
    /// How the planned root stands in it; as it does unless the file turns it.
    pub(crate) urdf_root_from_root: Option<DQuat>,
    /// Links whose meshes stay meshes.
    pub(crate) exact_meshes: Vec<(String, FileLocation)>,
    /// The feet, in the order of [`FOOT_NAMES`](crate::robot::model::FOOT_NAMES).
    pub(crate) feet: Vec<FootSpec>,
    /// Joint positions of the standing posture.
    pub(crate) standing: JointValues,
    /// Joints held still.
    pub(crate) locked: JointValues,
    /// Tighter effort limits.
    pub(crate) effort_limits: JointValues,
    pub(crate) accelerations: JointValues,
    /// What the URDF lacks, and where the file states it.
    pub(crate) additions: UrdfAdditions,
    pub(crate) additions_location: FileLocation,
    /// Links that may overlap, and where the file states it.
    pub(crate) allowed_overlaps: Vec<(AllowedOverlap, FileLocation)>,
    /// A factor on all effort limits, at most 1.
    pub(crate) effort_scale: f64,
    /// What counts for the digest.
    pub(crate) bytes: Vec<u8>,
}

/// Numbers by joint name, and where each stands.
pub(crate) type JointValues = BTreeMap<String, (f64, FileLocation)>;

/// A foot as a file describes it.
pub(crate) struct FootSpec {
    pub(crate) name: String,
    pub(crate) link: String,
    pub(crate) link_from_sole: Pose,
    pub(crate) polygon: Vec<DVec2>,
    pub(crate) location: FileLocation,
}

impl FootSpec {
    /// A foot whose sole is `outline`, without corners that lie on its edges; the message names the
    /// problem of it.
    pub(crate) fn new(
        name: String,
        link: String,
        link_from_sole: Pose,
        outline: &[[f64; 2]],
        location: FileLocation,
    ) -> Result<Self, InputError> {
        match sole_polygon(outline) {
            Ok(polygon) => Ok(Self { name, link, link_from_sole, polygon, location }),
            Err(message) => Err(location.error(format!("foot '{name}'"), message)),
        }
    }
}

fn sole_polygon(outline: &[[f64; 2]]) -> Result<Vec<DVec2>, String> {
    check_numbers("polygon", outline.as_flattened())?;
    if let Some(far) = outline.as_flattened().iter().find(|number| number.abs() > SOLE_REACH_MAX) {
        return Err(format!(
            "polygon reaches {far} m from the sole frame; at most {SOLE_REACH_MAX} m is allowed"
        ));
    }
    let outline: Vec<DVec2> = outline.iter().map(|point| DVec2::from_array(*point)).collect();
    let polygon = convex_polygon(&outline);
    if polygon.len() < 3 || polygon_area(&polygon) < SOLE_AREA_MIN {
        return Err(format!(
            "polygon is degenerate; its corners must enclose at least {SOLE_AREA_MIN:e} m2"
        ));
    }
    if polygon.len() > POLYGON_VERTICES_MAX {
        return Err(format!(
            "polygon's convex hull has {} corners; at most {POLYGON_VERTICES_MAX} are allowed",
            polygon.len()
        ));
    }
    check_convex(&outline, &polygon)?;
    Ok(polygon)
}

/// An error unless an outline is its convex hull: nothing outside of the sole carries.
fn check_convex(outline: &[DVec2], hull: &[DVec2]) -> Result<(), String> {
    let edges = || hull.iter().zip(hull.iter().cycle().skip(1));
    let inside = |corner: &DVec2| {
        let within = |(a, b): (&DVec2, &DVec2)| (*b - *a).normalize().perp_dot(*corner - *a);
        edges().map(within).fold(f64::INFINITY, f64::min)
    };
    if let Some(corner) = outline.iter().find(|corner| inside(corner) > CONCAVE_MAX) {
        return Err(format!(
            "polygon is not convex: corner [{}, {}] lies {:.1} mm inside the outline of the \
             others; leave it out, or choose the largest convex part that carries",
            corner.x,
            corner.y,
            1e3 * inside(corner)
        ));
    }
    let perimeter: f64 = edges().map(|(a, b)| a.distance(*b)).sum();
    let differs = (polygon_area(hull) - polygon_area(outline).abs()).abs();
    if differs > CONCAVE_MAX * perimeter {
        return Err("polygon crosses itself; list its corners in order around the sole".into());
    }
    Ok(())
}
