//! The rules of the architecture, read off the sources themselves.

#![allow(clippy::unwrap_used, reason = "a test ends where a source file cannot be read")]

use std::path::{Path, PathBuf};

/// Words that only some sources may hold.
struct Rule {
    /// What the rule is for.
    why: &'static str,
    /// The files and folders it binds.
    binds: &'static [&'static str],
    /// The files and folders among them that it leaves free.
    except: &'static [&'static str],
    /// What code there must not mention, comments aside.
    words: &'static [&'static str],
}

const RULES: [Rule; 13] = [
    Rule {
        why: "stage M knows nothing of possibility",
        binds: &["planner/src/motion"],
        except: &[],
        words: &["possibility"],
    },
    Rule {
        why: "possibility knows nothing of stage M",
        binds: &["planner/src/possibility"],
        except: &[],
        words: &["motion::", "crate::motion"],
    },
    Rule {
        why: "only channels and messages touch shared memory",
        binds: &["planner/src", "controller-sim/src", "shared-types/src"],
        except: &[
            "planner/src/channel/plan_publisher.rs",
            "planner/src/channel",
            "controller-sim/src/channel/plan_subscriber.rs",
            "controller-sim/src/channel",
            "shared-types/src/message",
            "shared-types/src/instance",
        ],
        words: &["iceoryx2"],
    },
    Rule {
        why: "the search has no clock",
        binds: &["planner/src"],
        except: &["planner/src/channel/plan_publisher.rs", "planner/src/channel"],
        words: &["Instant", "SystemTime", "std::time"],
    },
    Rule {
        why: "the search reads no files, prints nothing and starts no threads of its own",
        binds: &["planner/src"],
        except: &["planner/src/channel/plan_publisher.rs", "planner/src/channel"],
        words: &["std::fs", "std::env", "println!", "print!(", "std::thread", "std::process"],
    },
    Rule {
        why: "the checker has its own code",
        binds: &["controller-sim/src", "controller-sim/tests", "controller-sim/Cargo.toml"],
        except: &[],
        words: &["surefoot_planner", "surefoot-planner"],
    },
    Rule {
        why: "the planner does not know its checker",
        binds: &["planner/src", "planner/tests", "planner/Cargo.toml"],
        except: &[],
        words: &["surefoot_controller_sim", "surefoot-controller-sim"],
    },
    Rule {
        why: "shared types know neither side",
        binds: &["shared-types/src", "shared-types/Cargo.toml"],
        except: &[],
        words: &[
            "surefoot_planner",
            "surefoot-planner",
            "surefoot_controller_sim",
            "surefoot-controller-sim",
        ],
    },
    Rule {
        why: "geometry and mechanics lie below the search",
        binds: &[
            "planner/src/collision",
            "planner/src/foot_placement",
            "planner/src/kinematics",
            "planner/src/robot/ankle_limits.rs",
            "planner/src/robot/mechanism.rs",
            "planner/src/robot/single_support.rs",
            "planner/src/constraints/constraints.rs",
            "planner/src/robot/posture_ik.rs",
            "planner/src/geometry/convex_region.rs",
            "planner/src/robot/gravity_torques.rs",
            "planner/src/base/random.rs",
        ],
        except: &[],
        words: &[
            "crate::motion",
            "crate::possibility",
            "crate::rpg",
            "crate::seeding",
            "crate::chunking",
        ],
    },
    Rule {
        why: "nothing below calls the planner as a whole, and the search never sends",
        binds: &["planner/src"],
        except: &["planner/src/rpg.rs", "planner/src/lib.rs"],
        words: &["crate::rpg", "crate::channel"],
    },
    Rule {
        why: "stage P knows nothing of stage M",
        binds: &["planner/src/possibility"],
        except: &[],
        words: &["crate::motion", "crate::seeding"],
    },
    Rule {
        why: "stage M knows nothing of stage P",
        binds: &["planner/src/motion"],
        except: &[],
        words: &["crate::possibility", "crate::seeding"],
    },
    Rule {
        why: "what iterates in no fixed order decides nothing",
        binds: &["planner/src", "controller-sim/src", "shared-types/src"],
        except: &[],
        words: &["HashMap", "HashSet"],
    },
];

/// Where the sources are whose size is bounded.
const SOURCES: [&str; 4] = ["planner/src", "controller-sim/src", "shared-types/src", "src"];
/// A file has fewer lines than this.
const FILE_LINES_END: usize = 600;
/// A function has at most this many lines.
const FUNCTION_LINES_MAX: usize = 70;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The Rust and TOML files at or below a path, sorted; none where there is nothing.
fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let Ok(entries) = std::fs::read_dir(path) else { return vec![] };
    let mut found: Vec<PathBuf> = entries.flat_map(|entry| files(&entry.unwrap().path())).collect();
    found.retain(|file| {
        file.extension().is_some_and(|extension| extension == "rs" || extension == "toml")
    });
    found.sort();
    found
}

