//! Tests the effect of relief on light.

use std::path::Path;

use glam::DVec3;
use hachure::frame::{Light, Renderer};
use hachure::picture::PartRule;
use hachure::style::Style;
use hachure::tones::TONE;

use crate::tests::common::draw::{NOON, draw, halves, north_west, still};
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, full, grid_of, rough_height_m, shot};
use crate::tests::relief::gradient::{style, text};

const SIZE_PX: [u32; 2] = [240, 160];
const NEAR: &str = "900,-900,+60,315,-6,60";
const ABOVE: &str = "0,0,3000,0,-90,50";

/// Returns colours, which are grey tones except for haze, and the requested tones.
fn tones(world: &mut World, camera: &str, style: &Style, light: &Light) -> Vec<[f64; 4]> {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), style, light);
    halves(&world.gpu, renderer.target(&TONE).unwrap())
}

fn max_apart(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).abs()).fold(0.0, f64::max)
}

#[test]
fn without_alpha_the_picture_is_the_plain_one_to_the_bit() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    for gloss in [0.0, 1.0] {
        let mut drawn = |alpha_px: &str| {
            let style = style(&format!("alpha_px = {alpha_px}\ngloss = {gloss:.1}\ncolor = 0.5\ngamma = 0.7"));
            tones(&mut world, NEAR, &style, &north_west())
        };
        // The first style has no warp in its shader; the second has a warp of strength 0.
        let [plain, nothing, warped] = ["0.0", "1e-30", "20.0"].map(&mut drawn);
        assert_eq!(plain, nothing);
        // Planted: a visible warp.
        assert!(max_apart(&plain, &warped) > 0.05);
    }
}

#[test]
fn bulges_and_hollows_are_told_apart() {
    // The middle of a hill, or of a hollow of the same form, from above.
    let middle = |sign: f64, keys: &str| {
        let form_m = |x: f64, y: f64| sign * 300.0 * (-(x * x + y * y) / (2.0 * 400.0 * 400.0)).exp();
        let mut world = World::new(grid_of(321, 321, 10.0, form_m), 1.0)?;
        let pixel = (SIZE_PX[1] / 2 * SIZE_PX[0] + SIZE_PX[0] / 2) as usize;
        Some(tones(&mut world, ABOVE, &style(keys), &NOON)[pixel][0])
    };
    for keys in ["gamma = 0.5\nsun = 0.0", "kind = \"scaling\"\ninvariant = 0.2"] {
        let Some(plain) = middle(1.0, &format!("alpha_px = 0.0\n{keys}")) else { return };
        let of =
            |alpha_px: f64| [1.0, -1.0].map(|sign| middle(sign, &format!("alpha_px = {alpha_px:.1}\n{keys}")).unwrap());
        let is_emphasised = |[hill, hollow]: [f64; 2]| hill > 1.05 * plain && hollow < 0.95 * plain;
        let own = of(60.0);
        println!("{keys}: {plain:.3} becomes {:.3} on a hill and {:.3} in a hollow", own[0], own[1]);
        assert!(is_emphasised(own), "{own:?}");
        // Planted: curvature of the opposite sign.
        assert!(!is_emphasised(of(-60.0)));
    }
}

