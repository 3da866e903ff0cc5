//! Lines from tone: they lie on ridges and valleys of a tone image, `beta` decides about its edges, thresholds and the sign
//! of curvature mean what they say, and where there is nothing to see there are no lines. Each measure has planted errors
//! that it must find.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod common;

use common::draw::{self, NOON, draw, north_west, still};
use common::hill::Hill;
use common::{World, grid_of, rough_height_m};
use glam::{DVec2, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::{Frame, Light};
use hachure::gpu::Gpu;
use hachure::gpu::pools::Pools;
use hachure::gpu::recorder::{Cx, Submits};
use hachure::gpu::target::{Target, TargetKind, Targets};
use hachure::gpu::timer::Timer;
use hachure::lines::tone::tone_image::TONE_IMAGE;
use hachure::lines::tone::{self, search, trace};
use hachure::picture::PartRule;
use hachure::scene::view::{Pose, View};
use hachure::style::{Style, ToneLines};

const SIZE_PX: [u32; 2] = [181, 151];

/// A GPU and what recording needs.
struct Bench {
    gpu: Gpu,
    pools: Pools,
    timer: Timer,
    targets: Targets,
}

/// Ink of a picture: dark lines, and highlight lines.
struct Ink(Vec<[f64; 2]>);

impl Bench {
    fn new() -> Option<Self> {
        let gpu = common::gpu()?;
        let (pools, timer) = (Pools::new(&gpu), Timer::new(&gpu).unwrap());
        Some(Self { gpu, pools, timer, targets: Targets::default() })
    }

    /// The lines of a tone image; each pixel is its diffuse and specular tone, or sky.
    fn lines(&mut self, style: &ToneLines, tone: impl Fn(DVec2) -> Option<[f64; 2]>) -> Ink {
        let texels: Vec<[u16; 4]> = places()
            .map(|at| {
                let texel = tone(at).map_or([0.0; 4], |[tone, specular]| [tone, specular, style.width_px.into(), 1.0]);
                texel.map(|value| half::f16::from_f64(value).to_bits())
            })
            .collect();
        let kind = TargetKind { usage: TONE_IMAGE.usage | wgpu::TextureUsages::COPY_DST, ..TONE_IMAGE };
        let tone_image = Target::new(&self.gpu, &kind, SIZE_PX);
        self.gpu.queue.write_texture(
            tone_image.texture.as_image_copy(),
            bytemuck::cast_slice(&texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * SIZE_PX[0]), rows_per_image: None },
            wgpu::Extent3d { width: SIZE_PX[0], height: SIZE_PX[1], depth_or_array_layers: 1 },
        );
        self.targets.begin_frame(&self.gpu, SIZE_PX).unwrap();
        let mut cx = Cx::new(&self.gpu, &mut self.pools, &mut self.timer, Submits::default(), false);
        let pose = Pose { position_m: DVec3::ZERO, forward: DVec3::Y, right: DVec3::X, up: DVec3::Z, fov_rad: 1.0 };
        let view = &cx.uniform("view", &View::whole(pose, pose, SIZE_PX).uniform(DVec3::ZERO));
        let ink = trace(&mut cx, &tone::Inputs { view, style, tone_image: &tone_image }, &mut self.targets);
        assert!(cx.is_complete());
        cx.submit();
        self.gpu.wait();
        self.gpu.check().unwrap();
        Ink(draw::halves(&self.gpu, &ink).into_iter().map(|[dark, light, ..]| [dark, light]).collect())
    }
}

/// The centres of all pixels, row by row.
fn places() -> impl Iterator<Item = DVec2> {
    (0..SIZE_PX[1]).flat_map(|y| (0..SIZE_PX[0]).map(move |x| DVec2::new(x.into(), y.into()) + 0.5))
}

fn middle() -> DVec2 {
    DVec2::new(SIZE_PX[0].into(), SIZE_PX[1].into()) * 0.5
}

/// The search alone: what is found at each pixel, whatever its neighbours have.
fn bare(width_px: f32) -> ToneLines {
    let text = "name = \"t\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n[tone_lines]\n";
    let lines = Style::parse("t", text).unwrap().tone_lines.unwrap();
    let dark_ramp = [0.004, 0.012];
    ToneLines {
        width_px,
        dark_ramp,
        highlight_ramp: dark_ramp,
        counterchange: 0.0,
        shortest_px: 0.0,
        softness: 0.0,
        ..lines
    }
}

