//! Every shader composes and validates without a GPU.

use hachure::gpu::shader::{SHADERS, compose};
use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn every_shader_validates() {
    for (name, _) in SHADERS {
        let module = compose(name).unwrap_or_else(|error| panic!("{error}"));
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::default());
        validator.validate(&module).unwrap_or_else(|error| panic!("{name}: {error:?}"));
    }
}

#[test]
fn a_wrong_shader_does_not() {
    assert!(compose("lines/none").is_err());
}
