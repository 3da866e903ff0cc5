//! A frame does only what its style requires: a style without a layer or a section has no pass, no byte and no memory of
//! it, whether it never had one or lost it while it was drawn.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::collections::BTreeMap;
use std::sync::Arc;

use common::World;
use common::draw::{draw, north_west};
use common::hill::Hill;
use glam::DVec3;
use hachure::frame::{self, Renderer};
use hachure::gpu::pools::KEEP_FRAMES;
use hachure::gpu::trace::PassTrace;
use hachure::measure::work::FrameWork;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::{self, Style};
use hachure::tiles::Terrain;
use hachure::tiles::terrain::KEEP_MAPS_FRAMES;

const SIZE_PX: [u32; 2] = [96, 54];
/// Least size of the maps of one kind of a tile, in bytes.
const MAP_BYTES: u64 = 60_000;
/// Number of frames after which resources that they did not use are released: fewer than [`KEEP_FRAMES`], because the
/// frames drawn afterwards use them again.
const IDLE_FRAMES: u64 = KEEP_FRAMES - 4;
/// Memory of a renderer that no pass binds, such as readbacks and alignment: at most this many bytes and this share.
const UNBOUND: (u64, f64) = (1 << 16, 0.05);

/// A layer or section of a style, by its key in a style file, with the passes that only it runs, by their names or
/// folders. A section without passes changes values of passes that other parts of the style run.
type Part = (&'static str, &'static [&'static str]);

const PARTS: [Part; 19] = [
    ("tone_lines", &["lines/tone/"]),
    ("height_lines", &["layers/height_lines"]),
    ("ground", &["layers/ground"]),
    (
        "hatching",
        &["surface/mark_normal", "surface/bend_axis", "tones/hatching", "tones/fractal_hatching", "tones/balance/"],
    ),
    ("cuts", &["layers/cuts"]),
    ("rows", &["surface/rows/"]),
    ("water", &["surface/lakes/", "surface/water", "surface/dry", "tones/water"]),
    ("rims", &["surface/rims"]),
    (
        "lines",
        &[
            "lines/lsa",
            "lines/sobel",
            "lines/roystan",
            "lines/threshold",
            "lines/smooth",
            "lines/curvature",
            "lines/crowd/rank",
            "lines/crowd/thin",
        ],
    ),
    ("strokes", &["surface/land/edges", "lines/strokes/", "lines/suggestive", "lines/ridges", "lines/apparent"]),
    ("relief", &["tones/relief/"]),
    ("watercolor", &["tones/watercolor"]),
    ("sky", &["composite/sky"]),
    ("light", &["surface/land/horizons", "surface/form", "surface/planes", "tones/crests"]),
    ("curvature", &[]),
    ("focus", &[]),
    ("haze", &[]),
    ("paper", &[]),
    ("panorama", &[]),
];

/// Passes that several parts run.
const SHARED: [&str; 6] =
    ["gpu/scan", "surface/curvature", "lines/radial", "lines/rims", "lines/crowd/bar", "lines/crowd/clear"];
/// Passes of every style.
const ALWAYS: [&str; 6] = [
    "surface/land/vertices",
    "surface/land/raster",
    "surface/land/resolve",
    "tones/toon",
    "tones/plain",
    "composite/composite",
];

/// The needs of a style's frames.
#[derive(Clone, Debug, PartialEq)]
struct Need {
    /// Number of runs of each pass.
    passes: BTreeMap<&'static str, usize>,
    /// Bytes that they read and write.
    bytes: u64,
    /// Memory that a frame binds and that of the maps of the land, in bytes.
    bound_bytes: u64,
    /// Memory that the device has allocated since there was a renderer, without the land, in bytes.
    allocated_bytes: u64,
}

/// A part that is removed from a style, and what frames need before and after.
#[derive(Clone, Copy)]
struct Removed<'a> {
    part: Part,
    whole: &'a Need,
    reduced: &'a Need,
}

fn is_of(pass: &str, names: &[&str]) -> bool {
    names.iter().any(|name| pass == *name || name.ends_with('/') && pass.starts_with(name))
}

impl Removed<'_> {
    /// Checks that the style does not need more without the part, and less if the part has passes of its own.
    fn check(&self) -> Result<(), String> {
        let Self { part: (key, owned), whole, reduced } = self;
        let run = |need: &Need| need.passes.keys().filter(|pass| is_of(pass, owned)).copied().collect::<Vec<_>>();
        let (before, after) = (run(whole), run(reduced));
        if !after.is_empty() {
            return Err(format!("without {key}, {after:?} still run"));
        }
        for (pass, runs) in &reduced.passes {
            let known = whole.passes.get(pass).copied().unwrap_or_default();
            if *runs > known {
                return Err(format!("without {key}, {pass} runs {runs} times instead of {known}"));
            }
        }
        for pass in whole.passes.keys().filter(|pass| !reduced.passes.contains_key(*pass)) {
            if !is_of(pass, owned) && !SHARED.contains(pass) {
                return Err(format!("{pass} is not listed as a pass of {key}"));
            }
        }
        let amounts = [
            ("bytes", whole.bytes, reduced.bytes),
            ("bytes of memory that frames bind", whole.bound_bytes, reduced.bound_bytes),
            ("allocated bytes", whole.allocated_bytes, reduced.allocated_bytes),
        ];
        for (what, before_it, after_it) in amounts {
            if after_it > before_it || !before.is_empty() && after_it == before_it {
                return Err(format!("without {key}, {after_it} {what} instead of {before_it}"));
            }
        }
        Ok(())
    }
}

