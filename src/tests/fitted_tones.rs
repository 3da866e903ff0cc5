//! Tests tones that are fitted to the picture: the shares of paper and of darks are those of the style, on gentle and
//! on steep land, water does not count, near land is lighter as the rule says, parts join, and a flight changes tones
//! slowly.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{draw, halves, north_west, places_m, still, tones_in_parts};
use common::{World, full, grid_of, rough_height_m};
use hachure::frame::{Light, Renderer};
use hachure::picture::{self, PartRule, PictureRequest};
use hachure::scene::tone_curve::ToneCurve;
use hachure::scene::view::{Rig, View};
use hachure::style::Style;
use hachure::tones::TONE;

const SIZE_PX: [u32; 2] = [320, 200];
const VIEW: &str = "0,-9000,+2500,0,-14,55";
/// A view with near land.
const NEAR: &str = "0,-9000,+150,0,-9,60";

/// Returns a style of smooth grey tones without haze, with more keys of `[tone]` and more sections.
fn grey(tone: &str, more: &str) -> Style {
    let text = format!(
        "name = \"grey\"\ndescription = \"\"\n{more}\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\n{tone}\n\
         [haze]\nfaintest_tone = 1.0\n"
    );
    Style::parse("grey", &text).unwrap()
}

fn light() -> Light {
    Light { haze_m: 1e12, ..north_west() }
}

/// Opens land whose heights are `relief` times those of mountains.
fn land(relief: f64) -> Option<World> {
    World::new(grid_of(513, 513, 60.0, move |x_m, y_m| relief * rough_height_m(x_m, y_m)), 1.0)
}

/// A pixel that shows land.
struct Pixel {
    tone: f64,
    /// Linear colour before haze.
    color: [f64; 3],
    distance_m: f64,
    height_m: f64,
}

/// Draws the view, with a given curve or with a measured one. Returns the pixels with land, and the curve.
fn drawn(world: &mut World, style: &Style, curve: Option<ToneCurve>) -> (Vec<Pixel>, Option<ToneCurve>) {
    drawn_from(world, VIEW, style, curve)
}

/// Does the same as [`drawn`] from another camera.
fn drawn_from(
    world: &mut World,
    camera: &str,
    style: &Style,
    curve: Option<ToneCurve>,
) -> (Vec<Pixel>, Option<ToneCurve>) {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_tone_curve(curve);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), style, &light());
    let tones = halves(&world.gpu, renderer.target(&TONE).unwrap());
    let places_m = places_m(&world.gpu, &renderer, pose.position_m);
    let pixels = tones.iter().zip(&places_m).filter_map(|(texel, place_m)| {
        let place_m = (*place_m)?;
        let distance_m = place_m.distance(pose.position_m);
        let color = [texel[0], texel[1], texel[2]];
        Some(Pixel { tone: texel[3], color, distance_m, height_m: place_m.z })
    });
    (pixels.collect(), renderer.tone_curve(&world.gpu).unwrap())
}

/// Returns the shares of the pixels that are dark and paper.
fn shares<'a>(pixels: impl IntoIterator<Item = &'a Pixel>) -> [f64; 2] {
    let (mut count, mut dark, mut white) = (0.0, 0.0, 0.0);
    for pixel in pixels {
        count += 1.0;
        dark += f64::from(u8::from(pixel.tone < 0.25));
        white += f64::from(u8::from(pixel.tone > 0.97));
    }
    assert!(count > 5000.0, "{count}");
    [dark / count, white / count]
}

/// Returns whether the shares are those of the style, within 0.035: a sixteenth of the pixels was measured.
fn fits(found: [f64; 2], wanted: [f64; 2]) -> bool {
    found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 0.035)
}

#[test]
fn paper_and_full_dark_have_the_shares_of_the_style() {
    for (relief, asked) in [(0.5, vec![[0.05, 0.25]]), (1.5, vec![[0.05, 0.25], [0.15, 0.3]])] {
        let Some(mut world) = land(relief) else { return };
        for [dark, white] in asked {
            let style = grey(&format!("fit = true\nrecede = 0\nwhite_share = {white}\ndark_share = {dark}"), "");
            let found = shares(&drawn(&mut world, &style, None).0);
            println!("relief {relief}: {found:.3?} of the land is dark and paper; asked {:?}", [dark, white]);
            assert!(fits(found, [dark, white]));
            // Planted: other shares, and tones that are not fitted.
            assert!(!fits(found, [dark + 0.05, white]) && !fits(found, [dark, white - 0.05]));
            assert!(!fits(shares(&drawn(&mut world, &grey("", ""), None).0), [dark, white]));
        }
    }
}

