#!/usr/bin/env python3
"""Mutation tests of a crate with one build for all mutants.

usage: mutants.py FOLDER [FOLDER ...] [--crate controller-sim] [--again] [--sample N [--seed S]]
                  [--jobs N]

cargo-mutants lists the mutants. A copy of the crate under target/mutants holds all of them, each
behind a switch that an environment variable sets when a test starts, so that a mutant costs the run
of its tests and no build. A first run of every test records which mutants it reaches; a mutant is
tried with these tests alone, the quickest ones first. Mutants in constants cannot be switched; the
report lists them for cargo-mutants itself. With --again only those that the last run of the same
folders missed are tried, with --sample a random choice of so many.

FOLDER is relative to the crate's src. The report is target/mutants/CRATE.json; the summary and what
is missed go to the standard output. exit: 0 none is missed, 1 some are, 2 cannot be run.
Needs cargo-mutants and `pip install tree-sitter tree-sitter-rust`.
"""

import argparse
import bisect
import collections
import concurrent.futures
import json
import os
import random
import resource
import shutil
import subprocess
import sys
from pathlib import Path

try:
    import tree_sitter
    import tree_sitter_rust
except ImportError as error:
    print(f"cannot run: {error}; pip install tree-sitter tree-sitter-rust", file=sys.stderr)
    sys.exit(2)

ROOT = Path(__file__).resolve().parent.parent
SCRATCH = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "mutants"
# Tests shorter than this (s) run together in one process.
SHORT = 0.05
# A mutant's tests may take this much more processor time than without it, and s more. Deadlocks
# end after WAIT times as long, however loaded the machine is.
SLOWER, GRACE, WAIT = 10.0, 5.0, 20.0
# Memory of a test, bytes: mutants may allocate without end.
MEMORY_MAX = 4 << 30
BUILDS_MAX = 12

SWITCH = """//! Which mutant is active, set by the environment variable `MUTANT`.
#![allow(missing_docs, clippy::all)]
use std::sync::atomic::{AtomicU32, Ordering};
const UNKNOWN: u32 = u32::MAX;
const RECORDING: u32 = u32::MAX - 1;
static ACTIVE: AtomicU32 = AtomicU32::new(UNKNOWN);
static REACHED: [AtomicU32; COUNT] = [const { AtomicU32::new(0) }; COUNT];

/// Whether one of `count` mutants from `first` on is active.
#[inline(always)]
pub fn any(first: u32, count: u32) -> bool {
    let active = ACTIVE.load(Ordering::Relaxed);
    if active >= RECORDING {
        return record(first, count);
    }
    active.wrapping_sub(first) < count
}

#[inline(always)]
pub fn on(mutant: u32) -> bool {
    any(mutant, 1)
}

/// An iterator of one of two types, for functions that return `impl Iterator`.
#[derive(Clone)]
pub enum Either<L, R> {
    Left(L),
    Right(R),
}

impl<L: Iterator<Item = R::Item>, R: Iterator> Iterator for Either<L, R> {
    type Item = R::Item;

    fn next(&mut self) -> Option<R::Item> {
        match self {
            Either::Left(left) => left.next(),
            Either::Right(right) => right.next(),
        }
    }
}

#[cold]
#[inline(never)]
fn record(first: u32, count: u32) -> bool {
    if ACTIVE.load(Ordering::Relaxed) == UNKNOWN {
        let named = std::env::var("MUTANT").ok().and_then(|text| text.parse().ok());
        let recording = std::env::var_os("MUTANTS_REACHED").is_some();
        let none = if recording { RECORDING } else { RECORDING - 1 };
        ACTIVE.store(named.unwrap_or(none), Ordering::Relaxed);
        return any(first, count);
    }
    if REACHED[first as usize].swap(1, Ordering::Relaxed) == 0 {
        use std::io::Write;
        let path = std::env::var_os("MUTANTS_REACHED").unwrap();
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).unwrap();
        (first..first + count).for_each(|mutant| writeln!(file, "{mutant}").unwrap());
    }
    false
}
"""


def fail(text):
    print(text, file=sys.stderr)
    sys.exit(2)