/// Hilly land with a lake and a hole, on a device of its own.
struct Place {
    world: World,
    poses: [Pose; 2],
    /// Bytes that the device had allocated before there was a renderer, without the land.
    base_bytes: u64,
}

impl Place {
    fn new() -> Option<Self> {
        let (_, mut grid) = Hill::square(161, 20.0);
        let is_hole = |i: usize| (100..130).contains(&(i % 161)) && (100..130).contains(&(i / 161));
        for (i, height_m) in grid.heights_m.iter_mut().enumerate() {
            *height_m = if is_hole(i) { f32::NAN } else { height_m.max(30.0) };
        }
        let mut world = World::on_own_device(grid, 1.0)?;
        let pose = world.pose("900,-900,+120,315,-8,60");
        let poses = [pose, Pose { position_m: pose.position_m + DVec3::X * 0.01, ..pose }];
        // Resources that all frames share are created before anything is measured.
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &View::whole(pose, pose, SIZE_PX), &bare(), &north_west());
        drop(renderer);
        let mut place = Self { world, poses, base_bytes: 0 };
        place.base_bytes = place.allocated_bytes();
        Some(place)
    }

    /// Draws a frame that rebuilds strokes, and one that moves them. Returns their passes if they are `traced`.
    fn frames(&mut self, renderer: &mut Renderer, style: &Style, traced: bool) -> Vec<Vec<PassTrace>> {
        let ([first, then], world) = (self.poses, &mut self.world);
        renderer.forget();
        renderer.set_traces(traced);
        let views = [[first, first], [first, then]].map(|[before, now]| View::whole(before, now, SIZE_PX));
        let frame = |view: &View| {
            draw(&world.gpu, &mut world.surfaces, renderer, view, style, &north_west());
            renderer.trace().to_vec()
        };
        views.iter().map(frame).collect()
    }

    /// Draws a style until all resources that it does not need are released, and returns the resources that its frames
    /// then need.
    fn settled(&mut self, renderer: &mut Renderer, style: &Style) -> Need {
        self.forget_maps();
        for _ in 0..3 {
            self.frames(renderer, style, false);
            let view = View::whole(self.poses[0], self.poses[0], SIZE_PX);
            renderer.pass_frames(&self.world.gpu, &view, style, IDLE_FRAMES);
        }
        self.need(renderer, style)
    }

    /// Returns what two frames of a style need.
    fn need(&mut self, renderer: &mut Renderer, style: &Style) -> Need {
        let traces = self.frames(renderer, style, true);
        let bound_bytes = renderer.drawing_bytes(&self.world.surfaces).unwrap();
        renderer.set_traces(false);
        let mut passes = BTreeMap::new();
        traces.iter().flatten().for_each(|pass| *passes.entry(pass.name).or_default() += 1);
        let bytes = traces.iter().map(|trace| FrameWork::of(trace).bytes()).sum();
        drop(traces);
        Need { passes, bytes, bound_bytes, allocated_bytes: self.allocated_bytes() }
    }

    /// Returns what the first frames of a style need, which also compute maps of the land, and what later ones need, in a
    /// renderer that has drawn nothing else.
    fn needs_alone(&mut self, style: &Style) -> [Need; 2] {
        self.forget_maps();
        let mut renderer = Renderer::new(&self.world.gpu).unwrap();
        let first = self.need(&mut renderer, style);
        let later = self.settled(&mut renderer, style);
        // Until now, values of other styles were allocated as well.
        [Need { allocated_bytes: later.allocated_bytes, ..first }, later]
    }

    fn allocated_bytes(&self) -> u64 {
        self.world.gpu.wait();
        let terrain = &self.world.surfaces.terrain;
        self.world.gpu.memory_bytes() + terrain.map_bytes() - terrain.gpu_bytes() - self.base_bytes
    }

    /// Opens the land again, without maps: they are computed for the next style that needs them.
    fn forget_maps(&mut self) {
        let terrain = &self.world.surfaces.terrain;
        let (store, options) = (Arc::clone(terrain.store()), *terrain.options());
        self.world.surfaces = Terrain::new(&self.world.gpu, store, options).unwrap().into();
    }
}