#[test]
fn light_that_hardly_varies_is_spread_a_little() {
    let Some(mut world) = land(0.01) else { return };
    let fitted = grey("fit = true\nrecede = 0", "");
    let (plain, _) = drawn(&mut world, &grey("", ""), None);
    let (spread, curve) = drawn(&mut world, &fitted, None);
    let curve = curve.unwrap();
    assert!((curve.white - curve.dark - 0.72 / 2.5).abs() < 1e-3, "{curve:?}");
    let by = |spread: &[Pixel], times: f64| {
        let of_range = |pair: &(&Pixel, &Pixel)| pair.1.tone > 0.01 && pair.1.tone < 0.99;
        let pairs: Vec<_> = plain.iter().zip(spread).filter(of_range).collect();
        assert!(pairs.len() > 3000, "{}", pairs.len());
        let expected = |tone: f64| (tone - f64::from(curve.white)) * times + 0.97;
        pairs.iter().map(|(plain, spread)| (spread.tone - expected(plain.tone)).abs()).fold(0.0, f64::max)
    };
    println!("the spread differs by {:.4} from two and a half times the light", by(&spread, 2.5));
    assert!(by(&spread, 2.5) < 0.005);
    // Planted: light that is spread more.
    let (too_far, _) = drawn(&mut world, &fitted, Some(ToneCurve { dark: curve.white - 0.1, ..curve }));
    assert!(by(&too_far, 2.5) > 0.02);
}

#[test]
fn near_land_is_lighter_as_the_rule_says() {
    let Some(mut world) = land(1.0) else { return };
    let (flat, curve) = drawn_from(&mut world, NEAR, &grey("fit = true\nrecede = 0", ""), None);
    let middle_m = f64::from(curve.unwrap().middle_m);
    let nearer = flat.iter().filter(|pixel| pixel.distance_m < middle_m).count() as f64 / flat.len() as f64;
    // The bins of distances are half an octave wide.
    assert!((nearer - 0.5).abs() < 0.05, "{nearer} of the land is nearer than the middle");
    let error = |receding: &[Pixel], recede: f64| {
        let pairs = flat.iter().zip(receding);
        let errors = pairs.map(|(flat, near)| {
            let left = 1.0 - recede * foreground_part(middle_m, flat.distance_m);
            (near.tone - (1.0 - (1.0 - flat.tone) * left)).abs()
        });
        errors.fold(0.0, f64::max)
    };
    let (receding, _) = drawn_from(&mut world, NEAR, &grey("fit = true\nrecede = 0.8", ""), None);
    println!("tones of near land differ by {:.4} from the rule", error(&receding, 0.8));
    assert!(error(&receding, 0.8) < 0.005);
    // Planted: less of the darkness is lost.
    let planted = error(&receding, 0.6);
    assert!(planted > 0.02, "{planted}");
}

