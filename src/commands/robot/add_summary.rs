//! What `surefoot robot add` has found, chosen and estimated.

use std::collections::BTreeMap;
use std::path::Path;

use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::robot_draft::text::ROBOT_FILE;
use surefoot_shared_types::robot_draft::{DraftEstimates, DraftFoot, Noted, RobotDraft};

use crate::commands::robot::trial::Trial;

/// Largest share of a joint's effort on one foot at which walks are found, percent.
const STRAIN_MAX: f64 = 100.0;

/// Links without shapes are named from this mass on, kg.
const BARE_MASS_MIN: f64 = 0.1;

/// The summary, with the next commands.
pub(crate) fn summary(
    draft: &RobotDraft,
    model: &RobotModel,
    trial: &Trial,
    folder: &Path,
) -> String {
    let file = folder.join(ROBOT_FILE);
    let mut lines = vec![
        format!("wrote {}", file.display()),
        format!(
            "  robot      {}: {} joints move, {} are locked; {:.1} kg, root '{}'{}",
            draft.name,
            model.joints.len(),
            model.locked_joints.len(),
            model.mass(),
            draft.root,
            turned(draft)
        ),
    ];
    lines.extend(draft.feet.iter().map(foot_line));
    lines.push(format!(
        "  standing   {} joints off 0: knees bent, soles level",
        draft.posture.len()
    ));
    lines.extend(locked_lines(&draft.locked));
    lines.extend(estimate_lines(draft));
    lines.extend(exact_lines(&draft.exact_meshes));
    lines.extend(missing_line(&draft.missing_meshes));
    lines.extend(bare_links(model));
    lines.push(format!("  trial      {}", trial.line()));
    lines.extend(strain_line(trial));
    lines.extend(colliding_line(trial));
    lines.push(format!(
        "next: surefoot robot inspect {0} --picture robot.png; surefoot new first --robot {1}; surefoot walk first/scenario.toml",
        folder.display(),
        file.display()
    ));
    lines.join("\n")
}

fn turned(draft: &RobotDraft) -> String {
    let turned = draft.root_yaw.as_ref();
    turned.map_or_else(String::new, |yaw| {
        format!(", turned by {:.0} degrees: {}", yaw.value.to_degrees(), yaw.source)
    })
}

fn foot_line(foot: &DraftFoot) -> String {
    let extent = |axis: usize| {
        let along = foot.polygon.iter().map(|corner| corner[axis]);
        let low = along.clone().fold(f64::INFINITY, f64::min);
        along.fold(f64::NEG_INFINITY, f64::max) - low
    };
    format!(
        "  {:<10} {}: {:.0} x {:.0} mm, {}",
        format!("{} foot", foot.name),
        foot.link,
        1e3 * extent(0),
        1e3 * extent(1),
        foot.source
    )
}

/// The locked joints by the reason.
fn locked_lines(locked: &[Noted<f64>]) -> Vec<String> {
    let mut reasons: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for joint in locked {
        reasons.entry(&joint.source).or_default().push(&joint.name);
    }
    let line = |(reason, names): (&str, Vec<&str>)| {
        format!("  locked     {} ({reason})", names.join(", "))
    };
    reasons.into_iter().map(line).collect()
}

fn estimate_lines(draft: &RobotDraft) -> Vec<String> {
    let names = |values: Vec<&String>| -> String {
        values.into_iter().map(String::as_str).collect::<Vec<_>>().join(", ")
    };
    let DraftEstimates { position_limits, effort_limits, velocity_limits, inertias } =
        &draft.estimates;
    let tables = [
        ("position_limits", position_limits.iter().map(|value| &value.name).collect()),
        ("effort_limits", effort_limits.iter().map(|value| &value.name).collect()),
        ("velocity_limits", velocity_limits.iter().map(|value| &value.name).collect()),
        ("inertias", inertias.iter().map(|value| &value.name).collect::<Vec<_>>()),
    ];
    let has_any = tables.into_iter().filter(|(_, values)| !values.is_empty());
    has_any
        .map(|(table, values)| {
            format!("  estimated  [{table}], which the URDF does not state: {}", names(values))
        })
        .collect()
}

/// The links that keep their meshes, by the reason.
fn exact_lines(links: &[Noted<()>]) -> impl Iterator<Item = String> {
    links.iter().map(|link| format!("  exact mesh {}: {}", link.name, link.source))
}

/// Links whose mesh files are missing.
fn missing_line(links: &[Noted<()>]) -> Option<String> {
    let names: Vec<&str> = links.iter().map(|link| link.name.as_str()).collect();
    (!names.is_empty())
        .then(|| format!("  missing    the mesh files of {}: shapes left out", names.join(", ")))
}

/// Links with mass that no shape keeps from colliding.
fn bare_links(model: &RobotModel) -> Option<String> {
    let bare =
        model.links.iter().filter(|link| link.mass >= BARE_MASS_MIN && link.shapes.is_empty());
    let names: Vec<&str> = bare.map(|link| link.name.as_str()).collect();
    (!names.is_empty()).then(|| {
        format!(
            "  no shape   {} links have none, so nothing keeps them from colliding; visual_shapes can name them: {}",
            names.len(),
            names.join(", ")
        )
    })
}

fn colliding_line(trial: &Trial) -> Option<String> {
    let (links, percent) = trial.colliding.as_ref()?;
    Some(format!(
        "  advice     as the robot bends its knees and shifts its weight, {links} in {percent:.0} \
         % of its postures: few walks can be found; simpler shapes in the URDF may part them"
    ))
}

fn strain_line(trial: &Trial) -> Option<String> {
    let (joint, percent) = trial.strain.as_ref().filter(|(_, percent)| *percent > STRAIN_MAX)?;
    Some(format!(
        "  advice     on one foot '{joint}' needs {percent:.0} % of its effort limit: few walks can be found"
    ))
}
