//! The mirrors of the messages in other languages are generated from the messages' own layout
//! tables, and tested against compilers.
//! `SUREFOOT_BLESS=1 cargo test -p surefoot-shared-types --test mirrors` writes them anew.

#![allow(clippy::print_stdout, reason = "a test says what it skips")]
#![allow(clippy::unwrap_used, reason = "a test ends where a mirror cannot be read")]

#[path = "../../tests/common/absent.rs"]
mod absent;

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use iceoryx2::prelude::ZeroCopySend;
use surefoot_shared_types::base::limits::{
    CHUNK_WAYPOINTS_MAX, CONTACTS_MAX, CORRECTIONS_MAX, JOINTS_MAX, POLYGON_VERTICES_MAX,
};
use surefoot_shared_types::message::layout::Field;
use surefoot_shared_types::message::request::StancePoseData;
use surefoot_shared_types::message::simulation_state::FootForce;
use surefoot_shared_types::message::{
    Contact, Feedback, Layout, Margins, PlanChunk, PlanRequest, PlanStatus, RestState,
    SimulationState, Waypoint, WorldCorrection,
};

const LIMITS: [(&str, usize); 5] = [
    ("JOINTS_MAX", JOINTS_MAX),
    ("CHUNK_WAYPOINTS_MAX", CHUNK_WAYPOINTS_MAX),
    ("CONTACTS_MAX", CONTACTS_MAX),
    ("POLYGON_VERTICES_MAX", POLYGON_VERTICES_MAX),
    ("CORRECTIONS_MAX", CORRECTIONS_MAX),
];

/// What a mirror says of a message.
struct Message {
    name: &'static str,
    type_name: &'static str,
    fields: &'static [Field],
    hash: u64,
    size: usize,
}

fn message<M: Layout + ZeroCopySend>(name: &'static str) -> Message {
    // SAFETY: every message names itself with `#[type_name]`.
    let type_name = unsafe { <M as ZeroCopySend>::type_name() };
    Message { name, type_name, fields: M::FIELDS, hash: M::HASH, size: size_of::<M>() }
}

/// All messages, each after those that stand inside it.
fn messages() -> Vec<Message> {
    vec![
        message::<Waypoint>("Waypoint"),
        message::<Contact>("Contact"),
        message::<PlanChunk>("PlanChunk"),
        message::<Margins>("Margins"),
        message::<RestState>("RestState"),
        message::<WorldCorrection>("WorldCorrection"),
        message::<Feedback>("Feedback"),
        message::<StancePoseData>("StancePoseData"),
        message::<PlanRequest>("PlanRequest"),
        message::<PlanStatus>("PlanStatus"),
        message::<FootForce>("FootForce"),
        message::<SimulationState>("SimulationState"),
    ]
}

/// A Rust type as its innermost name and its lengths, outermost first.
fn parts(type_name: &str) -> (String, Vec<String>) {
    let Some(inner) = type_name.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) else {
        return (type_name.to_owned(), vec![]);
    };
    let (element, length) = inner.rsplit_once(';').unwrap();
    let (name, lengths) = parts(element.trim());
    (name, std::iter::once(length.trim().to_owned()).chain(lengths).collect())
}

fn screaming(name: &str) -> String {
    let mut out = String::new();
    for (at, letter) in name.char_indices() {
        if letter.is_uppercase() && at > 0 {
            out.push('_');
        }
        out.push(letter.to_ascii_uppercase());
    }
    out
}

fn header() -> String {
    let mut out = String::from(
        "/* The messages of Surefoot in C11. Generated from shared-types/src/message; see shared-types/tests/mirrors.rs. */\n\
         #ifndef SUREFOOT_MESSAGES_H\n#define SUREFOOT_MESSAGES_H\n\n#include <assert.h>\n#include <stddef.h>\n#include <stdint.h>\n\n",
    );
    for (name, value) in LIMITS {
        writeln!(out, "#define SUREFOOT_{name} {value}").unwrap();
    }
    out.push_str("\ntypedef struct { uint8_t bytes[32]; } surefoot_Digest;\n");
    for message in messages() {
        writeln!(
            out,
            "\n#define SUREFOOT_{}_TYPE_NAME \"{}\"",
            screaming(message.name),
            message.type_name
        )
        .unwrap();
        writeln!(
            out,
            "#define SUREFOOT_{}_LAYOUT \"{:016x}\"",
            screaming(message.name),
            message.hash
        )
        .unwrap();
        out.push_str("typedef struct {\n");
        for field in message.fields {
            let (name, lengths) = parts(field.type_name);
            let c_type = match name.as_str() {
                "u64" => "uint64_t".to_owned(),
                "u32" => "uint32_t".to_owned(),
                "f64" => "double".to_owned(),
                other => format!("surefoot_{other}"),
            };
            let lengths: String =
                lengths.iter().map(|length| format!("[{}]", c_length(length))).collect();
            writeln!(out, "    {c_type} {}{lengths};", field.name).unwrap();
        }
        writeln!(out, "}} surefoot_{};", message.name).unwrap();
        writeln!(
            out,
            "static_assert(sizeof(surefoot_{}) == {}, \"size\");",
            message.name, message.size
        )
        .unwrap();
        for field in message.fields {
            writeln!(
                out,
                "static_assert(offsetof(surefoot_{}, {}) == {}, \"offset\");",
                message.name, field.name, field.offset
            )
            .unwrap();
        }
    }
    out.push_str("\n#endif\n");
    out
}

