//! The guide: what a user needs to know of each method, one page each.

/// Windows, what they are in a scene, and what light does at them.
pub mod windows {
    #![doc = include_str!("windows.md")]
}

/// Models of design programs: Honeybee, OBJ; what a scene holds.
pub mod models {
    #![doc = include_str!("models.md")]
}

/// What is read, what is refused, and what is said.
pub mod files {
    #![doc = include_str!("files.md")]
}

/// All keys of a project file.
pub mod keys {
    #![doc = include_str!("keys.md")]
}

/// The five-phase method: accurate suns.
pub mod five_phases {
    #![doc = include_str!("five_phases.md")]
}

/// Façades that move: groups of windows, their states, and what decides them.
pub mod moving {
    #![doc = include_str!("moving.md")]
}

/// States that a run decides: rules, LM-83's blinds, the best of each step.
pub mod control {
    #![doc = include_str!("control.md")]
}

/// Pictures of every hour.
pub mod pictures {
    #![doc = include_str!("pictures.md")]
}

/// Annual glare.
pub mod glare {
    #![doc = include_str!("glare.md")]
}

/// Metrics with names: what each is, where it is defined, what noise makes of it.
pub mod metrics {
    #![doc = include_str!("metrics.md")]
}

/// BSDFs: look at them, mend them, make them.
pub mod bsdf {
    #![doc = include_str!("bsdf.md")]
}

/// From goniophotometer scans to scattering data.
pub mod measured {
    #![doc = include_str!("measured.md")]
}

/// How errors are computed, and accuracy against time.
pub mod accuracy {
    #![doc = include_str!("accuracy.md")]
}

/// A page of results to read, print and send.
pub mod report {
    #![doc = include_str!("report.md")]
}

/// The viewer.
pub mod viewer {
    #![doc = include_str!("viewer.md")]
}

/// Stopping, going on, and damaged files.
pub mod nothing_lost {
    #![doc = include_str!("nothing_lost.md")]
}