def listed(crate, folders):
    """The mutants of cargo-mutants, a dictionary each."""
    command = ["cargo", "mutants", "--list", "--json", "--colors", "never", "-p", package(crate)]
    for folder in folders:
        command += ["-f", f"{crate}/src/{folder}" + ("" if folder.endswith(".rs") else "/**")]
    try:
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    except FileNotFoundError as error:
        fail(f"cannot run: {error}")
    except subprocess.CalledProcessError as error:
        fail(f"cargo mutants --list: {error.stderr}")
    mutants = json.loads(found.stdout)
    return [mutant for mutant in mutants if not is_left_out(mutant)]


def tree_of(crate):
    """Where the copy of a crate stands, among links to the rest of the workspace."""
    return SCRATCH / "trees" / crate


def package(crate):
    """The name of the package in the crate's folder."""
    lines = (ROOT / crate / "Cargo.toml").read_text().splitlines()
    return next(line.split('"')[1] for line in lines if line.startswith("name"))


def is_left_out(mutant):
    """Texts for developers are not tested."""
    return "fmt::Debug" in ((mutant.get("function") or {}).get("function_name") or "")


class Source:
    """A file with its syntax tree and the switches to write into it."""

    def __init__(self, path):
        self.path, self.data = path, path.read_bytes()
        lines = self.data.split(b"\n")
        self.lines, self.starts, at = lines, [], 0
        for line in lines:
            self.starts.append(at)
            at += len(line) + 1
        parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language()))
        self.tree = parser.parse(self.data)
        # What to write around nodes, and at single places.
        self.around, self.single = [], []

    def offset(self, place):
        line = self.lines[place["line"] - 1].decode()
        return self.starts[place["line"] - 1] + len(line[:place["column"] - 1].encode())

    def range(self, mutant):
        return tuple(self.offset(mutant["span"][end]) for end in ("start", "end"))

    def node(self, span, kinds):
        """The smallest node of these kinds around a range."""
        node = self.tree.root_node.descendant_for_byte_range(span[0], max(span[0], span[1] - 1))
        while node is not None and node.type not in kinds:
            node = node.parent
        return node

    def is_constant(self, node):
        """Whether a node is evaluated by the compiler."""
        while node is not None:
            if node.type in ("const_item", "static_item", "const_block", "array_type"):
                return True
            modifiers = [c for c in node.children if c.type == "function_modifiers"]
            if node.type == "function_item" and any(b"const" in c.text for c in modifiers):
                return True
            node = node.parent
        return False

    def add(self, group):
        """Writes the switches of the mutants of one node; false where that cannot be done."""
        mutants = [mutant for _, mutant in group]
        first, genre = group[0][0], mutants[0]["genre"]
        span = self.range(mutants[0])
        if genre == "FnValue":
            return self.add_value(group, span)
        if genre == "MatchArm":
            pattern = self.node(span, ("match_arm",)).child_by_field_name("pattern")
            self.single.append(
                (pattern.end_byte, first, "", f" if !crate::mutant_switch::on({first})", ""))
            return True
        kinds = {
            "BinaryOperator": ("binary_expression", "compound_assignment_expr", "let_chain"),
            "UnaryOperator": ("unary_expression", "negative_literal"),
            "StructField": ("struct_expression",),
        }
        if genre == "MatchArmGuard":
            start, end = span
        else:
            node = self.node(span, kinds[genre])
            is_usable = node is not None and node.type in kinds[genre][:2] and (
                node.type != "negative_literal")
            if not is_usable or self.is_constant(node) or has_let(node):
                return False
            start, end = node.start_byte, node.end_byte
        text = self.data
        mutated = [(number, text[start:s] + mutant["replacement"].encode() + text[e:end])
                   for number, mutant in group for s, e in [self.range(mutant)]]
        self.around.append((start, end, first, len(group), mutated))
        return True

    def add_value(self, group, span):
        """As `add`, for mutants that replace the body of a function."""
        body = self.node(span, ("block",))
        kind = group[0][1]["function"]["return_type"].removeprefix("-> ")
        replacements = [(number, mutant["replacement"]) for number, mutant in group]
        if self.is_constant(body) or "impl " in kind and not is_iterator(kind, replacements, body):
            return False
        for number, replacement in replacements:
            before, value, after = f"if crate::mutant_switch::on({number}) {{ ", replacement, " }\n"
            if "impl " in kind:
                before += "crate::mutant_switch::Either::Left("
                after = ") } else { crate::mutant_switch::Either::Right({\n"
                self.single.append((span[1], number, "\n}) }", "", ""))
            else:
                value = f"return {value};"
            self.single.append((span[0], number, before, value, after))
        return True

    def written(self, module):
        """The text with all switches, and where each mutant stands in it: (start, end, number)."""
        # What opens first closes last, also around the same node.
        events = [(end, 0, -start, -index, ("close", mutated))
                  for index, (start, end, *_, mutated) in enumerate(self.around)]
        events += [(at, 1, number, 0, ("single", number, texts))
                   for at, number, *texts in self.single]
        events += [(start, 2, -end, index, ("open", first, count))
                   for index, (start, end, first, count, _) in enumerate(self.around)]
        events.sort(key=lambda event: event[:4])
        out, ranges, done = bytearray(), [], 0

        def mutated(number, text):
            ranges.append((len(out), len(out) + len(text), number))
            out.extend(text)

        for at, *_, event in events:
            out += self.data[done:at]
            done = at
            if event[0] == "open":
                out += b"(if !crate::mutant_switch::any(%d, %d) {" % event[1:]
            elif event[0] == "single":
                before, text, after = event[2]
                out += before.encode()
                mutated(event[1], text.encode())
                out += after.encode()
            else:
                *some, (number, text) = event[1]
                for other, other_text in some:
                    out += b"} else if crate::mutant_switch::on(%d) {" % other
                    mutated(other, other_text)
                out += b"} else {"
                mutated(number, text)
                out += b"})"
        out += self.data[done:]
        if module:
            out += b"\n#[doc(hidden)]\npub mod mutant_switch;\n"
        return bytes(out), ranges


