//! Tests the gallery without a window: what it shows, and what clicks do.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

use std::sync::Arc;
use std::time::Instant;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::thumbnails::{Scene, Textures, Thumbnails};
use super::{Choice, Gallery, families};
use crate::gpu::target::Group;
use crate::gpu::{Gpu, Target};
use crate::internals::read;
use crate::studio::favourites::{COUNT, Favourites};
use crate::style::families::Family;
use crate::style::names;
use crate::tests::common::draw::north_west;
use crate::tests::common::{World, full, grid_of, rough_height_m};
use crate::tiles::terrain::{Loading, Terrain, TerrainOptions};
use crate::window::screen_reader::tests::{focusable, repeated, unnamed};
use crate::window::settings::Styles;

struct Bench {
    gallery: Gallery,
    styles: Styles,
    favourites: Favourites,
    thumbnails: Thumbnails,
    choices: Vec<Choice>,
}

fn open() -> Harness<'static, Bench> {
    let (styles, present) = Styles::with("ink").unwrap();
    let gallery = Gallery { is_open: true, ..Gallery::default() };
    let favourites = Favourites::of_nobody();
    let bench = Bench { gallery, styles, favourites, thumbnails: Thumbnails::default(), choices: Vec::new() };
    let harness = Harness::builder().with_size(egui::vec2(900.0, 1400.0)).with_max_steps(40);
    let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
        move |ui, bench: &mut Bench| {
            let Bench { gallery, styles, favourites, thumbnails, choices } = bench;
            choices.extend(gallery.show(ui.ctx(), styles, favourites, thumbnails, present));
        },
        bench,
    );
    harness.run();
    harness
}

fn place(harness: &Harness<'_, Bench>, name: &str) -> usize {
    harness.state().styles.place_of(name).unwrap()
}

#[test]
fn every_preset_has_a_cell_and_baselines_come_last() {
    let harness = open();
    let bottom = |name: &str| harness.get_by_label(&format!("Style {name}")).rect().top();
    let last = names().into_iter().filter(|name| Family::of(name) != Family::Baseline).map(bottom);
    let last = last.fold(0.0, f32::max);
    for name in ["plain", "sobel", "roystan"] {
        assert!(bottom(name) > last, "{name} at {}, others to {last}", bottom(name));
    }
    let order: Vec<Family> = families(&harness.state().styles).into_iter().map(|(family, _)| family).collect();
    assert_eq!(order, [Family::Line, Family::Hatching, Family::Map, Family::Color, Family::Baseline]);
    // Planted: a style that does not exist has no cell.
    assert!(harness.query_by_label("Style no such").is_none());
}

#[test]
fn a_click_chooses_and_a_menu_sets_favourites() {
    let mut harness = open();
    harness.get_by_label("Style wash").click();
    harness.run();
    assert_eq!(harness.state().choices, [Choice::Style(place(&harness, "wash"))]);
    assert_eq!(harness.state().gallery.hovered(), Some(place(&harness, "wash")));
    harness.get_by_label("Style night").click_secondary();
    harness.run();
    harness.get_by_label("Favourite 3").click();
    harness.run();
    assert_eq!(harness.state().choices[1..], [Choice::Favourite(place(&harness, "night"), Some(2))]);
}

#[test]
fn every_widget_has_a_name_of_its_own() {
    let mut harness = open();
    let has_names = |harness: &Harness<'_, Bench>| {
        assert!(unnamed(harness).is_empty(), "{:?}", unnamed(harness));
        assert!(repeated(harness).is_empty(), "{:?}", repeated(harness));
        focusable(harness).len()
    };
    // The cells, the search, and the button that closes.
    assert_eq!(has_names(&harness), names().len() + 2);
    harness.get_by_label("Style night").click_secondary();
    harness.run();
    // The favourites of the menu, and none.
    assert_eq!(has_names(&harness), names().len() + 2 + COUNT + 1);
}

#[test]
fn a_search_finds_names_descriptions_and_families() {
    let cells = |harness: &Harness<'_, Bench>| -> Vec<&'static str> {
        names().into_iter().filter(|name| harness.query_by_label(&format!("Style {name}")).is_some()).collect()
    };
    let search = |words: &str| {
        let mut harness = open();
        assert_eq!(cells(&harness).len(), names().len());
        harness.get_by_label("Search styles").click();
        harness.run();
        harness.get_by_label("Search styles").type_text(words);
        harness.run();
        cells(&harness)
    };
    assert_eq!(search("HOKUSAI"), ["hokusai"], "a name");
    let baselines = search("baselines");
    assert!(baselines.len() == 7 && baselines.contains(&"roystan"), "a family: {baselines:?}");
    let style = crate::style::Style::load("wash").unwrap();
    assert!(search(&style.description).contains(&"wash"), "a description: {}", style.description);
    assert!(search("baselines hokusai").is_empty(), "all words must be found");
    // Planted: words that no style has.
    assert!(search("no such style").is_empty());
}

/// Counts the textures of a panel.
#[derive(Default)]
struct Counted {
    next: u64,
    registered: usize,
}

impl Textures for Counted {
    fn register(&mut self, _: &Gpu, _: &wgpu::TextureView) -> egui::TextureId {
        self.next += 1;
        self.registered += 1;
        egui::TextureId::User(self.next)
    }

