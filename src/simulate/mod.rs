//! From a project file to results on disk.
