//! Chooses the links that keep their meshes: those whose convex hulls collide as the robot bends
//! its knees and shifts its weight, where the meshes do not.

use std::collections::BTreeSet;
use std::path::Path;

use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::base::text_file::folder_of;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::exact_meshes::{TRIANGLES_MAX, triangles_of};
use surefoot_shared_types::robot::load::robot_from_text;
use surefoot_shared_types::robot::model::{LinkIndex, RobotModel};
use surefoot_shared_types::robot_draft::text::robot_file;
use surefoot_shared_types::robot_draft::{Noted, RobotDraft};
use surefoot_shared_types::{InputError, Shape};

use crate::commands::colliding_links::{PERCENT_MIN, percents};
use crate::commands::robot::trial::level_ground;

/// Pairs of links that are tried.
const PAIRS_MAX: usize = 6;
/// Meshes that collide in more than this share of the postures in which the hulls do are of no use.
const GAIN_MIN: f64 = 0.5;

/// A robot with some links' exact meshes.
struct Tried {
    links: Vec<LinkIndex>,
    draft: RobotDraft,
    model: RobotModel,
    percent: f64,
}

/// The robot of a draft, whose file will stand at `path`. Links join `exact_meshes` of the draft
/// where their hulls collide with another link in many postures and their meshes in at most half
/// as many: of each pair the one, or both if that is better, with the same links of the other side.
///
/// # Errors
/// As [`robot_from_text`].
pub(crate) fn with_exact_links(
    mut draft: RobotDraft,
    path: &Path,
) -> Result<(RobotDraft, RobotModel), InputError> {
    let mut model = load(&draft, path)?;
    let mut seen = BTreeSet::new();
    while seen.len() < PAIRS_MAX {
        let Some((pair, percent)) = worst_pair(&model, &seen) else { break };
        seen.insert(pair);
        if let Some(tried) = best_choice(&draft, &model, path, (pair, percent)) {
            (draft, model) = (tried.draft, tried.model);
        }
    }
    Ok((draft, model))
}

fn load(draft: &RobotDraft, path: &Path) -> Result<RobotModel, InputError> {
    robot_from_text(robot_file(draft, &folder_of(path)), path)
}

/// The pairs of links that collide and the share of postures, percent; none if the planner cannot
/// use the robot, which the trial reports.
fn colliding(model: &RobotModel) -> Vec<([LinkIndex; 2], f64)> {
    let config = PlannerConfig::default();
    let Ok(robot) = Mechanism::new(model, &config) else { return Vec::new() };
    let Ok(collision) = CollisionModel::new(model, &level_ground(), config.clearance) else {
        return Vec::new();
    };
    percents(&robot, &collision).into_iter().collect()
}

/// The pair that collides most often, and in which share of the postures.
fn worst_pair(
    model: &RobotModel,
    seen: &BTreeSet<[LinkIndex; 2]>,
) -> Option<([LinkIndex; 2], f64)> {
    let is_candidate = |(pair, percent): &([LinkIndex; 2], f64)| {
        *percent >= PERCENT_MIN
            && !seen.contains(pair)
            && pair.iter().any(|&link| has_mesh_hull(model, link))
    };
    let pairs = colliding(model).into_iter().filter(is_candidate);
    pairs.reduce(|worst, pair| if pair.1 > worst.1 { pair } else { worst })
}

fn has_mesh_hull(model: &RobotModel, link: LinkIndex) -> bool {
    let is_hull = |shape: &Shape| matches!(shape, Shape::ConvexHull { source: Some(_), .. });
    model.links[link].shapes.iter().any(|part| is_hull(&part.shape))
}

/// The links of a pair whose meshes collide least: one link before both.
fn best_choice(
    draft: &RobotDraft,
    model: &RobotModel,
    path: &Path,
    (pair, percent): ([LinkIndex; 2], f64),
) -> Option<Tried> {
    let hulls: Vec<LinkIndex> =
        pair.into_iter().filter(|&link| has_mesh_hull(model, link)).collect();
    let mut choices: Vec<Vec<LinkIndex>> = hulls.iter().map(|&link| vec![link]).collect();
    if hulls.len() > 1 {
        choices.push(hulls);
    }
    let mut best: Option<Tried> = None;
    for choice in choices {
        let limit = best.as_ref().map_or(GAIN_MIN * percent, |best| best.percent);
        if limit == 0.0 {
            break;
        }
        let tried = attempt(draft, model, path, (pair, &choice));
        let is_better = |tried: &Tried| match &best {
            Some(best) => tried.percent < best.percent,
            None => tried.percent <= limit,
        };
        best = tried.filter(is_better).or(best);
    }
    let mut best = best?;
    let chosen = notes(model, pair, &best, percent);
    best.draft.exact_meshes = [draft.exact_meshes.clone(), chosen].concat();
    Some(best)
}

/// The robot with the exact meshes of these links of a pair and of their partners; none if they
/// have too many triangles.
fn attempt(
    draft: &RobotDraft,
    model: &RobotModel,
    path: &Path,
    (pair, choice): ([LinkIndex; 2], &[LinkIndex]),
) -> Option<Tried> {
    let mut links = choice.to_vec();
    links.extend(choice.iter().filter_map(|&link| partner(model, link)));
    let mut draft = draft.clone();
    let name = |&link: &LinkIndex| Noted {
        name: model.links[link].name.clone(),
        value: (),
        source: String::new(),
    };
    draft.exact_meshes.extend(links.iter().map(name));
    let exact = load(&draft, path).ok()?;
    if links.iter().any(|&link| triangles_of(&exact.links[link]) > TRIANGLES_MAX) {
        return None;
    }
    let percent = colliding(&exact).into_iter().find(|(links, _)| *links == pair);
    let percent = percent.map_or(0.0, |(_, percent)| percent);
    Some(Tried { links, draft, model: exact, percent })
}

