//! Tests that pipelines and cached values belong to the device, which makes each of them once, whichever renderer
//! draws, and that an edit of a style makes and restarts only what depends on it.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

use std::collections::BTreeSet;

use crate::tests::common;

use common::World;
use common::draw::{draw, north_west, still};
use common::hill::Hill;
use hachure::composite::PICTURE;
use hachure::frame::{Antialias, Renderer};
use hachure::gpu::readback::read_as;
use hachure::gpu::stored_pipelines::StoredPipelines;
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [96, 54];
/// Large enough for several strokes.
const WIDE_PX: [u32; 2] = [320, 180];

/// Draws a frame of each style with a renderer of its own. Returns how many pipelines the renderers had to compile.
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
    let Some(mut world) = World::on_own_device(Hill::square(321, 10.0).1, 1.0) else { return };
    let names = ["lsa", "crosshatch", "wash"];
    let first = compiled(&mut world, &names);
    assert_eq!(first, world.gpu.pipelines().builds());
    // Other renderers of the same device compile nothing.
    assert_eq!(compiled(&mut world, &names), 0);
    assert_eq!(first, world.gpu.pipelines().builds());
    // Control: another device shares nothing with this one and compiles everything again. With many tests at a time, the
    // two numbers have differed by one.
    let Some(mut other) = World::on_own_device(Hill::square(321, 10.0).1, 1.0) else { return };
    assert!(compiled(&mut other, &names).abs_diff(first) <= 1);
    assert!(first > 30, "{first} pipelines");
}

/// The cost of an edited style in a running renderer.
#[derive(Debug)]
struct Cost {
    /// Pipelines that were compiled.
    pipelines: u64,
    /// GPU objects that were created: buffers, textures, bind groups and pipelines.
    objects: u64,
    /// Share of the strokes of the previous frame that are still there, by their numbers.
    kept: f64,
    /// Whether strokes continued those of the previous frame.
    strokes_continued: bool,
    /// Whether the temporal mean continued.
    mean_continued: bool,
}

/// A running renderer whose style is edited.
struct Edited<'a> {
    world: &'a mut World,
    renderer: Renderer,
}

impl Edited<'_> {
    fn draw(&mut self, style: &Style) {
        let view = still(self.world.pose("0,-3000,+300,10,-8,60"), WIDE_PX);
        draw(&self.world.gpu, &mut self.world.surfaces, &mut self.renderer, &view, style, &north_west());
    }

    /// Returns the numbers of the strokes of the last frame.
    fn numbers(&self) -> BTreeSet<u32> {
        let (_, samples) = self.renderer.strokes().unwrap().samples().read(&self.world.gpu).unwrap();
        samples.iter().map(|sample| sample.stroke).filter(|stroke| *stroke > 0).collect()
    }

    /// Draws a style until it has settled, then the edited one for a frame, and returns what the edit cost.
    fn cost(&mut self, style: &Style, edited: &Style) -> Cost {
        for _ in 0..if common::full() { 12 } else { 6 } {
            self.draw(style);
        }
        let (built, made, before) = (self.renderer.built_at_once(), self.world.gpu.objects_made(), self.numbers());
        assert!(before.len() > 5, "{} strokes", before.len());
        self.draw(edited);
        let (pipelines, objects) = (self.renderer.built_at_once() - built, self.world.gpu.objects_made() - made);
        let after = self.numbers();
        let kept = before.intersection(&after).count() as f64 / before.len() as f64;
        let strokes_continued = self.renderer.strokes().unwrap().continued();
        Cost { pipelines, objects, kept, strokes_continued, mean_continued: self.renderer.continues() }
    }
}

