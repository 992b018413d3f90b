//! Words that only some sources may hold.

use crate::imports::Mention;
use crate::lexer::{Kind, pieces};
use crate::rules::Read;
use crate::source::{Source, read_tree};

/// Words that only some sources may hold.
pub struct Rule {
    /// What the rule is for.
    pub why: &'static str,
    /// The files and folders it binds.
    pub binds: &'static [&'static str],
    /// The files and folders among them that it leaves free.
    pub except: &'static [&'static str],
    /// What code there must not mention, comments aside.
    pub words: &'static [&'static str],
}

/// The rules.
pub const RULES: [Rule; 16] = [
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
            "planner/src/channel",
            "controller-sim/src/channel",
            "shared-types/src/message",
            "shared-types/src/instance",
        ],
        words: &["iceoryx2"],
    },
    Rule {
        why: "the search has no clock, except to decide which thread works",
        binds: &["planner/src"],
        except: &["planner/src/channel", "planner/src/base/threads/preemption.rs"],
        words: &["Instant", "SystemTime", "std::time", "core::time", "clock_gettime"],
    },
    Rule {
        why: "only who works may depend on the clock of the threads",
        binds: &["planner/src"],
        except: &["planner/src/base/threads"],
        words: &["preemption::"],
    },
    Rule {
        why: "the search starts no threads but those of its pool",
        binds: &["planner/src"],
        except: &["planner/src/channel", "planner/src/base/threads"],
        words: &["std::thread"],
    },
    Rule {
        why: "the search reads no files and prints nothing",
        binds: &["planner/src"],
        except: &["planner/src/channel"],
        words: &["std::fs", "std::env", "println!", "print!(", "std::process"],
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
            "planner/src/base",
            "planner/src/geometry",
            "planner/src/kinematics",
            "planner/src/robot",
            "planner/src/collision",
            "planner/src/constraints",
            "planner/src/foot_placement",
        ],
        except: &[],
        words: &["crate::motion", "crate::possibility", "crate::pipeline", "crate::plan::"],
    },
    Rule {
        why: "nothing below calls the planner as a whole",
        binds: &["planner/src"],
        except: &["planner/src/pipeline", "planner/src/lib.rs"],
        words: &["crate::pipeline"],
    },
    Rule {
        why: "the search never sends",
        binds: &["planner/src"],
        except: &["planner/src/channel", "planner/src/lib.rs"],
        words: &["crate::channel"],
    },
    Rule {
        why: "stage P knows nothing of stage M",
        binds: &["planner/src/possibility"],
        except: &[],
        words: &["crate::motion", "crate::pipeline"],
    },
    Rule {
        why: "stage M knows nothing of stage P",
        binds: &["planner/src/motion"],
        except: &[],
        words: &["crate::possibility", "crate::pipeline"],
    },
    Rule {
        why: "what iterates in no fixed order decides nothing",
        binds: &["planner/src", "controller-sim/src", "shared-types/src"],
        except: &[],
        words: &["HashMap", "HashSet"],
    },
];

/// A source's lines with comments left out and string literals kept.
fn code_lines(text: &str) -> Vec<String> {
    let mut lines = vec![String::new(); text.lines().count()];
    for piece in pieces(text) {
        if piece.kind != Kind::Comment {
            lines[piece.line - 1].push_str(piece.text);
        }
    }
    lines
}

fn is_below(path: &str, folder: &str) -> bool {
    path.strip_prefix(folder).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

impl Rule {
    /// Whether it binds a file.
    pub fn binds(&self, path: &str) -> bool {
        self.binds.iter().any(|bound| is_below(path, bound))
            && !self.except.iter().any(|free| is_below(path, free))
    }

    /// Where the text of a source breaks the rule.
    pub fn offences(&self, source: &Source) -> Vec<String> {
        if !self.binds(&source.path) {
            return vec![];
        }
        let lines = if source.path.ends_with(".rs") {
            code_lines(&source.text)
        } else {
            let code = |line: &str| line.split('#').next().unwrap_or_default().to_owned();
            source.text.lines().map(code).collect()
        };
        let mut offences = vec![];
        for (at, line) in lines.iter().enumerate() {
            if let Some(word) = self.words.iter().find(|word| line.contains(*word)) {
                offences.push(format!("{}:{}: {word}: {}", source.path, at + 1, self.why));
            }
        }
        offences
    }

    /// Where an import breaks the rule, also if its path is written in braces.
    pub fn import_offence(&self, path: &str, mention: &Mention) -> Option<String> {
        let shown = format!("{}::", mention.shown());
        let names = |word: &&&str| match word.contains("::") {
            true => is_path_prefix(&shown, word),
            false => mention.path.iter().any(|part| part == **word),
        };
        let word = self.words.iter().find(names).filter(|_| self.binds(path))?;
        Some(format!("{path}:{}: {word}: {}", mention.line, self.why))
    }
}

/// Whether a path with `::` at its end begins with a word.
fn is_path_prefix(path: &str, word: &str) -> bool {
    path.strip_prefix(word.trim_end_matches("::")).is_some_and(|rest| rest.starts_with("::"))
}

/// The sources that a rule may bind.
pub fn sources() -> Vec<Source> {
    ["planner", "controller-sim", "shared-types"]
        .iter()
        .flat_map(|folder| ["src", "tests", "Cargo.toml"].map(|inner| format!("{folder}/{inner}")))
        .flat_map(|path| read_tree(&path, &["rs", "toml"]))
        .collect()
}

/// Where any rule is broken.
pub fn offences(read: &Read<'_>, sources: &[Source]) -> Vec<String> {
    let mut found = vec![];
    for rule in &RULES {
        found.extend(sources.iter().flat_map(|source| rule.offences(source)));
        found.extend(read.mentions.iter().filter_map(|mention| {
            rule.import_offence(&read.house.files[mention.file].path, mention)
        }));
    }
    found.sort();
    found.dedup();
    found
}
