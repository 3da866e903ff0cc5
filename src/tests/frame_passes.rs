//! The table in `src/frame_passes.md` agrees with the traces of frames that are drawn here.
//!
//! `HACHURE_REWRITE=1 cargo test --release --lib tests::frame_passes` rewrites the table.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]
#![allow(clippy::disallowed_methods, reason = "the table is a source file under version control")]

use crate::tests::common;

use crate::tests::helpers::shapes;
use common::hill::Hill;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::DVec3;
use hachure::draped::Draped;
use hachure::frame::{self, Antialias, Renderer};
use hachure::gpu::shader::SHADERS;
use hachure::gpu::target::{Group, Target, TargetKind};
use hachure::gpu::trace::{PassTrace, Traced, Work};
use hachure::imagery::Imagery;
use hachure::imagery::tests::write_png;
use hachure::picture::show::{self, ShowError};
use hachure::scene::forest::Form;
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, View};
use hachure::scene::{FeatureFile, ImageFile, Wind};
use hachure::style::{self, Detector, ReliefKind, Style};
use hachure::surface::hidden::HiddenArea;

use crate::tests::common::draw::{draw, north_west};
use crate::tests::common::{World, full};

const LIST: &str = include_str!("../frame_passes.md");
const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/frame_passes.md");
const BEGIN: &str = "<!-- The table begins. -->\n";
const END: &str = "<!-- The table ends. -->\n";

const SIZE_PX: [u32; 2] = [96, 54];

/// The resources that a pass reads and writes in any frame, and the frames that have it.
struct Row {
    name: &'static str,
    reads: BTreeSet<String>,
    writes: BTreeSet<String>,
    frames: BTreeSet<String>,
}

/// The passes of several kinds of frames: those of presets, with meshes, with motion, and others.
struct Traces {
    presets: Vec<&'static str>,
    rows: Vec<Row>,
}

fn named(used: &Traced) -> String {
    used.format().map_or_else(|| used.name.to_owned(), |format| format!("{} `{format:?}`", used.name))
}

impl Traces {
    /// Adds a frame; a new pass is inserted after the pass that it followed.
    fn add(&mut self, renderer: &str, trace: &[PassTrace]) {
        let mut at = 0;
        for pass in trace {
            let found = self.rows.iter().position(|row| row.name == pass.name);
            let row = found.unwrap_or_else(|| {
                let (reads, writes, frames) = Default::default();
                self.rows.insert(at, Row { name: pass.name, reads, writes, frames });
                at
            });
            // A pass that runs several times is listed where it ran first.
            at = at.max(row + 1);
            self.rows[row].reads.extend(pass.reads.iter().map(named));
            self.rows[row].writes.extend(pass.writes.iter().map(named));
            self.rows[row].frames.insert(renderer.to_owned());
        }
    }

    /// Returns the frames in which a pass runs.
    fn when(&self, row: &Row) -> String {
        let styles: Vec<&str> = self.presets.iter().copied().filter(|name| row.frames.contains(*name)).collect();
        if styles.len() == self.presets.len() {
            return "always".to_owned();
        }
        if styles.is_empty() {
            return row.frames.iter().cloned().collect::<Vec<_>>().join(", ");
        }
        format!("`{}`", styles.join("`, `"))
    }

    fn table(&self) -> String {
        let mut text = "| # | pass | reads | writes | in frames of |\n| --- | --- | --- | --- | --- |\n".to_owned();
        let list = |names: &BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(", ");
        for (number, row) in (1..).zip(&self.rows) {
            let (reads, writes, when) = (list(&row.reads), list(&row.writes), self.when(row));
            text += &format!("| {number} | `{}` | {reads} | {writes} | {when} |\n", row.name);
        }
        text
    }

    /// Returns the passes that a table does not describe as the frames have them; the table may list more frames.
    fn unlike<'a>(&self, table: &'a str) -> Vec<&'a str> {
        let lines = table.lines().skip(2).map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let [_, _, name, reads, writes, when, _] = cells[..] else { panic!("{line}") };
            (name.trim_matches('`'), [reads, writes, when])
        });
        let lines: BTreeMap<&str, [&str; 3]> = lines.collect();
        let mut unlike: Vec<&str> =
            self.rows.iter().map(|row| row.name).filter(|name| !lines.contains_key(name)).collect();
        for (name, [reads, writes, when]) in lines {
            let row = self.rows.iter().find(|row| row.name == name);
            let has = |cell: &str, names: &BTreeSet<String>| {
                names.iter().all(|name| cell.split(", ").any(|listed| listed == name))
            };
            let has_all = row.is_none_or(|row| has(reads, &row.reads) && has(writes, &row.writes));
            let is_drawn = |preset: &str| row.is_some_and(|row| row.frames.contains(preset));
            let is_said = |preset: &str| when == "always" || when.contains(&format!("`{preset}`"));
            if !has_all || self.presets.iter().any(|preset| is_drawn(preset) != is_said(preset)) {
                unlike.push(name);
            }
        }
        unlike
    }
}