/// Writes a Radiance picture of a sphere whose rows from `black_from` on are black.
fn write_sky(path: &Path, black_from: usize) {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 16 +X 32\n".to_vec();
    for row in 0..16 {
        for _ in 0..32 {
            bytes.extend(if row < black_from { [128, 128, 128, 129] } else { [0, 0, 0, 0] });
        }
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn a_white_sky_is_white_on_everything() {
    let Some(mut world) = World::new(grid_of(513, 513, 30.0, rough_height_m), 1.0) else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut spread = |black_from: usize, alpha_px: f64| {
        let path = folder.path().join("sky.hdr");
        write_sky(&path, black_from);
        let file = folder.path().join("style.toml");
        std::fs::write(&file, text(&format!("environment = \"sky.hdr\"\nalpha_px = {alpha_px:.1}"))).unwrap();
        let style = Style::load(file.to_str().unwrap()).unwrap();
        let found = tones(&mut world, "0,-5000,+900,0,-14,55", &style, &north_west());
        let land = found.iter().filter(|texel| texel[0] < 1.0);
        land.map(|texel| (texel[0] / 0.5 - 1.0).abs()).fold(0.0, f64::max)
    };
    for alpha_px in [0.0, 30.0, -1000.0, 1000.0] {
        let own = spread(16, alpha_px);
        println!("alpha {alpha_px} px: a white sky is off by {own:.1e} at most");
        assert!(own < 0.01, "{own}");
    }
    // Planted: a sky that is black below the horizon.
    assert!(spread(8, 30.0) > 0.05);
}

#[test]
fn flat_ground_and_the_ends_of_all_parameters_are_calm() {
    let Some(mut flat) = World::new(grid_of(257, 257, 30.0, |_, _| 100.0), 1.0) else { return };
    for camera in [ABOVE, "0,-2000,+300,0,-20,40"].into_iter().skip(usize::from(!full())) {
        let [plain, warped] = ["0.0", "1000.0"]
            .map(|alpha_px| tones(&mut flat, camera, &style(&format!("alpha_px = {alpha_px}")), &north_west()));
        let own = max_apart(&plain, &warped);
        println!("{camera}: flat ground changes by {own:.1e} at alpha 1000 px");
        assert!(own < 0.02, "{own}");
    }
    // Rough land with a cliff.
    let cliff_m = |x: f64, y: f64| rough_height_m(x, y) + if x > 0.0 { 900.0 } else { 0.0 };
    let Some(mut cliff) = World::new(grid_of(257, 257, 30.0, cliff_m), 1.0) else { return };
    let suns = [
        north_west(),
        Light { to_sun: DVec3::new(0.0, 0.95, 0.3).normalize(), ..NOON },
        Light { to_sun: -DVec3::Z, ..NOON },
    ];
    let parameters = [
        "alpha_px = 1000.0\ngamma = 1.0\ngloss = 4.0\nshininess = 256.0",
        "alpha_px = -1000.0\ngamma = -1.0\nlights = 1\nscale_px = 12.0\ncoarser_far = 4.0\ncoarser_level = 4.0",
        "lights = 256\nsun = 1.0\nscale_px = 0.0\ncrease_deg = 1.0\nforeshortening = 1.0",
        "sun = 0.0\nforeshortening = 0.0\nscale_px = 0.0",
        "kind = \"scaling\"\nalpha_px = 1000.0\nscaling = 8.0\ninvariant = 0.99",
        "kind = \"scaling\"\nalpha_px = -1000.0\nscaling = 8.0\ninvariant = 0.01",
        "kind = \"exaggerated\"\nscales = 8\nexaggeration = 50.0\ncoarser = 4.0\nfinest_px = 64.0",
        "kind = \"exaggerated\"\nscales = 1\nexaggeration = 0.1\ncoarser = 0.1\nfinest_px = 1.0",
    ];
    let cameras = [ABOVE, "-1500,-2000,+200,20,-5,60"];
    let views: Vec<_> = suns.iter().flat_map(|light| cameras.map(|camera| (light, camera))).collect();
    for (number, keys) in parameters.into_iter().enumerate() {
        // In the fast tier, each set of parameters meets one light and one camera.
        let one = &views[number % views.len()..][..1];
        for (light, camera) in if full() { &views[..] } else { one } {
            let found = tones(&mut cliff, camera, &style(keys), light);
            let holds = |texel: &[f64; 4]| texel.iter().all(|value| (0.0..=1.0).contains(value));
            let wrong = found.iter().filter(|texel| !holds(texel)).count();
            assert_eq!(wrong, 0, "{keys}, {camera}, {}", light.to_sun);
        }
    }
}

#[test]
fn no_light_is_black_and_shadows_fall() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let night = Light { to_sun: -DVec3::Z, ..NOON };
    let dark = tones(&mut world, ABOVE, &style("sun = 1.0"), &night);
    let land = dark.iter().filter(|texel| texel[0] < 1.0);
    assert!(land.clone().count() > 20_000 && land.clone().all(|texel| texel[0] < 0.01));
    let low = Light { to_sun: DVec3::new(-1.0, 0.0, 0.15).normalize(), ..NOON };
    for kind in ["warp", "scaling"] {
        let mut shadowed = |shadow: f32| {
            let mut style = style(&format!("kind = \"{kind}\"\nalpha_px = 20.0"));
            style.light.shadow = shadow;
            tones(&mut world, ABOVE, &style, &low)
        };
        let [free, cast] = [0.0, 1.0].map(&mut shadowed);
        let darker = free.iter().zip(&cast).filter(|(free, cast)| cast[0] < free[0] - 0.02).count();
        let lighter = free.iter().zip(&cast).filter(|(free, cast)| cast[0] > free[0] + 1e-3).count();
        println!("{kind}: cast shadows darken {darker} pixels");
        assert!(darker > 100 && lighter == 0, "{darker} pixels got darker, {lighter} lighter");
    }
}

#[test]
fn exaggerated_relief_has_folds_on_slopes_that_face_the_sun() {
    // A slope that faces the sun, with small furrows down it.
    let furrows_m = |x: f64, y: f64| -0.5 * y + 6.0 * (x / 25.0).sin();
    let Some(mut world) = World::new(grid_of(257, 257, 10.0, furrows_m), 1.0) else { return };
    let light = Light { to_sun: DVec3::new(0.0, 0.6, 0.8), ..NOON };
    let mut spread = |keys: &str| {
        let found = tones(&mut world, "0,0,1200,0,-90,50", &style(keys), &light);
        let row = &found[(80 * SIZE_PX[0] + 40) as usize..(80 * SIZE_PX[0] + 200) as usize];
        let [least, most] = [f64::min, f64::max].map(|pick| row.iter().map(|texel| texel[0]).reduce(pick).unwrap());
        most - least
    };
    let plain = spread("alpha_px = 0.0\nsun = 1.0");
    let own = spread("kind = \"exaggerated\"\nscales = 4\nexaggeration = 8.0\nfinest_px = 8.0\ncoarser = 0.7");
    println!("tones of furrows differ by {own:.3}, in plain light by {plain:.3}");
    assert!(own > 3.0 * plain && own > 0.03);
    // Planted: no exaggeration.
    assert!(
        spread("kind = \"exaggerated\"\nscales = 4\nexaggeration = 0.1\nfinest_px = 8.0\ncoarser = 0.7") < 0.3 * own
    );
}

#[test]
fn parts_of_a_large_picture_have_the_relief_of_the_whole() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    // A shot reads the errors of LSA, so the style needs its lines.
    let mut style = style("alpha_px = 40.0\nscale_px = 6.0");
    style.set_lines(Style::load("lsa").unwrap().lines().cloned());
    style.lines_mut().unwrap().crowd = 1.0;
    let pose = world.pose(NEAR);
    let mut renderer = None;
    let size_px = if full() { [320, 200] } else { [160, 100] };
    let mut shoot = |style: &Style, rule: PartRule| {
        shot::shoot_style(&mut world, &mut renderer, pose, pose, size_px, style, &rule).picture
    };
    let whole = shoot(&style, PartRule::default());
    let parts = PartRule { whole_px: 1, part_px: 64, margin_px: 12 };
    let differing = |parts: Vec<[f32; 4]>| {
        let apart = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.02);
        whole.iter().zip(&parts).filter(|pair| apart(*pair)).count()
    };
    let own = differing(shoot(&style, parts));
    println!("{own} of {} pixels differ where parts meet", whole.len());
    assert!(own < whole.len() / 3200);
    // Planted: another blur.
    style.relief.as_mut().unwrap().scale_px = 2.0;
    assert!(differing(shoot(&style, parts)) > whole.len() / 640);
}