/// Returns how much land at a distance is foreground, where half of the land in view is nearer than `middle_m`.
fn foreground_part(middle_m: f64, distance_m: f64) -> f64 {
    let t = (((middle_m / distance_m).log2() - 0.25) / 1.75).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[test]
fn near_land_is_tinted_as_the_rule_says() {
    let Some(mut world) = land(1.0) else { return };
    let keys = "fit = true\nrecede = 0\nlightest = 0.8";
    let (plain, curve) = drawn_from(&mut world, NEAR, &grey(keys, ""), None);
    let middle_m = f64::from(curve.unwrap().middle_m);
    let keys = format!("{keys}\nforeground_color = \"#0080ff\"\nforeground_tint = 0.5");
    let (tinted, _) = drawn_from(&mut world, NEAR, &grey(&keys, ""), None);
    let error = |ink: [f64; 3]| {
        let of = |(plain, tinted): (&Pixel, &Pixel)| {
            let part = 0.5 * foreground_part(middle_m, plain.distance_m);
            let off = |k: usize| (tinted.color[k] - plain.color[k] * (1.0 - part * (1.0 - ink[k]))).abs();
            // What hatching draws is unchanged.
            (0..3).map(off).fold((tinted.tone - plain.tone).abs(), f64::max)
        };
        plain.iter().zip(&tinted).map(of).fold(0.0, f64::max)
    };
    // Linear values of the colour.
    let ink = [0.0, 0.2159, 1.0];
    println!("colours of near land differ by {:.4} from the rule", error(ink));
    assert!(error(ink) < 0.005);
    // Planted: the colour before it is linear.
    let planted = error([0.0, 0.502, 1.0]);
    assert!(planted > 0.02, "{planted}");
}

#[test]
fn water_does_not_count() {
    let Some(mut world) = land(1.0) else { return };
    let (mut heights, _) = drawn(&mut world, &grey("", ""), None);
    heights.sort_by(|a, b| a.height_m.total_cmp(&b.height_m));
    let sea_m = heights[heights.len() / 2].height_m;
    // Level water, as in real data.
    let flooded = move |x_m: f64, y_m: f64| rough_height_m(x_m, y_m).max(sea_m);
    let Some(mut world) = World::new(grid_of(513, 513, 60.0, flooded), 1.0) else { return };
    let water = "[[layers]]\nkind = \"water\"\n";
    let of_land = |pixels: &[Pixel]| {
        let land: Vec<&Pixel> = pixels.iter().filter(|pixel| pixel.height_m > sea_m + 1.0).collect();
        let part = land.len() as f64 / pixels.len() as f64;
        assert!(part > 0.3 && part < 0.8, "{part} of the picture is land");
        shares(land)
    };
    let (pixels, _) = drawn(&mut world, &grey("fit = true\nrecede = 0", water), None);
    let found = of_land(&pixels);
    println!("{found:.3?} of the land above the sea is dark and paper");
    // Pixels on the shore may be either.
    let off = |found: [f64; 2]| (found[0] - 0.05).abs().max((found[1] - 0.25).abs());
    assert!(off(found) < 0.03);
    // Planted: water that counts as level land.
    let (pixels, _) = drawn(&mut world, &grey("fit = true\nrecede = 0", ""), None);
    let planted = off(of_land(&pixels));
    assert!(planted > 0.04, "{planted}");
}

#[test]
fn parts_have_one_curve() {
    let Some(mut world) = land(1.0) else { return };
    let mut picture = |parts: &PartRule, white: f64| {
        let style = grey(&format!("fit = true\nwhite_share = {white}"), "");
        let still = PictureRequest::still(world.pose(VIEW), SIZE_PX, &style, light());
        tones_in_parts(&mut world, still, parts)
    };
    let whole = picture(&PartRule { whole_px: u64::MAX, part_px: 2048, margin_px: 12 }, 0.25);
    let difference = |tone: &[f32]| {
        let differ = whole.iter().zip(tone).filter(|(a, b)| (*a - *b).abs() > 0.005).count();
        differ as f64 / whole.len() as f64
    };
    let in_parts = PartRule { whole_px: 0, part_px: 100, margin_px: 12 };
    let found = difference(&picture(&in_parts, 0.25));
    println!("{found:.4} of the pixels differ in parts");
    assert!(found < 0.002);
    // Planted: a curve that is a little different.
    let planted = difference(&picture(&in_parts, 0.4));
    assert!(planted > 0.2, "{planted}");
}

#[test]
fn a_picture_that_fails_leaves_no_curve_behind() {
    let Some(mut world) = land(1.0) else { return };
    let style = grey("fit = true", "");
    // The renderer that drew the failed picture draws another view; a new renderer draws the same.
    let mut later = |white_share: Option<f64>| {
        let mut renderer = None;
        if let Some(share) = white_share {
            let other = grey(&format!("fit = true\nwhite_share = {share}"), "");
            let request = PictureRequest::still(world.pose(VIEW), SIZE_PX, &other, light());
            let parts = PartRule { whole_px: 0, part_px: 100, margin_px: 12 };
            let fails = |_| Err("full");
            picture::render_in_parts(&world.gpu, &mut renderer, &mut world.surfaces, &request, &parts, fails)
                .unwrap_err();
        }
        assert!(renderer.is_some() || white_share.is_none(), "the failed picture was not begun");
        let mut renderer = renderer.unwrap_or_else(|| Renderer::new(&world.gpu).unwrap());
        let mut curve = |given: Option<ToneCurve>| {
            if given.is_some() {
                renderer.set_tone_curve(given);
            }
            renderer.forget();
            let view = still(world.pose(NEAR), SIZE_PX);
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &light());
            renderer.tone_curve(&world.gpu).unwrap().unwrap()
        };
        let own = curve(None);
        (own, curve(Some(ToneCurve { white: 0.5 * (own.dark + own.white), ..own })))
    };
    let (after, _) = later(Some(0.6));
    let (alone, kept) = later(None);
    let differ = |a: &ToneCurve, b: &ToneCurve| (a.dark - b.dark).abs().max((a.white - b.white).abs());
    assert!(differ(&after, &alone) < 1e-4, "{after:?} {alone:?}");
    // Planted: a curve that stays.
    assert!(differ(&kept, &alone) > 0.02, "{kept:?} {alone:?}");
}

