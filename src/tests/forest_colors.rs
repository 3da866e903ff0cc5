//! Trees and models have their own colours in styles with local colours, the same at all distances; other styles do not
//! change.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::tests::helpers::forest::{listed, of};
use crate::tests::helpers::shapes;
use common::draw::{NOON, draw, halves, still};
use common::{World, grid_of};
use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::forest::model::TreeModel;
use hachure::frame::Renderer;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::gpu::readback::read;
use hachure::mesh::placed::Placed;
use hachure::mesh::{Mesh, obj};
use hachure::scene::forest::{Form, Species};
use hachure::scene::{Forest, Wind};
use hachure::source::Silent;
use hachure::style::{self, Style};
use hachure::surface::local_color::LOCAL_COLOR;
use hachure::surface::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR};
use hachure::surface::{SURFACE_ID, id};
use hachure::tiles::Terrain;
use hachure::tiles::terrain::TerrainOptions;
use hachure::tones::TONE;
use hachure::world::Surfaces;

const SIZE_PX: [u32; 2] = [320, 180];
const LEVELS: [u32; 4] = [NEAR, MIDDLE, IMPOSTOR, CANOPY];

/// Loads a preset and sets its amount of local colours.
fn style(name: &str, amount: f32) -> Style {
    let text = style::preset_text(name).unwrap().replace("fit = true\n", "");
    let own: String =
        text.lines().filter(|line| !line.starts_with("local_color")).map(|line| format!("{line}\n")).collect();
    let text = own.replace("[tone]\n", &format!("[tone]\nlocal_color = {amount}\n"));
    let style = Style::parse(name, &text).unwrap();
    assert_eq!(style.tone.local_color(), amount);
    style
}

fn plain() -> Option<World> {
    World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02)
}

fn ids(world: &World, renderer: &Renderer) -> Vec<u32> {
    let target = renderer.target(&SURFACE_ID).unwrap();
    let bytes = read(&world.gpu, target, [0, 0], target.size_px()).unwrap();
    bytes.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect()
}

/// Returns the fractions of red, green and blue in a colour.
fn parts(color: DVec3) -> DVec3 {
    color / color.element_sum().max(1e-9)
}

fn luminance([red, green, blue, _]: [f64; 4]) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// A sum of colours, and the number of pixels in it.
#[derive(Clone, Copy, Default)]
struct Sum(DVec3, u32);

impl Sum {
    fn parts(self) -> DVec3 {
        parts(self.0)
    }
}

/// Returns the colours in which a forest's trees are drawn before lines and haze, for each level: from within the
/// forest, from above it, and from high above.
fn colors(world: &mut World, forest: &Forest, models: &[Arc<TreeModel>]) -> BTreeMap<u32, Sum> {
    world.surfaces.set_forest(Some(forest.clone()));
    world.surfaces.set_tree_models(models.to_vec());
    let mut sums: BTreeMap<u32, Sum> = BTreeMap::new();
    let style = style("plain", 1.0);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    // Near trees are seen from among their crowns; from the ground most of the pixels are trunks.
    for (camera, detail) in [
        ("0,0,18,0,-4,50", 3.0),
        ("60,80,18,120,-4,50", 3.0),
        ("0,-900,60,0,-12,50", 1.0),
        ("0,-2800,500,0,-14,40", 1.0),
    ] {
        world.surfaces.set_tree_detail(detail);
        let pose = world.pose(camera);
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &NOON);
        let mut levels: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for tree in listed(world, &renderer, pose.position_m) {
            levels.entry(tree.instance.id).or_default().push(tree.level);
        }
        let tones = halves(&world.gpu, renderer.target(&TONE).unwrap());
        for (id, tone) in ids(world, &renderer).into_iter().zip(tones).filter(|(id, _)| *id >= id::FIRST_TREE) {
            // A tree that dissolves between two levels is skipped.
            if let [level] = levels[&id][..] {
                let sum = sums.entry(level).or_default();
                *sum = Sum(sum.0 + DVec3::new(tone[0], tone[1], tone[2]), sum.1 + 1);
            }
        }
    }
    for level in LEVELS {
        assert!(sums.get(&level).is_some_and(|sum| sum.1 > 400), "level {level}: too few pixels");
    }
    sums
}

