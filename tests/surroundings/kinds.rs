//! Files of a wrong kind, names that are nearly right, and text that a terminal would obey.

use crate::shell::Folder;

/// A folder with one file of each kind.
fn folder_of_kinds() -> Folder {
    let folder = Folder::new();
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/robots/hubo");
    folder.good(&format!("cp {robots}/robot.toml {robots}/hubo.urdf ."));
    folder.good("$S plan flat.toml --quiet --export plan.json --json report.json");
    folder.good("mkdir inner; head -c 80 /dev/zero >mesh.stl; printf '\\1\\0\\0\\0' >>mesh.stl");
    folder.good("head -c 50 /dev/zero >>mesh.stl; printf '\\211PNG\\r\\n\\032\\n' >picture.png");
    folder.good("gzip -c flat.toml >flat.toml.gz");
    folder.write("robot.xacro", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"/>");
    folder
}

#[test]
fn a_file_of_another_kind_is_named_with_the_next_step() {
    let folder = folder_of_kinds();
    for (command, file, expected) in [
        ("plan", "robot.toml", "is a robot file, and a scenario is needed; name it in a scenario"),
        ("walk", "hubo.urdf", "is a URDF, and a scenario is needed; 'surefoot robot add'"),
        ("plan", "walled.toml", "is a world, and a scenario is needed"),
        ("plan", "plan.json", "is a plan, and a scenario is needed; 'surefoot check'"),
        ("walk", "report.json", "is a report, and a scenario is needed; 'surefoot explain'"),
        ("plan", "mesh.stl", "is a mesh, and a scenario is needed"),
        ("plan", "picture.png", "is a picture, and a scenario is needed"),
        ("plan", "flat.toml.gz", "is a compressed file, and a scenario is needed"),
        ("plan", "./inner", "is a folder"),
        ("config show", "walled.toml", "is a world, and a scenario is needed"),
        ("check", "flat.toml", "is a scenario, and a plan is needed"),
        ("check", "report.json", "is a report, and a plan is needed"),
        ("check", "mesh.stl", "is a mesh, and a plan is needed"),
        ("prepare", "hubo.urdf", "is a URDF, and a robot file is needed"),
        ("prepare", "robot.xacro", "is a xacro file, and a robot file is needed"),
        ("prepare", "flat.toml", "is a scenario, and a robot file is needed"),
    ] {
        let err = folder.error(&format!("$S {command} {file}"));
        assert!(err.contains(file) && err.contains(expected), "{command} {file}: {err}");
    }
}

#[test]
fn a_file_of_another_kind_inside_a_file_is_named_too() {
    let folder = folder_of_kinds();
    for (key, file, expected) in [
        ("robot", "hubo.urdf", "hubo.urdf: is a URDF, and a robot file is needed"),
        ("robot", "flat.toml", "flat.toml: is a scenario, and a robot file is needed"),
        ("world", "robot.toml", "robot.toml: is a robot file, and a world is needed"),
        ("world", "mesh.stl", "mesh.stl: is a mesh, and a world is needed"),
        ("world", "inner", "inner: is a folder"),
    ] {
        let line = format!("sed 's#^{key} = .*#{key} = \"{file}\"#' flat.toml | $S plan -");
        let err = folder.error(&line);
        assert!(err.contains(expected), "{key} {file}: {err}");
    }
    let line = "sed 's#^urdf = .*#urdf = \"mesh.stl\"#' robot.toml >r.toml; $S prepare r.toml";
    let err = folder.error(line);
    assert!(err.contains("mesh.stl: is a mesh, and a URDF is needed"), "{err}");
}

#[test]
fn names_that_are_nearly_right_are_proposed() {
    let folder = Folder::new();
    for (line, expected) in [
        ("$S plan falt.toml", "did you mean 'flat.toml'?"),
        ("$S walk Flat.toml", "did you mean 'flat.toml'?"),
        ("sed 's#hubo/robot.toml#hubo/robto.toml#' flat.toml | $S plan -", "hubo/robot.toml'?"),
        ("sed 's#robots/hubo/#robots/hobo/#' flat.toml | $S plan -", "robots/hubo'?"),
        ("sed 's#flat_walk.toml#flat_wlak.toml#' flat.toml | $S plan -", "worlds/flat_walk.toml'?"),
        ("sed 's#work_max#wrok_max#' endless.toml | $S plan -", "did you mean `work_max`?"),
        ("sed 's#^seed#sede#' flat.toml | $S plan -", "did you mean `seed`?"),
        ("sed 's#\\[goal\\]#[gaol]#' flat.toml | $S plan -", "did you mean `goal`?"),
    ] {
        let err = folder.error(line);
        assert!(err.contains(expected), "{line}: {err}");
    }
    let option = folder.run("$S plan flat.toml --exprot plan.json");
    assert!(option.code == 2 && option.err.contains("--export"), "{}", option.err);
}

#[test]
fn no_character_that_a_terminal_obeys_is_printed() {
    let folder = Folder::new();
    let evil = "\u{1b}[2J\u{7}\u{9b}31m\u{202e}";
    let flat = String::from_utf8(folder.read("flat.toml")).unwrap();
    let world = flat.lines().find(|line| line.starts_with("world")).unwrap();
    for text in [
        format!("{evil}\n{flat}"),
        format!("{flat}\n\"{evil}\" = 1\n"),
        flat.replacen(world, "world = \"\\u001b[2J\\u0007.toml\"", 1),
        flat.replacen(
            world,
            &format!("world = '{}.toml'", evil.replace(['\u{1b}', '\u{7}'], "")),
            1,
        ),
    ] {
        folder.write("evil.toml", &text);
        for command in ["plan", "walk", "config show"] {
            let output = folder.run(&format!("$S {command} evil.toml"));
            let shown = output.out + &output.err;
            let is_obeyed = |letter: char| {
                letter.is_control() && letter != '\n' || ('\u{202a}'..='\u{202e}').contains(&letter)
            };
            assert!(!shown.contains(is_obeyed), "{command}: {shown:?}");
        }
    }
    folder.good("cp flat.toml \"$(printf 'a\\033b.toml')\"");
    let shown = folder.good("$S config show --json \"$(printf 'a\\033b.toml')\"").out;
    let value: serde_json::Value = serde_json::from_str(&shown).unwrap();
    assert_eq!(value["scenario"], "a\u{1b}b.toml");
}

#[test]
fn a_package_above_the_working_folder_is_found() {
    let folder = Folder::new();
    let robots = concat!(env!("CARGO_MANIFEST_DIR"), "/configs/robots/hubo");
    folder.good("mkdir -p legs/urdf legs/meshes");
    folder.good(&format!("cp {robots}/robot.toml {robots}/hubo.urdf legs/urdf"));
    folder.write("legs/package.xml", "<package><name>legs</name></package>");
    let corner = "v 0 0 0\nv 0.04 0 0\nv 0 0.04 0\nv 0 0 0.04\n";
    let mesh = format!("{corner}f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    folder.write("legs/meshes/head.obj", &mesh);
    let mesh = "<mesh filename=\"package://legs/meshes/head.obj\"/>";
    folder.good(&format!("sed -i 's|<cylinder.*length=\"0.08\"/>|{mesh}|' legs/urdf/hubo.urdf"));
    folder.good("grep -q package: legs/urdf/hubo.urdf");
    for line in
        ["$S robot inspect legs/urdf/robot.toml", "cd legs/urdf; $S robot inspect robot.toml"]
    {
        folder.good(line);
    }
}
