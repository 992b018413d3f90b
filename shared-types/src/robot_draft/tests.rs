//! Drafts of variants of the shipped URDF: each loads, stands level, and says what was decided.

#![allow(clippy::unwrap_used, reason = "a test ends where a draft is not made")]

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::geometry::convex_hull::polygon_area;
use crate::geometry::shape::Shape;
use crate::robot::load::robot_from_text;
use crate::robot::model::RobotModel;
use crate::robot_draft::text::robot_file;
use crate::robot_draft::{DraftEstimates, DraftFoot, DraftOptions, RobotDraft};

mod contact_points;
mod joint_frames;

/// Soles of a draft are level to within this angle, as a sine: positions have five decimals.
const LEVEL: f64 = 1e-4;

fn hubo() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/robots/hubo/hubo.urdf");
    std::fs::read_to_string(path).unwrap()
}

/// A URDF in a folder of its own.
struct Published {
    folder: tempfile::TempDir,
}

impl Published {
    fn new(urdf: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("robot.urdf"), urdf).unwrap();
        Self { folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("robot.urdf")
    }

    fn draft(&self) -> Result<RobotDraft, InputError> {
        RobotDraft::from_urdf(&self.path(), &DraftOptions::default())
    }

    fn load(&self, draft: &RobotDraft) -> RobotModel {
        let text = robot_file(draft, self.folder.path());
        robot_from_text(text, &self.folder.path().join("robot.toml")).unwrap()
    }
}

fn drafted(urdf: &str) -> (RobotDraft, RobotModel) {
    let published = Published::new(urdf);
    let draft = published.draft().unwrap();
    let model = published.load(&draft);
    assert_stands(&model);
    (draft, model)
}

fn refusal(urdf: &str) -> String {
    Published::new(urdf).draft().unwrap_err().to_string()
}

fn soles(model: &RobotModel) -> Vec<Pose> {
    let links = model.root_from_links(&model.standing_q);
    model.feet.iter().map(|foot| links[foot.link] * foot.link_from_sole).collect()
}

/// Both soles are level, at one height, point ahead, and lie left and right of the root.
fn assert_stands(model: &RobotModel) {
    let soles = soles(model);
    for sole in &soles {
        assert!((sole.rotation * DVec3::Z).truncate().length() < LEVEL, "{sole:?}");
        assert!((sole.rotation * DVec3::X - DVec3::X).length() < LEVEL, "{sole:?}");
    }
    assert!((soles[0].translation.z - soles[1].translation.z).abs() < 1e-4);
    assert!(soles[0].translation.y > soles[1].translation.y);
}

fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "no '{from}'");
    text.replace(from, to)
}

/// The text with a change in one element that begins with `head` and ends with `tail`.
fn changed(text: &str, head: &str, tail: &str, change: impl Fn(&str) -> String) -> String {
    let start = text.find(head).unwrap();
    let end = start + text[start..].find(tail).unwrap() + tail.len();
    format!("{}{}{}", &text[..start], change(&text[start..end]), &text[end..])
}

#[test]
fn the_shipped_robot_gets_its_soles_back() {
    let (draft, model) = drafted(&hubo());
    assert_eq!(draft.root, "pelvis");
    assert!(draft.root_yaw.is_none() && draft.visual_shapes.is_empty());
    assert_eq!(
        draft.feet.iter().map(|foot| foot.link.as_str()).collect::<Vec<_>>(),
        ["left_foot", "right_foot"]
    );
    for foot in &model.feet {
        assert!(foot.link_from_sole.translation.abs_diff_eq(DVec3::new(0.0, 0.0, -0.12), 1e-6));
        assert!((polygon_area(&foot.polygon) - 0.22 * 0.14).abs() < 1e-6);
    }
    assert_eq!(model.joints.len(), 27);
    let knee = model.joints.iter().position(|joint| joint.name == "left_knee").unwrap();
    assert!(model.standing_q[knee] > 0.2, "{}", model.standing_q[knee]);
}