/// Returns trees whose leaves and bark have exchanged colours.
fn exchanged(form: Form) -> Forest {
    let [leaf, bark] = match form {
        Form::Birch => [[0.94, 0.93, 0.90], [0.60, 0.66, 0.28]],
        Form::Conifer => [[0.42, 0.31, 0.25], [0.26, 0.38, 0.31]],
        _ => [[0.40, 0.33, 0.27], [0.37, 0.50, 0.22]],
    };
    let forest = of(form, 150.0, 20.0);
    let species = Species { color_srgb: Some(leaf), bark_srgb: Some(bark), ..forest.species[0].clone() };
    Forest { species: vec![species], ..forest }
}

/// Largest difference between levels of one species, in fractions of red, green and blue; species differ by more.
const LIKE: f64 = 0.03;

#[test]
fn a_species_has_the_same_colour_at_all_levels() {
    let Some(mut world) = plain() else { return };
    let forms = [Form::Conifer, Form::Birch, Form::Broadleaf, Form::Snag];
    let forms = if common::full() { &forms[..] } else { &forms[..2] };
    let mut means = Vec::new();
    for &form in forms {
        let sums = colors(&mut world, &of(form, 150.0, 20.0), &[]);
        let own = LEVELS.map(|level| sums[&level].parts());
        println!("{form:?}: {own:.3?}");
        for (a, b) in (0..4).flat_map(|a| (0..a).map(move |b| (a, b))) {
            assert!(own[a].distance(own[b]) < LIKE, "{form:?}: levels {a} and {b} have different colours");
        }
        // Planted error: leaves and bark have exchanged colours. In the fast tier the test of wind plants it.
        if common::full() && form != Form::Snag {
            let other = colors(&mut world, &exchanged(form), &[]);
            for level in LEVELS {
                let far = other[&level].parts().distance(own[0]);
                println!("  leaves and bark exchanged, level {level}: {far:.3}");
                assert!(far > LIKE, "{form:?}: level {level}: exchanged colours differ by only {far}");
            }
        }
        means.push(own);
    }
    // Planted error: two species are exchanged.
    for (a, b) in (0..forms.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let far = means[a][i].distance(means[b][j]);
            assert!(far > LIKE, "{:?} level {i} and {:?} level {j} differ by only {far}", forms[a], forms[b]);
        }
    }
}

#[test]
fn wind_takes_no_colour_along() {
    let Some(mut world) = plain() else { return };
    let forest = of(Form::Birch, 150.0, 20.0);
    let still = colors(&mut world, &forest, &[]);
    world.surfaces.set_wind(Some(Wind { speed_m_s: 15.0, from_deg: 270.0 }));
    let (swaying, planted) = (colors(&mut world, &forest, &[]), colors(&mut world, &exchanged(Form::Birch), &[]));
    for level in LEVELS {
        let [far, planted] = [&swaying, &planted].map(|sums| sums[&level].parts().distance(still[&level].parts()));
        assert!(
            far < 0.02 && planted > 0.05,
            "level {level}: differences in wind {far}, with exchanged colours {planted}"
        );
    }
}

/// The head of an OBJ file of two boxes with two materials.
const BOXES: &str = "mtllib paint.mtl\nusemtl one\n";

