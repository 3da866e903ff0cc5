//! Frames whose every pass is searched for numbers that are not finite, and the planted numbers that the search finds.

use std::io;
use std::path::Path;

use hachure::frame::{DISTANCE, Light, Renderer};
use hachure::gpu::finite::{NonFinite, Place};
use hachure::gpu::recorder::Submits;
use hachure::gpu::shader::SHADERS;
use hachure::gpu::texts::Texts;
use hachure::scene::view::{Pose, View};
use hachure::style::Style;

use crate::tests::common::draw::{draw, floats, north_west, still};
use crate::tests::common::{World, full, grid_of, rough_height_m};

pub(super) const SIZE_PX: [u32; 2] = [64, 48];

/// A world with a renderer whose frames are checked.
pub(super) struct Checked {
    pub world: World,
    pub renderer: Renderer,
    /// Number of frames that were drawn.
    pub frames: usize,
    /// A line for each case with numbers that are not finite.
    pub wrong: Vec<String>,
}

impl Checked {
    pub(super) fn new(world: World) -> Self {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_submits(Submits::Checked);
        renderer.set_wants_motion(true);
        renderer.set_wants_ids(true);
        renderer.set_wants_mark_sets(true);
        Self { world, renderer, frames: 0, wrong: Vec::new() }
    }

    /// Draws a frame, and returns what was found.
    pub(super) fn frame(&mut self, view: &View, style: &Style, light: &Light) -> Vec<NonFinite> {
        draw(&self.world.gpu, &mut self.world.surfaces, &mut self.renderer, view, style, light);
        self.frames += 1;
        self.renderer.take_non_finite()
    }

    /// Draws a view at rest without a history, and notes under the name of the case what was found.
    pub(super) fn case(&mut self, name: &str, pose: Pose, size_px: [u32; 2], style: &Style, light: &Light) {
        self.renderer.forget();
        let found = self.frame(&still(pose, size_px), style, light);
        self.note(name, &found);
    }

    /// Draws the frame after that of [`Checked::case`], with strokes that continue it.
    pub(super) fn then(&mut self, name: &str, poses: [Pose; 2], size_px: [u32; 2], style: &Style, light: &Light) {
        let [previous, pose] = poses;
        let found = self.frame(&View::whole(previous, pose, size_px), style, light);
        self.note(&format!("{name}, in motion"), &found);
    }

    /// Returns the part of the last picture that shows ground.
    pub(super) fn ground(&self) -> f64 {
        let along_m = floats::<1>(&self.world.gpu, self.renderer.target(&DISTANCE).unwrap());
        along_m.iter().filter(|along_m| along_m[0] > 0.0).count() as f64 / along_m.len() as f64
    }

    pub(super) fn note(&mut self, name: &str, found: &[NonFinite]) {
        if let Some(first) = found.first() {
            self.wrong.push(format!("{name}: {first}"));
        }
    }

    /// Fails if any case had numbers that are not finite.
    pub(super) fn finish(self, what: &str) {
        println!("{what}: {} frames, {} of them with numbers that are not finite", self.frames, self.wrong.len());
        assert!(self.wrong.is_empty(), "{what}:\n{}", self.wrong.join("\n"));
    }
}

/// Writes a shader with a statement before the only one that begins with `before`.
fn plant(folder: &Path, name: &str, before: &str, statement: &str) -> io::Result<()> {
    let (_, text) = SHADERS.iter().find(|(known, _)| *known == name).unwrap();
    assert_eq!(text.matches(before).count(), 1, "{name}: {before}");
    let path = folder.join(format!("{name}.wgsl"));
    std::fs::create_dir_all(path.parent().unwrap())?;
    std::fs::write(path, text.replace(before, &format!("{statement}\n{before}")))
}

/// Opens a small world on a device of its own, whose shaders are read from a folder first.
fn planted_world() -> Option<(Checked, Pose, tempfile::TempDir)> {
    let world = World::on_own_device(grid_of(65, 65, 30.0, rough_height_m), 1.0)?;
    let pose = world.pose("0,-900,+400,0,-20,60");
    let folder = tempfile::tempdir().unwrap();
    world.gpu.pipelines().set_texts(Texts::of(Some(folder.path().to_owned())));
    Some((Checked::new(world), pose, folder))
}