fn drawing(world: &mut World, renderer: &mut Renderer, style: &Style, poses: [Pose; 2]) -> Vec<PassTrace> {
    let [previous, pose] = poses;
    let view = View::whole(previous, pose, SIZE_PX);
    renderer.set_traces(true);
    draw(&world.gpu, &mut world.surfaces, renderer, &view, style, &north_west());
    renderer.trace().to_vec()
}

/// Returns the traces of all frames, or of a few of them.
fn traces(all: bool) -> Option<Traces> {
    let (hill, mut world) = shapes::hill()?;
    let presets = if all { style::names() } else { vec!["lsa", "pen", "wash"] };
    let mut traces = Traces { presets, rows: Vec::new() };
    let pose = world.pose("900,-900,+20,315,3,60");
    // Between updates, strokes are moved with the world.
    let next = Pose { position_m: pose.position_m + DVec3::X * 0.01, ..pose };
    // A turn makes an update, in which strokes take over from those of the previous frame.
    let turned = world.pose("900,-900,+20,326,3,60");
    // Frames with the most passes come first, since they determine the order.
    traces.presets.sort_by_key(|name| (!["pen", "wash"].contains(name), *name));
    for name in traces.presets.clone() {
        let style = Style::load(name).unwrap();
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let first = drawing(&mut world, &mut renderer, &style, [pose; 2]);
        let then = drawing(&mut world, &mut renderer, &style, [pose, next]);
        let last = drawing(&mut world, &mut renderer, &style, [next, turned]);
        [first, then, last].iter().for_each(|trace| traces.add(name, trace));
    }
    let style = Style::load("pen").unwrap();
    if all {
        add_kinds(&mut traces, &mut world, pose, &style);
    }
    // The number of styles in which things that stand on the land are drawn.
    let count = if all { 3 } else { 1 };
    world.surfaces.set_forest(Some(crate::tests::helpers::forest::of(Form::Conifer, 100.0, 20.0)));
    for name in ["pen", "crosshatch", "wash"].into_iter().take(count) {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let trace = drawing(&mut world, &mut renderer, &Style::load(name).unwrap(), [pose; 2]);
        traces.add("scenes with a forest", &trace);
    }
    world.surfaces.set_wind(Some(Wind { speed_m_s: 5.0, from_deg: 270.0 }));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_wants_motion(true);
    let trace = drawing(&mut world, &mut renderer, &style, [pose; 2]);
    traces.add("scenes with a forest in wind", &trace);
    world.surfaces.set_wind(None);
    world.surfaces.set_forest(None);
    if all {
        let text = "name = \"water\"\ndescription = \"\"\n[water]\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\n";
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let trace = drawing(&mut world, &mut renderer, &Style::parse("water", text).unwrap(), [pose; 2]);
        traces.add("styles with water", &trace);
    }
    let at_m = DVec3::new(850.0, -850.0, 0.0);
    let at_m = at_m.with_z(hill.height_m(at_m.x, at_m.y) + 10.0);
    shapes::place(&mut world, &Arc::new(shapes::mesh(shapes::cube())), &shapes::stance(at_m, 0.0, 10.0));
    for name in ["pen", "wash", "hachures"].into_iter().take(count) {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let trace = drawing(&mut world, &mut renderer, &Style::load(name).unwrap(), [pose; 2]);
        traces.add("scenes with meshes", &trace);
    }
    traces.presets.sort_unstable();
    if !all {
        return Some(traces);
    }
    let (_, mut grid) = Hill::square(321, 10.0);
    let is_hole = |i: usize| (200..260).contains(&(i % 321)) && (200..260).contains(&(i / 321));
    grid.heights_m.iter_mut().enumerate().filter(|(i, _)| is_hole(*i)).for_each(|(_, height_m)| *height_m = f32::NAN);
    let mut world = World::new(grid, 1.0)?;
    for name in ["lsa", "pen"] {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let trace = drawing(&mut world, &mut renderer, &Style::load(name).unwrap(), [pose; 2]);
        traces.add("land with holes", &trace);
    }
    Some(traces)
}