fn boxed(first: u32, [low, high]: [[f64; 3]; 2]) -> String {
    let at = |i: u32| (0..3).map(move |axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let vertices = (0..8).map(|i| format!("v {}\n", at(i).map(|v| v.to_string()).collect::<Vec<_>>().join(" ")));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = faces.map(|face| format!("f {}\n", face.map(|corner| (first + corner).to_string()).join(" ")));
    vertices.collect::<String>() + &faces.concat()
}

/// Returns a model of two boxes with two materials of the given colours.
fn painted(boxes: [[[f64; 3]; 2]; 2], colors: [&str; 2]) -> Mesh {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = colors;
    std::fs::write(folder.path().join("paint.mtl"), format!("newmtl one\nKd {one}\nnewmtl two\nKd {two}\n")).unwrap();
    let text = BOXES.to_owned() + &boxed(1, boxes[0]) + "usemtl two\n" + &boxed(9, boxes[1]);
    let path = folder.path().join("boxes.obj");
    std::fs::write(&path, text).unwrap();
    obj::read_with(&path, &Silent, &mut |warning| panic!("{warning}")).unwrap()
}

const RED: &str = "0.7 0.2 0.1";
const BLUE: &str = "0.1 0.3 0.8";

fn is_red(color: DVec3) -> bool {
    color.x > 1.6 * color.z
}

fn is_blue(color: DVec3) -> bool {
    color.z > 1.6 * color.x
}

#[test]
fn a_model_shows_its_materials() {
    let Some((hill, mut world)) = shapes::hill() else { return };
    let at_m = DVec3::new(-300.0, -500.0, hill.height_m(-300.0, -500.0) + 5.0);
    let pose = world.pose("-300,-560,+12,0,0,40");
    let boxes = [[[-2.0, -1.0, -1.0], [-0.1, 1.0, 1.0]], [[0.1, -1.0, -1.0], [2.0, 1.0, 1.0]]];
    let size_px = if common::full() { SIZE_PX } else { [160, 90] };
    let mut halves_of = |colors: [&str; 2], name: &str, amount: f32| {
        let mut placed = Placed::default();
        placed.add(&Arc::new(painted(boxes, colors)), &shapes::stance(at_m, 0.0, 8.0)).unwrap();
        world.surfaces.set_meshes(placed);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, size_px), &style(name, amount), &NOON);
        let mut sums = [Sum::default(); 2];
        let tones = halves(&world.gpu, renderer.target(&TONE).unwrap());
        for (i, (id, tone)) in ids(&world, &renderer).into_iter().zip(&tones).enumerate() {
            if (id::FIRST_MESH..id::FIRST_TREE).contains(&id) {
                let sum = &mut sums[usize::from(i as u32 % size_px[0] >= size_px[0] / 2)];
                *sum = Sum(sum.0 + DVec3::new(tone[0], tone[1], tone[2]), sum.1 + 1);
            }
        }
        assert!(sums.iter().all(|sum| sum.1 > 200));
        sums.map(Sum::parts)
    };
    for name in ["plain", "wash"] {
        let [left, right] = halves_of([RED, BLUE], name, 1.0);
        println!("{name}: {left:.3} {right:.3}");
        assert!(is_red(left) && is_blue(right), "{name}: expected red and blue, found {left} and {right}");
        // Planted errors: exchanged colours; no local colours; grey materials.
        let [left, right] = halves_of([BLUE, RED], name, 1.0);
        assert!(is_blue(left) && is_red(right), "{name}: expected blue and red, found {left} and {right}");
        let bare = halves_of([RED, BLUE], name, 0.0);
        assert!(
            !bare.iter().any(|color| is_red(*color) || is_blue(*color)),
            "{name}: colours without local colours: {bare:?}"
        );
        let grey = halves_of(["0.5 0.5 0.5", "0.5 0.5 0.5"], name, 1.0);
        assert!(
            !grey.iter().any(|color| is_red(*color) || is_blue(*color)),
            "{name}: colours of grey materials: {grey:?}"
        );
    }
}

#[test]
fn a_model_of_a_tree_has_its_materials_at_all_levels() {
    let Some(mut world) = plain() else { return };
    // A wide crown on a thick trunk, y up.
    let boxes = [[[-0.8, 0.0, -0.8], [0.8, 4.0, 0.8]], [[-2.0, 4.0, -2.0], [2.0, 10.0, 2.0]]];
    let of_colors = |colors: [&str; 2]| Arc::new(TreeModel::new(&painted(boxes, colors), false).unwrap());
    let forest = of(Form::Model(0), 150.0, 20.0);
    let bluish = colors(&mut world, &forest, &[of_colors([RED, BLUE])]);
    let reddish = common::full().then(|| colors(&mut world, &forest, &[of_colors([BLUE, RED])]));
    for level in LEVELS {
        // Trunks are visible at all levels but the canopy. Exchanged materials give exchanged colours.
        let (blue, red) = (bluish[&level].parts(), reddish.as_ref().map(|sums| sums[&level].parts()));
        println!("level {level}: {blue:.3}, exchanged {red:.3?}");
        assert!(is_blue(blue), "level {level}: expected blue, found {blue}");
        assert!(red.is_none_or(is_red), "level {level}: expected red, found {red:?}");
        let trunks = blue.distance(bluish[&CANOPY].parts());
        assert!((trunks > 0.01) == (level != CANOPY), "level {level}: the trunk changes the colour by {trunks}");
    }
    // A model without materials has the green of the species it resembles, or the colour that the scene gives it.
    let mesh =
        |text: &str| Arc::new(TreeModel::new(&obj::parse("a".to_owned(), text.as_bytes()).unwrap(), false).unwrap());
    let bare = mesh(&(boxed(1, boxes[0]) + &boxed(9, boxes[1])));
    let green = common::full().then(|| colors(&mut world, &forest, &[Arc::clone(&bare)]));
    let species = Species { color_srgb: Some([0.8, 0.3, 0.2]), ..forest.species[0].clone() };
    let colored = colors(&mut world, &Forest { species: vec![species], ..forest }, &[bare]);
    for level in LEVELS {
        // Planted error: the colours of another model.
        let (blue, colored) = (bluish[&level].parts(), colored[&level].parts());
        assert!(is_red(colored) && !is_red(blue), "level {level}: with the scene's colour {colored}");
        let green = green.as_ref().map(|sums| sums[&level].parts());
        let is_green = |color: DVec3| color.y > color.x && color.y > 1.5 * color.z;
        assert!(green.is_none_or(is_green), "level {level}: without materials {green:?}");
    }
}

