//! Every struct that Rust and WGSL share has the same fields at the same offsets, and the same size.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use hachure::frame::shared_structs;
use hachure::gpu::shader::{SHADERS, compose};
use hachure::gpu::shared::SharedStruct;
use naga::proc::Layouter;

/// A struct as naga lays it out: (bytes, fields).
fn in_wgsl(shader: &str, name: &str) -> Option<(usize, Vec<(String, usize)>)> {
    let module = compose(shader).unwrap();
    let mut layouter = Layouter::default();
    layouter.update(module.to_ctx()).unwrap();
    module.types.iter().find_map(|(handle, ty)| {
        let naga::TypeInner::Struct { members, span } = &ty.inner else { return None };
        // The names of imported structs carry their module.
        let bare = ty.name.as_deref()?.split("X_naga_oil_mod_").next()?;
        if bare != name {
            return None;
        }
        assert_eq!(layouter[handle].size, *span, "{name}");
        let fields = members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset as usize));
        Some((*span as usize, fields.collect()))
    })
}

fn same(rust: &SharedStruct) -> Result<(), String> {
    let (size, fields) =
        in_wgsl(rust.shader, rust.name).ok_or_else(|| format!("{}.wgsl has no struct {}", rust.shader, rust.name))?;
    let ours: Vec<_> = rust.fields.iter().map(|(name, offset)| ((*name).to_owned(), *offset)).collect();
    if fields != ours {
        return Err(format!("{}: WGSL {fields:?}, Rust {ours:?}", rust.name));
    }
    // An element of an array has the size of the struct in both; a lone uniform may not be larger in WGSL.
    if size != rust.size {
        return Err(format!("{}: WGSL {size} bytes, Rust {} bytes", rust.name, rust.size));
    }
    println!("{} in {}.wgsl: {} fields, {size} bytes", rust.name, rust.shader, fields.len());
    Ok(())
}

#[test]
fn rust_and_wgsl_agree() {
    for rust in shared_structs() {
        same(&rust).unwrap();
    }
}

#[test]
fn differences_are_found() {
    for rust in shared_structs() {
        let mut moved = rust.clone();
        moved.fields.last_mut().unwrap().1 += 4;
        assert!(same(&moved).is_err(), "a moved field");
        let mut swapped = rust.clone();
        let (first, last) = (0, swapped.fields.len() - 1);
        let name = swapped.fields[first].0;
        swapped.fields[first].0 = swapped.fields[last].0;
        swapped.fields[last].0 = name;
        assert!(same(&swapped).is_err(), "two fields with each other's name");
        assert!(same(&SharedStruct { size: rust.size + 16, ..rust.clone() }).is_err(), "another size");
        assert!(same(&SharedStruct { name: "Nothing", ..rust }).is_err(), "another name");
    }
}

/// Every struct in a buffer of a shader is in the list.
#[test]
fn none_is_forgotten() {
    let known: Vec<_> = shared_structs().iter().map(|rust| rust.name).collect();
    for (shader, _) in SHADERS {
        let module = compose(shader).unwrap();
        for (_, variable) in module.global_variables.iter().filter(|(_, variable)| variable.binding.is_some()) {
            let inner = match &module.types[variable.ty].inner {
                naga::TypeInner::Array { base, .. } => *base,
                _ => variable.ty,
            };
            if let naga::Type { name: Some(name), inner: naga::TypeInner::Struct { members, .. } } =
                &module.types[inner]
            {
                let bare = name.split("X_naga_oil_mod_").next().unwrap_or(name);
                if bare == "Order" {
                    // It ends with a list, so Rust has no struct for it: `Ordered` writes two numbers, and sums what
                    // begins at byte 256.
                    let offsets: Vec<u32> = members.iter().map(|member| member.offset).collect();
                    assert_eq!(offsets, [0, 4, 8, 256]);
                    continue;
                }
                assert!(known.contains(&bare), "{shader}.wgsl: {bare}");
            }
        }
    }
}
