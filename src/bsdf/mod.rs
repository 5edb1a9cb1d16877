//! Bidirectional scattering distribution functions of windows: reading, checking, making, converting.
