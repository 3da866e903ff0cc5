//! Inside a focus the picture keeps its contrast, and away from it contrast falls as specified: in tones, lines, marks
//! and washes, around a position, a distance or a point of the picture.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, halves, north_west, places_m, still};
use common::{World, grid_of, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::{Light, Renderer};
use hachure::scene::focus::{Focus, FocusAbout, SceneFocus};
use hachure::scene::scene_file::SceneError;
use hachure::scene::view::Pose;
use hachure::scene::{self, Scene};
use hachure::style::{self, Style};

const SIZE_PX: [u32; 2] = [320, 200];
const CAMERA: &str = "0,-9000,+2500,0,-14,55";
const PLACE_M: DVec2 = DVec2::new(600.0, 1500.0);
const RADIUS_M: f64 = 2500.0;
const STRENGTH: f64 = 0.8;

fn world() -> Option<World> {
    World::new(grid_of(513, 513, 60.0, rough_height_m), 1.0)
}

/// Returns light without haze, so that only the focus reduces contrast.
fn light(focus: Option<Focus>) -> Light {
    Light { haze_m: 1e9, focus, ..north_west() }
}

fn about_place(place_m: DVec2, strength: f64) -> Focus {
    SceneFocus { place_m, height_m: None, radius_m: RADIUS_M, strength }.focus()
}

/// Returns a style of one dark grey without paper grain, whose ink is the remaining contrast.
fn grey() -> Style {
    let text = "name = \"grey\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\nlightest = 0\n";
    Style::parse("grey", text).unwrap()
}

/// A picture: the darkness of each pixel relative to paper, and the world position of the land in it.
struct Drawn {
    pose: Pose,
    ink: Vec<f64>,
    places_m: Vec<Option<DVec3>>,
}

fn drawn(world: &mut World, style: &Style, focus: Option<Focus>) -> Drawn {
    drawn_in(world, style, focus, SIZE_PX)
}

fn drawn_in(world: &mut World, style: &Style, focus: Option<Focus>, size_px: [u32; 2]) -> Drawn {
    let pose = world.pose(CAMERA);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, size_px), style, &light(focus));
    let paper = style.paper.color.linear();
    let ink = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
    let ink = ink.iter().map(|texel| (0..3).map(|i| 1.0 - texel[i] / f64::from(paper[i])).sum::<f64>() / 3.0).collect();
    Drawn { pose, ink, places_m: places_m(&world.gpu, &renderer, pose.position_m) }
}

/// Returns the largest difference between the drawn contrast and that of `rule`.
fn farthest(world: &mut World, focus: Focus, rule: Focus) -> f64 {
    let (style, pose) = (grey(), world.pose(CAMERA));
    let drawn = drawn(world, &style, Some(focus));
    let view = still(pose, SIZE_PX).uniform(pose.position_m);
    let rule = rule.seen_from(pose.position_m, |flat_m| flat_m);
    let pixels = drawn.ink.iter().zip(&drawn.places_m).enumerate();
    let errors = pixels.filter_map(|(i, (ink, place_m))| {
        let at_m = ((*place_m)? - drawn.pose.position_m).as_vec3().to_array();
        let px = [(i as u32 % SIZE_PX[0]) as f32 + 0.5, (i as u32 / SIZE_PX[0]) as f32 + 0.5];
        Some((f64::from(rule.left(&view, at_m, px)) - ink).abs())
    });
    let errors: Vec<f64> = errors.collect();
    assert!(errors.len() > 20_000, "{}", errors.len());
    errors.into_iter().fold(0.0, f64::max)
}

#[test]
fn contrast_is_what_the_rule_says_at_each_pixel() {
    let Some(mut world) = world() else { return };
    let distance = Focus { about: FocusAbout::Distance { distance_m: 10_000.0 }, extent: 1500.0, strength: STRENGTH };
    let sheet = Focus { about: FocusAbout::Picture { at: DVec2::new(0.3, 0.7) }, extent: 0.2, strength: STRENGTH };
    let high = SceneFocus { place_m: PLACE_M, height_m: Some(900.0), radius_m: 800.0, strength: STRENGTH }.focus();
    for focus in [about_place(PLACE_M, STRENGTH), distance, sheet, high] {
        let error = farthest(&mut world, focus, focus);
        println!("{:?}: largest error of the contrast {error:.4}", focus.about);
        assert!(error < 0.003, "largest error of the contrast {error}, expected less than 0.003");
        // Planted errors: another extent, and another strength.
        assert!(farthest(&mut world, focus, Focus { extent: 1.1 * focus.extent, ..focus }) > 0.02);
        assert!(farthest(&mut world, focus, Focus { strength: 0.7, ..focus }) > 0.02);
    }
}

/// Returns the fraction of pixels in the focus that differ from the picture without it, and the fraction of ink that
/// remains far away.
fn judged(without: &Drawn, with: &Drawn, place_m: DVec2) -> [f64; 2] {
    let (mut differ, mut inside, mut ink) = (0_usize, 0_usize, [0.0; 2]);
    for (i, at_m) in without.places_m.iter().enumerate() {
        let Some(at_m) = at_m else { continue };
        let off_m = at_m.truncate().distance(place_m);
        // Washes that run, and cells in which ink is balanced, reach over the rim.
        if off_m < 0.5 * RADIUS_M {
            inside += 1;
            differ += usize::from((without.ink[i] - with.ink[i]).abs() > 0.02);
        }
        if off_m > 3.5 * RADIUS_M {
            ink[0] += without.ink[i];
            ink[1] += with.ink[i];
        }
    }
    assert!(inside > 500 && ink[0] > 50.0, "{inside} {ink:?}");
    [differ as f64 / inside as f64, ink[1] / ink[0]]
}