/// A bell about a line that is so far away: what is half as deep is so wide.
fn bell(away_px: f64, wide_px: f64) -> f64 {
    let deviation = wide_px / (8.0 * 2.0_f64.ln()).sqrt();
    (-0.5 * (away_px / deviation).powi(2)).exp()
}

/// A tone image by its places.
type Tones = Box<dyn Fn(DVec2) -> Option<[f64; 2]>>;

/// A curve by the signed distance of a place from it.
type Curve<'a> = &'a dyn Fn(DVec2) -> f64;

/// Of ink about a curve: how far its middle lies from the curve where it is farthest, how many parts of the curve have
/// none, and how much of all ink lies elsewhere. Places for which `counts` says no are left out.
#[derive(Debug)]
struct Found {
    off_px: f64,
    bare: f64,
    elsewhere: f64,
    wide_px: f64,
}

/// `way` is along the curve: its parts are counted by it, in steps of 3 px.
fn judge(ink: &[f64], curve: Curve<'_>, way: Curve<'_>, reach_px: f64, counts: impl Fn(DVec2) -> bool) -> Found {
    let mut parts = std::collections::BTreeMap::new();
    let (mut elsewhere, mut all) = (0.0, 0.0);
    for (at, ink) in places().zip(ink) {
        let is_border = at.min_element() < 12.0 || (middle() * 2.0 - at).min_element() < 12.0;
        if is_border || !counts(at) {
            continue;
        }
        all += ink;
        let away_px = curve(at);
        if away_px.abs() > reach_px {
            elsewhere += ink;
            continue;
        }
        let part = parts.entry((way(at) / 3.0).floor() as i64).or_insert([0.0, 0.0, 0.0]);
        *part = [part[0] + ink, part[1] + ink * away_px, part[2] + 1.0];
    }
    // Parts that the border cuts off have fewer pixels.
    let most = parts.values().map(|part| part[2]).fold(0.0, f64::max);
    parts.retain(|_, part| part[2] > 0.8 * most);
    let inked = parts.values().filter(|part| part[0] > 0.5);
    let off_px = inked.clone().map(|[ink, sum, _]| (sum / ink).abs()).fold(0.0, f64::max);
    let count = parts.len() as f64;
    let wide_px = inked.clone().map(|[ink, ..]| ink / 3.0).sum::<f64>() / inked.clone().count().max(1) as f64;
    Found { off_px, bare: 1.0 - inked.count() as f64 / count, elsewhere: elsewhere / f64::max(all, 1e-9), wide_px }
}

impl Found {
    /// Centre lines within half a pixel, whole, and alone.
    fn is_right(&self) -> bool {
        self.off_px < 0.5 && self.bare == 0.0 && self.elsewhere < 0.02
    }
}

const DARK: usize = 0;
const LIGHT: usize = 1;

impl Ink {
    fn of(&self, kind: usize) -> Vec<f64> {
        self.0.iter().map(|ink| ink[kind]).collect()
    }

    fn sum(&self, kind: usize) -> f64 {
        self.0.iter().map(|ink| ink[kind]).sum()
    }
}

#[test]
fn lines_lie_on_valleys_and_ridges() {
    let Some(mut bench) = Bench::new() else { return };
    let mut worst = 0.0_f64;
    for width_px in [3.0, 5.0] {
        let style = bare(width_px);
        for times in [0.5, 1.0, 2.0, 4.0] {
            for turn_deg in [0.0_f64, 17.0, 45.0, 73.0, 90.0, 128.0] {
                let wide_px = times * f64::from(width_px);
                let across = DVec2::from_angle(turn_deg.to_radians());
                let curve = |at: DVec2| (at - middle()).dot(across) - 0.3;
                let along = |at: DVec2| (at - middle()).dot(across.perp());
                for (kind, depth) in [(DARK, -0.5), (LIGHT, 0.5)] {
                    let tone = |at: DVec2| Some([0.5 + depth * bell(curve(at), wide_px), 0.0]);
                    let ink = bench.lines(&style, tone);
                    let found = judge(&ink.of(kind), &curve, &along, 0.6 * wide_px + 2.0, |_| true);
                    assert!(found.is_right(), "{width_px} px, {times} times, {turn_deg} degrees: {found:?}");
                    worst = worst.max(found.off_px);
                    // As wide as asked; a shape that is much wider than lines has one of their width as well.
                    let part = found.wide_px / f64::from(width_px);
                    assert!((0.6..1.5).contains(&part), "{width_px} px, {times} times: {part} of the width");
                    // Planted: the image a pixel aside, and the sign of curvature exchanged: the other kind of line.
                    let aside = |at: DVec2| curve(at) - 1.0;
                    assert!(!judge(&ink.of(kind), &aside, &along, 0.6 * wide_px + 2.0, |_| true).is_right());
                    let flipped = bench.lines(&style, |at| tone(at).map(|[tone, _]| [1.0 - tone, 0.0]));
                    assert!(!judge(&flipped.of(kind), &curve, &along, 0.6 * wide_px + 2.0, |_| true).is_right());
                }
            }
        }
    }
    println!("straight lines are {worst:.2} px from where they should be at most");
}

