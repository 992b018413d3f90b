//! URDFs whose joints' frames lie elsewhere on their axes, and joints without `<limit>`.

use super::*;

/// Hubo with the frame of a leg's joint moved along x, its axis.
fn moved_joint(text: &str, joint: &str, by: f64) -> String {
    changed(text, &format!("<joint name=\"{joint}\""), "</joint>", |joint| {
        replaced(joint, "xyz=\"0 0 0\"", &format!("xyz=\"{by} 0 0\""))
    })
}

/// Hubo with the frame of a foot's joint 60 mm before the ankle, its shapes where they were.
fn moved_foot(text: &str, side: &str) -> String {
    let text = moved_joint(text, &format!("{side}_ankle_roll"), 0.06);
    changed(&text, &format!("<link name=\"{side}_foot\""), "</link>", |link| {
        replaced(link, "xyz=\"0.02 0 -0.1\"", "xyz=\"-0.04 0 -0.1\"")
    })
}

#[test]
fn toes_are_seen_from_the_ankle_wherever_the_foot_has_its_frame() {
    let (draft, _) = drafted(&moved_foot(&moved_foot(&hubo(), "left"), "right"));
    let (shipped, _) = drafted(&hubo());
    for (foot, known) in draft.feet.iter().zip(&shipped.feet) {
        let sole = foot.link_from_sole.translation;
        assert!(sole.abs_diff_eq(DVec3::new(-0.06, 0.0, -0.12), 1e-9), "{sole}");
        let corners = foot.polygon.iter().zip(&known.polygon);
        assert!(corners.into_iter().all(|(a, b)| a.abs_diff_eq(*b, 1e-9)), "{:?}", foot.polygon);
    }
    assert_eq!(draft.posture, shipped.posture);
}

#[test]
fn feet_are_side_by_side_whose_frames_are_not() {
    let (draft, model) = drafted(&moved_foot(&hubo(), "right"));
    assert!(draft.root_yaw.is_none(), "{:?}", draft.root_yaw);
    let soles = soles(&model);
    assert!((soles[0].translation.x - soles[1].translation.x).abs() < 1e-4, "{soles:?}");
}

#[test]
fn legs_mirror_each_other_though_their_frames_do_not() {
    let urdf = moved_joint(&moved_joint(&hubo(), "right_hip_roll", -0.06), "right_hip_pitch", 0.06);
    let (draft, _) = drafted(&urdf);
    assert_eq!(draft.feet[0].link, "left_foot");
}

/// Hubo whose legs turn on and on, as far as the file says.
fn without_limits() -> String {
    let mut urdf = hubo();
    for side in ["left", "right"] {
        for joint in ["hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"] {
            urdf =
                changed(&urdf, &format!("<joint name=\"{side}_{joint}\""), "</joint>", |joint| {
                    let (head, _) = joint.split_once("<limit").unwrap();
                    replaced(head, "revolute", "continuous") + "</joint>"
                });
        }
    }
    urdf
}

#[test]
fn continuous_joints_of_legs_need_no_limits() {
    let (draft, model) = drafted(&without_limits());
    let DraftEstimates { position_limits, effort_limits, velocity_limits, .. } = &draft.estimates;
    assert_eq!([position_limits.len(), effort_limits.len(), velocity_limits.len()], [12; 3]);
    let knee = model.joints.iter().find(|joint| joint.name == "left_knee").unwrap();
    assert!((knee.upper - std::f64::consts::FRAC_PI_2).abs() < 1e-5, "{knee:?}");
    let published = Published::new(&without_limits());
    let folder = published.folder.path();
    let text = robot_file(&published.draft().unwrap(), folder);
    let (head, _) = text.split_once("[velocity_limits]").unwrap();
    let error = robot_from_text(head.to_owned(), &folder.join("robot.toml"));
    let error = error.unwrap_err().to_string();
    assert!(error.contains("under [effort_limits] and [velocity_limits]"), "{error}");
}

#[test]
fn meshes_that_may_be_missing_are_passed_over_beside_other_errors() {
    let urdf = changed(&hubo(), "<link name=\"torso\"", "</link>", |link| {
        changed(link, "<geometry>", "</geometry>", |_| {
            "<geometry><mesh filename=\"trunk.obj\"/></geometry>".to_owned()
        })
    });
    let published = Published::new(&urdf);
    let options = DraftOptions { skip_missing_meshes: true, ..Default::default() };
    let draft = RobotDraft::from_urdf(&published.path(), &options).unwrap();
    let text = robot_file(&draft, published.folder.path());
    let broken = changed(&urdf, "<joint name=\"left_knee\"", "</joint>", |joint| {
        joint.split_once("<limit").unwrap().0.to_owned() + "</joint>"
    });
    std::fs::write(published.path(), broken).unwrap();
    let error = robot_from_text(text, &published.folder.path().join("robot.toml"));
    let error = error.unwrap_err().to_string();
    assert!(error.contains("'left_knee': has no <limit>"), "{error}");
    assert!(!error.contains("trunk.obj"), "{error}");
}

#[test]
fn short_legs_are_named_before_their_feet_lack_shapes() {
    let mut urdf = hubo();
    for side in ["left", "right"] {
        let head = format!("<joint name=\"{side}_hip_yaw\"");
        urdf = changed(&urdf, &head, ">", |joint| replaced(joint, "revolute", "fixed"));
        for link in ["foot", "ankle"] {
            let head = format!("<link name=\"{side}_{link}\"");
            urdf = changed(&urdf, &head, "</link>", |link| link.replace("collision>", "remark>"));
        }
    }
    let error = refusal(&urdf);
    for part in ["_foot' lie lowest", "5 moving joints", "not supported"] {
        assert!(error.contains(part), "{error}");
    }
}
