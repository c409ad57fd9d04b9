//! `recover --resume`: the journal of a recovery, in its folder of results.
//!
//! It is one file, which grows by one record per step and is removed when the results are written. Its
//! first line is JSON: the identity of the recovery ([`Head`]). A record is its length (8 bytes,
//! little-endian), the SHA-256 of its number and bytes, and the bytes. It is on the disk before the
//! recovery continues. An incomplete last record of a killed process does not match its hash, and ends
//! the journal. A full disk ends it too, with a warning: the recovery continues without.

use crate::fingerprint::fingerprint;
use crate::result_folder::hash;
use crate::run::{Ended, Run};
use crate::{Error, Job, output};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use unrender_formats::{FileError, atomic};
use unrender_recover::Journal;

/// It begins like our temporary files, so that it is not a result, but ends differently, so that it
/// is not removed with them.
const NAME: &str = ".unrender-recover.journal";
/// Bytes before those of a record: its length and its SHA-256.
const BEFORE: usize = 8 + 32;
/// The longest first line: it has about 500 bytes. A file with a longer one is not a journal; a higher
/// limit would only read more of a foreign file.
const LINE: u64 = 1 << 14;

/// The identity of a recovery.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Head {
    /// The version of unrender, and SHA-256 of the program.
    program: String,
    /// The bytes of the project file.
    project: String,
    /// Geometry, lights and known materials.
    scene: String,
    /// The developed photograph, with its mask and its camera.
    photograph: String,
    /// The options of the command line, by name.
    options: BTreeMap<String, String>,
}

impl Head {
    /// The head for the recovery of `job` with the `options` of the command line.
    pub(crate) fn of(job: &Job, options: BTreeMap<String, String>) -> Self {
        let program = std::env::current_exe().and_then(|path| hash(&path)).unwrap_or_default();
        let photograph = |k: usize| {
            let alone = job.alone(k);
            let photo = &alone.photo;
            let masks = (&photo.valid, &photo.saturated, &alone.mask);
            let seen = (&photo.radiance, &photo.quantisation_step, masks);
            fingerprint(&(seen, &alone.camera, &alone.off))
        };
        let photographs: Vec<String> = (0..job.photographs()).map(photograph).collect();
        Self {
            program: format!("{} {program}", env!("CARGO_PKG_VERSION")),
            project: hash(&job.project.path).unwrap_or_default(),
            scene: fingerprint(&job.scene),
            photograph: fingerprint(&photographs),
            options,
        }
    }

    /// How the recovery `other`, which is to be resumed, differs, in words; none if it is the same.
    fn difference(&self, other: &Self) -> Option<String> {
        let parts = [
            (&self.program, &other.program, "by another version or build of unrender"),
            (&self.project, &other.project, "from another project file"),
            (&self.scene, &other.scene, "from another scene"),
            (&self.photograph, &other.photograph, "from another photograph, mask or camera"),
        ];
        let [program, rest @ ..] =
            parts.map(|(mine, theirs, what)| (mine != theirs).then(|| what.to_owned()));
        program.or_else(|| self.other_options(other)).or_else(|| rest.into_iter().flatten().next())
    }

    /// The options with which `other` was begun, if they differ.
    fn other_options(&self, other: &Self) -> Option<String> {
        let changed = |(name, theirs): (&String, &String)| {
            let mine = self.options.get(name)?;
            (mine != theirs).then(|| format!("--{name} {theirs} and not {mine}"))
        };
        let changed: Vec<String> = other.options.iter().filter_map(changed).collect();
        let is_other = self.options != other.options;
        is_other.then(|| match changed.is_empty() {
            true => "with other options".to_owned(),
            false => format!("with other options: {}", changed.join(", ")),
        })
    }
}

/// The journal of one recovery.
pub(crate) struct RecoveryJournal {
    path: PathBuf,
    head: Head,
    writing: Mutex<Writing>,
}

/// The state of a journal.
struct Writing {
    /// None until the first record is written.
    file: Option<File>,
    /// Where the next record begins, and its number.
    at: u64,
    number: u64,
    /// Whether there may be records that were not read yet.
    recalling: bool,
    /// Whether nothing is written from here on.
    closed: bool,
}

/// Whether the folder of results `folder` holds those of a recovery that was not interrupted, and no journal of a later
/// one.
pub(crate) fn has_ended(folder: &Path) -> bool {
    let ended = || {
        Run::read(folder)
            .is_ok_and(|run| run.ended.is_some_and(|ended| ended != Ended::Interrupted))
    };
    !folder.join(NAME).exists() && ended()
}