/// Draws a frame of a mixed forest, in the fast tier a strip of it. Returns tones before water and haze, ids, the
/// picture, and whether any pass used colours.
fn frame_of(world: &mut World, renderer: &mut Renderer, style: &Style) -> (Vec<[f64; 4]>, Vec<u32>, Vec<u8>, bool) {
    let pose = world.pose("0,0,14,0,-4,50");
    let size_px = if common::full() { SIZE_PX } else { [80, SIZE_PX[1]] };
    renderer.set_traces(true);
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, size_px), style, &NOON);
    let used = renderer.trace().iter().flat_map(|pass| pass.reads.iter().chain(&pass.writes));
    let names = ["local color", "tree colors", "tree palette", "tree paints", "mesh colors"];
    let is_colored = used.map(|used| used.name).any(|name| names.contains(&name));
    let tones = halves(&world.gpu, renderer.target(&TONE).unwrap());
    let picture = read(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], size_px).unwrap();
    (tones, ids(world, renderer), picture, is_colored)
}

#[test]
fn colours_change_no_tone_and_nothing_else() {
    let Some(mut world) = plain() else { return };
    let forest = of(Form::Conifer, 200.0, 20.0);
    world.surfaces.set_forest(Some(Forest { species: Species::mixed(20.0)[1..3].to_vec(), ..forest }));
    // Strokes persist from frame to frame, so each picture has its own renderer.
    let drawn = |world: &mut World, style: &Style| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        frame_of(world, &mut renderer, style)
    };
    // The first frame loads the tiles.
    drawn(&mut world, &style("wash", 0.0));
    let (bare, ids, bare_picture, is_colored) = drawn(&mut world, &style("wash", 0.0));
    assert!(!is_colored, "colours are computed for a style that has none");
    let text = style::preset_text("wash").unwrap();
    let silent: String = text
        .lines()
        .filter(|line| !line.starts_with("local_color") && *line != "fit = true")
        .map(|line| format!("{line}\n"))
        .collect();
    let silent = drawn(&mut world, &Style::parse("wash", &silent).unwrap());
    assert!(silent.2 == bare_picture, "a style without local_color must have none");
    let (full, full_ids, full_picture, is_colored) = drawn(&mut world, &style("wash", 1.0));
    assert!(is_colored && full_ids == ids && full_picture != bare_picture);
    let (mut trees, mut changed, mut worst) = (0, 0, 0.0_f64);
    for ((id, bare), full) in ids.iter().zip(&bare).zip(&full) {
        if *id < id::FIRST_TREE {
            assert_eq!(bare, full, "local colours of trees change the land");
            continue;
        }
        trees += 1;
        changed += u32::from((0..3).any(|i| (bare[i] - full[i]).abs() > 0.01));
        worst = worst.max((luminance(*bare) - luminance(*full)).abs());
        assert_eq!(bare[3], full[3], "colours change the darkness of marks");
    }
    println!("{trees} pixels of trees, {changed} changed; largest change of luminance {worst:.5}");
    let least = if common::full() { 9_000 } else { 2_250 };
    assert!(trees > least && f64::from(changed) > 0.8 * f64::from(trees) && worst < 2e-3);
    // Planted error: colours with a lightness of their own, as in `plain`.
    let [bare, full] = [0.0, 1.0].map(|amount| drawn(&mut world, &style("plain", amount)).0);
    let far = bare.iter().zip(&full).map(|(a, b)| (luminance(*a) - luminance(*b)).abs()).fold(0.0, f64::max);
    assert!(far > 0.02, "in plain, colours change luminance by only {far}");

    // Styles without local colours have nothing of them, even right after a style that has them.
    for name in common::presets() {
        let says_so = style::preset_text(name).unwrap().contains("local_color");
        assert_eq!(
            Style::load(name).unwrap().needs_local_colors(),
            says_so,
            "{name}: local colours should be {says_so}"
        );
    }
    let ink = Style::load("lsa").unwrap();
    let mut one = Renderer::new(&world.gpu).unwrap();
    assert!(frame_of(&mut world, &mut one, &Style::load("wash").unwrap()).3);
    let after = frame_of(&mut world, &mut one, &ink);
    let alone = drawn(&mut world, &ink);
    assert!(!alone.3 && !after.3 && alone.2 == after.2);
}