    fn unregister(&mut self, _: egui::TextureId) {
        self.registered -= 1;
    }
}

/// Returns the bytes of a thumbnail.
fn bytes(gpu: &Gpu, texture: &wgpu::Texture) -> Vec<u8> {
    let target = Target::of_texture("thumbnail", Group::Whole.shows("A thumbnail"), texture.clone());
    read(gpu, &target, [0, 0], target.size_px()).unwrap()
}

#[test]
fn thumbnails_show_their_styles() {
    let Some(mut world) = World::new(grid_of(129, 129, 60.0, |x, y| 0.5 * rough_height_m(x, y)), 0.5) else { return };
    let (styles, _) = Styles::with("ink").unwrap();
    let mut scene =
        Scene { pose: world.pose("-1500,-3600,+450,20,-9,50"), light: north_west(), shown_px: [66.0, 40.0] };
    let order = if full() { ["ink", "wash", "night"] } else { ["strokes", "lsa", "relief"] };
    let order = order.map(|name| styles.place_of(name).unwrap());
    let (mut thumbnails, mut panel) = (Thumbnails::default(), Counted::default());
    let mut fill = |thumbnails: &mut Thumbnails, panel: &mut Counted, scene: Scene| {
        let begun = Instant::now();
        thumbnails.wake(begun);
        while thumbnails.next_at().is_some() {
            thumbnails.work(&world.gpu, &mut world.surfaces, panel, scene, styles.list(), &order).unwrap();
            world.gpu.check().unwrap();
            assert!(begun.elapsed().as_secs() < 120, "thumbnails take too long");
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        order.map(|style| bytes(&world.gpu, thumbnails.texture(style).unwrap()))
    };
    let drawn = fill(&mut thumbnails, &mut panel, scene);
    assert_eq!(panel.registered, 3);
    for (number, picture) in drawn.iter().enumerate() {
        assert_eq!(picture.len(), 4 * 132 * 80);
        let darkest = picture.chunks_exact(4).map(|texel| texel[1]).min().unwrap();
        let brightest = picture.chunks_exact(4).map(|texel| texel[1]).max().unwrap();
        assert!(brightest > darkest + 60, "style {number}: {darkest} to {brightest}");
        assert!(drawn.iter().filter(|other| *other == picture).count() == 1);
    }
    // Nothing is drawn again until something changes, and then the old textures are released.
    let again = fill(&mut thumbnails, &mut panel, scene);
    assert!(again == drawn && panel.next == 3);
    scene.light.to_sun.x = -scene.light.to_sun.x;
    let other = fill(&mut thumbnails, &mut panel, scene);
    assert!(other.iter().zip(&drawn).all(|(other, drawn)| other != drawn));
    assert_eq!((panel.registered, panel.next), (3, 6));
}

/// Draws thumbnails of a style until none is out of date, and returns its bytes.
fn thumbnail(world: &mut World, thumbnails: &mut Thumbnails, scene: Scene, name: &str) -> Vec<u8> {
    let (styles, style) = Styles::with(name).unwrap();
    let begun = Instant::now();
    thumbnails.wake(begun);
    while thumbnails.next_at().is_some() {
        let panel = &mut Counted::default();
        thumbnails.work(&world.gpu, &mut world.surfaces, panel, scene, styles.list(), &[style]).unwrap();
        assert!(begun.elapsed().as_secs() < 120, "the thumbnail takes too long");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    bytes(&world.gpu, thumbnails.texture(style).unwrap())
}

/// A window builds blocks of hachures, and maps of water and shadows, over several frames, and draws nothing while
/// pipelines are built. The first thumbnail must not lack any of them.
#[test]
fn a_first_thumbnail_is_whole() {
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, |x, y| 0.5 * rough_height_m(x, y)), 0.5) else { return };
    let pose = world.pose("-1500,-6600,+900,20,-12,50");
    let shown_px = if full() { [132.0, 80.0] } else { [66.0, 40.0] };
    let scene = Scene { pose, light: north_west(), shown_px };
    let store = Arc::clone(world.surfaces.terrain.store());
    let mut open = |loading| {
        let options = TerrainOptions { lod_error_px: 0.5, loading, ..TerrainOptions::default() };
        world.surfaces = Terrain::new(&world.gpu, Arc::clone(&store), options).unwrap().into();
        let mut thumbnails = Thumbnails::default();
        let first = thumbnail(&mut world, &mut thumbnails, scene, "hachures");
        if loading == Loading::Wait && !full() {
            return first;
        }
        // Another sun and back: everything that the view needs has been built.
        let mut other = scene;
        other.light.to_sun.x = -other.light.to_sun.x;
        assert!(thumbnail(&mut world, &mut thumbnails, other, "hachures") != first, "the sun has moved");
        let again = thumbnail(&mut world, &mut thumbnails, scene, "hachures");
        let different = first.iter().zip(&again).filter(|(first, again)| first != again).count();
        assert_eq!(different, 0, "{loading:?}: bytes of the first thumbnail and of a later one");
        first
    };
    assert!(open(Loading::Stream) == open(Loading::Wait), "a window's thumbnail and that of a file");
}
