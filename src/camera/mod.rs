//! Radiance views: from pixels to rays and back.
