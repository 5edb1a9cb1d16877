//! Viewer for what Lucarne and Radiance write: BSDFs as hemispheres, pictures as falsecolours, a
//! year of results to scrub through, and sensors on their plan.
//!
//! Every panel has a *model* (what is shown for which state; tested without a window) and a *panel*
//! that paints it. [`offscreen`] runs the same program without a window system, for
//! `--screenshot` and for the tests.

mod app;
mod args;
mod bsdf;
mod grid;
mod help;
mod history;
mod job;
mod list;
mod menu;
mod offscreen;
mod open;
mod outbox;
mod picture;
mod plot;
mod remember;
mod results;
mod save;
mod scale;
#[cfg(test)]
#[path = "../../src/testing.rs"]
mod testing;
mod texture;
mod year;

#[cfg(test)]
mod tests;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    let args = args::Args::parse();
    let outcome = match &args.screenshot {
        Some(path) => offscreen::screenshot(&args, path).map_err(|e| e.to_string()),
        None => app::run_window(&args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("lucarne-viewer: error: {message}");
            ExitCode::FAILURE
        }
    }
}