fn c_length(length: &str) -> String {
    if length.chars().all(|letter| letter.is_ascii_digit()) {
        length.to_owned()
    } else {
        format!("SUREFOOT_{length}")
    }
}

fn python() -> String {
    let mut out = String::from(
        "\"\"\"The messages of Surefoot for ctypes. Generated from shared-types/src/message; see shared-types/tests/mirrors.rs.\n\n\
         The classes fit the `iceoryx2` package: `type_name()` is the name under which a service knows them. A service of\n\
         Surefoot carries the attribute `surefoot.layout`, whose value must be the message's LAYOUT.\n\"\"\"\n\nimport ctypes\n\n",
    );
    for (name, value) in LIMITS {
        writeln!(out, "{name} = {value}").unwrap();
    }
    out.push_str("\nDigest = ctypes.c_uint8 * 32\n");
    for message in messages() {
        writeln!(out, "\n\nclass {}(ctypes.Structure):", message.name).unwrap();
        writeln!(out, "    LAYOUT = \"{:016x}\"", message.hash).unwrap();
        out.push_str("    _fields_ = [\n");
        for field in message.fields {
            let (name, lengths) = parts(field.type_name);
            let base = match name.as_str() {
                "u64" => "ctypes.c_uint64".to_owned(),
                "u32" => "ctypes.c_uint32".to_owned(),
                "f64" => "ctypes.c_double".to_owned(),
                other => other.to_owned(),
            };
            let full = lengths.iter().rev().fold(base, |inner, length| {
                if inner.contains('*') {
                    format!("({inner}) * {length}")
                } else {
                    format!("{inner} * {length}")
                }
            });
            writeln!(out, "        (\"{}\", {full}),", field.name).unwrap();
        }
        writeln!(
            out,
            "    ]\n\n    @staticmethod\n    def type_name() -> str:\n        return \"{}\"",
            message.type_name
        )
        .unwrap();
    }
    out.push_str("\n\nif __name__ == \"__main__\":\n    for message in [");
    out.push_str(&messages().iter().map(|message| message.name).collect::<Vec<_>>().join(", "));
    out.push_str(
        "]:\n        print(message.__name__, ctypes.sizeof(message))\n        for field in message._fields_:\n            \
         place = getattr(message, field[0])\n            print(field[0], place.offset, place.size)\n",
    );
    out
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tools/mirrors").join(name)
}

fn assert_committed(name: &str, text: &str) {
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        std::fs::create_dir_all(file("")).unwrap();
        std::fs::write(file(name), text).unwrap();
    }
    let committed = std::fs::read_to_string(file(name)).unwrap();
    assert!(committed == text, "{name} is out of date; write it anew with SUREFOOT_BLESS=1");
}

#[test]
fn the_c_header_is_what_a_compiler_makes_of_it() {
    assert_committed("surefoot_messages.h", &header());
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("check.c");
    std::fs::write(&source, "#include \"surefoot_messages.h\"\nint main(void) { return 0; }\n")
        .unwrap();
    let compiled = Command::new("cc")
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I"])
        .arg(file(""))
        .arg(&source)
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
}

#[test]
fn the_python_mirror_is_what_ctypes_makes_of_it() {
    assert_committed("surefoot_messages.py", &python());
    let output = match Command::new("python3").arg("-B").arg(file("surefoot_messages.py")).output()
    {
        Ok(output) => output,
        Err(error) => return absent::skip(&format!("no python3 ({error})")),
    };
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut expected = String::new();
    for message in messages() {
        writeln!(expected, "{} {}", message.name, message.size).unwrap();
        for field in message.fields {
            writeln!(expected, "{} {} {}", field.name, field.offset, field.size).unwrap();
        }
    }
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expected);
}
