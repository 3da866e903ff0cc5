//! What hachure writes: pictures, channels, films. Every output is written beside its name and then renamed, so
//! that a stopped run leaves the old file or none.

pub mod atomic;