#[test]
fn a_fast_flight_changes_tones_slowly() {
    // Steep land in the west, gentle land in the east.
    let height_m =
        |x_m: f64, y_m: f64| if x_m < 0.0 { rough_height_m(x_m, y_m) } else { 0.05 * rough_height_m(x_m, y_m) };
    let Some(mut world) = World::new(grid_of(513, 513, 60.0, height_m), 1.0) else { return };
    let style = grey("fit = true", "");
    // In the fast tier frames are so far apart in time that only the bound of each frame holds the curve back.
    let (size_px, step_s, frames) =
        if full() { ([160, 100], 1.0 / 30.0, [150_u32; 2]) } else { ([80, 50], 0.4, [110, 10]) };
    let mut flight = |forgets: bool| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_step_s(step_s);
        let (mut curves, mut previous) = (Vec::<ToneCurve>::new(), None);
        for frame in 0..frames[usize::from(forgets)] {
            // It turns by 15 degrees a frame, from the west to the east, and rests.
            let yaw_deg = -60.0 + 15.0 * f64::from(frame.min(8));
            let pose = world.pose(&format!("0,-1000,+2500,{yaw_deg},-14,55"));
            let view = View::whole(previous.unwrap_or(pose), pose, size_px);
            if forgets {
                renderer.forget();
            }
            renderer.render_eyes(&world.gpu, &mut world.surfaces, &Rig::mono(view), &style, &light()).unwrap();
            curves.push(renderer.tone_curve(&world.gpu).unwrap().unwrap());
            previous = Some(pose);
        }
        curves
    };
    // The largest change of any tone from a frame to the next.
    let largest = |curves: &[ToneCurve]| {
        let tone = |curve: &ToneCurve, lit: f32| ((lit - curve.dark) / (curve.white - curve.dark)).clamp(0.0, 1.0);
        let change = |pair: &[ToneCurve]| {
            let lit = (0..=100).map(|part| part as f32 / 100.0);
            lit.map(|lit| (tone(&pair[1], lit) - tone(&pair[0], lit)).abs()).fold(0.0, f32::max)
        };
        curves.windows(2).map(change).fold(0.0, f32::max)
    };
    let (slow, at_once) = (flight(false), flight(true));
    println!(
        "tones change by {:.4} in a frame at most, and by {:.4} without a memory",
        largest(&slow),
        largest(&at_once)
    );
    assert!(largest(&slow) <= 0.02);
    // Planted: a renderer that forgets.
    assert!(largest(&at_once) > 0.1);
    // It arrives.
    let (last, wanted) = (slow.last().unwrap(), at_once.last().unwrap());
    assert!((last.dark - wanted.dark).abs() < 0.02 && (last.white - wanted.white).abs() < 0.02, "{last:?} {wanted:?}");
    assert!((last.middle_m / wanted.middle_m).log2().abs() < 0.1, "{last:?} {wanted:?}");
}
