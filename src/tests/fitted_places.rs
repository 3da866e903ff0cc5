//! Each preset whose tones are fitted has its shares of paper and of darks on real land that no preset was made for.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, floats, halves, places, still};
use common::{full, gpu, quantile, real_data};
use hachure::frame::{Light, Renderer};
use hachure::scene::tone_curve::ToneCurve;
use hachure::style::{self, Style, Tone, Toon};
use hachure::surface::water::WATER;
use hachure::tiles::terrain::TerrainOptions;
use hachure::tones::TONE;
use hachure::world::OpenWorld;

/// Land of every kind, and a word for it.
const PLACES: [(&str, &str); 10] = [
    ("gentle", "dem/geotiff/zh_dem_25.tif"),
    ("steep", "dem/geotiff/mt_everest_90m.tif"),
    ("coast", "dem/geotiff/N49W124.tif"),
    ("volcano", "dem/usgsdem/SainteHelens.dem"),
    ("plateau", "dem/geotiff/ds_glo_merged.tif"),
    ("canyon", "dem/asc/ll_SRTMGL3_front_range.asc"),
    ("glacier", "dem/geotiff/dem_south_pole.tif"),
    ("hills with forest", "dem/asc/spearfish_dem.asc"),
    ("island", "dem/geotiff/riorgbify_elev.tif"),
    ("badlands", "dem/geotiff/ds_los_angeles_tile_0.tif"),
];
const SIZE_PX: [u32; 2] = [640, 400];
/// How far shares may differ: a sixteenth of the pixels is counted.
const TOLERANCE: f64 = 0.04;
/// How much further those of a style with planes may differ: steps end at ridges, and small masses are merged.
const PLANES: f64 = 0.16;
/// Least difference of the tones at a twentieth of the land from each end. Where tones differ less, all of the land is in
/// one or two bins of the counts, and shares mean nothing.
const LEAST_RANGE: f64 = 0.1;
/// Width of a bin of the counts of tones.
const BIN: f32 = 1.0 / 64.0;

/// Measurements of a picture.
struct Measured {
    /// Shares of the land that are dark and paper: of stepped tones those below the second step and those on the last one
    /// (a soft step changes before its end), of smooth tones those that the decision on fitted tones names.
    shares: [f64; 2],
    /// Tone of nineteen twentieths of the land, less that of one.
    range: f64,
    curve: ToneCurve,
}

/// Returns the shares of the tones, between the darkest and the lightest of the style.
fn shares(tones: &[f64], toon: &Toon) -> [f64; 2] {
    let part = |tone: f64| (tone - f64::from(toon.darkest)) / f64::from(toon.lightest - toon.darkest).max(1e-6);
    let (dark, white) = match toon.steps {
        0 => (0.25, 0.97),
        steps => (1.0 / f64::from(steps - 1) - 0.01, 0.99),
    };
    let share = |is_wanted: &dyn Fn(f64) -> bool| {
        tones.iter().filter(|tone| is_wanted(part(**tone))).count() as f64 / tones.len() as f64
    };
    [share(&|part| part < dark), share(&|part| part > white)]
}

/// Returns whether the shares are those of the style. On land whose light hardly varies there may be fewer darks and more
/// paper, since light is spread by a bounded factor; where more of the land than the share is in full light or in full
/// shade, all of that is paper or dark, as far as soft steps leave it.
fn fits(measured: &Measured, toon: &Toon, has_planes: bool) -> bool {
    let tolerance = TOLERANCE + if has_planes { PLANES } else { 0.0 };
    let [dark, white] = measured.shares;
    let [dark_share, white_share] = [toon.dark_share, toon.white_share].map(f64::from);
    // The two tones are at 0.25 and 0.97, or at the inner ends of the first and the last step.
    let span = match toon.steps {
        0 => 0.72,
        2 => 0.5,
        steps => 1.0 - 2.0 / steps as f32,
    };
    let is_spread_most = measured.curve.white - measured.curve.dark < span / 2.5 * 1.05;
    let is_in_full_light = measured.curve.white > 1.0 - BIN;
    let is_in_full_shade = measured.curve.dark < BIN;
    let is_dark =
        is_in_full_shade || dark < dark_share + tolerance && (is_spread_most || dark > dark_share - tolerance);
    // Steps show a bin of the counts as a whole.
    let may_be_darker = is_spread_most && toon.steps > 0;
    let may_be_lighter = is_in_full_light || is_spread_most;
    is_dark && (may_be_darker || white > white_share - tolerance) && (may_be_lighter || white < white_share + tolerance)
}

