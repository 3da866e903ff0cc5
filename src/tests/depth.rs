//! Distance reduces ink, in every preset with tone.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, halves, places_m, still};
use common::{World, full, grid_of, quantile, rough_height_m};
use hachure::composite::PICTURE;
use hachure::frame::{Light, Renderer};
use hachure::scene::{Haze, Scene};
use hachure::style::Style;

const SPACING_M: f64 = 60.0;
const SAMPLES: u32 = 1025;

/// Returns how much darker than paper the nearest and the farthest third of the land are, by distance. In the fast tier
/// the picture is half as wide, at the same scale.
fn darkness(world: &mut World, renderer: &mut Renderer, style: &Style, light: &Light) -> [f64; 2] {
    let pose = world.pose("0,-22000,+1200,4,-7,50");
    let (size_px, least) = if full() { ([480, 270], 1000) } else { ([240, 270], 500) };
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, size_px), style, light);
    let paper = f64::from(style.paper.color.linear()[1]);
    let picture = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
    let land: Vec<(f64, f64)> = places_m(&world.gpu, renderer, pose.position_m)
        .iter()
        .zip(picture)
        .filter_map(|(place, texel)| Some(((*place)?.distance(pose.position_m), 1.0 - texel[1] / paper)))
        .collect();
    let mut distances: Vec<f64> = land.iter().map(|(distance, _)| *distance).collect();
    let [near, far] = [quantile(&mut distances, 0.01), quantile(&mut distances, 0.99)];
    let third = (far - near) / 3.0;
    let mean = |from: f64, to: f64| {
        let inks: Vec<f64> =
            land.iter().filter(|(distance, _)| (from..to).contains(distance)).map(|(_, ink)| *ink).collect();
        assert!(inks.len() > least, "{}", inks.len());
        inks.iter().sum::<f64>() / inks.len() as f64
    };
    [mean(near, near + third), mean(far - third, far)]
}

#[test]
fn the_far_third_has_less_ink_than_the_near_one() {
    let Some(mut world) = World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, rough_height_m), 1.0) else { return };
    let extent_m = [f64::from(SAMPLES - 1) * SPACING_M; 2];
    let light = Scene::default().light(extent_m);
    // Planted error: a world without haze.
    let clear = Light { haze_m: 1e9, ..light };
    let mut failed = Vec::new();
    // In the fast tier one preset each with hatching, cut lines and rows.
    let names = if full() { common::presets() } else { vec!["crosshatch", "engraving", "hachures"] };
    for name in names {
        // Terraces of this land are as level as lakes, and their shores are not marks.
        let style = Style::load(name).unwrap().without(&["water"]);
        // Styles of lines alone draw hardly anything on near faces and more far away, so they are not tested.
        if style.hatching().is_none() && !style.has_land_lines() {
            continue;
        }
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let [near, far] = darkness(&mut world, &mut renderer, &style, &light);
        let part = far / near;
        // In the fast tier the planted error is that of one preset.
        let clear_part = (full() || name == "crosshatch").then(|| {
            let [near, far] = darkness(&mut world, &mut renderer, &style, &clear);
            far / near
        });
        println!("{name:12} near {near:.3}, far {far:.3}: {part:.2}; without haze {clear_part:.2?}");
        // The aim is 0.5. The rest is contours: this land has ridges one behind the other to its edge. Rows of hachures
        // have more: on land that is folded at every sample, they draw more far away than near. Rock drawing is for
        // steep land, of which this picture has hardly any near the camera.
        let most = match name {
            "rock" => 2.0,
            _ if style.rows().is_some() => 0.85,
            // The foreground recedes, and dots are few where it is light.
            "stipple" => 0.82,
            _ => 0.68,
        };
        if part > most || clear_part.is_some_and(|clear_part| clear_part < 1.5 * part) {
            failed.push(name);
        }
    }
    assert!(failed.is_empty(), "presets in which haze does not reduce the ink of the far third enough: {failed:?}");
}

/// The distance of haze grows with the extent of the world, up to a limit, so that large worlds have haze too.
#[test]
fn air_is_clear_for_thirty_kilometres_at_most() {
    let haze = Haze::default();
    assert_eq!(haze.distance_over_m([3000.0, 4000.0]), 2250.0);
    assert_eq!(haze.distance_over_m([1e6, 1e6]), 30_000.0);
}
