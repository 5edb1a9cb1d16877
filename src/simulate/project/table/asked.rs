//! Which keys a reader asks for, for the test that each has its text.

use std::cell::RefCell;
use std::collections::BTreeSet;

thread_local! {
    static ASKED: RefCell<BTreeSet<(String, String)>> = const { RefCell::new(BTreeSet::new()) };
}

/// A key of a table, whose name and those of the tables that it is in may end with their numbers.
pub(super) fn note(table: &str, key: &str) {
    let section: Vec<&str> = table.split('.').map(|part| part.split(' ').next().unwrap_or_default()).collect();
    ASKED.with_borrow_mut(|asked| asked.insert((section.join("."), key.to_string())));
}

/// Sections and keys that `read` asks for.
pub(in super::super) fn asked_keys(read: impl FnOnce()) -> BTreeSet<(String, String)> {
    ASKED.take();
    read();
    ASKED.take()
}