def is_iterator(kind, replacements, body):
    """Whether a function's value can be one of two iterators."""
    is_plain = kind.startswith("impl Iterator") and b"return" not in body.text
    return is_plain and not any("leak" in value for _, value in replacements)


def has_let(node):
    """Whether a condition binds a name."""
    is_let = node.type in ("let_condition", "let_chain")
    return is_let or node.type != "block" and any(map(has_let, node.children))


class Crate:
    """The copy of the crate with the switches of its mutants."""

    def __init__(self, crate, mutants):
        self.crate, self.mutants, self.tree = crate, mutants, tree_of(crate)
        # Mutants that do not compile, with the message, and those that cannot be switched.
        self.unviable, self.unswitched = {}, set()
        # Where mutants stand in the copy's files.
        self.ranges = {}
        self.copy()

    def copy(self):
        self.tree.mkdir(parents=True, exist_ok=True)
        for entry in ROOT.iterdir():
            there = self.tree / entry.name
            if entry.name in (self.crate, "target", ".git", "Cargo.lock") or there.is_symlink():
                continue
            there.symlink_to(entry)
        shutil.copyfile(ROOT / "Cargo.lock", self.tree / "Cargo.lock")
        home = self.tree / self.crate
        for path in sorted((ROOT / self.crate).rglob("*")):
            if path.is_file():
                write(home / path.relative_to(ROOT / self.crate), path.read_bytes())

    def write(self):
        """Writes all mutants that are viable."""
        groups = collections.defaultdict(list)
        for number, mutant in enumerate(self.mutants):
            if number not in self.unviable and number not in self.unswitched:
                span = mutant["span"]
                ends = [(span[end]["line"], span[end]["column"]) for end in ("start", "end")]
                key = (mutant["file"], mutant["genre"], *ends)
                groups[key].append((number, mutant))
        sources, main = {}, f"{self.crate}/src/lib.rs"
        for (file, *_), group in groups.items():
            source = sources.setdefault(file, None) or Source(ROOT / file)
            sources[file] = source
            # A switch knows its mutants by the first number and their count.
            for run in successive(group):
                if not source.add(run):
                    self.unswitched.update(number for number, _ in run)
        sources.setdefault(main, Source(ROOT / main))
        self.ranges = {}
        for file, source in sources.items():
            text, self.ranges[file] = source.written(file == main)
            self.ranges[file].sort()
            write(self.tree / file, text)
        count = f"const COUNT: usize = {len(self.mutants)};\n"
        write(self.tree / self.crate / "src" / "mutant_switch.rs",
              SWITCH.replace("static ACTIVE", count + "static ACTIVE").encode())

    def build(self):
        """The test programs, without the mutants that do not compile."""
        for _ in range(BUILDS_MAX):
            self.write()
            programs, errors = self.compile()
            if programs is not None:
                return programs
            found = 0
            for message in errors:
                for number in self.blamed(message):
                    found += number not in self.unviable
                    self.unviable[number] = message["message"]
            print(f"{found} mutants do not compile", file=sys.stderr, flush=True)
            if not found:
                fail("\n".join(message.get("rendered") or "" for message in errors[:5]))
        fail("too many builds")

    def compile(self):
        command = ["cargo", "--config", 'profile.release.package."*".opt-level=3', "test",
                   "--release", "-p", package(self.crate), "--no-run", "--message-format", "json"]
        environment = {**os.environ, "CARGO_TARGET_DIR": str(SCRATCH / "target"),
                       "CARGO_PROFILE_RELEASE_OPT_LEVEL": "1", "CARGO_INCREMENTAL": "1",
                       "RUSTFLAGS": os.environ.get("RUSTFLAGS", "") + " --cap-lints warn"}
        if not os.environ.get("RUSTFLAGS"):
            environment.pop("RUSTFLAGS")
        done = subprocess.run(command, cwd=self.tree, capture_output=True, text=True, env=environment)
        messages = [json.loads(line) for line in done.stdout.splitlines() if line[:1] == "{"]
        errors = [message["message"] for message in messages
                  if message["reason"] == "compiler-message"
                  and message["message"]["level"] == "error"]
        if done.returncode == 0:
            return [message["executable"] for message in messages
                    if message["reason"] == "compiler-artifact" and message.get("executable")], []
        if not errors:
            fail(done.stderr)
        return None, errors

    def blamed(self, message):
        """The mutants in whose text an error lies; where none, those that its labels name."""
        spans = sorted(message["spans"], key=lambda span: not span["is_primary"])
        for span in spans:
            while span.get("expansion"):
                span = span["expansion"]["span"]
            ranges = self.ranges.get(span["file_name"], [])
            last = bisect.bisect_right(ranges, (span["byte_start"], 1 << 60, 0))
            inside = [number for start, end, number in ranges[:last]
                      if start <= span["byte_start"] and span["byte_end"] <= end]
            if inside:
                return inside
        return []