/// With wind, models and colours at once, drawing needs no more than 32 bytes of attachments per pixel and four storage
/// textures, which every WebGPU device has.
#[test]
fn colours_draw_within_the_default_limits() {
    let Some((hill, world)) = shapes::hill() else { return };
    let gpu = Gpu::open_within(&AdapterWish::Best, wgpu::Limits::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(gpu.device.limits().max_color_attachment_bytes_per_sample, 32);
    let pose = world.pose("900,-900,+20,315,3,60");
    let store = Arc::clone(world.surfaces.terrain.store());
    let mut surfaces = Surfaces::from(Terrain::new(&gpu, store, TerrainOptions::default()).unwrap());
    let at_m = DVec3::new(850.0, -850.0, hill.height_m(850.0, -850.0) + 10.0);
    let mut placed = Placed::default();
    let boxes = [[[-2.0, -1.0, -1.0], [-0.1, 1.0, 1.0]], [[0.1, -1.0, -1.0], [2.0, 1.0, 1.0]]];
    placed.add(&Arc::new(painted(boxes, [RED, BLUE])), &shapes::stance(at_m, 0.0, 8.0)).unwrap();
    surfaces.set_meshes(placed);
    surfaces.set_forest(Some(of(Form::Birch, 100.0, 20.0)));
    surfaces.set_wind(Some(Wind { speed_m_s: 5.0, from_deg: 270.0 }));
    // With shadows, marks and colours, every tone pass has all of its inputs.
    let all =
        Style::parse("all", &common::absolute("crosshatch").text().replace("local_color = 0.0", "local_color = 0.5"))
            .unwrap();
    assert!(all.needs_local_colors() && all.hatching().is_some() && all.needs_tree_shadows());
    // In the fast tier the style with all inputs alone.
    let others = [common::absolute("wash"), Style::load("plain").unwrap()];
    for style in others.into_iter().filter(|_| common::full()).chain([all]) {
        let mut renderer = Renderer::new(&gpu).unwrap();
        for _ in 0..2 {
            draw(&gpu, &mut surfaces, &mut renderer, &still(pose, [96, 54]), &style, &NOON);
        }
        assert!(renderer.target(&LOCAL_COLOR).is_some(), "{} has no local colours", style.name);
    }
}

#[test]
fn scenes_say_colours_of_species() {
    let scene = |species: &str| {
        let text = format!("[world]\nprocedural = {{ seed = 1 }}\n[forest]\n[[forest.species]]\n{species}");
        hachure::scene::Scene::parse(Path::new("scene.toml"), &text).map_err(|error| error.to_string())
    };
    let species =
        scene("form = \"birch\"\ncolor = \"#ff8000\"\nbark_color = \"#ffffff\"").unwrap().forest.unwrap().species;
    assert_eq!(species[0].color_srgb, Some([1.0, 128.0 / 255.0, 0.0]));
    assert_eq!(species[0].bark_srgb, Some([1.0; 3]));
    assert_eq!(scene("form = \"birch\"").unwrap().forest.unwrap().species[0].color_srgb, None);
    for (wrong, cause) in [
        (
            "form = \"birch\"\ncolor = \"green\"",
            "scene.toml:6:9: forest.species.color: it must be written as \"#rrggbb\"",
        ),
        (
            "form = \"birch\"\nbark_color = \"#12345\"",
            "scene.toml:6:14: forest.species.bark_color: it must be written as \"#rrggbb\"",
        ),
        ("file = \"a.obj\"\nbark_color = \"#123456\"", "forest.species.bark_color: it is only used with form"),
    ] {
        let error = scene(wrong).unwrap_err();
        println!("{error}");
        assert!(error.contains(cause) && !error.contains('\n'), "{error}");
    }
}
