//! Pipelines and cached values belong to the device: each is made once, whoever draws.

use crate::tests::common;

use common::World;
use common::draw::{draw, north_west, still};
use common::hill::Hill;
use hachure::frame::Renderer;
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [96, 54];

/// Draws a frame of each style with a renderer of its own; returns how many pipelines the renderers had to compile.
fn compiled(world: &mut World, names: &[&str]) -> u64 {
    let pose = world.pose("900,-900,+20,315,3,60");
    let compile = |name: &&str| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let style = Style::load(name).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &north_west());
        renderer.built_at_once()
    };
    names.iter().map(compile).sum()
}

#[test]
fn renderers_share_pipelines() {
    let Some(mut world) = World::apart(Hill::square(321, 10.0).1, 1.0) else { return };
    let names = ["ink", "crosshatch", "wash"];
    let first = compiled(&mut world, &names);
    assert_eq!(first, world.gpu.pipelines().builds());
    // Other renderers of the same device compile nothing.
    assert_eq!(compiled(&mut world, &names), 0);
    assert_eq!(first, world.gpu.pipelines().builds());
    // Planted error: a device that shares nothing compiles everything again.
    let Some(mut apart) = World::apart(Hill::square(321, 10.0).1, 1.0) else { return };
    assert_eq!(compiled(&mut apart, &names), first);
    assert!(first > 30, "{first} pipelines");
}
