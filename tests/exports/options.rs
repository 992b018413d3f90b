//! Options that are missing, wrong or not the format's, and files that have changed.

use crate::command::{CommandOutput, finish, surefoot};
use crate::plan::PLAN;

/// Exports the plan to a temporary file with these options.
fn attempt(arguments: &[&str]) -> CommandOutput {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let plan = PLAN.to_str().unwrap();
    let all = [&["export", plan, "--out", out.to_str().unwrap()], arguments].concat();
    let output = finish(surefoot(&all).spawn().unwrap());
    assert_eq!(out.exists(), output.code == 0, "{}", output.err);
    output
}

#[test]
fn nothing_is_chosen_silently() {
    let cases: [(&[&str], &str); 9] = [
        (&["--to", "csv", "--joint-order", "urdf", "--quat", "xyzw"], "csv needs --hz N"),
        (&["--to", "csv", "--hz", "50", "--quat", "xyzw"], "csv needs --joint-order urdf|surefoot"),
        (&["--to", "npz", "--hz", "50", "--joint-order", "urdf"], "npz needs --quat xyzw|wxyz"),
        (&["--to", "footsteps", "--hz", "50"], "footsteps takes no --hz"),
        (&["--to", "contacts", "--hz", "9", "--quat", "xyzw"], "contacts takes no --quat"),
        (&["--to", "mujoco", "--hz", "9"], "mujoco needs --joint-order"),
        (
            &["--to", "mujoco", "--hz", "9", "--joint-order", "right_knee"],
            "a keyframe holds all joints, and --joint-order lacks",
        ),
        (
            &["--to", "csv", "--hz", "9", "--quat", "xyzw", "--joint-order", "right_knee,knee"],
            "the robot has no moving joint 'knee'; it has ",
        ),
        (
            &[
                "--to",
                "csv",
                "--hz",
                "9",
                "--quat",
                "xyzw",
                "--joint-order",
                "right_knee,right_knee",
            ],
            "moving joint 'right_knee' is named twice",
        ),
    ];
    for (arguments, message) in cases {
        let output = attempt(arguments);
        assert_eq!(output.code, 2, "{arguments:?}");
        let lines = output.err.trim_end().lines().count();
        assert!(output.err.contains(message) && lines == 1, "{arguments:?}: {}", output.err);
    }
    assert!(attempt(&["--to", "bvh"]).err.contains("one of csv, npz, footsteps"));
    assert_eq!(attempt(&["--to", "footsteps"]).code, 0);
}

#[test]
fn a_plan_of_a_robot_that_has_changed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["robot.toml", "hubo.urdf"] {
        let robots = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots/hubo");
        std::fs::copy(robots.join(file), folder.path().join(file)).unwrap();
    }
    let mut plan: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&*PLAN).unwrap()).unwrap();
    let files = plan["origin"]["files"].as_object_mut().unwrap();
    let (name, digest) =
        files.iter().next().map(|(name, digest)| (name.clone(), digest.clone())).unwrap();
    assert!(name.ends_with("hubo.urdf") && digest.as_str().unwrap().len() == 64);
    files.clear();
    files.insert("hubo.urdf".into(), digest);
    plan["robot"]["urdf"] = "hubo.urdf".into();
    let path = folder.path().join("plan.json");
    std::fs::write(&path, plan.to_string()).unwrap();
    let export = || {
        let path = path.to_str().unwrap();
        let arguments = ["export", path, "--to", "footsteps", "--out", "/dev/null"];
        finish(surefoot(&arguments).spawn().unwrap())
    };
    assert_eq!(export().code, 0, "{}", export().err);
    let urdf = folder.path().join("hubo.urdf");
    let text = std::fs::read_to_string(&urdf).unwrap();
    std::fs::write(&urdf, format!("{text}<!-- another robot -->\n")).unwrap();
    let output = export();
    assert_eq!(output.code, 2);
    let message = "hubo.urdf: its content is not what the plan was made from; restore the file";
    assert!(output.err.contains(message), "{}", output.err);
}
