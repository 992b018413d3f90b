//! Life of an instance: creation, attaching, removal, private folders and locks.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;

use crate::instance::error::{BASE_PATH_LEN_MAX, ChannelError, InstanceError, NAME_LEN_MAX};
use crate::instance::instance::Instance;
use crate::instance::participant::Participant;
use crate::instance::token::Token;
use crate::instance::{lock, private};

fn base() -> tempfile::TempDir {
    tempfile::Builder::new()
        .prefix("sf-test")
        .permissions(fs::Permissions::from_mode(0o700))
        .tempdir_in("/dev/shm")
        .unwrap()
}

fn segments_of(instance: &Instance) -> Vec<String> {
    let all = fs::read_dir("/dev/shm")
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap());
    all.filter(|name| name.starts_with(instance.segment_prefix())).collect()
}

#[test]
fn names_are_checked() {
    let base = base();
    for name in ["", "A", "a/b", "..", "a b", "ä", &"x".repeat(33), "a\0"] {
        assert!(
            matches!(Instance::create_in(base.path(), name), Err(InstanceError::Name { .. })),
            "{name:?}"
        );
    }
    let longest_base =
        base.path().join("b".repeat(BASE_PATH_LEN_MAX - base.path().as_os_str().len() - 1));
    let instance = Instance::create_in(&longest_base, &"x".repeat(NAME_LEN_MAX)).unwrap();
    assert!(Participant::open(&instance).is_ok());
    assert!(matches!(
        Instance::create_in(&longest_base.join("c"), "a"),
        Err(InstanceError::Path { .. })
    ));
    assert!(matches!(
        Instance::create_in(Path::new("relative"), "a"),
        Err(InstanceError::Path { .. })
    ));
}

#[test]
fn the_last_process_removes_everything() {
    let base = base();
    let inner = base.path().join("mine");
    let created = Instance::create_in(&inner, "walk").unwrap();
    assert_eq!(fs::metadata(created.root()).unwrap().permissions().mode() & 0o7777, 0o700);
    let attached = Instance::attach_in(&inner, "walk").unwrap();
    let participant = Participant::open(&attached).unwrap();
    assert!(!segments_of(&attached).is_empty());
    drop(created);
    assert!(attached.root().exists(), "an attached process keeps it");
    let probe = Instance::attach_in(&inner, "walk").unwrap();
    drop((participant, attached));
    let (root, prefix) = (probe.root().to_owned(), probe.segment_prefix().to_owned());
    drop(probe);
    assert!(!root.exists() && !inner.exists());
    let left: Vec<_> = fs::read_dir("/dev/shm")
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().file_name().to_str().unwrap().starts_with(&prefix))
        .collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn an_instance_in_use_is_not_created_again_and_a_missing_one_is_not_attached() {
    let base = base();
    let first = Instance::create_in(base.path(), "a").unwrap();
    assert!(matches!(Instance::create_in(base.path(), "a"), Err(InstanceError::InUse { .. })));
    assert!(matches!(Instance::attach_in(base.path(), "b"), Err(InstanceError::Missing { .. })));
    let neighbour = Instance::create_in(base.path(), "a-b").unwrap();
    drop(first);
    assert!(neighbour.root().exists());
    assert!(Instance::create_in(base.path(), "a").is_ok());
}

#[test]
fn folders_that_are_not_private_are_refused() {
    let base = base();
    let refused = |path: &Path, name: &str| {
        let error = Instance::create_in(path, name).unwrap_err();
        assert!(matches!(error, InstanceError::NotPrivate { .. }), "{error}");
        assert!(matches!(Instance::attach_in(path, name), Err(InstanceError::NotPrivate { .. })));
    };
    for (name, mode) in [("open", 0o777), ("group", 0o750)] {
        let root = base.path().join(name);
        fs::create_dir(&root).unwrap();
        fs::set_permissions(&root, fs::Permissions::from_mode(mode)).unwrap();
        refused(base.path(), name);
        refused(&root, "inside");
    }
    let private = base.path().join("private");
    fs::create_dir(&private).unwrap();
    fs::set_permissions(&private, fs::Permissions::from_mode(0o700)).unwrap();
    symlink(&private, base.path().join("link")).unwrap();
    refused(base.path(), "link");
    fs::write(base.path().join("file"), "").unwrap();
    refused(base.path(), "file");
    assert_eq!(fs::read_dir(&private).unwrap().count(), 0, "nothing was written through the link");
}