impl RecoveryJournal {
    /// The journal in the folder of results `folder`. With `resume`, the journal of an interrupted
    /// recovery there is continued; else the first step replaces it.
    ///
    /// # Errors
    /// If `resume` is set and the journal there belongs to another recovery.
    pub(crate) fn open(folder: &Path, head: Head, resume: bool) -> Result<Self, Error> {
        let path = folder.join(NAME);
        let found = read_head(&path);
        let mut writing = Writing { file: None, at: 0, number: 0, recalling: false, closed: false };
        match (found, resume) {
            (Some((file, at, theirs)), true) => {
                if let Some(what) = head.difference(&theirs) {
                    let problem = format!(
                        "the interrupted recovery there was begun {what}; without --resume it \
                         starts again"
                    );
                    return Err(FileError::new(folder, problem).into());
                }
                writing = Writing { file: Some(file), at, recalling: true, ..writing };
                let steps = writing.count().unwrap_or(0);
                output::tell(&format!(
                    "the interrupted recovery continues after its {steps} steps"
                ));
            }
            (None, true) => output::tell(&format!(
                "no interrupted recovery is in {}: it starts from the beginning",
                folder.display()
            )),
            (Some(_), false) => output::tell(&format!(
                "warning: the interrupted recovery in {} is started again; --resume would continue it",
                folder.display()
            )),
            (None, false) => {}
        }
        Ok(Self { path, head, writing: Mutex::new(writing) })
    }

    /// Writes nothing from here on.
    pub(crate) fn close(&self) {
        self.writing().closed = true;
    }

    /// Removes the file when the results are written.
    pub(crate) fn remove(self) {
        // A file that cannot be removed does no harm: a resumed recovery finds the same results.
        let _ = fs::remove_file(&self.path);
    }

    fn writing(&self) -> MutexGuard<'_, Writing> {
        self.writing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A new file with only the first line.
    fn create(&self) -> io::Result<(File, u64)> {
        let line = serde_json::to_string(&self.head)? + "\n";
        if fs::symlink_metadata(&self.path).is_ok_and(|meta| !meta.is_file()) {
            // The target of a link is not ours.
            fs::remove_file(&self.path)?;
        }
        atomic::write(&self.path, line.as_bytes()).map_err(io::Error::other)?;
        let file = OpenOptions::new().read(true).write(true).open(&self.path)?;
        Ok((file, line.len() as u64))
    }

    fn append(&self, writing: &mut Writing, bytes: &[u8]) -> io::Result<()> {
        if writing.file.is_none() {
            let (file, at) = self.create()?;
            (writing.file, writing.at) = (Some(file), at);
        }
        let record = [&(bytes.len() as u64).to_le_bytes()[..], &checksum(writing.number, bytes)];
        let Writing { file: Some(file), at, .. } = writing else { return Ok(()) };
        file.set_len(*at)?;
        file.seek(SeekFrom::Start(*at))?;
        file.write_all(&record.concat())?;
        file.write_all(bytes)?;
        file.sync_data()
    }
}

impl Journal for RecoveryJournal {
    fn recall(&self, understand: &mut dyn FnMut(&[u8]) -> bool) -> bool {
        let mut writing = self.writing();
        if writing.closed || !writing.recalling {
            return false;
        }
        // A step that cannot be read is computed again.
        let recalled = writing.next().ok().flatten().filter(|bytes| understand(bytes));
        match &recalled {
            Some(bytes) => writing.pass(bytes.len()),
            None => writing.recalling = false,
        }
        recalled.is_some()
    }

    fn keep(&self, found: &[u8]) {
        let mut writing = self.writing();
        if writing.closed {
            return;
        }
        match self.append(&mut writing, found) {
            Ok(()) => writing.pass(found.len()),
            Err(error) => {
                writing.closed = true;
                output::tell(&format!(
                    "warning: {} cannot be written ({error}): the recovery continues without it, \
                     and --resume would start from here",
                    self.path.display()
                ));
            }
        }
    }
}

impl Writing {
    /// The next record, if there is a whole one.
    fn next(&mut self) -> io::Result<Option<Vec<u8>>> {
        let Some(file) = &mut self.file else { return Ok(None) };
        let end = file.metadata()?.len();
        file.seek(SeekFrom::Start(self.at))?;
        let mut before = [0; BEFORE];
        file.read_exact(&mut before)?;
        let (length, sha256) = before.split_at(8);
        let length = u64::from_le_bytes(length.try_into().unwrap_or_default());
        if length > end.saturating_sub(self.at + BEFORE as u64) {
            return Ok(None);
        }
        let mut bytes = vec![0; length as usize];
        file.read_exact(&mut bytes)?;
        Ok((checksum(self.number, &bytes)[..] == *sha256).then_some(bytes))
    }

    /// Moves past a record of `length` bytes.
    fn pass(&mut self, length: usize) {
        self.at += (BEFORE + length) as u64;
        self.number += 1;
    }

