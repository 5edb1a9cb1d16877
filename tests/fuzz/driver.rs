//! Feeds a reader with changed files until its time is over, and looks after what it does.
//!
//! Inputs that are answered in a new way (another message, numbers and names left out) join those that are
//! changed further. All depends on the seed alone. The input that is being read lies in a file: whatever ends the
//! process, it is there.

use crate::mutate::{MOST_BYTES, Random, mutate};
use crate::targets::{Reader, Target};
use std::cell::Cell;
use std::collections::HashSet;
use std::fs::{self, File};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{Seek, SeekFrom, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A reader that takes longer hangs.
const HANG: Duration = Duration::from_secs(10);
/// Inputs that are changed further, at most.
const MOST_INPUTS: usize = 400;
/// Words by which answers are told apart: what follows is often taken from the file.
const WORDS_OF_ANSWER: usize = 8;
/// Memory of the process, at most.
pub const MOST_MEMORY: u64 = 1 << 30;

/// What a target was found to do.
pub struct Found {
    pub executions: u64,
    pub answers: usize,
    pub slowest: Duration,
    /// Inputs that ended in a panic, with its message, and seeds that are refused.
    pub faults: Vec<(PathBuf, String)>,
}

/// Ends the process if a reader hangs.
struct Watch {
    /// Number of the execution; 0 between them.
    execution: AtomicU64,
    input: PathBuf,
}

/// Time that the process has had a processor for, so that a busy machine is no hang; where the system does not tell,
/// the clock's.
fn busy() -> Duration {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let clock = START.get_or_init(Instant::now).elapsed();
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in parentheses; hundredths of seconds.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<u64>().ok());
    ticks(11).zip(ticks(12)).map_or(clock, |(user, system)| Duration::from_millis(10 * (user + system)))
}

fn watch(watch: Arc<Watch>) {
    std::thread::spawn(move || {
        let (mut execution, mut since) = (0, busy());
        while Arc::strong_count(&watch) > 1 {
            std::thread::sleep(Duration::from_millis(500));
            let now = watch.execution.load(Ordering::Relaxed);
            if now != execution {
                (execution, since) = (now, busy());
            } else if now > 0 && busy() - since > HANG {
                eprintln!("a reader has been at it for {} s: {}", HANG.as_secs(), watch.input.display());
                std::process::abort();
            }
        }
    });
}

/// Most memory that the process has had, bytes; 0 where the system does not tell.
pub fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:")).unwrap_or("0");
    line.split_whitespace().next().and_then(|kib| kib.parse::<u64>().ok()).unwrap_or(0) * 1024
}

/// The input as the reader gets it.
struct Place {
    path: PathBuf,
    /// Of inputs that are read from memory: written over, never cut, which is several times as fast.
    open: Option<File>,
}

impl Place {
    fn new(target: &Target, folder: &Path) -> Self {
        let path = folder.join(target.file);
        let open = matches!(target.reader, Reader::Bytes(_)).then(|| File::create(&path).unwrap());
        Self { path, open }
    }

    fn put(&mut self, bytes: &[u8]) {
        match &mut self.open {
            None => fs::write(&self.path, bytes).unwrap(),
            Some(file) => {
                file.seek(SeekFrom::Start(0)).unwrap();
                file.write_all(&[&(bytes.len() as u64).to_le_bytes(), bytes].concat()).unwrap();
            }
        }
    }
}

thread_local! {
    static READING: Cell<bool> = const { Cell::new(false) };
}

/// Whether this thread is in a reader.
pub fn is_reading() -> bool {
    READING.get()
}

/// Reads one input; what the reader says of it, or the message of its panic.
fn read(target: &Target, place: &Path, bytes: &[u8]) -> Result<String, String> {
    READING.set(true);
    let answer = catch_unwind(AssertUnwindSafe(|| match target.reader {
        Reader::Bytes(read) => read(bytes),
        Reader::File(read) => read(place),
    }));
    READING.set(false);
    answer.map_err(|panic| {
        let text = panic.downcast_ref::<&str>().map(|s| (*s).to_string());
        text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
    })
}

/// An answer without what differs from file to file.
fn kind(answer: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    let mut quoted = false;
    let kept = |c: &char| {
        quoted ^= *c == '\'';
        !quoted && !c.is_ascii_digit()
    };
    let plain: String = answer.lines().next().unwrap_or_default().chars().filter(kept).collect();
    plain.split_whitespace().take(WORDS_OF_ANSWER).for_each(|word| word.hash(&mut hasher));
    hasher.finish()
}

/// Reads changed files for some time. Its seeds come first, as they are.
pub fn fuzz(target: &Target, seed: u64, time: Duration, kept: &Path) -> Found {
    let folder = tempfile::Builder::new().prefix("fuzz").tempdir_in(fast_folder()).unwrap();
    (target.beside)(folder.path());
    let mut place = Place::new(target, folder.path());
    let watched = Arc::new(Watch { execution: AtomicU64::new(0), input: place.path.clone() });
    watch(watched.clone());
    let mut name = DefaultHasher::new();
    target.name.hash(&mut name);
    let mut random = Random(seed ^ name.finish());
    let seeds = (target.seeds)();
    assert!(!seeds.is_empty() && seeds.iter().all(|s| s.len() <= MOST_BYTES), "{}: seeds", target.name);
    let mut inputs = seeds.clone();
    let mut answers = HashSet::new();
    let mut found = Found { executions: 0, answers: 0, slowest: Duration::ZERO, faults: Vec::new() };
    let mut panics = HashSet::new();
    let start = Instant::now();
    let mut waiting = seeds.into_iter();
    while start.elapsed() < time || waiting.len() > 0 {
        let original = waiting.next();
        let is_seed = original.is_some();
        let bytes = original.unwrap_or_else(|| {
            let mut bytes = inputs[random.below(inputs.len())].clone();
            let other = random.below(inputs.len());
            mutate(&mut bytes, &inputs[other], target.words, &mut random);
            bytes
        });
        place.put(&bytes);
        let clock = Instant::now();
        watched.execution.store(found.executions + 1, Ordering::Relaxed);
        let answer = read(target, &place.path, &bytes);
        watched.execution.store(0, Ordering::Relaxed);
        let took = clock.elapsed();
        found.slowest = found.slowest.max(took);
        found.executions += 1;
        match answer {
            Err(message) => {
                if panics.insert(kind(&message)) {
                    found.faults.push((keep(kept, target, &bytes), message));
                }
            }
            Ok(answer) => {
                if is_seed && target.good && !answer.starts_with("read") {
                    found.faults.push((keep(kept, target, &bytes), format!("a seed is refused: {answer}")));
                }
                if answers.insert(kind(&answer)) && !is_seed && took < Duration::from_millis(50) && inputs.len() < MOST_INPUTS {
                    inputs.push(bytes.clone());
                }
            }
        }
        // Memory takes its time to fill.
        if took > Duration::from_millis(20) {
            let peak = peak_memory();
            assert!(peak <= MOST_MEMORY, "{} MiB: {}", peak >> 20, keep(kept, target, &bytes).display());
        }
    }
    found.answers = answers.len();
    found
}

/// Where small files cost the least.
fn fast_folder() -> PathBuf {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() }
}

fn keep(folder: &Path, target: &Target, bytes: &[u8]) -> PathBuf {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    let path = folder.join(format!("{}-{:016x}-{}", target.name, hasher.finish(), target.file));
    fs::create_dir_all(folder).and_then(|()| fs::write(&path, bytes)).unwrap();
    path
}