#[test]
fn an_edit_of_a_value_restarts_nothing() {
    // Hills behind hills, whose contours are several strokes.
    let hills = common::grid_of(257, 257, 30.0, |x_m, y_m| 220.0 * (x_m / 310.0).sin() + 240.0 * (y_m / 270.0).cos());
    let Some(mut world) = World::on_own_device(hills, 1.0) else { return };
    let mut style = Style::load("charcoal").unwrap();
    let strokes = style.strokes_mut().unwrap();
    (strokes.shortest_px, strokes.width_px, strokes.taper_px, strokes.crowd) = (4.0, 2.0, 4.0, 1.0);
    style.set_lines(Style::load("lsa").unwrap().lines().cloned());
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_antialias(Antialias::Temporal);
    let mut running = Edited { world: &mut world, renderer };
    let changed = |change: &dyn Fn(&mut Style)| {
        let mut edited = style.clone();
        change(&mut edited);
        edited
    };
    let edits = [
        ("colour", changed(&|style| style.strokes_mut().unwrap().ink = "#802010".parse().unwrap())),
        ("width", changed(&|style| style.strokes_mut().unwrap().width_px *= 1.2)),
        ("threshold", changed(&|style| style.lines_mut().unwrap().ramp = [0.3, 0.6])),
        ("threshold of strokes", changed(&|style| style.strokes_mut().unwrap().shortest_px += 1.0)),
    ];
    for (name, edited) in edits {
        let cost = running.cost(&style, &edited);
        println!("{name}: {cost:?}");
        let continued = cost.strokes_continued && cost.mean_continued && cost.kept > 0.9;
        assert!(cost.pipelines == 0 && cost.objects == 0 && continued, "{name}: {cost:?}");
    }
    let pencil = Style::load("pencil-lines").unwrap().strokes().unwrap().clone();
    let texture = changed(&|style| {
        let strokes = style.strokes_mut().unwrap();
        (strokes.texture, strokes.texture_name) = (pencil.texture.clone(), pencil.texture_name.clone());
    });
    let cost = running.cost(&style, &texture);
    println!("texture: {cost:?}");
    // The texture itself and the bind group that has it; strokes begin again, because their marks differ.
    assert!(cost.pipelines == 0 && (1..=4).contains(&cost.objects), "{cost:?}");
    assert!(!cost.strokes_continued && cost.mean_continued, "{cost:?}");
    // Controls: a style with another name counts as another style, even with the same values, and restarts everything;
    // one with other passes also compiles some.
    let renamed = changed(&|style| style.name = "other".to_owned());
    let cost = running.cost(&style, &renamed);
    assert!(!cost.strokes_continued && !cost.mean_continued, "{cost:?}");
    let cost = running.cost(&style, &Style::load("wash").unwrap());
    assert!(cost.pipelines > 0 && cost.objects > 0, "{cost:?}");
}

#[test]
fn an_edited_color_leaves_no_trace_in_the_temporal_mean() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let on_paper = |color: &str| {
        let mut style = Style::load("lsa").unwrap();
        (style.paper.color, style.paper.grain) = (color.parse().unwrap(), 0.0);
        style
    };
    let [white, black] = ["#ffffff", "#101010"].map(on_paper);
    let renderer = || {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_antialias(Antialias::Temporal);
        renderer
    };
    let [edited, fresh, planted] = [renderer(), renderer(), renderer()];
    let mut picture = |mut renderer: Renderer, styles: &[&Style]| {
        let view = still(world.pose("900,-900,+20,315,3,60"), SIZE_PX);
        for style in styles {
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &north_west());
        }
        let texels = read_as::<[u16; 4]>(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap();
        texels.iter().flat_map(|texel| texel[..3].to_vec()).map(|bits| half::f16::from_bits(bits).to_f32()).collect()
    };
    let twelve = |style| vec![style; 12];
    let mean = |one: &[f32], other: &[f32]| {
        one.iter().zip(other).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / one.len() as f64
    };
    let edited: Vec<f32> = picture(edited, &[twelve(&white), vec![&black]].concat());
    let fresh: Vec<f32> = picture(fresh, &twelve(&black));
    // Planted error: the colour before the edit.
    let planted: Vec<f32> = picture(planted, &twelve(&white));
    let [found, planted] = [&edited, &planted].map(|picture| mean(picture, &fresh));
    println!("the first frame after an edit differs by {found:.4}, the frame before it by {planted:.4}");
    assert!(found < 0.02 && planted > 0.2);
}

#[test]
fn pipelines_are_stored_and_damaged_files_are_ignored() {
    let Some(gpu) = common::own_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let open = || StoredPipelines::open(&gpu.device, &gpu.adapter.get_info(), folder.path());
    let Some(first) = open() else {
        return println!("skipped: this driver cannot store pipelines");
    };
    assert!(!first.has_data());
    let path = first.path.clone();
    assert!(first.store() && !first.store(), "an unchanged cache is not written again");
    drop(first);
    assert!(open().unwrap().has_data());
    // Planted errors: a byte that has changed, and half of a file.
    let whole = std::fs::read(&path).unwrap();
    let mut changed = whole.clone();
    *changed.last_mut().unwrap() ^= 1;
    for damaged in [changed.as_slice(), &whole[..whole.len() / 2], b"hachurepipe1", b""] {
        std::fs::write(&path, damaged).unwrap();
        let opened = open().unwrap();
        assert!(!opened.has_data());
        assert!(opened.store());
    }
    assert!(open().unwrap().has_data());
}