def successive(group):
    """Runs of successive numbers."""
    runs = [[group[0]]]
    for entry in group[1:]:
        if entry[0] == runs[-1][-1][0] + 1:
            runs[-1].append(entry)
        else:
            runs.append([entry])
    return runs


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_bytes() != data:
        path.write_bytes(data)


def processor_time():
    """Of all programs run so far, s."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


class Tests:
    """All tests, how long each takes, and which mutants it reaches."""

    def __init__(self, crate, programs):
        self.folder = tree_of(crate) / crate
        self.seconds, self.reached = {}, collections.defaultdict(list)
        record = tree_of(crate) / "reached"
        for program in programs:
            names = self.run(program, ["--list", "--format", "terse"], {}, 60)[1].splitlines()
            for name in (line[:-6] for line in names if line.endswith(": test")):
                record.unlink(missing_ok=True)
                self.run(program, ["--exact", name], {"MUTANTS_REACHED": str(record)}, 600)
                begin = processor_time()
                passes, _ = self.run(program, ["--exact", name], {}, 600)
                if not passes:
                    print(f"left out, fails without a mutant: {name}", file=sys.stderr)
                    continue
                self.seconds[program, name] = processor_time() - begin
                for line in record.read_text().split() if record.exists() else []:
                    self.reached[int(line)].append((program, name))

    def run(self, program, arguments, environment, seconds):
        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY_MAX, MEMORY_MAX))
            resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))

        try:
            done = subprocess.run(
                [program, "--test-threads", "1", *arguments], cwd=self.folder, text=True,
                capture_output=True, timeout=WAIT * seconds, preexec_fn=limit, errors="replace",
                env={**os.environ, "CARGO_MANIFEST_DIR": str(self.folder), **environment})
        except subprocess.TimeoutExpired:
            return False, "timeout"
        return done.returncode == 0, done.stdout

    def catch(self, number):
        """Whether a test fails with a mutant."""
        tests = sorted(self.reached[number], key=self.seconds.get)
        batches = collections.defaultdict(list)
        for test in tests:
            if self.seconds[test] < SHORT:
                batches[test[0]].append(test)
        runs = list(batches.values()) + [[t] for t in tests if self.seconds[t] >= SHORT]
        for run in runs:
            seconds = SLOWER * sum(map(self.seconds.get, run)) + GRACE
            names = [name for _, name in run]
            passes, _ = self.run(run[0][0], ["--exact", *names], {"MUTANT": str(number)}, seconds)
            if not passes:
                return True
        return False


def summary(results):
    """Figures per folder."""
    table = collections.defaultdict(collections.Counter)
    for result in results:
        folder = "/".join(result["name"].split(":")[0].split("/")[2:-1])
        table[folder][result["outcome"]] += 1
        table[folder]["total"] += 1
    outcomes = ("total", "caught", "missed", "unviable", "unswitched", "untried")
    lines = ["folder".ljust(12) + "".join(outcome.rjust(12) for outcome in outcomes)]
    for folder, counts in sorted(table.items()):
        lines.append(folder.ljust(12) + "".join(str(counts[o]).rjust(12) for o in outcomes))
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description="Mutation tests with one build.")
    parser.add_argument("folders", nargs="+", metavar="FOLDER")
    parser.add_argument("--crate", default="controller-sim")
    parser.add_argument("--again", action="store_true", help="only those missed before")
    parser.add_argument("--sample", type=int, metavar="N", help="only a random choice of N")
    parser.add_argument("--seed", type=int, default=1, help="of the choice")
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    report = SCRATCH / f"{arguments.crate}.json"
    mutants = listed(arguments.crate, arguments.folders)
    crate = Crate(arguments.crate, mutants)
    programs = crate.build()
    tests = Tests(arguments.crate, programs)
    tested = [n for n in range(len(mutants))
              if n not in crate.unviable and n not in crate.unswitched]
    known = {}
    if arguments.again and report.exists():
        known = {key: result["outcome"] for key, result in keyed(json.loads(report.read_text()))}
    outcome = {n: "unviable" for n in crate.unviable}
    outcome.update({n: "unswitched" for n in crate.unswitched})
    # Those not tried yet keep the outcome of the last run.
    for number, (key, _) in enumerate(keyed(mutants)):
        outcome.setdefault(number, known.get(key, "untried"))
    # Those that the last run missed come first.
    tried = [n for n in tested if outcome[n] != "caught"]
    if arguments.sample is not None:
        tried = random.Random(arguments.seed).sample(tried, min(arguments.sample, len(tried)))
    tried.sort(key=lambda number: outcome[number] != "missed")
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for done, (number, found) in enumerate(
                pool.map(lambda n: (n, "caught" if tests.catch(n) else "missed"), tried)):
            outcome[number] = found
            if found == "missed":
                print(f"missed: {mutants[number]['name']}"
                      + ("" if tests.reached[number] else " (no test reaches it)"), flush=True)
            if done % 50 == 49:
                print(f"{done + 1} of {len(tried)}", file=sys.stderr, flush=True)
                save(report, mutants, outcome)
    for number in sorted(crate.unswitched):
        print(f"not switched: {mutants[number]['name']}")
    results = save(report, mutants, outcome)
    print(summary(results))
    sys.exit(int(any(result["outcome"] == "missed" for result in results)))


def save(report, mutants, outcome):
    results = [{"name": mutant["name"], "outcome": outcome[number]}
               for number, mutant in enumerate(mutants)]
    report.write_text(json.dumps(results, indent=1) + "\n")
    return results


def keyed(mutants):
    """Each mutant with a key that does not depend on its line, which moves with every edit."""
    count = collections.Counter()
    for mutant in mutants:
        file, _, _, text = mutant["name"].split(":", 3)
        count[file, text] += 1
        yield (file, text, count[file, text]), mutant


if __name__ == "__main__":
    main()
