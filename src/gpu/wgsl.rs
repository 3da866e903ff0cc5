//! The structs and constants of the shaders, as `build.rs` takes them from `shaders/`: each has one definition, and
//! that is the one in WGSL.
//!
//! Why: `docs/decisions/shaders-and-passes.md`.

#![allow(missing_docs, reason = "what needs words has them in the shader")]
#![allow(clippy::module_inception, reason = "a folder of shaders may have a shader of its name")]
#![allow(clippy::approx_constant, reason = "the shader has no name for it")]

/// A struct as Rust lays it out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedStruct {
    /// In WGSL.
    pub name: &'static str,
    /// Bytes.
    pub size: usize,
    /// In order, with their offsets; the names are those of WGSL as well.
    pub fields: Vec<(&'static str, usize)>,
}

fn describe<T>(name: &'static str, fields: &[(&'static str, usize)]) -> SharedStruct {
    SharedStruct { name, size: size_of::<T>(), fields: fields.to_vec() }
}

include!(concat!(env!("OUT_DIR"), "/wgsl.rs"));