#[test]
fn lines_marks_and_washes_keep_their_contrast_in_the_focus_and_lose_it_elsewhere() {
    let Some(mut world) = world() else { return };
    let names = ["lsa", "crosshatch", "strokes", "wash", "hachures", "stipple", "cartoon"];
    for name in names.into_iter().take(if common::full() { 7 } else { 2 }) {
        // Terraces of this land are as level as lakes.
        let style = common::absolute(name).without(&["water"]);
        let without = drawn(&mut world, &style, None);
        let with = drawn(&mut world, &style, Some(about_place(PLACE_M, STRENGTH)));
        let [differ, left] = judged(&without, &with, PLACE_M);
        println!("{name:11} {:.2} % of the focus differs; {left:.2} of the ink remains far away", 100.0 * differ);
        // Lines one pixel wide lose more than others; marks are fewer, and balanced to the ink that the land can hold.
        let is_held = |[differ, left]: [f64; 2]| differ < 0.03 && (0.08..0.32).contains(&left);
        assert!(
            is_held([differ, left]),
            "{name}: fraction of the focus that differs {differ}, ink that remains far away {left}"
        );
        // Planted errors: a focus elsewhere, and one that is too weak.
        let elsewhere = drawn(&mut world, &style, Some(about_place(PLACE_M + DVec2::new(-5000.0, -3000.0), STRENGTH)));
        assert!(!is_held(judged(&without, &elsewhere, PLACE_M)), "{name}: a focus elsewhere passes");
        let weak = drawn(&mut world, &style, Some(about_place(PLACE_M, 0.4)));
        assert!(!is_held(judged(&without, &weak, PLACE_M)), "{name}: a weak focus passes");
    }
}

#[test]
fn a_focus_that_takes_nothing_changes_no_bit() {
    let Some(mut world) = World::new(grid_of(385, 385, 60.0, rough_height_m), 1.0) else { return };
    let size_px = if common::full() { SIZE_PX } else { [128, 80] };
    // In the fast tier one style for each pass that reads the focus: detected lines, strokes with marks, and relief.
    let names = if common::full() { common::presets() } else { vec!["lsa", "crosshatch", "relief"] };
    for name in names {
        let style = common::preset(name);
        let mut bits = |focus: Option<Focus>| {
            let drawn = drawn_in(&mut world, &style, focus, size_px);
            drawn.ink.iter().map(|ink| ink.to_bits()).collect::<Vec<_>>()
        };
        let without = bits(None);
        assert!(without == bits(Some(about_place(PLACE_M, 0.0))), "{name}: a focus of strength 0 changes the picture");
        // Planted error: a focus with a little strength.
        assert!(without != bits(Some(about_place(PLACE_M, 0.1))), "{name}: a focus of strength 0.1 changes nothing");
    }
}

#[test]
fn a_style_may_have_a_focus_and_a_scene_comes_before_it() {
    let Some(mut world) = world() else { return };
    let mut style = grey();
    style.focus = Some(
        Style::parse("focus", "name = \"\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n[focus]\nradius = 0.1\n")
            .unwrap()
            .focus
            .unwrap(),
    );
    let by_style = drawn(&mut world, &style, None);
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let ink = |drawn: &Drawn, across: f64, down: f64| {
        drawn.ink[(down * height as f64) as usize * width + (across * width as f64) as usize]
    };
    assert!((ink(&by_style, 0.5, 0.6) - 1.0).abs() < 1e-3, "{}", ink(&by_style, 0.5, 0.6));
    assert!((ink(&by_style, 0.05, 0.95) - 0.3).abs() < 0.01, "{}", ink(&by_style, 0.05, 0.95));
    let everywhere = SceneFocus { place_m: PLACE_M, height_m: None, radius_m: 1e6, strength: 1.0 };
    let scene = Scene { focus: Some(everywhere), ..Scene::default() };
    let by_scene = drawn(&mut world, &style, scene.light([1e4; 2]).focus);
    assert!((ink(&by_scene, 0.05, 0.95) - 1.0).abs() < 1e-3, "the scene's focus must replace that of the style");
    // A map has no distance from an eye, so a focus at a distance is dropped.
    let far = style::Focus { distance_m: Some(5000.0), ..style.focus.clone().unwrap() };
    assert_eq!(Style { focus: Some(far), ..style.clone() }.for_map(10.0).unwrap().focus, None);
    assert!(style.for_map(10.0).unwrap().focus.is_some());
}

#[test]
fn scenes_name_a_place() {
    let scene = |focus: &str| {
        Scene::parse("focus.toml".as_ref(), &format!("[world]\nprocedural = {{ seed = 1 }}\n[focus]\n{focus}"))
    };
    let focus = scene("place = [1200, -300, 900]\nradius_m = 2000\n").unwrap().focus.unwrap();
    assert_eq!((focus.place_m, focus.height_m), (DVec2::new(1200.0, -300.0), Some(900.0)));
    assert_eq!((focus.radius_m, focus.strength), (2000.0, scene::focus::STRENGTH));
    for (wrong, key) in [
        ("place = [1]\nradius_m = 5\n", "focus.place"),
        ("place = [1, nan]\nradius_m = 5\n", "focus.place"),
        ("place = [1, 2]\nradius_m = 0\n", "focus.radius_m"),
        ("place = [1, 2]\nradius_m = 5\nstrength = 1.5\n", "focus.strength"),
    ] {
        let error = scene(wrong).unwrap_err();
        assert!(matches!(error, SceneError::Toml(_)));
        assert!(error.to_string().contains(key) && error.to_string().starts_with("focus.toml:"), "{error}");
    }
}
