//! Forests, maps, the sea and panoramas at the ends of their ranges.

use glam::DVec2;
use hachure::scene::Forest;
use hachure::scene::Wind;
use hachure::scene::forest::{Form, Species};
use hachure::scene::map::{Map, MapArea};
use hachure::style::{Panorama, Style};

use super::checked::{Checked, SIZE_PX};
use super::lands::{EXTREME, Land, ORDINARY, SPACING_M};
use super::views::{kinds, suns};
use crate::tests::common::draw::north_west;
use crate::tests::common::full;
use crate::tests::helpers::forest;

/// Forests at the ends of their ranges, each with a wind.
fn forests() -> Vec<(&'static str, Forest, Option<Wind>)> {
    let mixed = |trees_per_ha, height_m| Forest {
        species: Species::mixed(height_m),
        ..forest::of(Form::Conifer, trees_per_ha, height_m)
    };
    let wind = |speed_m_s| Some(Wind { speed_m_s, from_deg: 250.0 });
    vec![
        ("a dense forest", mixed(Forest::MAX_TREES_PER_HA, 20.0), wind(Wind::FASTEST_M_S)),
        ("trees of 1 km", mixed(5.0, 1000.0), wind(5.0)),
        ("trees of 1 cm", mixed(Forest::MAX_TREES_PER_HA, 0.01), wind(0.0)),
        ("no trees", mixed(0.0, 20.0), None),
    ]
}

#[test]
fn forests_are_finite() {
    let Some(mut land) = Land::of_spacing(SPACING_M) else { return };
    let names: &[&str] =
        if full() { &["plain", "pencil", "strokes", "lsa", "wash", "relief", "stipple"] } else { &["plain"] };
    let styles: Vec<Style> = names.iter().map(|name| Style::load(name).unwrap()).collect();
    let views: Vec<_> = [&ORDINARY].into_iter().chain(&EXTREME).map(|camera| (camera, land.pose(camera))).collect();
    let most = if full() { views.len() } else { 2 };
    land.world.surfaces.set_forest(None);
    let mut checked = Checked::new(land.world);
    for (name, forest, wind) in forests().into_iter().take(if full() { 4 } else { 1 }) {
        checked.world.surfaces.set_forest(Some(forest));
        checked.world.surfaces.set_wind(wind);
        for style in &styles {
            for (camera, pose) in &views[..most] {
                let name = format!("{}, {name}, {}", style.name, camera.name);
                checked.case(&name, *pose, SIZE_PX, style, &north_west());
            }
            for (sun, light) in suns().into_iter().filter(|_| full()) {
                checked.case(&format!("{}, {name}, {sun}", style.name), views[0].1, SIZE_PX, style, &light);
            }
            checked.case(&format!("{}, {name}, one pixel", style.name), views[0].1, [1, 1], style, &north_west());
        }
    }
    checked.finish("forests");
}

#[test]
fn maps_are_finite() {
    let mut lands = vec![Land::of_spacing(0.001)];
    if full() {
        lands.extend([Land::of_spacing(SPACING_M), Land::of_spacing(10_000.0), Land::far()]);
    }
    for land in lands {
        let Some(land) = land else { return };
        let range_m = land.world.surfaces.terrain.range_m().map(f64::from);
        let (middle_m, factor) = (land.middle_m, land.factor);
        let mut checked = Checked::new(land.world);
        let is_drawn = |style: &Style| full() || ["wash", "relief"].contains(&style.name.as_str());
        for style in kinds().into_iter().filter(is_drawn) {
            let widths_m = [6000.0 * factor, 0.001, 1e8, 1.0];
            for width_m in widths_m.into_iter().take(if full() { 4 } else { 2 }) {
                for size_px in [SIZE_PX, [1, 1]] {
                    // Of one pixel, only the ordinary one.
                    if size_px == [1, 1] && width_m != 6000.0 * factor {
                        continue;
                    }
                    let area = MapArea::Around { centre_m: middle_m + DVec2::new(3.1, -7.3) * factor, width_m };
                    let map = Map::new(area, [middle_m; 2], size_px);
                    let name = format!("{}, {}, a map of {width_m} m, {size_px:?} px", style.name, land.name);
                    checked.case(&name, map.pose(range_m), size_px, &style, &north_west());
                }
            }
        }
        checked.finish(&format!("maps, {}", land.name));
    }
}

#[test]
fn panoramas_and_seas_are_finite() {
    let Some(land) = Land::of_spacing(SPACING_M) else { return };
    let views: Vec<_> = [&ORDINARY].into_iter().chain(&EXTREME).map(|camera| (camera, land.pose(camera))).collect();
    let mut checked = Checked::new(land.world);
    // The fast tier has only the lens of 150 degrees.
    let views = if full() { &views[..] } else { &views[2..3] };
    for horizon_deg in [0.001, 30.0, 60.0].into_iter().filter(|horizon_deg| full() || *horizon_deg != 30.0) {
        let style = Style { panorama: Panorama { horizon_deg }, ..Style::load("panorama").unwrap() };
        for (camera, pose) in views {
            let name = format!("a horizon {horizon_deg} degrees down, {}", camera.name);
            checked.case(&name, *pose, SIZE_PX, &style, &north_west());
        }
    }
    let style = Style::load("wash").unwrap();
    for sea_level_m in [-12_000.0, 400.0, 9000.0].into_iter().skip(usize::from(!full())) {
        checked.world.surfaces.set_sea_level(Some(sea_level_m));
        for (camera, pose) in views {
            let name = format!("the sea at {sea_level_m} m, {}", camera.name);
            checked.case(&name, *pose, SIZE_PX, &style, &north_west());
        }
    }
    checked.finish("panoramas and seas");
}
