//! Tests which strokes are drawn with a texture.

use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::gpu::shader::{SHADERS, compose};
use hachure::lines::strokes::stroke::INK;
use hachure::style::Style;
use hachure::style::texture::Recipe;

use crate::tests::common::World;
use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::hill::Hill;
use crate::tests::stroke_texture::recipe;

const SIZE_PX: [u32; 2] = [480, 270];

/// Returns the ink of strokes, as 16-bit floats.
fn ink(world: &mut World, renderer: &mut Option<Renderer>, style: &Style) -> Vec<u16> {
    let pose = world.pose("900,-900,+20,315,3,60");
    let view = still(pose, SIZE_PX);
    let gpu = &world.gpu;
    let renderer = Renderer::or_new(renderer, gpu).unwrap();
    draw(gpu, &mut world.surfaces, renderer, &view, style, &NOON);
    read_as(gpu, renderer.target(&INK).unwrap(), [0, 0], SIZE_PX).unwrap()
}

/// Returns the texture that a frame draws with.
fn drawn_with(renderer: &Option<Renderer>) -> Option<wgpu::Texture> {
    renderer.as_ref().unwrap().strokes().unwrap().texture().map(|texture| texture.texture().clone())
}

#[test]
fn solid_strokes_know_of_no_texture() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let mut renderer = None;
    let style = |texture: Option<Recipe>| {
        let mut style = crate::tests::common::all_lines("strokes");
        let strokes = style.strokes_mut().unwrap();
        (strokes.texture, strokes.faintest, strokes.taper_px) = (texture, 1.0, 0.0);
        // Each picture is drawn without the history of strokes.
        (strokes.carry, strokes.update_every) = (false, 1);
        style
    };
    let solid = ink(&mut world, &mut renderer, &style(None));
    assert!(drawn_with(&renderer).is_none() && solid.iter().filter(|ink| **ink > 0).count() > 500);
    let pencil = ink(&mut world, &mut renderer, &style(Some(recipe("pencil"))));
    let kept = drawn_with(&renderer);
    assert_ne!(pencil, solid);
    // The texture is retained as long as the style has it, and released after that.
    assert!(ink(&mut world, &mut renderer, &style(Some(recipe("pencil")))) == pencil);
    assert!(kept.is_some() && drawn_with(&renderer) == kept);
    let charcoal = ink(&mut world, &mut renderer, &style(Some(recipe("charcoal"))));
    assert!(drawn_with(&renderer) != kept && charcoal != pencil);
    assert!(ink(&mut world, &mut renderer, &style(None)) == solid, "solid strokes must not change");
    assert!(drawn_with(&renderer).is_none());
    // With a texture that takes all the ink, strokes equal solid ones, except at their last pixels.
    let mut full = recipe("pen");
    (full.pigment.density, full.pigment.variation) = (1.0, 0.0);
    (full.touch.softness, full.touch.response, full.touch.fill) = (0.01, 0.05, 1.0);
    (full.touch.border_px, full.touch.border_pressure) = (0.0, 1.0);
    let share = |drawn: &[u16]| {
        let differ = drawn.iter().zip(&solid).filter(|(a, b)| a != b).count();
        differ as f64 / solid.iter().filter(|ink| **ink > 0).count() as f64
    };
    let drawn = ink(&mut world, &mut renderer, &style(Some(full)));
    println!("{:.4} of the inked pixels differ; by a pencil {:.4}", share(&drawn), share(&pencil));
    assert!(share(&drawn) < 0.02 && share(&pencil) > 0.5);
}

#[test]
fn only_textured_strokes_read_the_texture() {
    assert!(SHADERS.iter().any(|(name, _)| *name == "lines/strokes/stroke"));
    let module = compose("lines/strokes/stroke").unwrap();
    let mut validator =
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::default());
    let info = validator.validate(&module).unwrap();
    let reads = |entry: &str| {
        let index = module.entry_points.iter().position(|point| point.name == entry).unwrap();
        let of_texture = |name: &str| name.starts_with("brush");
        let uses =
            module.global_variables.iter().filter(|(_, variable)| variable.name.as_deref().is_some_and(of_texture));
        uses.filter(|(handle, _)| !info.get_entry_point(index)[*handle].is_empty()).count()
    };
    assert_eq!((reads("fragment"), reads("textured")), (0, 3));
}
