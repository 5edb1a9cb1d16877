//! Cutting work into tiles that fit the device and the memory the user allows.

use super::Device;
use crate::error::{Error, Result};
use std::sync::OnceLock;

/// Memory that a computation may use unless its caller says otherwise, bytes.
pub(crate) const DEFAULT_MEMORY: u64 = 1 << 30;

/// What all computations of the process may use at most, bytes.
static ALLOWED: OnceLock<u64> = OnceLock::new();

/// Sets how much memory the matrices and tables of a computation may take together, bytes: work is cut into
/// smaller tiles, which changes no result. Only the first call counts, before anything is computed. Left out, it is
/// half of what the machine, or the process' control group, has to give.
pub fn allow_memory(bytes: u64) {
    let _ = ALLOWED.set(bytes);
}

/// As much of this memory as the process may use.
pub(crate) fn allowed(memory: u64) -> u64 {
    memory.min(*ALLOWED.get_or_init(|| available().map_or(u64::MAX, |bytes| (bytes / 2).max(LEAST))))
}

/// Less is not worth trying, bytes.
const LEAST: u64 = 1 << 27;

/// Memory that is free now, by the system and the limits of the process' control group; nothing if neither tells.
pub fn available() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let number = |text: String| text.trim().parse::<u64>().ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?.trim().strip_suffix("kB")?.trim().to_string();
        number(line).map(|kib| kib << 10)
    });
    let group = read("/sys/fs/cgroup/memory.max").and_then(number);
    let used = read("/sys/fs/cgroup/memory.current").and_then(number).unwrap_or(0);
    let group = group.map(|most| most.saturating_sub(used));
    [machine, group].into_iter().flatten().min()
}

/// Rows of work cut into equal chunks (the last may be shorter).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    rows: usize,
    rows_per_chunk: usize,
}

/// A run of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chunk {
    /// First row.
    pub first: usize,
    /// Number of rows.
    pub count: usize,
}

impl Plan {
    /// The largest chunks of `rows` such that every binding fits the device and everything together
    /// fits `memory` bytes. `bytes_per_row` has one entry per buffer that grows with the rows;
    /// `fixed_bytes` one per buffer that does not. Chunks are multiples of `alignment` rows where
    /// more than one chunk is needed.
    ///
    /// # Errors
    /// If not even `alignment` rows fit.
    pub fn new(device: &Device, memory: u64, rows: usize, bytes_per_row: &[u64], fixed_bytes: &[u64], alignment: usize) -> Result<Self> {
        let limit = device.limits().max_storage_buffer_binding_size.min(device.limits().max_buffer_size);
        Self::within(limit, allowed(memory), rows, bytes_per_row, fixed_bytes, alignment)
    }

    /// As [`new`](Self::new) with an explicit limit per binding, bytes.
    ///
    /// # Errors
    /// If not even `alignment` rows fit.
    pub fn within(
        binding_limit: u64,
        memory: u64,
        rows: usize,
        bytes_per_row: &[u64],
        fixed_bytes: &[u64],
        alignment: usize,
    ) -> Result<Self> {
        let alignment = alignment.max(1);
        if let Some(fixed) = fixed_bytes.iter().find(|b| **b > binding_limit) {
            return Err(Error::device(format!("{fixed} bytes do not fit the {binding_limit} bytes that the device binds at once")));
        }
        let largest_row = bytes_per_row.iter().copied().max().unwrap_or(0).max(1);
        let all_rows: u64 = bytes_per_row.iter().sum::<u64>().max(1);
        let fixed: u64 = fixed_bytes.iter().sum();
        let by_binding = binding_limit / largest_row;
        let by_memory = memory.saturating_sub(fixed) / all_rows;
        let fit = usize::try_from(by_binding.min(by_memory)).unwrap_or(usize::MAX);
        if fit >= rows {
            return Ok(Self { rows, rows_per_chunk: rows.max(1) });
        }
        let rows_per_chunk = fit / alignment * alignment;
        if rows_per_chunk == 0 {
            let needed = fixed + all_rows * alignment as u64;
            return Err(Error::new(format!("the smallest tile needs {needed} bytes; {memory} are allowed, {binding_limit} per binding"))
                .field("memory")
                .help(format!("allow at least {} (--memory, of the verbs that have it)", human(needed))));
        }
        Ok(Self { rows, rows_per_chunk })
    }

    /// Rows of a full chunk.
    pub(crate) fn rows_per_chunk(&self) -> usize {
        self.rows_per_chunk
    }

    /// The same plan with smaller chunks, for tests of tiling and for finer progress.
    #[must_use]
    pub(crate) fn at_most(self, rows_per_chunk: usize) -> Self {
        Self { rows_per_chunk: self.rows_per_chunk.min(rows_per_chunk.max(1)), ..self }
    }

    /// The chunks in order. None for no rows.
    pub fn chunks(self) -> impl Iterator<Item = Chunk> {
        (0..self.rows).step_by(self.rows_per_chunk).map(move |first| Chunk { first, count: self.rows_per_chunk.min(self.rows - first) })
    }
}

/// A number of bytes in the unit a `--memory` option takes.
fn human(bytes: u64) -> String {
    format!("{}M", bytes.div_ceil(1 << 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunks(plan: Plan) -> Vec<(usize, usize)> {
        plan.chunks().map(|c| (c.first, c.count)).collect()
    }

    #[test]
    fn chunks_cover_all_rows_once_and_respect_both_limits() {
        for rows in [0usize, 1, 7, 64, 1000] {
            for memory in [600u64, 1000, 5000, 1 << 40] {
                for binding in [64u64, 100, 1 << 40] {
                    let Ok(plan) = Plan::within(binding, memory, rows, &[8, 2], &[64], 4) else { continue };
                    let mut next = 0;
                    for c in plan.chunks() {
                        assert_eq!(c.first, next);
                        assert!(c.count > 0 && c.count as u64 * 8 <= binding && 64 + c.count as u64 * 10 <= memory);
                        next += c.count;
                    }
                    assert_eq!(next, rows);
                }
            }
        }
        assert_eq!(chunks(Plan::within(100, 1 << 40, 20, &[8], &[], 4).unwrap()), [(0, 12), (12, 8)]);
        assert_eq!(chunks(Plan::within(1000, 1 << 40, 10, &[8], &[], 4).unwrap().at_most(6)), [(0, 6), (6, 4)]);
    }

    #[test]
    fn what_cannot_fit_is_an_error_that_says_how_much_is_needed() {
        let error = Plan::within(1 << 30, 10, 100, &[1 << 20], &[0], 4).unwrap_err().to_string();
        assert!(error.contains("--memory") && error.contains("4M"), "{error}");
        assert!(Plan::within(10, 1 << 30, 1, &[1], &[11], 1).is_err());
    }
}