#[test]
fn a_root_that_looks_backward_is_turned() {
    let base = "<robot name=\"hubo\"><link name=\"base\"/><joint name=\"turn\" type=\"fixed\"><parent \
                link=\"base\"/><child link=\"pelvis\"/><origin rpy=\"0 0 3.14159265359\"/></joint>";
    let (draft, _) = drafted(&replaced(&hubo(), "<robot name=\"hubo\">", base));
    let yaw = draft.root_yaw.unwrap();
    assert!((yaw.value.abs() - std::f64::consts::PI).abs() < 1e-9, "{yaw:?}");
    assert!(yaw.source.contains("names"), "{yaw:?}");
}

#[test]
fn toes_show_left_and_right_where_names_do_not() {
    let urdf = replaced(&replaced(&hubo(), "left_", "one_"), "right_", "two_");
    let (draft, _) = drafted(&urdf);
    assert_eq!(draft.feet[0].link, "one_foot");
}

#[test]
fn names_that_contradict_the_toes_are_asked_about() {
    let urdf = replaced(&replaced(&hubo(), "left_", "\u{e9}_"), "right_", "left_");
    let error = refusal(&replaced(&urdf, "\u{e9}_", "right_"));
    for part in ["feet", "--feet left_foot,right_foot", "--feet right_foot,left_foot"] {
        assert!(error.contains(part), "{error}");
    }
    assert_eq!(error.lines().count(), 1);
}

