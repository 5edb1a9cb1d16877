//! The `lucarne` program: arguments in, exit code out.

// In place of the standard ones, which panic where nobody reads: a closed pipe, a full disk.
macro_rules! print {
    ($($text:tt)*) => { crate::cli::output::print(format_args!($($text)*), "") };
}
macro_rules! println {
    ($($text:tt)*) => { crate::cli::output::print(format_args!($($text)*), "\n") };
}
macro_rules! eprint {
    ($($text:tt)*) => { crate::cli::output::tell(format_args!($($text)*), "") };
}
macro_rules! eprintln {
    ($($text:tt)*) => { crate::cli::output::tell(format_args!($($text)*), "\n") };
}

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    silence_device_selection();
    cli::main()
}

/// Without a desktop session, Mesa's device-selection layer complains on standard error about a
/// missing XDG_RUNTIME_DIR each time Vulkan starts. Lucarne chooses its device itself.
#[allow(unsafe_code, reason = "nothing else runs yet, so nobody reads the environment meanwhile")]
fn silence_device_selection() {
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() && std::env::var_os("NODEVICE_SELECT").is_none() {
        // SAFETY: the first statement of the program, before any thread exists.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