/// Adds frames of all kinds of views and styles.
fn add_kinds(traces: &mut Traces, world: &mut World, pose: Pose, pen: &Style) {
    for name in ["lsa", "pencil"] {
        let style = Style::load(name).unwrap();
        let rig = Pair { ipd_m: 1.0, convergence_m: None }.rig(&View::whole(pose, pose, SIZE_PX));
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_traces(true);
        let prepared = frame::prepare(&world.gpu, &mut world.surfaces, &rig, &style, &north_west());
        renderer.render_rig(&world.gpu, &world.surfaces, &prepared, &rig, &style, &north_west()).unwrap();
        traces.add("pairs of eyes", renderer.trace());
    }
    for name in ["lsa", "pen"] {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_antialias(Antialias::Temporal);
        let trace = drawing(world, &mut renderer, &Style::load(name).unwrap(), [pose; 2]);
        traces.add("temporal anti-aliasing", &trace);
    }
    let mut style = Style::load("lsa").unwrap();
    style.lines_mut().unwrap().detector = Detector::Curvature;
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let trace = drawing(world, &mut renderer, &style, [pose; 2]);
    traces.add("styles with `detector = \"curvature\"`", &trace);
    for kind in [ReliefKind::Scaling, ReliefKind::Exaggerated] {
        let mut style = Style::load("relief").unwrap();
        style.relief.as_mut().unwrap().kind = kind;
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let trace = drawing(world, &mut renderer, &style, [pose; 2]);
        traces.add(&format!("styles with relief of kind `{}`", kind.name()), &trace);
    }
    let mut style = Style::load("suggestive").unwrap();
    style.strokes_mut().unwrap().ridge_apparent = true;
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let trace = drawing(world, &mut renderer, &style, [pose; 2]);
    traces.add("styles with apparent ridges", &trace);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let trace = drawing(world, &mut renderer, &pen.clone().for_map(10.0).unwrap(), [pose; 2]);
    traces.add("maps", &trace);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_room(Some(SIZE_PX));
    drawing(world, &mut renderer, pen, [pose; 2]);
    let smaller = View::whole(pose, pose, SIZE_PX.map(|side| side / 2));
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &smaller, pen, &north_west());
    traces.add("another size with room for it", renderer.trace());
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_wants_motion(true);
    let trace = drawing(world, &mut renderer, pen, [pose; 2]);
    traces.add("channel `motion`", &trace);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_hidden(vec![HiddenArea { corners: vec![[-1.0, -1.0], [0.0, -1.0], [-1.0, 0.0]] }]);
    let trace = drawing(world, &mut renderer, pen, [pose; 2]);
    traces.add("headsets that hide areas", &trace);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.csv");
    std::fs::write(
        &path,
        "wkt,name\n\"LINESTRING (-800 -800,800 800)\",a\n\"POLYGON ((-500 0,500 0,0 500,-500 0))\",b\n",
    )
    .unwrap();
    let store = world.surfaces.terrain.store();
    let (place, size) = (store.georeference().clone(), store.levels()[0]);
    let samples = [size.width, size.height];
    let read = |files: &[FeatureFile]| Draped::read(files, None, &place, samples).unwrap();
    world.surfaces.set_features(read(&[FeatureFile { path, layer: None }]));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let trace = drawing(world, &mut renderer, &pen.clone().with_features([true, false]), [pose; 2]);
    traces.add("worlds with features", &trace);
    world.surfaces.set_features(read(&[]));
    let path = folder.path().join("image.png");
    write_png(&path, [64, 64], |x, y| [x as u8, y as u8, 0, 255]);
    let gpu = world.gpu.clone();
    let open = |files: &[ImageFile]| Imagery::open(files, &place, samples).unwrap();
    world.surfaces.set_imagery(&gpu, open(&[ImageFile { path }]));
    for name in ["plain", "wash"] {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let trace = drawing(world, &mut renderer, &Style::load(name).unwrap(), [pose; 2]);
        traces.add("worlds with images", &trace);
    }
    world.surfaces.set_imagery(&gpu, open(&[]));
}

