//! The Python listener hears a running walk. Skipped where the `iceoryx2` package is missing; `SUREFOOT_PYTHON` names another
//! interpreter, such as that of an environment which has it.

#![allow(clippy::print_stdout, reason = "a test says what it skips")]
#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use command::{finish, scenario, surefoot};
use surefoot_shared_types::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;

#[test]
fn a_python_program_hears_every_chunk_and_the_robot() {
    let python = std::env::var("SUREFOOT_PYTHON").unwrap_or_else(|_| "python3".into());
    let imports = Command::new(&python).args(["-c", "import iceoryx2"]).stderr(Stdio::null()).status();
    if !imports.is_ok_and(|status| status.success()) {
        println!("skipped: {python} has no iceoryx2 package; pip install iceoryx2==0.10.0, or set SUREFOOT_PYTHON");
        return;
    }
    let name = format!("test-python-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let _services = Observer::open(&instance).unwrap();
    let mut listener = Command::new(python);
    listener.args(["tools/mirrors/listen.py", &name, "--states-every", "500"]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let mut listener = listener.stdout(Stdio::piped()).spawn().unwrap();
    let mut out = BufReader::new(listener.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    assert_eq!(line, format!("listening to {name}\n"));
    let file = scenario("stepping_stones");
    let control = surefoot(&["control", &file, "--instance", &name, "--rate", "40"]).spawn().unwrap();
    let plan = surefoot(&["plan", &file, "--quiet", "--instance", &name]).spawn().unwrap();
    let (control, plan) = (finish(control), finish(plan));
    assert_eq!((control.code, plan.code), (0, 0), "{}{}", control.err, plan.err);
    let mut rest = String::new();
    out.read_to_string(&mut rest).unwrap();
    assert!(listener.wait().unwrap().success());
    let heard: Vec<&str> = rest.lines().filter(|line| line.starts_with("chunk ")).collect();
    let accepted: usize = control.out.split(" chunks walked").next().unwrap().trim().rsplit(' ').next().unwrap().parse().unwrap();
    assert_eq!(heard.len(), accepted, "{rest}");
    assert!(heard.iter().enumerate().all(|(index, line)| line.starts_with(&format!("chunk {index} of plan 1, epoch 0: "))), "{rest}");
    assert!(rest.lines().any(|line| line.starts_with("robot at 5.00 s: centre of mass ")), "{rest}");
}
