//! Scenarios from pipes: generated ones.

use crate::shell::Folder;

#[test]
fn a_scenario_may_come_from_a_pipe() {
    let folder = Folder::new();
    let digest = |text: &str| {
        let line = text.lines().find(|line| line.contains("digest")).unwrap_or_default();
        line.to_owned()
    };
    let expected = digest(&folder.good("$S plan flat.toml --quiet").out);
    assert!(!expected.is_empty());
    folder.good("mkfifo pipe");
    for command in ["plan", "walk"] {
        for line in [
            "cat flat.toml | $S COMMAND - --quiet",
            "cat flat.toml | $S COMMAND /dev/stdin --quiet",
            "$S COMMAND - --quiet <flat.toml",
            "$S COMMAND /dev/stdin --quiet <flat.toml",
            "$S COMMAND /dev/fd/3 --quiet 3<flat.toml",
            "cat flat.toml >pipe & $S COMMAND pipe --quiet && wait",
        ] {
            let line = line.replace("COMMAND", command);
            assert_eq!(digest(&folder.good(&line).out), expected, "{line}");
        }
    }
    let shown = folder.good("cat endless.toml | $S config show -").out;
    let row = shown.lines().find(|line| line.starts_with("planner.work_max")).unwrap();
    assert!(row.contains("1000000000000"), "{row}");
    folder.good("cat flat.toml | $S doctor -");
    folder.good("$S plan flat.toml --quiet --export plan.json");
    folder.good("cat flat.toml | $S check plan.json --scenario -");
}

#[test]
fn relative_paths_of_a_piped_scenario_begin_in_the_working_folder() {
    let folder = Folder::new();
    folder.good("mkdir inner; cp walled.toml inner; sed 's/work_max.*/work_max = 2000/' endless.toml >inner/s.toml");
    let piped = folder.run("cd inner; cat s.toml | $S plan - --quiet");
    assert_eq!(piped.code, 3, "{}", piped.err);
    let err = folder.error("rm walled.toml; cat inner/s.toml | $S plan - --quiet");
    assert!(err.contains("walled.toml"), "{err}");
}

#[test]
fn broken_scenarios_from_a_pipe_name_their_line() {
    let folder = Folder::new();
    let err = folder.error("printf 'robot = 1\\n' | $S plan -");
    assert!(err.contains("/dev/stdin:1"), "{err}");
    let err = folder.error("$S plan - </dev/null");
    assert!(err.contains("/dev/stdin"), "{err}");
    let err = folder.error("printf '\\377\\376' | $S walk -");
    assert!(err.contains("not UTF-8"), "{err}");
}
