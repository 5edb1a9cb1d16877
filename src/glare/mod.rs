//! Glare: sources in a picture, and the indices made of them.
