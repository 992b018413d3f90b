//! A walk on one host, its monitor on another: iceoryx2's tunnel over Zenoh between two network
//! namespaces, each with a `/dev/shm` of its own.
//!
//! Needs root, iproute2, a core without other load, and the program `iox2-link-tunnel-zenoh`
//! (docs/OTHER_HOSTS.md), whose path is in `SUREFOOT_TUNNEL`.

#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// What both hosts begin with: an empty shared memory, a function that starts the tunnel of the
/// instance as soon as it exists, and one that ends it and lists the rest.
const PRELUDE: &str = r#"
set -u
mount -t tmpfs -o mode=1777,size=256m tmpfs /dev/shm || exit 9
tunnel() {
    mkdir -p config
    until "$SUREFOOT" config iceoryx2 --instance mine > config/iceoryx2.toml 2> missing.txt
    do sleep 0.05; done
    timeout 90 "$TUNNEL" --zenoh-config zenoh.json5 --allow 'surefoot/mine/*' --poll 1 \
        > tunnel.txt 2>&1 &
    tunnel=$!
}
leave() {
    kill -INT $tunnel
    wait
    ls -A /dev/shm > left.txt
    exit $1
}
"#;

/// The host of the walk. It waits for the other one's tunnel, which offers its services here.
const ROBOT: &str = r#"
"$SUREFOOT" control "$SCENARIO" --instance mine > control.txt 2>&1 &
tunnel
touch tunnels
until [ -e ../far/listens ]; do sleep 0.1; done
"$SUREFOOT" plan "$SCENARIO" --instance mine --quiet > plan.txt 2>&1
leave $?
"#;

/// The host that listens. Its tunnel takes seconds to find the other one, once that one runs.
const FAR: &str = r#"
"$SUREFOOT" monitor --instance mine --create --json --seconds 60 > monitor.txt 2>&1 &
monitor=$!
tunnel
until [ -e ../robot/tunnels ]; do sleep 0.1; done
sleep 5
touch listens
wait $monitor
leave $?
"#;

/// Two network namespaces joined by a cable; removed with it.
struct Hosts {
    names: [String; 2],
}

impl Hosts {
    fn create() -> Self {
        let id = std::process::id();
        let names = ["robot", "far"].map(|host| format!("sf-{host}-{id}"));
        let hosts = Self { names };
        let [robot, far] = &hosts.names;
        ip(&format!("netns add {robot}"));
        ip(&format!("netns add {far}"));
        ip(&format!("-n {robot} link add cable type veth peer name cable netns {far}"));
        for (name, address) in [(robot, "10.77.0.1/24"), (far, "10.77.0.2/24")] {
            ip(&format!("-n {name} addr add {address} dev cable"));
            ip(&format!("-n {name} link set cable up"));
            ip(&format!("-n {name} link set lo up"));
        }
        hosts
    }

    /// Starts a script on a host, in a folder of its own.
    fn start(&self, host: usize, folder: &Path, zenoh: &str, script: &str) -> Child {
        std::fs::create_dir_all(folder).unwrap();
        std::fs::write(folder.join("zenoh.json5"), zenoh).unwrap();
        Command::new("ip")
            .args(["netns", "exec", &self.names[host], "unshare", "-m", "bash", "-c"])
            .arg(format!("{PRELUDE}{script}"))
            .env("SUREFOOT", env!("CARGO_BIN_EXE_surefoot"))
            .env("TUNNEL", std::env::var_os("SUREFOOT_TUNNEL").unwrap())
            .env("SCENARIO", repository().join("configs/scenarios/flat_walk.toml"))
            .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
            .current_dir(folder)
            .stdin(Stdio::null())
            .spawn()
            .unwrap()
    }
}

impl Drop for Hosts {
    fn drop(&mut self) {
        for name in &self.names {
            let _ = Command::new("ip").args(["netns", "del", name]).status();
        }
    }
}

fn ip(arguments: &str) {
    let status = Command::new("ip").args(arguments.split(' ')).status().unwrap();
    assert!(status.success(), "ip {arguments}");
}

fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Zenoh's configuration of a host that `joins` the other one: `listen` or `connect`.
fn zenoh(joins: &str) -> String {
    format!(
        "{{ mode: \"peer\", {joins}: {{ endpoints: [\"tcp/10.77.0.1:7447\"], \
         retry: {{ period_init_ms: 200, period_max_ms: 200 }} }}, \
         scouting: {{ multicast: {{ enabled: false }} }} }}"
    )
}

#[test]
#[ignore = "needs root and iceoryx2's tunnel"]
fn a_monitor_on_another_host_receives_every_chunk() {
    let folder = tempfile::tempdir().unwrap();
    let hosts = Hosts::create();
    let [robot, far] = ["robot", "far"].map(|host| folder.path().join(host));
    let mut listens = hosts.start(1, &far, &zenoh("connect"), FAR);
    let mut walks = hosts.start(0, &robot, &zenoh("listen"), ROBOT);
    let codes = [walks.wait().unwrap().code(), listens.wait().unwrap().code()];
    let read = |file: PathBuf| std::fs::read_to_string(file).unwrap_or_default();
    let (plan, monitor) = (read(robot.join("plan.txt")), read(far.join("monitor.txt")));
    assert_eq!(codes, [Some(0); 2], "{plan}{monitor}");
    let sent = plan.lines().find(|line| line.contains(" sent, ")).unwrap().trim().to_owned();
    let count: u64 = sent.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert_eq!(sent, format!("chunks     {count} sent, {count} accepted, 0 lost, 0 duplicated"));
    let finished = monitor.lines().find(|line| line.contains("\"finished\"")).unwrap();
    assert!(finished.contains(&format!("\"chunks\":{count},")), "{finished}");
    let last = monitor.lines().last().unwrap();
    assert!(last.contains(&format!("\"accepted\":{count},\"missed_chunks\":0,")), "{last}");
    assert_eq!(read(robot.join("left.txt")) + &read(far.join("left.txt")), "");
}
