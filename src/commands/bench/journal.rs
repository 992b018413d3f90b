//! Results kept on disk as they come, one JSON object a line, so that an interrupted bench goes on
//! where it was.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use surefoot_shared_types::InputError;

use crate::commands::bench::trial::Trial;
use crate::report::command_error::CommandError;

/// A result of a bench: a trial, with or without more.
pub trait TrialRecord: AsRef<Trial> + Clone + Serialize + DeserializeOwned {}

impl<R: AsRef<Trial> + Clone + Serialize + DeserializeOwned> TrialRecord for R {}

/// The results so far.
#[derive(Debug)]
pub struct Journal<R> {
    known: BTreeMap<String, R>,
    file: Option<(PathBuf, File)>,
}

impl<R: TrialRecord> Journal<R> {
    /// Opens `folder/name`, creates both if they are missing, and reads the results; `fresh`
    /// deletes them. Without a folder nothing is saved. Where only one `setup` gives these results,
    /// e.g. a commit and a work limit, the file's first line names it.
    ///
    /// # Errors
    /// When the file cannot be opened, another process writes to it, a line in it is no result, or
    /// it holds results of another setup.
    pub fn open(
        folder: Option<&Path>,
        name: &str,
        fresh: bool,
        setup: Option<&str>,
    ) -> Result<Self, CommandError> {
        let Some(folder) = folder else { return Ok(Self { known: BTreeMap::new(), file: None }) };
        let path = folder.join(name);
        let mut file = open_locked(folder, &path).map_err(|reason| unwritable(&path, reason))?;
        let mut text = String::new();
        if !fresh {
            file.read_to_string(&mut text)
                .map_err(|error| InputError::file(&path, format!("cannot be read: {error}")))?;
        }
        // A killed process leaves half a line behind.
        text.truncate(text.rfind('\n').map_or(0, |last| last + 1));
        let length = text.len() as u64;
        let ready = file.set_len(length).and_then(|()| file.seek(SeekFrom::Start(length)));
        ready.map_err(|error| unwritable(&path, error.to_string()))?;
        match setup {
            Some(setup) if text.is_empty() => append(&mut file, &path, &setup)?,
            Some(setup) => check_setup(&text, setup, &path)?,
            None => {}
        }
        let known = parse(&text, usize::from(setup.is_some()), &path)?;
        Ok(Self { known, file: Some((path, file)) })
    }

    /// The result of this key, with a check_result if one is needed; made and kept if there is
    /// none.
    ///
    /// # Errors
    /// When it cannot be made or written.
    pub fn find_or_make(
        &mut self,
        key: &str,
        needs_check_result: bool,
        make: impl FnOnce() -> Result<R, CommandError>,
    ) -> Result<R, CommandError> {
        if let Some(known) = self.find(key, needs_check_result) {
            return Ok(known.clone());
        }
        let made = make()?;
        self.keep(&made)?;
        Ok(made)
    }

    /// The result of this key, with a check_result if one is needed.
    fn find(&self, key: &str, needs_check_result: bool) -> Option<&R> {
        self.known.get(key).filter(|record| {
            let trial = (*record).as_ref();
            !needs_check_result || !trial.is_found() || trial.check_result.is_some()
        })
    }

    /// Keeps a result.
    fn keep(&mut self, record: &R) -> Result<(), CommandError> {
        if let Some((path, file)) = &mut self.file {
            append(file, path, record)?;
        }
        self.known.insert(record.as_ref().key.clone(), record.clone());
        Ok(())
    }
}

/// Writes a line.
fn append(file: &mut File, path: &Path, value: &impl Serialize) -> Result<(), CommandError> {
    let line = serde_json::to_string(value).map_err(std::io::Error::from);
    let written = line.and_then(|line| file.write_all(format!("{line}\n").as_bytes()));
    written.map_err(|error| unwritable(path, error.to_string()))
}

/// Refuses a file whose first line names another setup, or none.
fn check_setup(text: &str, setup: &str, path: &Path) -> Result<(), InputError> {
    let first = text.lines().next().unwrap_or_default();
    match serde_json::from_str::<String>(first) {
        Ok(found) if found == setup => Ok(()),
        Ok(found) => Err(format!("holds results of {found}; this is {setup}")),
        Err(error) => Err(format!("is no journal of this bench ({error})")),
    }
    .map_err(|reason| {
        let reason = format!("{reason}; --fresh starts anew, --out may name another folder");
        InputError::file(path, reason).at_line(1)
    })
}

