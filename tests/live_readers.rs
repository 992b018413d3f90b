//! Readers of a running walk in Rust, C++ and Python, a sampler of set-points and ROS 2 messages:
//! each receives every chunk or says how many it missed, and the walk is the one without readers.
//! The C++ part is skipped without a compiler, the ROS 2 part without the Python packages iceoryx2
//! and rosbags; with `SUREFOOT_REQUIRE_ALL` they fail instead. `SUREFOOT_PYTHON` names an
//! interpreter.

#![allow(clippy::print_stdout, reason = "a test prints why it is skipped")]
#![allow(clippy::unwrap_used, reason = "a command that fails unexpectedly fails the test")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use command::{CommandOutput, finish, surefoot};
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::message::set_point::{FLAG_FINISHED, FLAG_LOADS};
use surefoot_shared_types::message::{Description, PlanChunk, SetPoint};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::GRAVITY;

/// Longest time to wait for another process.
const WAIT_MAX: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_micros(200);
/// Time between two set-points, s of the plan.
const TICK: f64 = 0.01;

#[allow(clippy::disallowed_methods, reason = "a test waits for other processes")]
fn now() -> Instant {
    Instant::now()
}

/// A walk of four steps, planned with a seed.
fn scenario(folder: &Path, seed: u64) -> PathBuf {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let text = format!(
        "seed = {seed}\nrobot = \"{configs}/robots/hubo/robot.toml\"\nworld = \"{configs}/worlds/flat_walk.toml\"\n\
         [start]\nxyz = [0.5, 0.0, 0.0]\n[goal]\nxyz = [0.9, 0.0, 0.0]\n",
        configs = configs.display()
    );
    let path = folder.join("short.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn hubo() -> RobotModel {
    load_robot(
        Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/robots/hubo/robot.toml").as_ref(),
    )
    .unwrap()
}

/// The instance of this name, once it exists.
fn attach(name: &str) -> Instance {
    let begin = now();
    loop {
        match Instance::attach(name) {
            Ok(instance) => return instance,
            Err(error) => assert!(begin.elapsed() < WAIT_MAX, "{error}"),
        }
        std::thread::sleep(PAUSE);
    }
}

/// What a reader in this process has received.
#[derive(Default)]
struct Received {
    chunks: Vec<PlanChunk>,
    missed: u64,
    points: Vec<SetPoint>,
    description: Option<Description>,
}

/// Reads an instance until it has no planner and no controller, and then its set-points until the
/// last one.
fn read(observer: &Observer, reads_points: bool) -> Received {
    let mut received = Received::default();
    let begin = now();
    loop {
        let is_attended = observer.publisher_count() > 0;
        while observer.feedback().unwrap().is_some() {}
        received.description = observer.description().unwrap().or(received.description);
        while let Some(chunk) = observer.chunk().unwrap() {
            received.chunks.push(chunk);
        }
        while let Some(point) = observer.set_point().unwrap() {
            received.points.push(point);
        }
        let last = received.points.last();
        let is_played = !reads_points || last.is_some_and(|point| point.flags & FLAG_FINISHED != 0);
        if !is_attended && !received.chunks.is_empty() && is_played {
            received.missed = observer.missed_chunks();
            return received;
        }
        assert!(
            begin.elapsed() < WAIT_MAX,
            "no end: {} chunks, {} set-points; planner or controller there: {is_attended}; all \
             set-points played: {is_played}",
            received.chunks.len(),
            received.points.len()
        );
        std::thread::sleep(PAUSE);
    }
}

fn number_after(text: &str, before: &str) -> u64 {
    let rest = text.split(before).nth(1).unwrap_or_else(|| panic!("'{before}' in: {text}"));
    rest.split(|letter: char| !letter.is_ascii_digit()).next().unwrap().parse().unwrap()
}

fn digest(output: &CommandOutput) -> String {
    let report: serde_json::Value = serde_json::from_str(&output.out).unwrap();
    report["digest"].as_str().unwrap().to_owned()
}

/// The C++ listener, built; `None` without a compiler.
fn cpp_listener(folder: &Path) -> Option<PathBuf> {
    // Used, so that cargo builds the library.
    let _ = surefoot_c::surefoot_reader_close;
    let libraries = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let program = folder.join("listen");
    let mut compiler = Command::new("c++");
    compiler.current_dir(env!("CARGO_MANIFEST_DIR"));
    compiler.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-Ic/include", "-Itools/mirrors"]);
    compiler.arg("examples/cpp/listen.cpp").arg("-o").arg(&program);
    compiler.arg("-L").arg(&libraries).arg("-lsurefoot_c");
    compiler.arg(format!("-Wl,-rpath,{}", libraries.display()));
    match compiler.output() {
        Ok(built) => {
            assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
            Some(program)
        }
        Err(error) => {
            absent::skip(&format!("no C++ compiler ({error})"));
            None
        }
    }
}

/// The Python program that decodes the ROS 2 messages; `None` without its packages.
fn ros_reader(instance: &str) -> Option<Command> {
    let python = std::env::var("SUREFOOT_PYTHON").unwrap_or_else(|_| "python3".into());
    let imports = Command::new(&python)
        .args(["-c", "import iceoryx2, rosbags"])
        .stderr(Stdio::null())
        .status();
    if !imports.is_ok_and(|status| status.success()) {
        absent::skip(&format!("{python} has no iceoryx2 and rosbags packages"));
        return None;
    }
    let mut reader = Command::new(python);
    reader.current_dir(env!("CARGO_MANIFEST_DIR"));
    reader.args(["tests/live/check_ros_topics.py", instance]);
    Some(reader)
}

/// A reader in another process that has attached to the instance.
struct Reader {
    child: Child,
    /// The rest of what it prints.
    out: BufReader<ChildStdout>,
}

impl Reader {
    /// Starts a reader and waits until it says that it is attached.
    fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::inherit()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        assert!(line.starts_with("attached"), "{line}");
        Self { child, out }
    }

    /// Its exit code and the rest of its output.
    fn finish(mut self) -> (i32, String) {
        let mut text = String::new();
        self.out.read_to_string(&mut text).unwrap();
        (self.child.wait().unwrap().code().unwrap(), text)
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        // Does nothing where it has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn all_readers_of_a_walk_receive_it_and_do_not_change_it() {
    walk_with_all_readers(1);
}

#[test]
#[ignore = "takes minutes"]
fn all_readers_of_fifty_walks_receive_them_and_do_not_change_them() {
    (1..=50).for_each(walk_with_all_readers);
}

fn walk_with_all_readers(seed: u64) {
    let folder = tempfile::tempdir().unwrap();
    let file = scenario(folder.path(), seed);
    let file = file.to_str().unwrap();
    let plan = ["plan", file, "--quiet", "--json", "-"];
    let alone = finish(surefoot(&plan).spawn().unwrap());
    assert_eq!(alone.code, 0, "{}", alone.err);
    let name = format!("test-readers-{seed}-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let observer = Observer::open(&instance).unwrap();
    let sample = ["sample", "--instance", &name, "--hz", "100", "--rate", "40", "--ros"];
    let sampler = Reader::start(surefoot(&sample));
    let listener = cpp_listener(folder.path()).map(|program| {
        let mut command = Command::new(program);
        // Cargo's may lead to the library of an older build.
        command.arg(&name).env_remove("LD_LIBRARY_PATH");
        Reader::start(command)
    });
    let ros = ros_reader(&name).map(Reader::start);
    let control = surefoot(&["control", file, "--instance", &name]).spawn().unwrap();
    let plan = surefoot(&[&plan[..], &["--instance", &name]].concat()).spawn().unwrap();
    let received = read(&observer, true);
    let (controlled, planned) = (finish(control), finish(plan));
    assert_eq!((controlled.code, planned.code), (0, 0), "{}{}", controlled.err, planned.err);
    assert_eq!(digest(&planned), digest(&alone), "readers do not change a plan");
    let report: serde_json::Value = serde_json::from_str(&planned.out).unwrap();
    let accepted = report["chunks"]["accepted"].as_u64().unwrap();
    assert_eq!(received.chunks.len() as u64 + received.missed, accepted);
    check_description(received.description.as_ref().unwrap());
    let (code, sampled) = sampler.finish();
    let missed = number_after(&sampled, "without a chunk; ");
    assert_eq!(code, if missed == 0 { 0 } else { 2 }, "{sampled}");
    if missed == 0 {
        check_points(&received);
    }
    if let Some((code, printed)) = listener.map(Reader::finish) {
        let [got, missed] = ["received ", "missed "].map(|before| number_after(&printed, before));
        assert_eq!((code, got + missed), (0, accepted), "{printed}");
        assert!(printed.contains("robot hubo: "), "{printed}");
    }
    if let Some((code, printed)) = ros.map(Reader::finish) {
        assert_eq!(code, 0, "{printed}");
    }
}

fn check_description(description: &Description) {
    let model = hubo();
    let names: Vec<&str> =
        description.joints().iter().map(|joint| joint.name.text().unwrap()).collect();
    let expected: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, expected);
    assert_eq!((description.robot, description.mass), (model.digest, model.mass()));
    assert_eq!(description.root_link.text(), Some(model.links[0].name.as_str()));
    let feet: Vec<&str> = description.feet().iter().map(|foot| foot.name.text().unwrap()).collect();
    assert_eq!(feet, ["left", "right"]);
}

/// The set-points follow the plan without a jump and end where it ends.
fn check_points(received: &Received) {
    let model = hubo();
    let points = &received.points;
    for pair in points.windows(2).filter(|pair| pair[1].tick == pair[0].tick + 1) {
        for (joint, limits) in model.joints.iter().enumerate() {
            let step = (pair[1].waypoint.q[joint] - pair[0].waypoint.q[joint]).abs();
            assert!(
                step <= 1.001 * TICK * limits.velocity + 1e-9,
                "{} moves {step} rad in a tick at {} s",
                limits.name,
                pair[1].waypoint.time
            );
        }
    }
    let end = points.last().unwrap();
    assert_eq!((end.waypoint.joint_velocity, end.rate), ([0.0; 48], 0.0));
    assert_eq!([end.feet[0].in_contact, end.feet[1].in_contact], [1, 1]);
    let is_last = |chunk: &&PlanChunk| chunk.sequence == end.sequence;
    if let Some(chunk) = received.chunks.iter().rfind(is_last) {
        let last = chunk.waypoints().last().unwrap();
        assert_eq!((end.waypoint.q, end.waypoint.time), (last.q, last.time));
    }
}

#[test]
fn set_points_state_the_contact_wrenches_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let file = scenario(folder.path(), 1);
    let file = file.to_str().unwrap();
    let name = format!("test-loads-{}", std::process::id());
    let instance = Instance::create(&name).unwrap();
    let observer = Observer::open(&instance).unwrap();
    let sample = ["sample", "--instance", &name, "--hz", "20", "--rate", "10", "--loads", file];
    let sampler = Reader::start(surefoot(&sample));
    let control = surefoot(&["control", file, "--instance", &name]).spawn().unwrap();
    let plan = surefoot(&["plan", file, "--quiet", "--instance", &name]).spawn().unwrap();
    let received = read(&observer, true);
    assert_eq!((finish(control).code, finish(plan).code), (0, 0));
    assert_eq!(sampler.finish().0, 0);
    for point in &received.points {
        assert_ne!(point.flags & FLAG_LOADS, 0, "no loads at {} s", point.waypoint.time);
        let swinging = point.feet.iter().filter(|foot| foot.in_contact == 0);
        assert!(swinging.into_iter().all(|foot| (foot.force, foot.moment) == ([0.0; 3], [0.0; 3])));
    }
    let end = received.points.last().unwrap();
    let weight: f64 = end.feet.iter().map(|foot| foot.force[2]).sum();
    let expected = hubo().mass() * GRAVITY;
    assert!((weight - expected).abs() < 1e-3 * expected, "{weight} N instead of {expected}");
    assert!(end.waypoint.torque.iter().any(|torque| torque.abs() > 1.0));
}

#[test]
fn a_late_reader_of_a_serving_controller_learns_the_joints() {
    let folder = tempfile::tempdir().unwrap();
    let file = scenario(folder.path(), 1);
    let name = format!("test-late-reader-{}", std::process::id());
    let mut control =
        surefoot(&["control", file.to_str().unwrap(), "--serve", "--instance", &name]);
    let control = control.spawn().unwrap();
    let instance = attach(&name);
    for _ in 0..2 {
        let observer = Observer::open(&instance).unwrap();
        let begin = now();
        let description = loop {
            if let Some(description) = observer.description().unwrap() {
                break description;
            }
            assert!(begin.elapsed() < WAIT_MAX, "no description");
            std::thread::sleep(PAUSE);
        };
        check_description(&description);
    }
    // SAFETY: a signal to a child that is not waited for yet.
    assert_eq!(unsafe { libc::kill(control.id() as i32, libc::SIGINT) }, 0);
    assert_eq!(finish(control).code, 0);
}