#[test]
fn a_nan_in_one_texel_is_found_with_its_pass_and_pixel() {
    let Some((mut checked, pose, folder)) = planted_world() else { return };
    let style = Style::load("plain").unwrap();
    assert_eq!(checked.frame(&still(pose, SIZE_PX), &style, &north_west()), []);
    let numbers = [("0x7fc00000u", "NaN", f32::NAN), ("0xff800000u", "-inf", f32::NEG_INFINITY)];
    for (bits, shown, value) in numbers.into_iter().take(if full() { 2 } else { 1 }) {
        // Compilers refuse a constant that is not finite.
        let statement = format!(
            "if all(id.xy == vec2<u32>(40u, 41u)) {{ let number = bitcast<f32>({bits} | (id.x & 16u)); \
             textureStore(tone, pixel, vec4<f32>(1.0, number, 1.0, 1.0)); return; }}"
        );
        plant(folder.path(), "tones/plain", "    textureStore(tone, pixel, vec4<f32>(color, ", &statement).unwrap();
        checked.renderer.reload_shaders(&checked.world.gpu);
        let found = checked.frame(&still(pose, SIZE_PX), &style, &north_west());
        let first = found.first().unwrap();
        let place = Place::Texel { size_px: SIZE_PX, layer: 0, pixel: [40, 41], channel: 1 };
        assert_eq!((first.pass, first.target, first.place, first.count), ("tones/plain", "tone", place, 1));
        assert!(first.value == value || first.value.is_nan() && value.is_nan());
        let message = format!(
            "the pass tones/plain wrote {shown} into the picture \"tone\" (64x48 px), pixel (40, 41), channel 1, the \
             only one that is not finite of those searched"
        );
        assert_eq!(first.to_string(), message);
        // Passes that read it come after it.
        assert!(found[1..].iter().all(|later| later.pass != "tones/plain"), "{found:?}");
        // Without the check nothing is read back.
        checked.renderer.set_submits(Submits::Whole);
        assert_eq!(checked.frame(&still(pose, SIZE_PX), &style, &north_west()), []);
        checked.renderer.set_submits(Submits::Checked);
    }
    finds_planted_buffer(&mut checked, pose, folder.path());
}

/// Checks that a planted NaN in a buffer is found: in the long tier in a buffer of strokes, otherwise in one of the
/// preset `plain`, whose pipelines are compiled already.
fn finds_planted_buffer(checked: &mut Checked, pose: Pose, folder: &Path) {
    // Only the first number of an element is not finite.
    let [name, shader, before, statement, buffer] = if full() {
        [
            "strokes",
            "lines/strokes/points",
            "    lengths[place + number] = ",
            "points[place + number] = Point(vec2<f32>(bitcast<f32>(0x7fc00000u | (id.x & 1u)), 1.0), at.z, number, \
             kind, 0u);",
            "stroke points",
        ]
    } else {
        [
            "plain",
            "surface/land/vertices",
            "    positions[id.y * VERTICES + id.x] = ",
            "if id.x + id.y == 0u { let number = bitcast<f32>(0x7fc00000u | id.x); \
             positions[0] = vec4<f32>(number, at_m.yz, 1.0); return; }",
            "vertices",
        ]
    };
    let style = Style::load(name).unwrap();
    if full() {
        checked.case(name, pose, SIZE_PX, &style, &north_west());
        assert_eq!(checked.wrong, [""; 0]);
    }
    plant(folder, shader, before, statement).unwrap();
    checked.renderer.reload_shaders(&checked.world.gpu);
    checked.case(name, pose, SIZE_PX, &style, &north_west());
    let found = checked.wrong.first().unwrap();
    let expected = format!("{name}: the pass {shader} wrote NaN into the buffer \"{buffer}\", word 0");
    assert!(found.starts_with(&expected), "{found}");
}
