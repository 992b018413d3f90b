//! Results kept on disk as they come, one JSON object a line, so that an interrupted bench goes on
//! where it was.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use surefoot_shared_types::InputError;

use crate::commands::bench::trial::Trial;
use crate::report::command_error::CommandError;

/// The results so far.
#[derive(Debug, Default)]
pub struct Journal {
    known: BTreeMap<String, Trial>,
    file: Option<(PathBuf, File)>,
}

impl Journal {
    /// Opens `folder/name`, creates both if they are missing, and reads the results; `fresh`
    /// deletes them. Without a folder nothing is saved.
    ///
    /// # Errors
    /// When the file cannot be opened, another process writes to it, or a line in it is no result.
    pub fn open(folder: Option<&Path>, name: &str, fresh: bool) -> Result<Self, CommandError> {
        let Some(folder) = folder else { return Ok(Self::default()) };
        let path = folder.join(name);
        let mut file = open_locked(folder, &path).map_err(|reason| unwritable(&path, reason))?;
        let mut text = String::new();
        if !fresh {
            file.read_to_string(&mut text)
                .map_err(|error| InputError::file(&path, format!("cannot be read: {error}")))?;
        }
        // A killed process leaves half a line behind.
        text.truncate(text.rfind('\n').map_or(0, |last| last + 1));
        let known = parse(&text, &path)?;
        let ready = file.set_len(text.len() as u64).and_then(|()| file.seek(SeekFrom::End(0)));
        ready.map_err(|error| unwritable(&path, error.to_string()))?;
        Ok(Self { known, file: Some((path, file)) })
    }

    /// The result of this key, with a check_result if one is needed.
    pub fn find(&self, key: &str, needs_check_result: bool) -> Option<&Trial> {
        self.known.get(key).filter(|trial| {
            !needs_check_result || !trial.is_found() || trial.check_result.is_some()
        })
    }

    /// Keeps a result.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn keep(&mut self, trial: &Trial) -> Result<(), CommandError> {
        if let Some((path, file)) = &mut self.file {
            let line = serde_json::to_string(trial).map_err(std::io::Error::from);
            let written = line.and_then(|line| file.write_all(format!("{line}\n").as_bytes()));
            written.map_err(|error| unwritable(path, error.to_string()))?;
        }
        self.known.insert(trial.key.clone(), trial.clone());
        Ok(())
    }
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

fn parse(text: &str, path: &Path) -> Result<BTreeMap<String, Trial>, InputError> {
    let trial = |(index, line): (usize, &str)| {
        let bad = |error| {
            InputError::file(
                path,
                format!("is no journal of this bench ({error}); --fresh starts anew"),
            )
            .at_line(index + 1)
        };
        serde_json::from_str(line).map(|trial: Trial| (trial.key.clone(), trial)).map_err(bad)
    };
    text.lines().enumerate().map(trial).collect()
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
        let open = |fresh| Journal::open(Some(folder.path()), "a.jsonl", fresh);
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
        let open = || Journal::open(Some(folder.path()), "a.jsonl", false);
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
    fn without_a_folder_results_stay_in_memory() {
        let mut journal = Journal::open(None, "a.jsonl", false).unwrap();
        journal.keep(&trial("one", None)).unwrap();
        assert!(journal.find("one", false).is_some());
    }
}
