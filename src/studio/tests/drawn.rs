//! Tests that edits are drawn: nothing fails or grows, and in the end the picture is that of the saved file.

#![allow(clippy::print_stdout, reason = "a test says what it measured")]

use crate::composite::PICTURE;
use crate::frame::Renderer;
use crate::gpu::readback::read_as;
use crate::scene::view::Rig;
use crate::studio::neighbours::Switches;
use crate::style::Style;
use crate::style::parameters::ValueKind;
use crate::tests::common::draw::{draw, north_west, still};
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, full};

use super::{Random, Row, StyleDocument, open};

const SIZE_PX: [u32; 2] = [96, 54];
/// Frames after which nothing fades any more.
const REST: usize = 12;

fn frame(world: &mut World, renderer: &mut Renderer, style: &Style) {
    let view = still(world.pose("900,-900,+20,315,3,60"), SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, renderer, &view, style, &north_west());
}

/// Compiles the pipelines of the styles that one edit would switch to, as a window does at rest.
fn request_neighbours(world: &World, renderer: &mut Renderer, document: &StyleDocument) {
    let rig = Rig::mono(still(world.pose("900,-900,+20,315,3,60"), SIZE_PX));
    for (key, value) in document.switchable() {
        if let Some(style) = document.neighbour(&key, value) {
            renderer.request_spares(&world.gpu, &world.surfaces, &rig, &style, &north_west()).unwrap();
        }
    }
    while renderer.has_spares(&world.gpu) {
        renderer.take_built(&world.gpu);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

fn picture(world: &mut World, renderer: &mut Renderer, style: &Style) -> Vec<[u16; 4]> {
    renderer.forget();
    (0..REST).for_each(|_| frame(world, renderer, style));
    read_as(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap()
}

#[test]
fn random_edits_are_drawn_and_the_last_picture_is_that_of_the_saved_file() {
    let Some(mut world) = World::on_own_device(Hill::square(321, 10.0).1, 1.0) else { return };
    // The neighbours and their pipelines take most of the time, so the fast tier edits only one style.
    let (styles, count) = if full() { (2, 500) } else { (1, 12) };
    let folder = tempfile::tempdir().unwrap();
    for (name, seed) in [("lsa", 3), ("crosshatch", 8)].into_iter().take(styles) {
        let mut random = Random(seed);
        let mut document = open(name);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let first = picture(&mut world, &mut renderer, document.style());
        let start_bytes = world.gpu.memory_bytes();
        let (mut numbers, mut with_pipelines, mut largest_bytes) = (0, Vec::new(), start_bytes);
        let mut requested = None;
        for _ in 0..count {
            let switches = Switches::of(&document);
            if requested.as_ref() != Some(&switches) {
                request_neighbours(&world, &mut renderer, &document);
                requested = Some(switches);
            }
            let rows: Vec<Row> = document.sections().iter().flat_map(|section| section.rows.clone()).collect();
            let row = &rows[random.below(rows.len())];
            let value = random.value(row);
            let is_number = matches!(row.definition.kind, ValueKind::Number | ValueKind::Color);
            let is_taken = document.set(&row.key, value).is_ok();
            document.release();
            if is_taken && random.below(4) == 0 {
                document.undo();
            }
            let built = renderer.built_at_once();
            frame(&mut world, &mut renderer, document.style());
            numbers += u64::from(is_taken && is_number);
            if is_number && renderer.built_at_once() > built {
                with_pipelines.push(format!(
                    "{} = {:?}",
                    row.key,
                    document.row(&row.key).and_then(|row| row.value.clone())
                ));
            }
            largest_bytes = largest_bytes.max(world.gpu.memory_bytes());
        }
        let saved = document.save_as(folder.path().join(name).to_str().unwrap(), None).unwrap();
        let edited = picture(&mut world, &mut renderer, document.style());
        let read = Style::read(saved.path().unwrap()).unwrap();
        let mut fresh = Renderer::new(&world.gpu).unwrap();
        assert!(edited == picture(&mut world, &mut fresh, &read), "{name}: the saved file draws something else");
        // Planted: another style draws something else.
        assert!(edited != first, "{name}: no edit had an effect");
        drop(fresh);
        document.revert().unwrap();
        assert!(first == picture(&mut world, &mut renderer, document.style()), "{name}: an edit left a trace");
        let end_bytes = world.gpu.memory_bytes();
        println!(
            "{name}: {count} edits, {numbers} numbers and colours, {} of them with pipelines ({}); GPU \
             memory {start_bytes} bytes at the start, {largest_bytes} at most, {end_bytes} at the end",
            with_pipelines.len(),
            with_pipelines.join(", ")
        );
        // Planted: without the neighbours' pipelines, 9 of these values build one in the full run.
        assert!(with_pipelines.is_empty(), "{name}: {with_pipelines:?}");
        assert!(end_bytes <= start_bytes + start_bytes / 10, "{name}: memory grew from {start_bytes} to {end_bytes}");
    }
}
