// Paths finished, to be compared with paths started: some drivers end long loops silently.

import package::generated::{Counters};

// Whether a traversal of this invocation ended without emptying its stack: a driver that cuts
// loops short, or a stack that overflowed. Such a path is not counted as finished.
var<private> traversal_failed: bool = false;

@group(0) @binding(15) var<storage, read_write> counters: Counters;

fn count_finished(path_ended: bool) {
    if path_ended && !traversal_failed {
        atomicAdd(&counters.finished, 1u);
    } else {
        atomicAdd(&counters.failed, 1u);
    }
}
