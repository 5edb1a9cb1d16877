//! Standard output and standard error, which others may close at any time.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// Prints results. Where nobody reads them any more (`| head`), the program ends quietly; where they cannot be
/// written (a full disk), it ends with an error.
pub fn print(text: Arguments<'_>, end: &str) {
    let mut out = std::io::stdout().lock();
    let Err(error) = out.write_fmt(text).and_then(|()| out.write_all(end.as_bytes())) else { return };
    if error.kind() == ErrorKind::BrokenPipe {
        std::process::exit(0);
    }
    let error = lucarne::Error::io("standard output", &error);
    eprintln!("lucarne: error: {error}");
    std::process::exit(super::progress::IO_FAILED.into());
}

/// Tells something about the work. Nobody need listen.
pub fn tell(text: Arguments<'_>, end: &str) {
    let mut out = std::io::stderr().lock();
    let _ = out.write_fmt(text).and_then(|()| out.write_all(end.as_bytes()));
}
