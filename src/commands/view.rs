//! `surefoot view`: shows a plan in Rerun, by the Python package.

use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};

use surefoot_shared_types::plan_file::read::load_plan;

use crate::cli::arguments::ViewArguments;
use crate::report::command_error::{CommandError, CommandOutcome};

/// Names the interpreter.
const INTERPRETER: &str = "SUREFOOT_PYTHON";
/// What the Python package needs for it.
const PROBE: &str = "import rerun, surefoot.view";

/// Runs `python3 -m surefoot.view` in place of this process.
///
/// # Errors
/// The plan cannot be read, or the interpreter or the package is not there.
pub fn run(arguments: &ViewArguments) -> Result<CommandOutcome, CommandError> {
    load_plan(&arguments.plan)?;
    let python = std::env::var_os(INTERPRETER).unwrap_or_else(|| "python3".into());
    let name = python.to_string_lossy().into_owned();
    let mut probe = Command::new(&python);
    probe.args(["-c", PROBE]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    match probe.status() {
        Ok(status) if status.success() => {}
        Ok(_) => {
            return Err(CommandError::Usage(format!(
                "{name} has no surefoot package with a viewer; build the wheel as docs/PYTHON.md \
                 says and run: pip install 'surefoot[view]'; {INTERPRETER} names another \
                 interpreter, and 'surefoot picture' draws without Python"
            )));
        }
        Err(error) => return Err(not_run(&name, &error)),
    }
    let mut view = Command::new(&python);
    view.args(["-m", "surefoot.view"]).arg(&arguments.plan);
    if let Some(path) = &arguments.save {
        view.arg("--save").arg(path);
    }
    Err(not_run(&name, &view.exec()))
}

fn not_run(name: &str, error: &std::io::Error) -> CommandError {
    CommandError::Usage(format!(
        "{name} cannot be run: {error}; install Python 3.10 or newer, or name it by {INTERPRETER}"
    ))
}
