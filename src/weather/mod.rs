//! Weather files and the position of the sun.