#[test]
fn lines_follow_curves_and_cross() {
    let Some(mut bench) = Bench::new() else { return };
    let style = bare(3.0);
    for radius_px in [14.0, 30.0, 55.0] {
        for wide_px in [1.5, 3.0, 6.0] {
            let curve = |at: DVec2| (at - middle()).length() - radius_px;
            let along = |at: DVec2| (at - middle()).to_angle() * radius_px;
            let ink = bench.lines(&style, |at| Some([0.7 - 0.5 * bell(curve(at), wide_px), 0.0]));
            let found = judge(&ink.of(DARK), &curve, &along, wide_px + 2.0, |_| true);
            println!("a circle of {radius_px} px, {wide_px} px wide: {found:?}");
            assert!(found.is_right(), "{radius_px} {wide_px}: {found:?}");
            // Planted: a circle that is a pixel wider.
            assert!(!judge(&ink.of(DARK), &|at| curve(at) - 1.0, &along, wide_px + 2.0, |_| true).is_right());
        }
    }
    // Two that cross: all of the first, whose crossing is not bare, and the second beside it.
    for turn_deg in [90.0_f64, 60.0] {
        let across = [DVec2::Y, DVec2::from_angle(turn_deg.to_radians()).perp()];
        let away = |line: usize, at: DVec2| (at - middle()).dot(across[line]);
        let deep = |at: DVec2| bell(away(0, at), 3.0).max(bell(away(1, at), 3.0));
        let ink = bench.lines(&style, |at| Some([0.8 - 0.6 * deep(at), 0.0]));
        let crossing = (middle() - 0.5).as_uvec2();
        let around = (0..3).flat_map(|j| (0..3).map(move |i| (crossing.y + j - 1) * SIZE_PX[0] + crossing.x + i - 1));
        let least = around.map(|pixel| ink.0[pixel as usize][DARK]).fold(1.0, f64::min);
        assert!(least > 0.5, "a hole where lines cross: {least}");
        for line in [0, 1] {
            let counts = |at: DVec2| away(1 - line, at).abs() > 9.0;
            let along = |at: DVec2| (at - middle()).dot(across[line].perp());
            let found = judge(&ink.of(DARK), &|at| away(line, at), &along, 5.0, counts);
            assert!(found.off_px < 0.5 && found.bare == 0.0, "{turn_deg} degrees, line {line}: {found:?}");
        }
        // Spots are left out by the bound on roundness, and with them what crosses: the choice does something.
        let bound = bench.lines(&ToneLines { roundest: 0.3, ..style.clone() }, |at| Some([0.8 - 0.6 * deep(at), 0.0]));
        assert!(turn_deg != 90.0 || bound.0[(crossing.y * SIZE_PX[0] + crossing.x) as usize][DARK] < 0.2);
    }
}

/// Of curvatures that an edge has.
const EDGE_RAMP: [f32; 2] = [0.008, 0.01];

/// A step of tone, a line width wide, and how much ink a pixel of it has for a `beta`: dark, and light.
fn edge(bench: &mut Bench, beta: f32, height: f64) -> [f64; 2] {
    let style = ToneLines { beta, dark_ramp: EDGE_RAMP, highlight_ramp: EDGE_RAMP, ..bare(4.0) };
    let across = DVec2::from_angle(0.3);
    let curve = |at: DVec2| (at - middle()).dot(across);
    let ink = bench.lines(&style, |at| Some([0.5 + height * (f64::from(u8::from(curve(at) > 0.0)) - 0.5), 0.0]));
    [DARK, LIGHT]
        .map(|kind| judge(&ink.of(kind), &curve, &|at| (at - middle()).dot(across.perp()), 9.0, |_| true).wide_px)
}

