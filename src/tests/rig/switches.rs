//! Tests drawing styles in turn: each draws as if it were alone, and memory does not grow.

use hachure::frame::Renderer;
use hachure::scene::view::Rig;
use hachure::style::Style;

use crate::tests::common::{full, preset};
use crate::tests::rig::{START, differing, draw_rig, few_presets, hill, seen, view};

/// `HACHURE_SWITCHES=200` tests all pairs of styles.
#[test]
fn styles_in_turns_draw_as_if_alone() {
    let Some(mut world) = hill() else { return };
    let usual = if full() { 34 } else { 8 };
    let turns: usize = std::env::var("HACHURE_SWITCHES").map_or(usual, |turns| turns.parse().unwrap());
    let pose = world.pose(START);
    let rig = Rig::mono(view(pose, pose));
    let styles: Vec<Style> = few_presets().into_iter().map(preset).collect();
    let alone: Vec<_> = styles
        .iter()
        .map(|style| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            draw_rig(&mut world, &mut renderer, style, &rig);
            seen(&world, &renderer, 0)
        })
        .collect();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let mut memory_bytes = Vec::new();
    for turn in 0..turns {
        // Each style eventually follows every other one.
        let next = (turn * (1 + turn / styles.len())) % styles.len();
        draw_rig(&mut world, &mut renderer, &styles[next], &rig);
        let name = &styles[next].name;
        assert_eq!(
            differing(&alone[next], &seen(&world, &renderer, 0)),
            0,
            "turn {turn}: {name} differs from its picture alone"
        );
        world.gpu.wait();
        memory_bytes.push(world.gpu.memory_bytes());
    }
    // After all styles have been drawn, only lists of other lengths may take more memory.
    let (first, last) = (memory_bytes[styles.len()], memory_bytes[turns - 1]);
    println!("{} KiB after a round, {} KiB after {turns} turns", first >> 10, last >> 10);
    assert!(last < first + (1 << 14), "memory grew from {first} to {last} bytes");
    // Control: styles differ.
    assert!(differing(&alone[0], &alone[1]) > 1000);
}