#[test]
fn legs_of_five_joints_are_named() {
    let fixed = |name: &str, text: &str| {
        changed(text, &format!("<joint name=\"{name}\""), ">", |joint| {
            joint.replace("revolute", "fixed")
        })
    };
    let urdf = fixed("left_ankle_roll", &fixed("right_ankle_roll", &hubo()));
    let error = refusal(&urdf);
    for part in ["left foot", "5 moving joints", "left_knee", "6 to 8", "not supported"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn what_the_urdf_does_not_state_is_estimated() {
    let urdf = changed(&hubo(), "<joint name=\"left_knee\"", "</joint>", |joint| {
        let (head, rest) = joint.split_once("effort=\"").unwrap();
        let (_, tail) = rest.split_once('"').unwrap();
        let (tail, _) = tail.split_once("velocity=").unwrap();
        format!("{head}effort=\"0\"{tail}/></joint>")
    });
    let urdf = changed(&urdf, "<link name=\"left_foot\"", "</link>", |link| {
        ["0.00282667", "0.00666667", "0.00906667"]
            .iter()
            .fold(link.to_owned(), |link, moment| link.replace(moment, "0"))
    });
    let (draft, model) = drafted(&urdf);
    assert_eq!(draft.estimates.effort_limits.len(), 1);
    assert_eq!(draft.estimates.velocity_limits.len(), 1);
    let knee = model.joints.iter().find(|joint| joint.name == "left_knee").unwrap();
    assert!(knee.effort > 100.0 && knee.velocity == 4.0, "{knee:?}");
    // The box of 0.22 x 0.14 x 0.04 m and 1.6 kg that the file had.
    let inertia = draft.estimates.inertias[0].value;
    assert!(inertia.abs_diff_eq(DVec3::new(0.002827, 0.006667, 0.009067), 1e-5), "{inertia}");
}

#[test]
fn a_foot_without_collision_shape_stands_on_its_looks() {
    let bare = |text: &str, foot: &str| {
        changed(text, &format!("<link name=\"{foot}\""), "</link>", |link| {
            link.replace("collision>", "visual>")
        })
    };
    let (draft, model) = drafted(&bare(&bare(&hubo(), "left_foot"), "right_foot"));
    let names: Vec<&str> = draft.visual_shapes.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["left_foot", "right_foot"]);
    assert!(draft.feet[0].source.contains("looks"), "{}", draft.feet[0].source);
    assert!(model.feet.iter().all(|foot| !model.links[foot.link].shapes.is_empty()));
}

#[test]
fn an_ankle_with_the_collision_shape_of_its_foot_is_taken_by_its_looks() {
    let sphere = "<sphere radius=\"0.045\"/>";
    let foot = "<origin xyz=\"0.02 0 -0.1\"/>\n      <geometry><box size=\"0.22 0.14 0.04\"/>";
    let urdf = changed(&hubo(), "<link name=\"right_foot\"", "</link>", |link| {
        link.replace("collision>", "visual>")
    });
    let urdf = changed(&urdf, "<link name=\"right_ankle\"", "</link>", |link| {
        let look = format!("<visual><geometry>{sphere}</geometry></visual></link>");
        let shape = format!("<origin xyz=\"0 0 0\"/>\n      <geometry>{sphere}");
        replaced(&replaced(link, &shape, foot), "</link>", &look)
    });
    let (draft, model) = drafted(&urdf);
    let names: Vec<&str> = draft.visual_shapes.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(names, ["right_foot", "right_ankle"]);
    let ankle = model.links.iter().find(|link| link.name == "right_ankle").unwrap();
    assert!(matches!(ankle.shapes[0].shape, Shape::Sphere { .. }));
}

#[test]
fn a_foot_of_balls_stands_on_its_looks() {
    let ball = |x: f64, y: f64| {
        format!(
            "<collision><origin xyz=\"{x} {y} -0.115\"/><geometry><sphere radius=\"0.005\"/>\
             </geometry></collision>"
        )
    };
    let corners = [(-0.08, -0.06), (-0.08, 0.06), (0.11, -0.06), (0.11, 0.06)];
    let balls: String = corners.iter().map(|&(x, y)| ball(x, y)).collect();
    let shown = |text: &str, foot: &str| {
        changed(text, &format!("<link name=\"{foot}\""), "</link>", |link| {
            let link = link.replace("collision>", "visual>");
            link.replace("</link>", &format!("{balls}</link>"))
        })
    };
    let (draft, model) = drafted(&shown(&shown(&hubo(), "left_foot"), "right_foot"));
    assert_eq!(draft.visual_shapes.len(), 2);
    assert!(draft.feet[0].source.contains("between its collision balls"), "{:?}", draft.feet[0]);
    let front = |foot: &DraftFoot| foot.polygon.iter().map(|c| c.x).fold(f64::MIN, f64::max);
    assert!(draft.feet.iter().all(|foot| (front(foot) - 0.11).abs() < 1e-5), "{:?}", draft.feet);
    assert!(model.feet.iter().all(|foot| model.links[foot.link].shapes.len() == 1));
}

/// Drake marks the points at which a foot touches the ground by spheres of radius 0, and shows them
/// by balls.
#[test]
fn spheres_of_radius_0_are_no_shapes() {
    // The foot's box ends at -0.12 m.
    let marks = |height: f64| {
        let corners = [(-0.08, -0.06), (-0.08, 0.06), (0.11, -0.06), (0.11, 0.06)];
        let mark = |(x, y): (f64, f64)| {
            let sphere = |tag: &str, radius: f64| {
                format!(
                    "<{tag}><origin xyz=\"{x} {y} {height}\"/><geometry>\
                     <sphere radius=\"{radius}\"/></geometry></{tag}>"
                )
            };
            sphere("collision", 0.0) + &sphere("visual", 0.01)
        };
        corners.map(mark).concat()
    };
    let marked = |height: f64, is_shown: bool| {
        ["left_foot", "right_foot"].iter().fold(hubo(), |text, foot| {
            changed(&text, &format!("<link name=\"{foot}\""), "</link>", |link| {
                let link =
                    if is_shown { link.replace("collision>", "visual>") } else { link.into() };
                link.replace("</link>", &format!("{}</link>", marks(height)))
            })
        })
    };
    for (urdf, looks) in [(marked(-0.122, false), 0), (marked(-0.12, true), 2)] {
        let (draft, model) = drafted(&urdf);
        assert_eq!(draft.visual_shapes.len(), looks);
        for (foot, found) in model.feet.iter().zip(&draft.feet) {
            assert!((foot.link_from_sole.translation.z + 0.12).abs() < 1e-6, "{found:?}");
            assert_eq!(model.links[foot.link].shapes.len(), 1);
        }
        let is_between_points = draft.feet[0].source.contains("between its collision balls");
        assert_eq!(is_between_points, looks > 0, "{:?}", draft.feet[0]);
    }
}

/// A foot of points whose look is in a format that is not read.
#[test]
fn a_foot_of_points_alone_is_named_with_its_look() {
    let marks = "<collision><geometry><sphere radius=\"0\"/></geometry></collision>";
    let look = "<visual><geometry><mesh filename=\"foot.wrl\"/></geometry></visual>";
    for (look, reason) in [("", ""), (look, "foot.wrl")] {
        let urdf = ["left_foot", "right_foot"].iter().fold(hubo(), |text, foot| {
            changed(&text, &format!("<link name=\"{foot}\""), "</link>", |link| {
                let (head, tail) = link.split_once("<collision>").unwrap();
                let tail = tail.split_once("</collision>").unwrap().1;
                let corners = [(-0.08, -0.06), (-0.08, 0.06), (0.11, -0.06), (0.11, 0.06)];
                let marks = corners.map(|(x, y)| {
                    let origin = format!("<collision><origin xyz=\"{x} {y} -0.12\"/>");
                    marks.replace("<collision>", &origin)
                });
                format!("{head}{}{look}{tail}", marks.concat())
            })
        });
        let published = Published::new(&urdf);
        std::fs::write(published.folder.path().join("foot.wrl"), "#VRML V2.0 utf8\n").unwrap();
        let error = published.draft().unwrap_err().to_string();
        let parts = ["left_foot", "a sphere of radius 0 is none", "a box is enough", reason];
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}

/// A heel behind the left foot, and one behind the right foot.
fn heels() -> String {
    let heel = |side: &str| {
        format!(
            "<link name=\"{side}_heel\"><collision><geometry><box size=\"0.04 0.1 0.04\"/></geometry>\
             </collision></link><joint name=\"{side}_heel_joint\" type=\"fixed\"><parent \
             link=\"{side}_foot\"/><child link=\"{side}_heel\"/><origin xyz=\"-0.12 0 -0.1\"/></joint>"
        )
    };
    replaced(&hubo(), "</robot>", &format!("{}{}</robot>", heel("left"), heel("right")))
}

#[test]
fn links_fixed_to_each_other_are_one_foot() {
    let (draft, model) = drafted(&heels());
    assert_eq!(draft.feet[0].link, "left_foot");
    let back = model.feet[0].polygon.iter().map(|corner| corner.x).fold(f64::INFINITY, f64::min);
    assert!((back + 0.14).abs() < 1e-6, "{back}");
}

/// A finger at each hand and a head, of which the second finger joint mimics the first.
fn fingers() -> String {
    let link = |name: &str| {
        format!(
            "<link name=\"{name}\"><inertial><mass value=\"0.02\"/><inertia ixx=\"1e-6\" ixy=\"0\" \
             ixz=\"0\" iyy=\"1e-6\" iyz=\"0\" izz=\"1e-6\"/></inertial></link>"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, more: &str| {
        format!(
            "<joint name=\"{name}\" type=\"revolute\"><parent link=\"{parent}\"/><child \
             link=\"{child}\"/><limit lower=\"0.1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>{more}</joint>"
        )
    };
    let mut added = link("skull") + &joint("nape", "torso", "skull", "");
    for side in ["left", "right"] {
        let (hand, tip) = (format!("{side}_finger"), format!("{side}_tip"));
        let mimic = format!("<mimic joint=\"{hand}_joint\" multiplier=\"1\"/>");
        added += &(link(&hand) + &link(&tip));
        added += &joint(&format!("{hand}_joint"), &format!("{side}_wrist_pitch_link"), &hand, "");
        added += &joint(&format!("{tip}_joint"), &hand, &tip, &mimic);
    }
    replaced(&hubo(), "</robot>", &format!("{added}</robot>"))
}

/// Hubo with arms that point to the sides where all joints stand at 0.
fn outstretched_arms() -> String {
    let roll = |urdf: &str, side: &str, rpy: &str| {
        changed(urdf, &format!("<joint name=\"{side}_shoulder_roll\""), "</joint>", |joint| {
            let joint =
                joint.replace("\"/>\n    <axis", &format!("\" rpy=\"{rpy} 0 0\"/>\n    <axis"));
            let limits = joint.find("<limit lower").unwrap();
            let rest = joint[limits..].find(" effort").unwrap() + limits;
            format!("{}<limit lower=\"-2\" upper=\"2\"{}", &joint[..limits], &joint[rest..])
        })
    };
    roll(&roll(&hubo(), "left", "1.5708"), "right", "-1.5708")
}

#[test]
fn outstretched_arms_hang_and_are_not_raised() {
    let (_, model) = drafted(&outstretched_arms());
    let links = model.root_from_links(&model.standing_q);
    let at = |name: &str| {
        let index = model.links.iter().position(|link| link.name == name).unwrap();
        links[index].translation
    };
    for side in ["left", "right"] {
        let (shoulder, forearm) =
            (at(&format!("{side}_upper_arm")), at(&format!("{side}_forearm")));
        let down = shoulder - forearm;
        assert!(down.z > 0.9 * down.length(), "the {side} arm points to {}", -down);
    }
}

#[test]
fn fingers_and_heads_are_locked_and_mimics_go_with_them() {
    let (draft, model) = drafted(&fingers());
    let names: Vec<&str> = draft.locked.iter().map(|joint| joint.name.as_str()).collect();
    for name in ["nape", "left_finger_joint", "right_finger_joint"] {
        assert!(names.contains(&name), "{names:?}");
    }
    assert!(!names.contains(&"left_tip_joint"), "{names:?}");
    let nape = draft.locked.iter().find(|joint| joint.name == "nape").unwrap();
    assert_eq!(nape.value, 0.1);
    assert!(model.locked_joints.iter().any(|locked| locked.joint.name == "left_tip_joint"));
}

/// Hubo with arms of the first `joints` joints; the others are fixed.
fn short_arms(joints: usize) -> String {
    let arm = ["shoulder_pitch", "elbow", "shoulder_roll", "shoulder_yaw"];
    let fixed = arm.iter().skip(joints).chain(&["wrist_yaw", "wrist_pitch", "wrist_roll"]);
    fixed.fold(hubo(), |urdf, joint| {
        ["left", "right"].iter().fold(urdf, |urdf, side| {
            let name = format!("<joint name=\"{side}_{joint}\" type=");
            replaced(&urdf, &format!("{name}\"revolute\""), &format!("{name}\"fixed\""))
        })
    })
}

#[test]
fn arms_of_two_joints_move_and_those_of_one_are_locked() {
    let (draft, model) = drafted(&short_arms(2));
    assert!(!draft.locked.iter().any(|joint| joint.name.contains("shoulder")));
    assert!(model.joints.iter().any(|joint| joint.name == "left_elbow"));
    // The hands pass through the thighs: without a roll of the shoulder its pitch clears them.
    let near = ["left", "right"].iter().fold(short_arms(2), |urdf, side| {
        changed(&urdf, &format!("<joint name=\"{side}_shoulder_pitch\""), "</joint>", |joint| {
            let at = joint.find("xyz=\"").unwrap() + 5;
            let end = at + joint[at..].find('"').unwrap();
            let xyz: Vec<&str> = joint[at..end].split(' ').collect();
            let aside = if *side == "left" { "0.12" } else { "-0.12" };
            format!("{}{} {aside} {}{}", &joint[..at], xyz[0], xyz[2], &joint[end..])
        })
    });
    let (draft, _) = drafted(&near);
    let turned = draft.posture.iter().find(|joint| joint.name == "left_shoulder_pitch");
    assert!(turned.is_some_and(|joint| joint.value != 0.0), "{:?}", draft.posture);
    let (draft, _) = drafted(&short_arms(1));
    let reason = "carries neither a leg nor an arm of two joints: a head, or a cover";
    let shoulder = draft.locked.iter().find(|joint| joint.name == "left_shoulder_pitch");
    assert_eq!(shoulder.unwrap().source, reason);
}

#[test]
fn a_joint_of_the_trunk_without_a_range_is_locked() {
    let urdf = changed(&hubo(), "<joint name=\"waist_yaw\"", "</joint>", |joint| {
        replaced(joint, "lower=\"-2\" upper=\"2\" ", "")
    });
    let (draft, _) = drafted(&urdf);
    assert_eq!(draft.locked[0].name, "waist_yaw");
    assert_eq!(draft.locked[0].source, "its <limit> states no range");
}

#[test]
fn named_feet_are_taken_or_asked_about() {
    let published = Published::new(&hubo());
    let draft = |left: &str, right: &str| {
        let feet = Some([left.to_owned(), right.to_owned()]);
        RobotDraft::from_urdf(&published.path(), &DraftOptions { feet, ..Default::default() })
    };
    assert_eq!(draft("left_foot", "right_foot").unwrap().feet[1].link, "right_foot");
    for (left, right, expected) in [
        ("left_fot", "right_foot", "did you mean 'left_foot'?"),
        ("left_foot", "left_foot", "fixed to each other"),
        ("left_foot", "left_ankle", "in one leg"),
    ] {
        let error = draft(left, right).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_robot_without_feet_is_answered_with_a_line_to_add() {
    let error = refusal(&changed(&hubo(), "<joint name=\"left_hip_yaw\"", "</joint>", |joint| {
        joint.replace("0.0885 0\"", "0.0885 0.3\"")
    }));
    assert!(error.contains("--feet"), "{error}");
}

#[test]
fn a_leg_without_a_stated_range_gets_an_estimate() {
    let bare = changed(&hubo(), "<joint name=\"left_hip_yaw\"", "</joint>", |joint| {
        let from = joint.find("lower=").unwrap();
        let to = joint.find("effort=").unwrap();
        format!("{}{}", &joint[..from], &joint[to..])
    });
    let (draft, model) = drafted(&bare);
    let estimate = &draft.estimates.position_limits[0];
    assert_eq!(
        (estimate.name.as_str(), draft.estimates.position_limits.len()),
        ("left_hip_yaw", 1)
    );
    let hip = model.joints.iter().find(|joint| joint.name == "left_hip_yaw").unwrap();
    let turn = std::f64::consts::FRAC_PI_2;
    assert!((hip.lower + turn).abs() < 1e-4 && (hip.upper - turn).abs() < 1e-4, "{hip:?}");
    // Without the estimate the file is refused, with the advice.
    let published = Published::new(&bare);
    let text = robot_file(&published.draft().unwrap(), published.folder.path());
    let text = changed(&text, "[position_limits]", "]  #", |_| "[accelerations]\n#".to_owned());
    let error = robot_from_text(text, &published.folder.path().join("robot.toml")).unwrap_err();
    let error = error.to_string();
    assert!(error.contains("neither lower nor upper") && error.contains("[position_limits]"));
}

#[test]
fn a_range_of_the_robot_file_lies_within_that_of_the_urdf() {
    let published = Published::new(&hubo());
    let text = robot_file(&published.draft().unwrap(), published.folder.path());
    let load = |joint: &str, range: &str| {
        let text = format!("{text}\n[position_limits]\n{joint} = {range}\n");
        robot_from_text(text, &published.folder.path().join("robot.toml"))
    };
    let model = load("left_knee", "[0.1, 1.5]").unwrap();
    let knee = model.joints.iter().find(|joint| joint.name == "left_knee").unwrap();
    assert_eq!((knee.lower, knee.upper), (0.1, 1.5));
    for (joint, range, expected) in [
        ("left_knee", "[-9.0, 1.5]", "within the URDF's"),
        ("left_knee", "[1.0, 1.0]", "is no range"),
        ("left_knee", "[nan, 1.0]", "is no range"),
        ("left_kne", "[0.0, 1.0]", "did you mean 'left_knee'?"),
    ] {
        let error = load(joint, range).unwrap_err().to_string();
        assert!(error.contains("[position_limits]") && error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn a_link_whose_mesh_is_missing_goes_without_only_if_asked() {
    let urdf = changed(&hubo(), "<link name=\"torso\"", "</link>", |link| {
        changed(link, "<geometry>", "</geometry>", |_| {
            "<geometry><mesh filename=\"trunk.obj\"/></geometry>".to_owned()
        })
    });
    let error = refusal(&urdf);
    for part in ["--skip-missing-meshes", "'torso': mesh 'trunk.obj' not found"] {
        assert!(error.contains(part), "{error}");
    }
    let two = replaced(&urdf, "<box size=\"0.1 0.2 0.12\"/>", "<mesh filename=\"hip.obj\"/>");
    assert!(refusal(&two).contains("mesh files of 2 of its"), "{}", refusal(&two));
    let published = Published::new(&urdf);
    let options = DraftOptions { skip_missing_meshes: true, ..Default::default() };
    let draft = RobotDraft::from_urdf(&published.path(), &options).unwrap();
    assert_eq!(draft.missing_meshes.len(), 1);
    assert_eq!(draft.missing_meshes[0].name, "torso");
    let shapes = || {
        let model = published.load(&draft);
        let torso = model.links.iter().find(|link| link.name == "torso").unwrap();
        torso.shapes.len()
    };
    assert_eq!(shapes(), 0);
    // A file that is there counts, whatever the robot file says.
    let corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n";
    let faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(published.folder.path().join("trunk.obj"), format!("{corners}{faces}")).unwrap();
    assert_eq!(shapes(), 1);
}

#[test]
fn feet_without_shapes_are_named_as_such() {
    let without = |text: &str, foot: &str| {
        changed(text, &format!("<link name=\"{foot}\""), "</link>", |link| {
            link.replace("collision>", "remark>")
        })
    };
    let urdf = without(&without(&hubo(), "left_foot"), "right_foot");
    let urdf = without(&without(&urdf, "left_ankle"), "right_ankle");
    let error = refusal(&urdf);
    for part in ["feet", "_foot' lie lowest and have no shape", "add a <collision>"] {
        assert!(error.contains(part), "{error}");
    }
}

/// A trunk with two arms of six joints, whose hands are boxes.
fn upper_body() -> String {
    let inertial = "<inertial><mass value=\"2\"/><inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" \
                    iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial>";
    let mut text = format!("<robot name=\"upper\"><link name=\"trunk\">{inertial}</link>");
    for (side, y) in [("left", 0.2), ("right", -0.2)] {
        let mut parent = "trunk".to_owned();
        for (at, axis) in ["1 0 0", "0 0 1", "0 1 0", "0 1 0", "0 1 0", "1 0 0"].iter().enumerate()
        {
            let link = format!("{side}_{at}");
            let (y, z) = if at == 0 { (y, 0.5) } else { (0.0, -0.1) };
            text += &format!(
                "<link name=\"{link}\">{inertial}<collision><geometry><box size=\"0.1 0.06 0.04\"/>\
                 </geometry></collision></link><joint name=\"{link}_joint\" type=\"revolute\">\
                 <parent link=\"{parent}\"/><child link=\"{link}\"/><origin xyz=\"0 {y} {z}\"/>\
                 <axis xyz=\"{axis}\"/><limit lower=\"-0.1\" upper=\"0.1\" effort=\"50\" \
                 velocity=\"2\"/></joint>"
            );
            parent = link;
        }
    }
    text + "</robot>"
}

#[test]
fn an_upper_body_has_no_legs() {
    let error = refusal(&upper_body());
    for part in ["'left_0_joint' to 'left_5'", "as arms do", "without legs cannot walk"] {
        assert!(error.contains(part), "{error}");
    }
}