/// The link of the other leg that has the place of this one.
fn partner(model: &RobotModel, link: LinkIndex) -> Option<LinkIndex> {
    let chains = [0, 1].map(|limb| -> Vec<LinkIndex> {
        let children = model.leg(limb).into_iter().map(|joint| model.joints[joint].child);
        children.chain([model.feet[limb].link]).collect()
    });
    let [left, right] = &chains;
    let of = |from: &[LinkIndex], to: &[LinkIndex]| {
        from.iter().position(|&at| at == link).and_then(|at| to.get(at).copied())
    };
    of(left, right).or_else(|| of(right, left)).filter(|&other| has_mesh_hull(model, other))
}

/// The links of a choice with the reason.
fn notes(model: &RobotModel, pair: [LinkIndex; 2], tried: &Tried, percent: f64) -> Vec<Noted<()>> {
    let name = |link: LinkIndex| model.links[link].name.as_str();
    let [a, b] = pair.map(name);
    let both = pair.iter().all(|link| tried.links.contains(link));
    let other = if tried.links.contains(&pair[0]) { b } else { a };
    let after = tried.percent;
    let reason = if both {
        format!(
            "chosen: as it bends its knees and shifts its weight, the hulls of '{a}' and '{b}' \
             collide in {percent:.0} % of its postures, the meshes in {after:.0} %"
        )
    } else {
        format!(
            "chosen: as it bends its knees and shifts its weight, its hull collides with \
             '{other}' in {percent:.0} % of its postures, the mesh in {after:.0} %"
        )
    };
    let note = |link: LinkIndex| {
        let of_pair = pair.contains(&link);
        let source =
            if of_pair { reason.clone() } else { "chosen: as on the other side".to_owned() };
        Noted { name: name(link).to_owned(), value: (), source }
    };
    tried.links.iter().map(|&link| note(link)).collect()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use glam::DVec3;
    use surefoot_shared_types::robot_draft::DraftOptions;

    use super::*;

    /// Corners of two bars beside the toes of Hubo's right foot, 3 mm higher than these where the
    /// robot stands, in the frame of the shin, as OBJ. The hull of both is above the toes.
    fn bars(model: &RobotModel) -> String {
        let root_from_links = model.root_from_links(&model.standing_q);
        let pose = |name: &str| {
            root_from_links[model.links.iter().position(|link| link.name == name).unwrap()]
        };
        let shin_from_foot = pose("right_shin").inverse() * pose("right_foot");
        let mut text = String::new();
        for y in [-0.1, 0.1] {
            for corner in 0..8 {
                let side = |bit: usize| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
                // The top of the foot's box is 0.08 m below the ankle.
                let from_middle = DVec3::new(0.008 * side(0), 0.004 * side(1), 0.02 * side(2));
                let at = shin_from_foot * (DVec3::new(0.1, y, -0.057) + from_middle);
                writeln!(text, "v {} {} {}", at.x, at.y, at.z).unwrap();
            }
        }
        let faces =
            [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
        for [a, b, c, d] in
            [0, 8].into_iter().flat_map(|bar| faces.map(|face| face.map(|at| at + bar)))
        {
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").unwrap();
        }
        text
    }

    #[test]
    fn a_link_whose_hull_alone_collides_keeps_its_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let [urdf, mesh, file] =
            ["hubo.urdf", "bars.obj", "robot.toml"].map(|name| folder.path().join(name));
        let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/robots/hubo/hubo.urdf");
        let text = std::fs::read_to_string(shipped).unwrap();
        std::fs::write(&urdf, &text).unwrap();
        let draft = || RobotDraft::from_urdf(&urdf, &DraftOptions::default()).unwrap();
        let (plain, model) = with_exact_links(draft(), &file).unwrap();
        assert!(plain.exact_meshes.is_empty());
        std::fs::write(&mesh, bars(&model)).unwrap();
        let link = "<link name=\"right_shin\">";
        let shape = "<collision><geometry><mesh filename=\"bars.obj\"/></geometry></collision>";
        std::fs::write(&urdf, text.replacen(link, &[link, shape].concat(), 1)).unwrap();
        let (chosen, exact) = with_exact_links(draft(), &file).unwrap();
        let [note] = &chosen.exact_meshes[..] else { panic!("{:?}", chosen.exact_meshes) };
        assert_eq!(note.name, "right_shin");
        let end = "% of its postures, the mesh in 0 %";
        assert!(
            note.source.contains("collides with 'right_foot'") && note.source.ends_with(end),
            "{note:?}"
        );
        assert!(colliding(&exact).iter().all(|(_, percent)| *percent < PERCENT_MIN));
        let written = robot_file(&chosen, folder.path());
        assert!(written.contains("exact_meshes = [\n  \"right_shin\",    # chosen: "), "{written}");
        assert_eq!(robot_from_text(written, &file).unwrap().links, exact.links);
    }
}
