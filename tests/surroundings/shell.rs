//! A folder with scenarios, in which the command runs by lines of a shell.

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::command::{CommandOutput, finish};

/// A folder with `flat.toml`, a short walk, and `endless.toml`, a search without end.
pub struct Folder {
    folder: tempfile::TempDir,
}

impl Folder {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let text = fs::read_to_string(configs.join("scenarios/flat_walk.toml")).unwrap();
        let flat = text.replace("\"../", &format!("\"{}/", configs.display()));
        let flat = flat.replacen("xyz = [9.5,", "xyz = [1.5,", 1);
        fs::write(folder.path().join("flat.toml"), &flat).unwrap();
        let wall = "\n[[shapes]]\nname = \"wall\"\nxyz = [3.0, 0.0, 1.0]\n\
                    box = { half_extents = [0.05, 5.0, 1.0] }\n";
        let world = fs::read_to_string(configs.join("worlds/flat_walk.toml")).unwrap() + wall;
        fs::write(folder.path().join("walled.toml"), world).unwrap();
        let world = format!("\"{}/worlds/flat_walk.toml\"", configs.display());
        let endless = flat.replacen(&world, "\"walled.toml\"", 1);
        let endless = endless.replacen("xyz = [1.5,", "xyz = [5.5,", 1);
        assert!(endless.contains("walled.toml") && endless.contains("5.5"), "{endless}");
        let endless = endless + "\n[planner]\nwork_max = 1000000000000\n";
        fs::write(folder.path().join("endless.toml"), endless).unwrap();
        Self { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }

    /// The names of all files but the scenarios and the world.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .filter(|name| !["flat.toml", "endless.toml", "walled.toml"].contains(&name.as_str()))
            .collect();
        names.sort();
        names
    }

    /// Starts a line of a shell in the folder. `$S` is the command.
    pub fn start(&self, line: &str) -> Child {
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).current_dir(self.folder.path());
        shell.env("S", env!("CARGO_BIN_EXE_surefoot"));
        shell.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
        shell.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // A parent that ignores signals, as nohup and Python do, passes that on.
        // SAFETY: signal is safe between fork and exec.
        unsafe { shell.pre_exec(heed_signals) };
        shell.spawn().unwrap()
    }

    pub fn run(&self, line: &str) -> CommandOutput {
        finish(self.start(line))
    }

    /// Runs a line that must end with exit code 2 and one line of error, which is returned.
    pub fn error(&self, line: &str) -> String {
        let output = self.run(line);
        assert_eq!(output.code, 2, "{line}: {}{}", output.out, output.err);
        assert_eq!(output.err.lines().count(), 1, "{line}: {}", output.err);
        assert!(output.err.starts_with("error: "), "{line}: {}", output.err);
        output.err
    }

    /// Runs a line that must succeed; returns its output.
    pub fn good(&self, line: &str) -> CommandOutput {
        let output = self.run(line);
        assert_eq!(output.code, 0, "{line}: {}{}", output.out, output.err);
        output
    }
}

/// Waits until `is_so`. The test's own limit of time ends it otherwise.
pub fn wait_until(is_so: impl Fn() -> bool) {
    while !is_so() {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Gives the signals of these tests their default effect.
fn heed_signals() -> std::io::Result<()> {
    for signal in [libc::SIGHUP, libc::SIGINT, libc::SIGTERM, libc::SIGXFSZ, libc::SIGPIPE] {
        // SAFETY: signal touches no memory of ours.
        unsafe { libc::signal(signal, libc::SIG_DFL) };
    }
    Ok(())
}