fn open_locked(folder: &Path, path: &Path) -> Result<File, String> {
    std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    let file = OpenOptions::new()
        .read(true)
        .write(true)
        .create(true)
        .truncate(false)
        .open(path)
        .map_err(|error| error.to_string())?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => {
            Err("another bench writes to it; wait for its end or choose another folder".to_owned())
        }
        Err(TryLockError::Error(error)) => Err(error.to_string()),
    }
}

/// The results of all lines but some first ones.
fn parse<R: TrialRecord>(
    text: &str,
    skipped: usize,
    path: &Path,
) -> Result<BTreeMap<String, R>, InputError> {
    let record = |(index, line): (usize, &str)| {
        let bad = |error| {
            InputError::file(
                path,
                format!("is no journal of this bench ({error}); --fresh starts anew"),
            )
            .at_line(index + 1)
        };
        serde_json::from_str(line)
            .map(|record: R| (record.as_ref().key.clone(), record))
            .map_err(bad)
    };
    text.lines().enumerate().skip(skipped).map(record).collect()
}

fn unwritable(path: &Path, reason: String) -> CommandError {
    CommandError::Output { path: path.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(key: &str, check_result: Option<&str>) -> Trial {
        Trial {
            key: key.into(),
            scenario: "flat".into(),
            seed: 1,
            threads: 2,
            outcome: "found".into(),
            ready_seconds: 0.5,
            seconds: 0.25,
            first_chunk_seconds: Some(0.125),
            processor_seconds: 0.5,
            work: 9,
            work_by_stage: [("footholds".to_owned(), 9)].into(),
            seconds_by_stage: None,
            waypoints: 3,
            arena_bytes: 4,
            digest: Some("d".into()),
            check_result: check_result.map(str::to_owned),
        }
    }

    #[test]
    fn what_was_kept_is_there_again() {
        let folder = tempfile::tempdir().unwrap();
        let open = |fresh| Journal::<Trial>::open(Some(folder.path()), "a.jsonl", fresh, None);
        let mut journal = open(false).unwrap();
        journal.keep(&trial("one", None)).unwrap();
        journal.keep(&trial("two", Some("accepted"))).unwrap();
        assert!(open(false).unwrap_err().to_string().contains("another bench"));
        drop(journal);
        let journal = open(false).unwrap();
        assert_eq!(journal.find("two", true), Some(&trial("two", Some("accepted"))));
        assert_eq!(journal.find("one", false), Some(&trial("one", None)));
        assert_eq!(journal.find("one", true), None, "no check_result yet");
        drop(journal);
        assert_eq!(open(true).unwrap().find("two", false), None);
    }

    #[test]
    fn half_a_line_is_dropped_and_a_broken_one_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        let open = || Journal::<Trial>::open(Some(folder.path()), "a.jsonl", false, None);
        let line = serde_json::to_string(&trial("one", None)).unwrap();
        std::fs::write(&path, format!("{line}\n{}", &line[..40])).unwrap();
        open().unwrap().keep(&trial("two", None)).unwrap();
        let journal = open().unwrap();
        assert!(journal.find("one", false).is_some() && journal.find("two", false).is_some());
        drop(journal);
        std::fs::write(&path, format!("{line}\nrubbish\n")).unwrap();
        assert!(open().unwrap_err().to_string().contains("a.jsonl:2: "));
    }

    #[test]
    fn results_of_another_setup_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let open = |fresh, setup| {
            Journal::<Trial>::open(Some(folder.path()), "a.jsonl", fresh, Some(setup))
        };
        open(false, "commit a").unwrap().keep(&trial("one", None)).unwrap();
        assert!(open(false, "commit a").unwrap().find("one", false).is_some());
        let error = open(false, "commit b").unwrap_err().to_string();
        assert!(
            error.contains("a.jsonl:1: holds results of commit a; this is commit b"),
            "{error}"
        );
        assert!(open(false, "commit a").unwrap().find("one", false).is_some(), "still there");
        assert!(open(true, "commit b").unwrap().find("one", false).is_none());
        assert!(open(false, "commit b").is_ok());
        let other = Journal::<Trial>::open(Some(folder.path()), "b.jsonl", false, None);
        other.unwrap().keep(&trial("one", None)).unwrap();
        let unnamed =
            Journal::<Trial>::open(Some(folder.path()), "b.jsonl", false, Some("commit a"));
        assert!(unnamed.unwrap_err().to_string().contains("b.jsonl:1: is no journal of this"));
    }

    #[test]
    fn without_a_folder_results_stay_in_memory() {
        let mut journal = Journal::<Trial>::open(None, "a.jsonl", false, None).unwrap();
        journal.keep(&trial("one", None)).unwrap();
        assert!(journal.find("one", false).is_some());
    }
}
