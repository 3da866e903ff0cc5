//! Structs that Rust and WGSL share: what Rust takes them to be, so that a test can hold it against naga's layout.

/// A struct as Rust lays it out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedStruct {
    /// In WGSL.
    pub name: &'static str,
    /// A shader that has it.
    pub shader: &'static str,
    /// Bytes.
    pub size: usize,
    /// In order; the names are those of WGSL as well.
    pub fields: Vec<(&'static str, usize)>,
}

/// Describes a struct: `describe!(ViewUniform as "View" in "surface/land/resolve": every, field, in, order)`. It does not
/// compile when a field is missing.
macro_rules! describe {
    ($rust:ident as $name:literal in $shader:literal: $($field:ident),+ $(,)?) => {
        impl $rust {
            /// For the test of shared structs.
            pub(crate) fn shared() -> crate::gpu::shared::SharedStruct {
                let Self { $($field: _),+ } = bytemuck::Zeroable::zeroed();
                crate::gpu::shared::SharedStruct {
                    name: $name,
                    shader: $shader,
                    size: size_of::<Self>(),
                    fields: vec![$((stringify!($field), std::mem::offset_of!(Self, $field))),+],
                }
            }
        }
    };
}
pub(crate) use describe;
