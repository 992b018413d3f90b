//! Limits of memory, files and descriptors: one line and exit code 2, or a walk.

use crate::command::assert_nothing_left;
use crate::shell::Folder;

#[test]
fn little_memory_is_one_line() {
    let folder = Folder::new();
    for kib in [150_000, 300_000] {
        for command in ["plan", "walk"] {
            for backtrace in [0, 1] {
                let line = format!(
                    "ulimit -v {kib}; export RUST_BACKTRACE={backtrace}; \
                     exec $S {command} flat.toml --quiet"
                );
                let output = folder.run(&line);
                assert!([0, 2].contains(&output.code), "{line}: {}", output.err);
                if output.code == 2 {
                    assert_eq!(output.err.lines().count(), 1, "{line}: {}", output.err);
                }
                assert_nothing_left(output.pid);
            }
        }
    }
    let err = folder.error("ulimit -v 150000; exec $S plan flat.toml --quiet");
    assert!(err.contains("no more memory") && err.contains("ulimit -v"), "{err}");
    let err = folder.error("ulimit -v 250000; exec $S walk flat.toml --quiet");
    assert!(err.contains("no more memory"), "{err}");
}

#[test]
fn a_limit_of_file_sizes_is_named_or_an_error_of_the_write() {
    let folder = Folder::new();
    for kib in [0, 1, 32, 1000, 16_000] {
        for command in ["walk", "plan --instance small", "control --instance small"] {
            let err = folder.error(&format!("ulimit -f {}; exec $S {command} flat.toml", 2 * kib));
            assert!(err.contains(&format!("file size: the limit is {kib} KiB")), "{err}");
        }
    }
    folder.good("ulimit -f 65536; exec $S walk flat.toml --quiet");
    let output = folder.run("ulimit -f 16; exec $S plan flat.toml --quiet --export plan.json");
    assert_eq!(output.code, 2, "{}", output.err);
    assert!(output.err.contains("plan.json: cannot be written: File too large"), "{}", output.err);
    assert!(output.out.contains("digest"), "the plan is not shown: {}", output.out);
    assert!(folder.names().is_empty(), "{:?}", folder.names());
    let err = folder.error("ulimit -f 0; exec $S plan flat.toml --quiet >out.txt");
    assert!(err.contains("standard output"), "{err}");
}

#[test]
fn few_descriptors_are_raised_or_named() {
    let folder = Folder::new();
    folder.good("ulimit -Sn 16; exec $S walk flat.toml --quiet");
    for command in ["walk", "plan --instance few", "control --instance few"] {
        let err = folder.error(&format!("ulimit -n 20; exec $S {command} flat.toml"));
        assert!(err.contains("open files: the limit is 20"), "{err}");
    }
    let err = folder.error("ulimit -n 20; exec $S request --instance few --cancel");
    assert!(err.contains("open files"), "{err}");
}

#[test]
fn a_small_stack_is_raised_or_not_used() {
    let folder = Folder::new();
    folder.good("ulimit -Ss 256; exec $S walk flat.toml --quiet");
    for kib in [128, 512, 2048, 4096] {
        folder.good(&format!("ulimit -s {kib}; exec $S walk flat.toml --quiet"));
    }
    folder.good("ulimit -s 128; exec $S walk --help");
    let err = folder.error("ulimit -s 128; exec $S plan none.toml");
    assert!(err.contains("none.toml"), "{err}");
    let line = "ulimit -s 128; timeout --preserve-status -s INT 1 $S control --instance small \
                --serve flat.toml";
    folder.good(line);
}

#[test]
fn a_strict_mask_does_not_lock_the_command_out() {
    let folder = Folder::new();
    folder.good("umask 0777; exec $S walk flat.toml --quiet --export plan.json --json report.json");
    let modes = folder.good("stat -c %a plan.json report.json").out;
    assert_eq!(modes, "600\n600\n");
    folder.good("umask 027; $S plan flat.toml --quiet --export plan.json --json new.json");
    assert_eq!(folder.good("stat -c %a plan.json new.json").out, "600\n640\n");
}

#[test]
fn closed_descriptors_are_no_error() {
    let folder = Folder::new();
    for closed in [">&-", "2>&-", "<&-", ">&- 2>&- <&-"] {
        let line = format!("exec $S walk flat.toml --quiet --json report.json {closed}");
        folder.good(&line);
        assert_eq!(folder.json("report.json")["outcome"], "accepted", "{closed}");
    }
    let full = folder.run("$S plan flat.toml --quiet >/dev/full");
    assert_eq!(full.code, 2, "{}", full.err);
    folder.good("$S plan flat.toml | true");
}
