//! Every shader composes and validates without a GPU.

#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use hachure::gpu::shader::{SHADERS, ShaderError, VARIANTS, compose, compose_variant};
use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_shader_validates() {
    for (name, _) in SHADERS {
        validate(name, compose(name));
    }
    for (name, definitions) in VARIANTS {
        validate(name, compose_variant(name, definitions));
        // The definitions change something.
        let size = |module: Result<naga::Module, ShaderError>| {
            module.unwrap().functions.iter().map(|(_, function)| function.expressions.len()).sum::<usize>()
        };
        assert_ne!(size(compose(name)), size(compose_variant(name, definitions)), "{name}");
    }
}

fn validate(name: &str, module: Result<naga::Module, ShaderError>) {
    let module = module.unwrap_or_else(|error| panic!("{error}"));
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
    validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {error:?}"));
}

#[test]
fn a_wrong_shader_does_not() {
    assert!(compose("lines/none").is_err());
}