/// As Figure 4 has it: small betas draw edges, large ones none, and what is between them strong ones.
fn follows_figure_4(strong: [[f64; 2]; 3], weak: [[f64; 2]; 3]) -> bool {
    let is_drawn = |ink: [f64; 2]| ink.iter().all(|ink| *ink > 0.6);
    let is_none = |ink: [f64; 2]| ink.iter().all(|ink| *ink == 0.0);
    is_drawn(strong[0])
        && is_drawn(weak[0])
        && is_drawn(strong[1])
        && !is_drawn(weak[1])
        && is_none(strong[2])
        && is_none(weak[2])
}

#[test]
fn beta_decides_about_edges() {
    let Some(mut bench) = Bench::new() else { return };
    const BETAS: [f32; 3] = [0.0, 0.2, 1.0];
    const WEAK: f64 = 0.05;
    let strong = BETAS.map(|beta| edge(&mut bench, beta, 0.8));
    let weak = BETAS.map(|beta| edge(&mut bench, beta, WEAK));
    println!("ink across an edge of 0.8 and of {WEAK}, for beta of {BETAS:?}: {strong:.2?} {weak:.2?}");
    assert!(follows_figure_4(strong, weak));
    // Planted: beta does nothing, whichever it is.
    for ignored in 0..3 {
        assert!(!follows_figure_4([strong[ignored]; 3], [weak[ignored]; 3]));
    }
    // The darker side has the dark line: planted is the other side.
    let style = ToneLines { beta: 0.1, ..bare(4.0) };
    let tone = |at: DVec2| Some([if at.x > middle().x { 0.9 } else { 0.1 }, 0.0]);
    let ink = bench.lines(&style, tone);
    let on_dark_side =
        |kind| places().zip(ink.of(kind)).filter(|(at, _)| at.x < middle().x).map(|(_, ink)| ink).sum::<f64>();
    assert!(on_dark_side(DARK) > 0.95 * ink.sum(DARK) && on_dark_side(LIGHT) < 0.05 * ink.sum(LIGHT));
    // Without edges, whatever beta says.
    assert!(bench.lines(&ToneLines { edges: false, ..style }, tone).sum(DARK) == 0.0);
}

/// Ink in the middle of a valley, for a ramp of curvatures.
fn ramped(bench: &mut Bench, dark_ramp: [f32; 2], depth: f64) -> f64 {
    let tone = |at: DVec2| Some([0.8 - depth * bell(at.x - middle().x, 4.0), 0.0]);
    let ink = bench.lines(&ToneLines { dark_ramp, ..bare(4.0) }, tone).of(DARK);
    places().zip(ink).filter(|(at, _)| at.x == middle().x).map(|(_, ink)| ink).fold(0.0, f64::max)
}

#[test]
fn opacity_rises_between_the_thresholds() {
    let Some(mut bench) = Bench::new() else { return };
    let ramp = [0.02, 0.08];
    let depths = [0.02, 0.1, 0.15, 0.2, 0.5];
    let mut inks = |ramp: [f32; 2]| depths.map(|depth| ramped(&mut bench, ramp, depth));
    let right = inks(ramp);
    println!("ink of valleys {depths:?} deep: {right:.3?}");
    // Curvature grows with depth, and so does ink between the thresholds.
    let rises = |ink: [f64; 5]| {
        let steps = [ink[2] - ink[1], ink[3] - ink[2]];
        ink[0] == 0.0 && ink[1] > 0.05 && ink[3] < 0.95 && ink[4] == 1.0 && (steps[0] - steps[1]).abs() < 0.02
    };
    assert!(rises(right));
    // Planted: thresholds that are exchanged, and one alone, which is no ramp.
    assert!(!rises(inks([ramp[1], ramp[0]])));
    assert!(!rises(inks([ramp[0], 1.01 * ramp[0]])));
}