#[test]
fn a_lock_that_is_a_link_is_refused() {
    let base = base();
    let root = base.path().join("a");
    fs::create_dir(&root).unwrap();
    fs::set_permissions(&root, fs::Permissions::from_mode(0o700)).unwrap();
    symlink(base.path().join("elsewhere"), root.join("lock")).unwrap();
    assert!(matches!(Instance::create_in(base.path(), "a"), Err(InstanceError::Io { .. })));
    assert!(!base.path().join("elsewhere").exists());
}

#[test]
fn a_pipe_a_socket_or_a_device_in_a_files_place_is_refused_at_once() {
    let base = base();
    let instance = Instance::create_in(base.path(), "a").unwrap();
    let pipe = instance.root().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
    assert!(made.success());
    let _socket = std::os::unix::net::UnixListener::bind(instance.root().join("socket")).unwrap();
    symlink("/dev/zero", instance.root().join("device")).unwrap();
    for name in ["pipe", "socket"] {
        let error = instance.open_file(name).unwrap_err();
        assert!(matches!(error, InstanceError::NotPrivate { .. }), "{name}: {error}");
    }
    assert!(matches!(instance.open_file("device"), Err(InstanceError::Io { .. })));
    let dead = base.path().join("b");
    private::ensure_folder(&dead).unwrap();
    fs::rename(pipe, dead.join("lock")).unwrap();
    assert!(matches!(Instance::create_in(base.path(), "b"), Err(InstanceError::NotPrivate { .. })));
    assert!(matches!(Instance::attach_in(base.path(), "b"), Err(InstanceError::NotPrivate { .. })));
}

#[test]
fn every_instance_has_its_own_prefix() {
    let base = base();
    let first = Instance::create_in(base.path(), "a").unwrap();
    let attached = Instance::attach_in(base.path(), "a").unwrap();
    assert_eq!(first.segment_prefix(), attached.segment_prefix());
    let before = first.segment_prefix().to_owned();
    drop((first, attached));
    assert_ne!(Instance::create_in(base.path(), "a").unwrap().segment_prefix(), before);
}

#[test]
fn files_of_a_crash_are_removed() {
    let base = base();
    let running = Instance::create_in(base.path(), "running").unwrap();
    let dead = Instance::create_in(base.path(), "dead").unwrap();
    let (root, segment) =
        (dead.root().to_owned(), format!("/dev/shm/{}data", dead.segment_prefix()));
    let lock_file = fs::read(root.join("lock")).unwrap();
    drop(dead);
    for path in [root.clone(), root.join("nodes")] {
        fs::create_dir(&path).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o700)).unwrap();
    }
    fs::write(root.join("lock"), lock_file).unwrap();
    fs::write(&segment, "left").unwrap();
    assert_eq!(Instance::clean_dead_in(base.path()).unwrap(), 1);
    assert!(!root.exists() && !Path::new(&segment).exists() && running.root().exists());
}

#[test]
fn another_layout_is_refused() {
    use crate::message::{Feedback, Layout, PlanChunk};
    let base = base();
    let instance = Instance::create_in(base.path(), "layout").unwrap();
    let participant = Participant::open(&instance).unwrap();
    for (chunk, feedback) in
        [(PlanChunk::HASH ^ 1, Feedback::HASH), (PlanChunk::HASH, Feedback::HASH ^ 1)]
    {
        assert!(matches!(
            Participant::open_with_layouts(&instance, chunk, feedback),
            Err(ChannelError::Layout { .. })
        ));
    }
    assert!(Participant::open(&instance).is_ok());
    drop(participant);
}

