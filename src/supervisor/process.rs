//! One role process and the thread that reads its lines.

use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::mpsc::Sender;
use std::time::Duration;

use crate::report::event::RoleEvent;
use crate::report::role::Role;
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Longest line of a role, bytes.
const LINE_BYTES_MAX: u64 = 1 << 16;
/// Longest time from SIGTERM to the end of a process before it is killed, s.
pub(crate) const GRACE_SECONDS: f64 = 3.0;
/// Time between two checks whether it has ended.
const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// Output of a role process.
#[derive(Debug)]
pub(crate) enum ProcessOutput {
    /// A line.
    Event(Box<RoleEvent>),
    /// A line that is not an event.
    NonEvent(String),
    /// The end of the output.
    Closed,
}

/// A running role process.
#[derive(Debug)]
pub(crate) struct Process {
    child: Child,
}

impl Process {
    /// Starts `command` in a process group of its own, so that a terminal's Ctrl-C reaches only the
    /// supervisor.
    pub(crate) fn start(
        mut command: Command,
        role: Role,
        sender: Sender<(Role, ProcessOutput)>,
    ) -> std::io::Result<Self> {
        let mut child = command.stdout(Stdio::piped()).process_group(0).spawn()?;
        let stdout = child.stdout.take();
        let process = Self { child };
        let read = move || stdout.into_iter().for_each(|stdout| read_lines(stdout, role, &sender));
        match std::thread::Builder::new().name(format!("{role} lines")).spawn(read) {
            Ok(_) => Ok(process),
            Err(error) => {
                process.ask_to_end();
                process.wait();
                Err(error)
            }
        }
    }

    /// Its number.
    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Asks it to end.
    pub(crate) fn ask_to_end(&self) {
        signals::ask_to_end(&self.child);
    }

    /// Kills it.
    pub(crate) fn kill(&mut self) {
        // Fails only if it has ended.
        let _ = self.child.kill();
    }

    /// Waits for its end, kills it if it takes too long, and returns its exit status as text.
    pub(crate) fn wait(mut self) -> String {
        let watch = Stopwatch::start();
        loop {
            match self.child.try_wait() {
                Ok(Some(status)) => return status.to_string(),
                Ok(None) if watch.seconds() < GRACE_SECONDS => std::thread::sleep(POLL_INTERVAL),
                Ok(None) => {
                    // Fails only if the process has just ended.
                    let _ = self.child.kill();
                    return self.child.wait().map_or_else(
                        |error| error.to_string(),
                        |_| "it hung and was killed".to_owned(),
                    );
                }
                Err(error) => return error.to_string(),
            }
        }
    }
}

/// Queues every line until the stream ends or the receiver is dropped.
fn read_lines(stdout: ChildStdout, role: Role, sender: &Sender<(Role, ProcessOutput)>) {
    let mut reader = BufReader::new(stdout);
    let mut text = Vec::new();
    loop {
        text.clear();
        let output = match reader.by_ref().take(LINE_BYTES_MAX).read_until(b'\n', &mut text) {
            Ok(0) | Err(_) => ProcessOutput::Closed,
            // Killed in the middle of a line.
            Ok(read) if text.last() != Some(&b'\n') && (read as u64) < LINE_BYTES_MAX => {
                ProcessOutput::Closed
            }
            Ok(_) => serde_json::from_slice(&text)
                .map_or_else(|_| non_event(&text), |event| ProcessOutput::Event(Box::new(event))),
        };
        let over = matches!(output, ProcessOutput::Closed);
        if sender.send((role, output)).is_err() || over {
            return;
        }
    }
}

fn non_event(text: &[u8]) -> ProcessOutput {
    ProcessOutput::NonEvent(
        String::from_utf8_lossy(text).chars().take(80).collect::<String>().trim().to_owned(),
    )
}