/// In the fast tier a few frames are drawn, and only what they have is compared.
#[test]
fn the_table_is_that_of_the_frames() {
    let is_rewritten = std::env::var_os("HACHURE_REWRITE").is_some();
    let all = full() || is_rewritten;
    let Some(mut traces) = traces(all) else { return };
    let table = traces.table();
    let (begin, end) = (LIST.find(BEGIN).unwrap() + BEGIN.len(), LIST.find(END).unwrap());
    if is_rewritten {
        std::fs::write(PATH, format!("{}\n{table}\n{}", &LIST[..begin], &LIST[end..])).unwrap();
    }
    let written = LIST[begin..end].trim();
    if all {
        for (written, drawn) in written.lines().zip(table.lines()) {
            assert_eq!(written, drawn, "HACHURE_REWRITE=1 rewrites the table");
        }
        assert_eq!(written, table.trim(), "HACHURE_REWRITE=1 rewrites the table");
    }
    assert!(traces.unlike(written).is_empty(), "HACHURE_REWRITE=1 rewrites the table: {:?}", traces.unlike(written));
    // Every shader is a pass of some frame, apart from those of the window and of the headset.
    let outside_frames = ["composite/present", "headset/show"];
    let known: BTreeSet<&str> =
        SHADERS.iter().map(|(name, _)| *name).filter(|name| !outside_frames.contains(name)).collect();
    let listed: BTreeSet<&str> = written.lines().skip(2).filter_map(|line| line.split('`').nth(1)).collect();
    assert_eq!(listed, known);
    assert!(outside_frames.iter().all(|name| LIST.contains(name)));
    // Planted errors: a pass that reads another resource, and a pass that is not listed.
    let more = Traced { name: "nothing", content: None, texture: None, buffer: None, bytes: 0 };
    let planted = |name| PassTrace {
        name,
        submit: 0,
        work: Work::Dispatch,
        copied: Vec::new(),
        reads: vec![more.clone()],
        writes: Vec::new(),
    };
    for name in ["surface/land/resolve", "surface/none"] {
        traces.add("lsa", &[planted(name)]);
        assert!(traces.table() != table, "a change of {name} does not change the table");
        assert!(traces.unlike(written).contains(&name), "a change of {name} was not detected");
    }
}

/// Reads every picture that a trace names; returns their names.
fn look_at_all(world: &World, trace: &[PassTrace]) -> Result<BTreeSet<&'static str>, ShowError> {
    let mut names = BTreeSet::new();
    for (name, texture) in show::pictures(trace) {
        let shown = show::read(&world.gpu, trace, name, SIZE_PX)?;
        let [width, height] = shown.size_px;
        assert!(width >= texture.width() && height >= texture.height(), "{name} is shown smaller than it is");
        assert_eq!(shown.rgba8().len() as u32, 4 * width * height, "{name} has the wrong number of bytes");
        assert!(!shown.channels().is_empty(), "{name} has no channels");
        names.insert(name);
    }
    Ok(names)
}

#[test]
fn every_picture_of_a_frame_can_be_shown() {
    let Some((_, mut world)) = shapes::hill() else { return };
    let pose = world.pose("900,-900,+20,315,3,60");
    let mut names = BTreeSet::new();
    let mut trace = Vec::new();
    // In the fast tier lines, marks, and strokes with washes.
    for name in if full() { common::presets() } else { vec!["lsa", "crosshatch", "wash"] } {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_wants_motion(true);
        renderer.set_wants_ids(true);
        trace = drawing(&mut world, &mut renderer, &Style::load(name).unwrap(), [pose; 2]);
        names.extend(look_at_all(&world, &trace).unwrap_or_else(|error| panic!("{name}: {error}")));
        world.gpu.check().unwrap();
    }
    // All pictures are in the table, in which a name is followed by its format.
    let is_listed = |name: &&str| LIST.contains(&format!(" {name} `"));
    assert!(names.len() > 20 && names.iter().all(is_listed), "pictures that the table lacks, or too few: {names:?}");
    assert!(
        ["depth", "surface id", "height tiles", "ramp", "stroke texture", "motion", "horizon maps"]
            .iter()
            .all(|name| names.contains(name))
    );
    // Planted errors: a picture of an unsupported format, and a name that does not exist.
    let kind = TargetKind::storage("new", wgpu::TextureFormat::Rgba8Uint, Group::Surface.shows("A planted picture"));
    let texture = Some(Target::new(&world.gpu, &kind, [4, 4]).texture);
    let new = Traced { name: "new", content: Some(kind.content), texture, buffer: None, bytes: 64 };
    trace.push(PassTrace {
        name: "surface/none",
        submit: 0,
        work: Work::Dispatch,
        copied: Vec::new(),
        reads: vec![new],
        writes: Vec::new(),
    });
    assert!(matches!(look_at_all(&world, &trace), Err(ShowError::Format { name: "new", .. })));
    let error = show::read(&world.gpu, &trace, "nwe", SIZE_PX).unwrap_err().to_string();
    assert!(error.contains("--show nwe") && error.contains("new") && error.contains("surface id"), "{error}");
}

#[test]
fn the_pictures_of_the_list_are_those_of_the_table() {
    let (_, meanings) = LIST.split_once("## What the formats hold").unwrap();
    let (begin, end) = (LIST.find(BEGIN).unwrap(), LIST.find(END).unwrap());
    let table = &LIST[begin..end];
    let mut pictures = 0;
    for row in meanings.lines().filter_map(|line| line.strip_prefix("| `")) {
        let (names, _) = row.split_once(" |").unwrap();
        for name in names.split("`, `").map(|name| name.trim_end_matches('`')) {
            assert!(table.contains(&format!("{name} `")), "no pass has a picture named {name}");
            pictures += 1;
        }
    }
    assert!(pictures > 15, "{pictures}");
}