/// A line without its comment.
fn code_of(line: &str) -> &str {
    let trimmed = line.trim_start();
    if trimmed.starts_with("//") || trimmed.starts_with('#') && !trimmed.starts_with("#[") {
        return "";
    }
    line.split_once(" // ").map_or(line, |(code, _)| code)
}

fn shown(file: &Path) -> String {
    file.strip_prefix(root()).unwrap_or(file).display().to_string()
}

/// Where a rule is broken.
fn offences(rule: &Rule) -> Vec<String> {
    let is_free =
        |file: &PathBuf| rule.except.iter().any(|free| file.starts_with(root().join(free)));
    let bound =
        rule.binds.iter().flat_map(|path| files(&root().join(path))).filter(|file| !is_free(file));
    let mut offences = vec![];
    for file in bound {
        let text = std::fs::read_to_string(&file).unwrap();
        for (number, line) in text.lines().enumerate() {
            if let Some(word) = rule.words.iter().find(|word| code_of(line).contains(*word)) {
                offences.push(format!("{}:{}: {word}: {}", shown(&file), number + 1, rule.why));
            }
        }
    }
    offences
}

#[test]
fn no_rule_is_broken() {
    let offences: Vec<String> = RULES.iter().flat_map(offences).collect();
    assert!(offences.is_empty(), "{offences:#?}");
}

#[test]
fn every_rule_but_those_for_possibility_binds_some_file() {
    for rule in RULES.iter().filter(|rule| !rule.why.starts_with("possibility")) {
        assert!(
            rule.binds.iter().all(|path| !files(&root().join(path)).is_empty()),
            "{}: binds nothing",
            rule.why
        );
    }
}

#[test]
fn the_reader_of_rules_sees_what_is_there() {
    let channels = Rule { why: "", binds: &["planner/src"], except: &[], words: &["iceoryx2"] };
    assert!(!offences(&channels).is_empty(), "the planner's channel mentions iceoryx2");
    assert_eq!(code_of("    /// iceoryx2 here"), "");
    assert_eq!(code_of("let a = 1; // iceoryx2"), "let a = 1;");
}

/// The functions of a formatted source: name, first line (from 1), lines.
fn functions(text: &str) -> Vec<(&str, usize, usize)> {
    let lines: Vec<&str> = text.lines().collect();
    let length = |from: usize, indent: usize| {
        let closes = |line: &&str| {
            line.len() > indent && &line[indent..=indent] == "}" && line[..indent].trim().is_empty()
        };
        lines[from..].iter().position(closes).map_or(0, |last| last + 1)
    };
    let mut found = vec![];
    for (number, line) in lines.iter().enumerate() {
        let Some((before, after)) = line.split_once("fn ") else { continue };
        let is_head = before.split_whitespace().all(|word| {
            ["pub", "pub(crate)", "pub(crate)", "const", "unsafe", "async"].contains(&word)
        });
        if is_head && !line.trim_end().ends_with('}') && !line.trim_end().ends_with(';') {
            let name = after.split(['(', '<']).next().unwrap_or_default();
            found.push((name, number + 1, length(number, line.len() - line.trim_start().len())));
        }
    }
    found
}

/// A source without its unit tests, which stand at its end.
fn without_tests(text: &str) -> &str {
    text.split_once("#[cfg(test)]\nmod tests {").map_or(text, |(code, _)| code)
}

#[test]
fn files_and_functions_stay_small() {
    let mut offences = vec![];
    let mut seen = 0;
    for file in SOURCES.iter().flat_map(|path| files(&root().join(path))) {
        let text = std::fs::read_to_string(&file).unwrap();
        let lines = text.lines().count();
        if lines >= FILE_LINES_END {
            offences.push(format!("{}: {lines} lines", shown(&file)));
        }
        for (name, line, length) in functions(without_tests(&text)) {
            seen += 1;
            if length > FUNCTION_LINES_MAX {
                offences.push(format!("{}:{line}: fn {name}: {length} lines", shown(&file)));
            }
        }
    }
    assert!(seen > 500, "only {seen} functions seen");
    assert!(offences.is_empty(), "{offences:#?}");
}

#[test]
fn functions_are_measured_to_their_closing_brace() {
    let text = "impl A {\n    pub fn one(&self) -> u8 {\n        if true {\n        }\n        1\n    }\n    fn two() {}\n}\n";
    assert_eq!(functions(text), [("one", 2, 5)]);
}