#[test]
fn presets_have_their_shares_on_unseen_land() {
    let Some(gpu) = gpu() else { return };
    let wanted = if full() { &PLACES[..] } else { &PLACES[..1] };
    let names = if full() { style::names() } else { vec!["crosshatch", "hokusai"] };
    let (mut count, mut level, mut strange) = (0, 0, Vec::new());
    for (place, file) in wanted {
        let Some(path) = real_data(file) else { continue };
        let mut world = OpenWorld::open(&gpu, path.to_str(), TerrainOptions::default()).unwrap();
        let pose = world.pose(&world.start_camera(1.6));
        for name in &names {
            let mut style = Style::load(name).unwrap();
            let Tone::Toon(toon) = &mut style.tone else { continue };
            if !toon.fit {
                continue;
            }
            // The shares are those of the picture before near land recedes and far land is in haze.
            toon.recede = 0.0;
            let toon = toon.clone();
            style.haze.faintest_tone = 1.0;
            style = style.without_layers(|key| !key.starts_with("water"));
            let light = Light { haze_m: 1e12, ..world.light() };
            let mut drawn = |curve: Option<ToneCurve>| {
                let mut renderer = Renderer::new(&gpu).unwrap();
                renderer.set_tone_curve(curve);
                draw(&gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &light);
                let tones = halves(&gpu, renderer.target(&TONE).unwrap());
                let places = places(&gpu, &renderer, 0);
                let water = renderer.target(&WATER).map(|water| floats::<1>(&gpu, water));
                let is_land =
                    |pixel: usize| places[pixel][3] > 0.0 && water.as_ref().is_none_or(|water| water[pixel][0] <= 0.0);
                let of_land = tones.iter().enumerate().filter(|(pixel, _)| is_land(*pixel));
                let mut tones: Vec<f64> = of_land.map(|(_, texel)| texel[3]).collect();
                let range = quantile(&mut tones, 0.95) - quantile(&mut tones, 0.05);
                Measured { shares: shares(&tones, &toon), range, curve: renderer.tone_curve(&gpu).unwrap().unwrap() }
            };
            let measured = drawn(None);
            let has_planes = style.light.planes_px > 0.0;
            let line = format!(
                "{place} {name}: {:.3?} of the land is dark and paper, asked {:.2?}; {:.3?}",
                measured.shares,
                [toon.dark_share, toon.white_share],
                [measured.curve.dark, measured.curve.white]
            );
            println!("{line}");
            if measured.range < LEAST_RANGE {
                level += 1;
                continue;
            }
            count += 1;
            if !fits(&measured, &toon, has_planes) {
                strange.push(line);
            }
            // Planted: another curve.
            let by = if has_planes { 0.3 } else { 0.15 };
            let darker =
                ToneCurve { dark: measured.curve.dark + by, white: measured.curve.white + by, ..measured.curve };
            assert!(!fits(&drawn(Some(darker)), &toon, has_planes), "{place} {name}: darker");
        }
    }
    // Without the real data there is nothing to measure.
    if count + level == 0 {
        return;
    }
    println!("{} of {count} have other shares: {strange:#?}; {level} are of one tone", strange.len());
    assert!(strange.is_empty() && count > level);
}