fn bare() -> Style {
    Style::parse("bare", "name = \"bare\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n").unwrap()
}

/// Returns the preset without a part as a style file says so, or `None` if the preset does not have it.
fn without(preset: &str, key: &str) -> Option<Style> {
    let text = format!("extends = \"{preset}\"\nwithout = [\"{key}\"]\n");
    Some(Style::parse(preset, &text).ok()?.without(if key == "rims" { &["rims"] } else { &[] }))
}

/// Returns the preset, if its text lacks the part from the beginning.
fn never_with(preset: &str, key: &str) -> Style {
    let mut document: toml_edit::DocumentMut = style::preset_text(preset).unwrap().parse().unwrap();
    if document.remove(key).is_none() {
        let layers = document["layers"].as_array_of_tables_mut().unwrap();
        layers.retain(|layer| layer["kind"].as_str() != Some(key));
    }
    Style::parse(preset, &document.to_string()).unwrap()
}

/// Removes parts from a preset one by one, and checks the resources that its frames need. Returns the parts that were
/// removed.
fn remove_parts(
    place: &mut Place,
    preset: &str,
    is_wanted: &mut dyn FnMut(&str) -> bool,
    wrong: &mut Vec<String>,
) -> Vec<&'static str> {
    let with_spacing_of_tests = |mut style: Style| {
        let of_tests = common::preset(preset);
        if let (Some(rows), Some(of_tests)) = (style.rows_mut(), of_tests.rows()) {
            rows.spacing_px = of_tests.spacing_px;
        }
        style
    };
    let has = |(key, _): &Part| *key == "rims" || without(preset, key).is_some();
    let parts: Vec<Part> = PARTS.into_iter().filter(has).filter(|(key, _)| is_wanted(key)).collect();
    if parts.is_empty() {
        return Vec::new();
    }
    let whole_style = common::preset(preset);
    let whole_needs = place.needs_alone(&whole_style);
    let [first, whole] = &whole_needs;
    for pass in first.passes.keys() {
        let owners = PARTS.iter().filter(|(_, owned)| is_of(pass, owned)).count();
        let is_known = owners == 1 || owners == 0 && (SHARED.contains(pass) || ALWAYS.contains(pass));
        if !is_known {
            wrong.push(format!("{preset}: {pass} has {owners} owners"));
        }
    }
    // The memory that reports list is that which the device has allocated.
    let [bound, allocated] = [whole.bound_bytes, whole.allocated_bytes];
    let room = UNBOUND.0 + (UNBOUND.1 * bound as f64) as u64;
    println!("{preset}: {bound} bytes bound, {allocated} allocated");
    if bound > allocated || allocated > bound + room {
        wrong.push(format!("{preset} binds {bound} bytes, and {allocated} are allocated"));
    }
    for part in &parts {
        let (key, owned) = part;
        // Without rows or cuts, hatching is drawn on the land instead of them.
        let others: &[&str] = if ["rows", "cuts"].contains(key) { &["hatching"] } else { &[] };
        let whole_style = whole_style.clone().without(others);
        let bare_needs = (!others.is_empty()).then(|| place.needs_alone(&whole_style));
        let [first, whole] = bare_needs.as_ref().unwrap_or(&whole_needs);
        let reduced_style = if *key == "rims" {
            common::preset(preset).without(&["rims"])
        } else {
            let style = with_spacing_of_tests(without(preset, key).unwrap());
            assert_eq!(style, with_spacing_of_tests(never_with(preset, key)), "{preset} without {key}");
            style.without(others)
        };
        // The style loses the part while it is drawn.
        let mut renderer = Renderer::new(&place.world.gpu).unwrap();
        place.frames(&mut renderer, &whole_style, false);
        place.frames(&mut renderer, &reduced_style, false);
        let early = place.allocated_bytes();
        let lost = place.settled(&mut renderer, &reduced_style);
        drop(renderer);
        let [reduced_first, reduced] = place.needs_alone(&reduced_style);
        if lost != reduced {
            wrong.push(format!(
                "{preset} without {key}, which was removed while it was drawn: {lost:?}, not {reduced:?}"
            ));
        }
        let removed = Removed { part: *part, whole, reduced: &reduced };
        for removed in [Removed { part: *part, whole: first, reduced: &reduced_first }, removed] {
            wrong.extend(removed.check().err().map(|error| format!("{preset}: {error}")));
        }
        let runs: Vec<&&str> = whole.passes.keys().filter(|pass| is_of(pass, owned)).collect();
        println!(
            "{preset} without {key}: {} passes less, {} of {} bytes, {} of {} bound, {} of {} allocated",
            whole.passes.len() - reduced.passes.len(),
            reduced.bytes,
            whole.bytes,
            reduced.bound_bytes,
            whole.bound_bytes,
            reduced.allocated_bytes,
            whole.allocated_bytes
        );
        let Some(pass) = runs.first() else { continue };
        // Planted: right after the switch, the memory of the part is still allocated.
        if early <= reduced.allocated_bytes {
            wrong.push(format!("{preset} without {key}: {early} bytes are allocated right after the switch"));
        }
        // Planted: a pass of the part still runs, its bytes are still moved, its memory is still bound or allocated.
        let mut still = reduced.clone();
        still.passes.insert(**pass, 1);
        let planted = [
            still,
            Need { bytes: whole.bytes, ..reduced.clone() },
            Need { bound_bytes: whole.bound_bytes, ..reduced.clone() },
            Need { allocated_bytes: whole.allocated_bytes, ..reduced.clone() },
        ];
        for reduced in &planted {
            if (Removed { reduced, ..removed }).check().is_ok() {
                wrong.push(format!("{preset} without {key}: a planted need passes: {reduced:?}"));
            }
        }
    }
    parts.into_iter().map(|(key, _)| key).collect()
}

