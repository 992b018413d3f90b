//! Writes a draft as a `robot.toml` with comments.

use std::fmt::Write;
use std::path::Path;

use glam::{DQuat, DVec3};

use crate::base::text_file::relative_path;
use crate::robot_draft::draft::{DraftFoot, Noted, RobotDraft};

/// The name of every robot file.
pub const ROBOT_FILE: &str = "robot.toml";

/// Lengths and angles are written with this many decimals.
const DECIMALS: usize = 5;

/// The text of the robot file that will stand in `folder`.
pub fn robot_file(draft: &RobotDraft, folder: &Path) -> String {
    let mut text = format!(
        "# {}: drafted by 'surefoot robot add' from its URDF. Metres and radians.\n\
         # Every value may be changed; 'surefoot robot inspect' shows the robot as it is read.\n\
         urdf = {}    # relative to this file\n\
         root = {}    # the URDF's root link\n",
        one_line(&draft.name),
        quoted(&relative_path(&draft.urdf_path, folder)),
        quoted(&draft.root),
    );
    if let Some(yaw) = &draft.root_yaw {
        let _ = writeln!(text, "root_rpy = [0.0, 0.0, {}]    # {}", number(yaw.value), yaw.source);
    }
    push_links(&mut text, "visual_shapes", &draft.visual_shapes);
    push_links(&mut text, "missing_meshes", &draft.missing_meshes);
    push_exact_meshes(&mut text, &draft.exact_meshes);
    draft.feet.iter().for_each(|foot| push_foot(&mut text, foot));
    push_packages(&mut text, draft, folder);
    let comments = [
        "The start posture. Joints not named stand at 0, or as near to it as their limits allow.",
        "Held still and left out of plans. Remove a line to let its joint move (48 at most).",
        "Estimates, N m: replace them by the maker's values.",
        "Estimates, rad/s: replace them by the maker's values.",
    ];
    let tables = [
        ("standing", &draft.posture),
        ("locked", &draft.locked),
        ("effort_limits", &draft.estimates.effort_limits),
        ("velocity_limits", &draft.estimates.velocity_limits),
    ];
    for ((name, values), comment) in tables.into_iter().zip(comments) {
        push_table(&mut text, name, comment, values, |value| number(*value));
    }
    let comment = "Estimates, rad: replace them by the maker's values.";
    let ranges = &draft.estimates.position_limits;
    push_table(&mut text, "position_limits", comment, ranges, |range| pair(*range));
    let comment = "Estimates about the centre of mass along the link's axes, kg m2.";
    push_table(&mut text, "inertias", comment, &draft.estimates.inertias, |value| moments(*value));
    text
}

fn push_links(text: &mut String, list: &str, links: &[Noted<()>]) {
    let Some(first) = links.first() else { return };
    let names: Vec<String> = links.iter().map(|link| quoted(&link.name)).collect();
    let _ = writeln!(text, "{list} = [{}]    # {}", names.join(", "), first.source);
}

fn push_exact_meshes(text: &mut String, links: &[Noted<()>]) {
    if links.is_empty() {
        return;
    }
    text.push_str(
        "# Links that keep their meshes; others become convex hulls.\nexact_meshes = [\n",
    );
    for link in links {
        let _ = writeln!(text, "  {},    # {}", quoted(&link.name), one_line(&link.source));
    }
    text.push_str("]\n");
}

fn push_packages(text: &mut String, draft: &RobotDraft, folder: &Path) {
    if !draft.packages.is_empty() {
        text.push_str(
            "\n# Where the packages of package:// are, relative to this file.\n[packages]\n",
        );
    }
    for (name, package) in &draft.packages {
        let path = relative_path(Path::new(package), folder);
        let _ = writeln!(text, "{} = {}", key(name), quoted(&path));
    }
}

fn push_foot(text: &mut String, foot: &DraftFoot) {
    let (xyz, rpy) = (foot.link_from_sole.translation, rpy(foot.link_from_sole.rotation));
    let corners: Vec<String> = foot
        .polygon
        .iter()
        .map(|corner| format!("[{}, {}]", number(corner.x), number(corner.y)))
        .collect();
    let _ = writeln!(
        text,
        "\n[[feet]]\nname = {}\nlink = {}\n# The sole: {}.\nsole_xyz = {}    # below the ankle\nsole_rpy = {}\npolygon = [",
        quoted(foot.name),
        quoted(&foot.link),
        one_line(&foot.source),
        triple(xyz),
        triple(rpy),
    );
    for row in corners.chunks(4) {
        let _ = writeln!(text, "  {},", row.join(", "));
    }
    text.push_str("]\n");
}

fn push_table<T>(
    text: &mut String,
    name: &str,
    comment: &str,
    values: &[Noted<T>],
    shown: impl Fn(&T) -> String,
) {
    if values.is_empty() {
        return;
    }
    let _ = writeln!(text, "\n# {comment}\n[{name}]");
    let width = values.iter().map(|value| key(&value.name).len()).max().unwrap_or(0);
    for value in values {
        let (name, shown) = (key(&value.name), shown(&value.value));
        let _ = writeln!(text, "{name:<width$} = {shown:<8}  # {}", one_line(&value.source));
    }
}

/// A TOML key, quoted where it must be.
fn key(name: &str) -> String {
    let is_bare = |letter: char| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-');
    if !name.is_empty() && name.chars().all(is_bare) { name.to_owned() } else { quoted(name) }
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            letter if letter.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(letter));
            }
            letter => quoted.push(letter),
        }
    }
    quoted + "\""
}

fn one_line(text: &str) -> String {
    text.replace(char::is_control, " ")
}

fn triple(values: DVec3) -> String {
    format!("[{}, {}, {}]", number(values.x), number(values.y), number(values.z))
}

fn pair([lower, upper]: [f64; 2]) -> String {
    format!("[{}, {}]", number(lower), number(upper))
}

fn moments(values: DVec3) -> String {
    format!("[{:.3e}, {:.3e}, {:.3e}]", values.x, values.y, values.z)
}

/// A number with few decimals, and one at least.
fn number(value: f64) -> String {
    let text = format!("{value:.DECIMALS$}");
    let text = text.trim_end_matches('0');
    let text = if text.ends_with('.') { format!("{text}0") } else { text.to_owned() };
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

/// Roll, pitch and yaw about fixed axes.
fn rpy(rotation: DQuat) -> DVec3 {
    let [x, y, z] = DVec3::AXES.map(|axis| rotation * axis);
    let level = libm::hypot(x.x, x.y);
    DVec3::new(libm::atan2(y.z, z.z), libm::atan2(-x.z, level), libm::atan2(x.y, x.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::spatial::rotation_from_rpy;

    #[test]
    fn numbers_are_short_and_floats() {
        for (value, text) in [(0.0, "0.0"), (-1e-9, "0.0"), (0.25, "0.25"), (-0.123456, "-0.12346")]
        {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn names_are_quoted_where_toml_needs_it() {
        assert_eq!(key("left_knee"), "left_knee");
        assert_eq!(key("left knee/1"), "\"left knee/1\"");
        assert_eq!(quoted("a\"b\\\n"), "\"a\\\"b\\\\\\u000A\"");
    }

    #[test]
    fn roll_pitch_and_yaw_are_those_of_a_robot_file() {
        let angles = rpy(rotation_from_rpy(0.1, -0.2, 2.5));
        assert!(angles.abs_diff_eq(DVec3::new(0.1, -0.2, 2.5), 1e-12), "{angles}");
    }
}
