//! The Python listener receives the messages of a running walk. Skipped without the `iceoryx2`
//! package, or failed if `SUREFOOT_REQUIRE_ALL` is set. `SUREFOOT_PYTHON` names another
//! interpreter.

#![allow(clippy::print_stdout, reason = "a test prints why it is skipped")]
#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use command::{finish, scenario, surefoot};
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;

/// Most chunks that the listener may miss: on a busy machine it may fall behind by more than its
/// buffer of eight, and no process waits for it.
const MISSED_MAX: usize = 8;

#[test]
fn a_python_program_receives_the_chunks_and_the_robot_state() {
    let python = std::env::var("SUREFOOT_PYTHON").unwrap_or_else(|_| "python3".into());
    let imports =
        Command::new(&python).args(["-c", "import iceoryx2"]).stderr(Stdio::null()).status();
    if !imports.is_ok_and(|status| status.success()) {
        return absent::skip(&format!(
            "{python} has no iceoryx2 package; pip install iceoryx2==0.10.0, or set SUREFOOT_PYTHON"
        ));
    }
    let name = format!("test-python-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let _services = Observer::open(&instance).unwrap();
    let mut listener = Command::new(python);
    listener
        .args(["tools/mirrors/listen.py", &name, "--states-every", "500"])
        .current_dir(env!("CARGO_MANIFEST_DIR"));
    let mut listener = listener.stdout(Stdio::piped()).spawn().unwrap();
    let mut out = BufReader::new(listener.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    assert_eq!(line, format!("listening to {name}\n"));
    let file = scenario("stepping_stones");
    let control =
        surefoot(&["control", &file, "--instance", &name, "--rate", "40"]).spawn().unwrap();
    let plan = surefoot(&["plan", &file, "--quiet", "--instance", &name]).spawn().unwrap();
    let (control, plan) = (finish(control), finish(plan));
    assert_eq!((control.code, plan.code), (0, 0), "{}{}", control.err, plan.err);
    let mut rest = String::new();
    out.read_to_string(&mut rest).unwrap();
    assert!(listener.wait().unwrap().success());
    let number = |line: &str| {
        line.strip_prefix("chunk ")?.split_once(" of plan 1, epoch 0: ")?.0.parse::<usize>().ok()
    };
    let received: Vec<usize> = rest.lines().filter_map(number).collect();
    let accepted: usize = control
        .out
        .split(" chunks walked")
        .next()
        .unwrap()
        .trim()
        .rsplit(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!(
        received.is_sorted_by(|a, b| a < b) && received.last().is_some_and(|last| *last < accepted),
        "{rest}"
    );
    assert!(
        received.len() + MISSED_MAX >= accepted,
        "{} of {accepted} received: {rest}",
        received.len()
    );
    let is_robot = |line: &str| {
        line.starts_with("robot at ")
            && line.contains(" s: centre of mass ")
            && line.contains(", feet carry ")
    };
    assert!(rest.lines().any(is_robot), "{rest}");
}