#[test]
fn a_style_without_a_part_needs_nothing_of_it() {
    let Some(mut place) = Place::new() else { return };
    let (mut seen, mut wrong) = (BTreeMap::new(), Vec::new());
    for preset in style::names() {
        // The fast tier removes two parts from one preset; the long one each part from up to three presets.
        let mut is_wanted = |key: &str| match common::full() {
            true => seen.get(key).copied().unwrap_or(0) < 3,
            false => preset == "lsa" && ["lines", "water"].contains(&key),
        };
        for key in remove_parts(&mut place, preset, &mut is_wanted, &mut wrong) {
            *seen.entry(key.to_owned()).or_insert(0) += 1;
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let missing = PARTS.iter().map(|(key, _)| *key).filter(|key| !seen.contains_key(*key));
    if common::full() {
        assert_eq!(missing.collect::<Vec<_>>(), ["focus"], "no preset has these");
    } else {
        assert!(seen.contains_key("lines") && seen.contains_key("water"), "{seen:?}");
    }
}

#[test]
fn maps_of_the_land_are_released() {
    let Some(mut place) = Place::new() else { return };
    let without_bytes = place.world.surfaces.terrain.gpu_bytes();
    let mut renderer = Renderer::new(&place.world.gpu).unwrap();
    // Strokes need no maps.
    let others: &[&str] = if common::full() { &[] } else { &["strokes"] };
    place.frames(&mut renderer, &Style::load("wash").unwrap().without(others), false);
    let with_bytes = place.world.surfaces.terrain.gpu_bytes();
    let view = View::whole(place.poses[0], place.poses[0], SIZE_PX);
    let mut prepare = |frames: u64| {
        for _ in 0..frames {
            frame::prepare(&place.world.gpu, &mut place.world.surfaces, &Rig::mono(view), &bare(), &north_west());
        }
        place.world.surfaces.terrain.gpu_bytes()
    };
    // They take long to compute, so they stay for a while.
    let (early_bytes, late_bytes) = (prepare(100), prepare(KEEP_MAPS_FRAMES));
    println!("{without_bytes} bytes without maps, {with_bytes} with them, {early_bytes} and {late_bytes} later");
    assert!(with_bytes > without_bytes + 2 * MAP_BYTES);
    assert_eq!((early_bytes, late_bytes), (with_bytes, without_bytes));
}
