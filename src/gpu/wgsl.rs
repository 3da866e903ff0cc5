//! The structs and constants of the shaders, which `build.rs` generates from `shaders/`: each is defined once, in WGSL.
//!
//! Why: `docs/decisions/shaders-and-passes.md`.

#![allow(dead_code, reason = "some constants are used by shaders alone")]
#![allow(unreachable_pub, reason = "`hachure::internals` shows one of the structs")]
#![allow(missing_docs, reason = "fields and constants are documented in the shaders where they need it")]
#![allow(clippy::module_inception, reason = "a folder of shaders may contain a shader of the same name")]
#![allow(
    clippy::approx_constant,
    reason = "the constants are copied from shaders, which have no named constants for π"
)]

/// The layout of a shared struct in Rust, which a test compares with that of WGSL.
#[cfg(test)]
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SharedStruct {
    /// Name in WGSL and in Rust.
    pub name: &'static str,
    /// Size in bytes.
    pub size: usize,
    /// Name and offset in bytes of each field, in order.
    pub fields: Vec<(&'static str, usize)>,
}

#[cfg(test)]
fn describe<T>(name: &'static str, fields: &[(&'static str, usize)]) -> SharedStruct {
    SharedStruct { name, size: size_of::<T>(), fields: fields.to_vec() }
}

include!(concat!(env!("OUT_DIR"), "/wgsl.rs"));