#[test]
fn processes_that_leave_at_once_remove_everything() {
    let base = base();
    let inner = base.path().join("mine");
    for round in 0..60 {
        let created = Instance::create_in(&inner, "walk").unwrap();
        let mut members = vec![Participant::open(&created).unwrap()];
        members
            .extend((0..3).map(|_| {
                Participant::open(&Instance::attach_in(&inner, "walk").unwrap()).unwrap()
            }));
        let (root, prefix) = (created.root().to_owned(), created.segment_prefix().to_owned());
        drop(created);
        let gate = std::sync::Barrier::new(members.len());
        std::thread::scope(|scope| {
            for participant in members.drain(..) {
                let instance = participant.instance.clone();
                drop(participant);
                let gate = &gate;
                scope.spawn(move || {
                    gate.wait();
                    drop(instance);
                });
            }
        });
        let left = fs::read_dir("/dev/shm")
            .unwrap()
            .flatten()
            .filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
        assert!(!root.exists() && left.count() == 0, "round {round}");
    }
}

#[test]
fn an_instance_can_be_created_while_others_try_to_attach() {
    let base = base();
    let over = std::sync::atomic::AtomicBool::new(false);
    let is_over = || over.load(std::sync::atomic::Ordering::Relaxed);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while !is_over() {
                    drop(Instance::attach_in(base.path(), "walk"));
                }
            });
        }
        let created: Vec<bool> =
            (0..40).map(|_| Instance::create_in(base.path(), "walk").is_ok()).collect();
        over.store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(created.iter().all(|created| *created), "{created:?}");
    });
}

/// Creates and drops an instance `rounds` times; returns the errors.
fn create_and_drop(base: &Path, name: &str, rounds: usize) -> Vec<String> {
    (0..rounds)
        .filter_map(|_| Instance::create_in(base, name).err())
        .map(|error| error.to_string())
        .collect()
}

#[test]
fn the_removal_of_one_instance_does_not_affect_another() {
    let base = base();
    let inner = base.path().join("mine");
    let over = std::sync::atomic::AtomicBool::new(false);
    let is_over = || over.load(std::sync::atomic::Ordering::Relaxed);
    std::thread::scope(|scope| {
        let cleaner = scope.spawn(|| {
            let mut failed = Vec::new();
            while !is_over() {
                failed.extend(Instance::clean_dead_in(&inner).err().map(|error| error.to_string()));
            }
            failed
        });
        let walks =
            ["left", "right"].map(|name| scope.spawn(|| create_and_drop(&inner, name, 2000)));
        let failed: Vec<String> = walks.into_iter().flat_map(|walk| walk.join().unwrap()).collect();
        over.store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(failed.is_empty(), "{failed:?}");
        assert_eq!(cleaner.join().unwrap(), Vec::<String>::new());
    });
    assert!(!inner.exists());
}

#[test]
fn no_process_enters_an_instance_that_is_not_ready() {
    let base = base();
    let root = base.path().join("a");
    private::ensure_folder(&root).unwrap();
    assert!(lock::lock_exclusive(&root).unwrap().is_some());
    let over = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for _ in 0..20_000 {
                if let Some(file) = lock::lock_exclusive(&root).unwrap() {
                    lock::mark_ready(&file, &root, Token::random()).unwrap();
                }
                if let Some(file) = lock::lock_exclusive(&root).unwrap() {
                    lock::mark_unready(&file, &root).unwrap();
                }
            }
            over.store(true, std::sync::atomic::Ordering::Relaxed);
        });
        while !over.load(std::sync::atomic::Ordering::Relaxed) {
            if let Some((file, _)) = lock::lock_shared(&root).unwrap() {
                assert_ne!(file.metadata().unwrap().len(), 0, "entered before it was ready");
            }
        }
    });
}