    /// How many records there are.
    fn count(&mut self) -> io::Result<u64> {
        let (at, number) = (self.at, self.number);
        while let Some(bytes) = self.next().ok().flatten() {
            self.pass(bytes.len());
        }
        let count = self.number - number;
        (self.at, self.number) = (at, number);
        Ok(count)
    }
}

fn checksum(number: u64, bytes: &[u8]) -> [u8; 32] {
    Sha256::new().chain_update(number.to_le_bytes()).chain_update(bytes).finalize().into()
}

/// The journal at `path`, the offset of its records, and its first line; none if there is none.
fn read_head(path: &Path) -> Option<(File, u64, Head)> {
    if !fs::symlink_metadata(path).ok()?.is_file() {
        return None;
    }
    let file = OpenOptions::new().read(true).write(true).open(path).ok()?;
    let mut line = Vec::new();
    BufReader::new(&file).take(LINE).read_until(b'\n', &mut line).ok()?;
    let head = serde_json::from_slice(line.strip_suffix(b"\n")?).ok()?;
    Some((file, line.len() as u64, head))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn head(options: &str) -> Head {
        let text = String::new;
        let options = BTreeMap::from([("effort".to_owned(), options.to_owned())]);
        Head { program: text(), project: text(), scene: text(), photograph: text(), options }
    }

    fn recalled(journal: &RecoveryJournal) -> Vec<Vec<u8>> {
        let mut all = Vec::new();
        while journal.recall(&mut |bytes| {
            all.push(bytes.to_vec());
            true
        }) {}
        all
    }

    #[test]
    fn wherever_it_is_cut_off_whole_records_come_back_and_it_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let open = |resume| RecoveryJournal::open(folder.path(), head("a"), resume).unwrap();
        let records = [&b"one"[..], &[0xff; 700], b"", b"four"];
        let journal = open(false);
        records.iter().for_each(|record| journal.keep(record));
        let path = folder.path().join(NAME);
        let whole = fs::read(&path).unwrap();
        let start = whole.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        for cut in start..=whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            let journal = open(true);
            let back = recalled(&journal);
            assert_eq!(back, records[..back.len()]);
            records[back.len()..].iter().for_each(|record| journal.keep(record));
            assert!(fs::read(&path).unwrap() == whole, "cut at {cut}");
        }
        for cut in 0..start {
            fs::write(&path, &whole[..cut]).unwrap();
            assert!(recalled(&open(true)).is_empty());
        }
        journal.remove();
        assert!(!path.exists());
    }

    #[test]
    fn a_changed_byte_ends_it_and_what_is_not_understood_is_dropped() {
        let folder = tempfile::tempdir().unwrap();
        let open = |resume| RecoveryJournal::open(folder.path(), head("a"), resume).unwrap();
        let journal = open(false);
        [b"one", b"two", b"six"].iter().for_each(|record| journal.keep(*record));
        let path = folder.path().join(NAME);
        let mut bytes = fs::read(&path).unwrap();
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        fs::write(&path, bytes).unwrap();
        assert_eq!(recalled(&open(true)), [b"one", b"two"]);
        let journal = open(true);
        assert!(!journal.recall(&mut |_| false));
        assert!(!journal.recall(&mut |_| true), "nothing comes after it");
        journal.keep(b"new");
        assert_eq!(recalled(&open(true)), [b"new"]);
        let journal = open(true);
        journal.close();
        assert!(!journal.recall(&mut |_| true));
        journal.keep(b"late");
        assert_eq!(recalled(&open(true)), [b"new"], "closed");
    }

    #[test]
    fn another_recovery_is_refused_and_begun_anew_without_resume() {
        let folder = tempfile::tempdir().unwrap();
        RecoveryJournal::open(folder.path(), head("a"), false).unwrap().keep(b"one");
        let Err(error) = RecoveryJournal::open(folder.path(), head("b"), true) else {
            panic!("it goes on")
        };
        let told = "was begun with other options: --effort a and not b; without --resume";
        assert!(error.to_string().contains(told), "{error}");
        RecoveryJournal::open(folder.path(), head("b"), false).unwrap().keep(b"two");
        let journal = RecoveryJournal::open(folder.path(), head("b"), true).unwrap();
        assert_eq!(recalled(&journal), [b"two"]);
    }

    #[cfg(unix)]
    #[test]
    fn what_a_link_leads_to_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let mine = folder.path().join("mine");
        fs::write(&mine, "mine").unwrap();
        std::os::unix::fs::symlink(&mine, folder.path().join(NAME)).unwrap();
        for resume in [true, false] {
            let journal = RecoveryJournal::open(folder.path(), head("a"), resume).unwrap();
            journal.keep(b"one");
            assert_eq!(fs::read(&mine).unwrap(), b"mine");
        }
    }
}