#[test]
fn lines_stand_against_their_tone() {
    let Some(mut bench) = Bench::new() else { return };
    // A dark line in the light is paler than one in the dark; a highlight line the other way around.
    let mut ink = |ground: f64, counterchange: f32| {
        let style = ToneLines { counterchange, ..bare(4.0) };
        let at = |sign: f64| move |at: DVec2| Some([ground + sign * 0.15 * bell(at.x - middle().x, 4.0), 0.0]);
        [bench.lines(&style, at(-1.0)).sum(DARK), bench.lines(&style, at(1.0)).sum(LIGHT)]
    };
    let stands = |[in_dark, in_light]: [[f64; 2]; 2]| {
        in_dark[DARK] > 1.5 * in_light[DARK] && in_light[LIGHT] > 1.5 * in_dark[LIGHT]
    };
    let right = [ink(0.25, 1.0), ink(0.75, 1.0)];
    assert!(stands(right), "{right:?}");
    // Planted: no counterchange, and the wrong way around.
    assert!(!stands([ink(0.25, 0.0), ink(0.75, 0.0)]));
    assert!(!stands([right[1], right[0]]));
}

#[test]
fn specular_highlights_have_lines_of_their_own() {
    let Some(mut bench) = Bench::new() else { return };
    // A broad bright tone hides a highlight in the diffuse channel.
    let style = ToneLines { specular: 1.0, ..bare(4.0) };
    let tone = |at: DVec2| Some([0.9, 0.6 * bell(at.y - middle().y, 5.0)]);
    let found = bench.lines(&style, tone);
    let curve = |at: DVec2| at.y - middle().y;
    let line = judge(&found.of(LIGHT), &curve, &|at| at.x, 6.0, |_| true);
    assert!(line.is_right() && found.sum(DARK) == 0.0, "{line:?}");
    // Planted: a style without the channel.
    assert!(bench.lines(&ToneLines { specular: 0.0, ..style.clone() }, tone).sum(LIGHT) == 0.0);
    assert!(bench.lines(&ToneLines { highlights: false, ..style }, tone).sum(LIGHT) == 0.0);
}

#[test]
fn short_lines_go_and_long_ones_stay() {
    let Some(mut bench) = Bench::new() else { return };
    let mut ink = |long_px: f64, shortest_px: f32| {
        let style = ToneLines { shortest_px, ..bare(3.0) };
        let tone = |at: DVec2| {
            let off = at - middle();
            let beyond = (off.x.abs() - 0.5 * long_px).max(0.0);
            Some([0.8 - 0.5 * bell(off.y.hypot(beyond), 3.0), 0.0])
        };
        bench.lines(&style, tone).sum(DARK)
    };
    let left = [4.0, 60.0].map(|long_px| ink(long_px, 32.0) / ink(long_px, 0.0));
    assert!(left[0] < 0.1 && left[1] > 0.9, "{left:?}");
    // Planted: crumbs are kept.
    assert!(ink(4.0, 2.0) > 0.5 * ink(4.0, 0.0));
}

#[test]
fn where_nothing_is_to_be_seen_there_are_no_lines() {
    let Some(mut bench) = Bench::new() else { return };
    let tones: [(&str, Tones); 6] = [
        ("black", Box::new(|_| Some([0.0, 0.0]))),
        ("white", Box::new(|_| Some([1.0, 1.0]))),
        ("sky", Box::new(|_| None)),
        ("a slope of tone", Box::new(|at| Some([0.1 + 0.8 * at.x / f64::from(SIZE_PX[0]), 0.0]))),
        ("rounding", Box::new(|at| Some([0.5 + 3e-4 * f64::from((at.x * 7.0 + at.y * 13.0) as i32 % 3), 0.0]))),
        ("half of it sky", Box::new(|at| (at.y > 70.0).then_some([0.4, 0.2]))),
    ];
    for (name, tone) in &tones {
        for width_px in [1.0, 4.0, 16.0] {
            for beta in [0.0, 0.2, 1.0] {
                let style =
                    ToneLines { beta, specular: 1.0, skyline: false, blur: 1.0, shortest_px: 16.0, ..bare(width_px) };
                let ink = bench.lines(&style, tone);
                assert!(ink.0.iter().flatten().all(|ink| ink.is_finite()), "{name}");
                assert!(ink.sum(DARK) == 0.0 && ink.sum(LIGHT) == 0.0, "{name}, {width_px} px, beta {beta}");
            }
        }
    }
    // Planted: an image with something in it, and a skyline where the sky is white.
    assert!(bench.lines(&bare(4.0), |at| Some([0.5 - 0.4 * bell(at.y - 60.0, 4.0), 0.0])).sum(DARK) > 100.0);
    let skyline = |at: DVec2| (at.y > 70.0).then_some([0.4, 0.0]);
    assert!(bench.lines(&bare(4.0), skyline).sum(DARK) > 100.0);
}

