//! Tests that the structs that `build.rs` generates from the shaders have the layout that naga computes: the same
//! fields at the same offsets, and the same size.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use hachure::gpu::shader::{SHADERS, VARIANTS, compose_variant};
use hachure::gpu::wgsl::{SharedStruct, structs};
use naga::proc::Layouter;

/// Returns every struct in a buffer of a shader, as naga lays it out. A runtime-sized list has no size: `Ordered`
/// writes the head of that one itself, and the sums that begin at byte 256.
fn in_wgsl(shader: &str, definitions: &[&str]) -> Vec<SharedStruct> {
    let module = compose_variant(shader, definitions).unwrap();
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    let is_endless = |ty: naga::Handle<naga::Type>| {
        matches!(module.types[ty].inner, naga::TypeInner::Array { size: naga::ArraySize::Dynamic, .. })
    };
    let variables = module.global_variables.iter().filter(|(_, variable)| variable.binding.is_some());
    let mut found = Vec::new();
    for (_, variable) in variables {
        let ty = match &module.types[variable.ty].inner {
            naga::TypeInner::Array { base, .. } => *base,
            _ => variable.ty,
        };
        let naga::Type { name: Some(name), inner: naga::TypeInner::Struct { members, span } } = &module.types[ty]
        else {
            continue;
        };
        // Names of imported structs contain their module.
        let bare = name.split("X_naga_oil_mod_").next().unwrap();
        let offsets: Vec<u32> = members.iter().map(|member| member.offset).collect();
        if bare == "Order" {
            assert_eq!(offsets, [0, 4, 256]);
            continue;
        }
        // A list after its rules, which are a separate struct.
        let (ty, name, members, span) = match members.as_slice() {
            [rules, list] if is_endless(list.ty) => {
                let naga::Type { name: Some(name), inner: naga::TypeInner::Struct { members, span } } =
                    &module.types[rules.ty]
                else {
                    panic!("{bare} has no rules before its list");
                };
                assert_eq!(list.offset, *span, "{bare}");
                (rules.ty, name, members, span)
            }
            _ => (ty, name, members, span),
        };
        let bare = name.split("X_naga_oil_mod_").next().unwrap();
        let offsets: Vec<u32> = members.iter().map(|member| member.offset).collect();
        assert_eq!(layouter[ty].size, *span, "{bare}");
        let names = members.iter().map(|member| &*member.name.clone().unwrap().leak());
        let fields = names.zip(offsets.iter().map(|offset| *offset as usize)).collect();
        found.push(SharedStruct { name: bare.to_owned().leak(), size: *span as usize, fields });
    }
    found
}

fn all_in_wgsl() -> Vec<SharedStruct> {
    let whole = SHADERS.iter().map(|(name, _)| (*name, [].as_slice()));
    whole.chain(VARIANTS.iter().copied()).flat_map(|(name, definitions)| in_wgsl(name, definitions)).collect()
}

/// Returns whether both structs are the same. Padding fields have no name in WGSL.
fn is_the_same(rust: &SharedStruct, wgsl: &SharedStruct) -> bool {
    rust.name == wgsl.name && rust.size == wgsl.size && rust.fields == wgsl.fields
}

#[test]
fn every_struct_of_a_buffer_lies_in_rust_as_in_wgsl() {
    let ours = structs();
    let theirs = all_in_wgsl();
    assert!(theirs.len() > 100, "{}", theirs.len());
    for wgsl in &theirs {
        let rust = ours.iter().find(|rust| is_the_same(rust, wgsl));
        assert!(rust.is_some(), "{wgsl:?} in WGSL, but in Rust {:?}", ours.iter().find(|rust| rust.name == wgsl.name));
    }
}

#[test]
fn differences_are_found() {
    let theirs = all_in_wgsl();
    for rust in structs() {
        let Some(wgsl) = theirs.iter().find(|wgsl| is_the_same(&rust, wgsl)) else { continue };
        let mut moved = rust.clone();
        moved.fields.last_mut().unwrap().1 += 4;
        assert!(!is_the_same(&moved, wgsl), "a moved field was not detected");
        let mut other = rust.clone();
        other.fields[0].0 = "nothing";
        assert!(!is_the_same(&other, wgsl), "a renamed field was not detected");
        assert!(
            !is_the_same(&SharedStruct { size: rust.size + 16, ..rust.clone() }, wgsl),
            "another size was not detected"
        );
        assert!(!is_the_same(&SharedStruct { name: "Nothing", ..rust }, wgsl), "another name was not detected");
    }
}