/// Ink of dark lines and highlight lines of a world, in pixels, from a picture without another mark.
fn ink_of_world(world: &mut World, camera: &str, style: &Style, light: &Light) -> [f64; 2] {
    let pose = world.pose(camera);
    let mut frame = Frame::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut frame, &still(pose, [320, 200]), style, light);
    assert!(draw::halves(&world.gpu, frame.target(&PICTURE).unwrap()).iter().flatten().all(|value| value.is_finite()));
    let lines = style.tone_lines.as_ref().unwrap();
    let ink = draw::halves(&world.gpu, frame.target(tone::ink_of(lines)).unwrap());
    [DARK, LIGHT].map(|kind| ink.iter().map(|ink| ink[kind]).sum())
}

#[test]
fn land_has_lines_and_flat_ground_and_no_light_have_none() {
    let Some(mut rough) = World::new(grid_of(513, 513, 60.0, rough_height_m), 0.0) else { return };
    let style = Style::load("tone-lines").unwrap();
    let camera = "0,-9000,+2500,0,-14,55";
    for light in ["sun", "head", "side"] {
        let text = style.text().replace("light = \"head\"", &format!("light = \"{light}\""));
        let style = Style::parse("t", &text).unwrap();
        let [dark, bright] = ink_of_world(&mut rough, camera, &style, &north_west());
        println!("rough land, light {light}: {dark:.0} px of dark lines, {bright:.0} of highlights");
        assert!(dark > 100.0 && bright > 20.0);
    }
    // The sun behind the land, and one that lights none of it.
    let sun = Style::parse(
        "t",
        &style.text().replace("light = \"head\"", "light = \"sun\"").replace("skyline = true", "skyline = false"),
    )
    .unwrap();
    for (to_sun, wrap, is_calm) in [(DVec3::new(0.0, 0.95, 0.3), 0.2, false), (-DVec3::Z, 0.0, true)] {
        let mut style = sun.clone();
        style.light.wrap = wrap;
        let ink = ink_of_world(&mut rough, camera, &style, &Light { to_sun: to_sun.normalize(), ..NOON });
        assert!(!is_calm || ink == [0.0; 2], "{to_sun}: {ink:?}");
    }
    let Some(mut flat) = World::new(grid_of(257, 257, 30.0, |_, _| 100.0), 0.0) else { return };
    for camera in ["0,0,2000,0,-90,50", "0,-2000,+600,0,-40,40"] {
        let ink = ink_of_world(&mut flat, camera, &sun, &north_west());
        assert!(ink[DARK] < 1.0 && ink[LIGHT] < 1.0, "{camera}: {ink:?}");
    }
}

#[test]
fn parts_of_a_large_picture_have_the_lines_of_the_whole() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let mut style = Style::load("tone-lines").unwrap();
    style.water = None;
    style.paper.grain = 0.0;
    // Errors of LSA are among what a shot reads.
    style.lines = Style::load("ink").unwrap().lines;
    style.lines.as_mut().unwrap().crowd = 1.0;
    let pose = world.pose("900,-900,+20,315,3,60");
    let mut frame = None;
    let mut shoot = |style: &Style, rule: PartRule| {
        common::shot::shoot_style(&mut world, &mut frame, pose, pose, [320, 200], style, &rule).picture
    };
    let whole = shoot(&style, PartRule::default());
    let parts = PartRule { whole_px: 1, part_px: 64, margin_px: 12 };
    let differing = |parts: Vec<[f32; 4]>| {
        let apart = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 0.02);
        whole.iter().zip(&parts).filter(|pair| apart(*pair)).count()
    };
    let own = differing(shoot(&style, parts));
    println!("{own} of {} pixels differ where parts meet", whole.len());
    assert!(own < 20);
    // Planted: lines that are a little wider.
    style.tone_lines.as_mut().unwrap().width_px += 0.3;
    assert!(differing(shoot(&style, parts)) > 100);
}

#[test]
fn the_ink_lies_where_styles_say() {
    let style = bare(3.0);
    assert_eq!(tone::ink_of(&style).name, search::TONE_INK.name);
    assert_ne!(tone::ink_of(&ToneLines { shortest_px: 9.0, ..style }).name, search::TONE_INK.name);
}
