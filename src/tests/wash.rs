//! Tests colours of tones and how they run: tints are those of their stops, wet edges are where washes end, granulation
//! keeps the mean, and patterns move with the land.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{draw, halves, places_m, still};
use common::hill::Hill;
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::{Light, Renderer};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;
use hachure::tones::TONE;
use hachure::tones::watercolor::WASHED;

const SIZE_PX: [u32; 2] = [256, 192];
const WIDTH: usize = SIZE_PX[0] as usize;
const HEIGHT: usize = SIZE_PX[1] as usize;

/// Results of a frame. Colours are linear.
#[derive(Clone)]
struct Drawn {
    view: View,
    /// In the world; `None` for the sky.
    place_m: Vec<Option<DVec3>>,
    /// Colour before water has run; the last channel is the requested tone.
    tone: Vec<[f64; 4]>,
    /// Colour after water has run.
    washed: Vec<[f64; 4]>,
    picture: Vec<[f64; 4]>,
}

fn drawing(world: &mut World, style: &Style, pose: Pose) -> Drawn {
    let light = Light { to_sun: DVec3::new(-0.6, 0.5, 0.4).normalize(), haze_m: 1e12, haze_srgb: None, focus: None };
    let gpu = &world.gpu;
    let mut renderer = Renderer::new(gpu).unwrap();
    let view = still(pose, SIZE_PX);
    draw(gpu, &mut world.surfaces, &mut renderer, &view, style, &light);
    let picture = |kind| renderer.target(kind).map_or(Vec::new(), |target| halves(gpu, target));
    Drawn {
        view,
        place_m: places_m(gpu, &renderer, pose.position_m),
        tone: picture(&TONE),
        washed: picture(&WASHED),
        picture: picture(&PICTURE),
    }
}

/// Returns a toon style with these tone keys and further sections.
fn style(tone: &str, more: &str) -> Style {
    let text = format!(
        "name = \"wash\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\ndarkest = 0.2\n{tone}\n{more}\n\
         [paper]\ngrain = 0.0\n"
    );
    Style::parse("wash", &text).unwrap()
}

/// Returns a watercolour section in which only the given effects are on.
fn water(more: &[(&str, f64)]) -> String {
    let value = |name: &str, none: f64| more.iter().find(|(of, _)| *of == name).map_or(none, |(_, value)| *value);
    let lines = [("edge", 0.0), ("edge_px", 1.0), ("granulation", 0.0), ("flow", 0.0), ("warp_px", 0.0)];
    lines
        .iter()
        .fold("[watercolor]\n".to_owned(), |text, (name, none)| text + &format!("{name} = {:?}\n", value(name, *none)))
}

fn linear(srgb: u8) -> f64 {
    let value = f64::from(srgb) / 255.0;
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn luminance(color: &[f64; 4]) -> f64 {
    0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
}

fn hill() -> Option<(Hill, World)> {
    let (hill, grid) = Hill::square(641, 10.0);
    Some((hill, World::new(grid, 1.0)?))
}

fn plain() -> Option<World> {
    World::new(grid_of(801, 801, 40.0, |_, _| 50.0), 1.0)
}

const ACROSS: &str = "-900,-1300,700,35,-25,50";
const ABOVE: &str = "100,-150,2000,20,-90,50";

/// Colours of the stops, each from the darkest tone to the lightest.
const STOPS: [[[u8; 3]; 2]; 3] =
    [[[40, 10, 90], [200, 60, 250]], [[0, 90, 20], [250, 200, 30]], [[90, 0, 0], [30, 250, 255]]];

/// Returns the largest difference of a channel from the colour that the stops give for a point's attribute and tone.
fn off_the_ramp(drawn: &Drawn, at: [f64; 3], attribute: impl Fn(DVec3) -> f64) -> f64 {
    let mut most = 0.0_f64;
    for (place_m, color) in drawn.place_m.iter().zip(&drawn.tone) {
        let Some(place_m) = place_m else { continue };
        let (value, tone) = (attribute(*place_m).clamp(at[0], at[2]), color[3]);
        let low = usize::from(value > at[1]);
        let t = (value - at[low]) / (at[low + 1] - at[low]);
        for (channel, drawn) in color.iter().enumerate().take(3) {
            let of = |stop: usize| {
                let [dark, light] = STOPS[stop].map(|color| linear(color[channel]));
                dark + (light - dark) * tone
            };
            most = most.max((of(low) + (of(low + 1) - of(low)) * t - drawn).abs());
        }
    }
    most
}

/// The attribute of a ramp, as a function of a point.
type Attribute<'a> = &'a dyn Fn(DVec3) -> f64;

#[test]
fn tints_are_those_of_their_stops() {
    let Some((hill, mut world)) = hill() else { return };
    let range_m = world.surfaces.terrain.range_m().map(f64::from);
    let height = move |at: DVec3| (hill.height_m(at.x, at.y) - range_m[0]) / (range_m[1] - range_m[0]);
    let slope_deg = move |at: DVec3| {
        let east = hill.height_m(at.x + 0.5, at.y) - hill.height_m(at.x - 0.5, at.y);
        let north = hill.height_m(at.x, at.y + 0.5) - hill.height_m(at.x, at.y - 0.5);
        east.hypot(north).atan().to_degrees()
    };
    for camera in [ACROSS, ABOVE] {
        let pose = world.pose(camera);
        let distance_m = move |at: DVec3| at.distance(pose.position_m);
        let kinds: [(&str, [f64; 3], Attribute<'_>); 3] = [
            ("height", [0.05, 0.4, 0.95], &height),
            ("slope", [1.0, 8.0, 18.0], &slope_deg),
            ("distance", [800.0, 1900.0, 2600.0], &distance_m),
        ];
        for (by, at, attribute) in kinds {
            let stops = (0..3).map(|i| {
                let [dark, light] = STOPS[i].map(|[r, g, b]| format!("\"#{r:02x}{g:02x}{b:02x}\""));
                format!("[[tone.ramp.stops]]\nat = {:?}\ncolors = [{dark}, {light}]\n", at[i])
            });
            let ramp = format!("steps = 0\n[tone.ramp]\nby = \"{by}\"\n{}", stops.collect::<String>());
            let drawn = drawing(&mut world, &style(&ramp, ""), pose);
            let off = off_the_ramp(&drawn, at, attribute);
            let shift = 0.04 * (at[2] - at[0]);
            let planted = off_the_ramp(&drawn, at, |place_m| attribute(place_m) + shift);
            println!("by {by}, {camera}: off by {off:.4}, shifted by 4 % of the ramp by {planted:.4}");
            assert!(off <= 0.01, "by {by}, {camera}: {off}");
            assert!(planted > 0.01, "a planted shift of the ramp was not detected: {planted}");
        }
    }
}

/// Two tones with hard borders.
const TWO: &str = "steps = 2\nsoftness = 0.0";
/// A constant tone.
const EVEN: &str = "steps = 0\nlightest = 0.2";

fn pixels() -> impl Iterator<Item = (usize, [i64; 2])> {
    (0..WIDTH * HEIGHT).map(|i| (i, [(i % WIDTH) as i64, (i / WIDTH) as i64]))
}

/// Returns the largest darkening of land far from a border of tones, and the mean relative darkening on the dark side
/// of a border.
fn edges(drawn: &Drawn, reach_px: f64) -> [f64; 2] {
    let reach = reach_px.ceil() as i64;
    let disc: Vec<[i64; 2]> = (-reach..=reach)
        .flat_map(|y| (-reach..=reach).map(move |x| [x, y]))
        .filter(|[x, y]| (*x as f64).hypot(*y as f64) <= reach_px)
        .collect();
    let at = |[x, y]: [i64; 2]| {
        let inside = (0..WIDTH as i64).contains(&x) && (0..HEIGHT as i64).contains(&y);
        inside.then(|| luminance(&drawn.tone[y as usize * WIDTH + x as usize]))
    };
    let (mut far, mut near, mut count) = (0.0_f64, 0.0, 0.0);
    for (i, [x, y]) in pixels() {
        if drawn.place_m[i].is_none() {
            continue;
        }
        let own = luminance(&drawn.tone[i]);
        let darkened = own - luminance(&drawn.washed[i]);
        let is_other = |step: &&[i64; 2]| at([x + step[0], y + step[1]]).is_some_and(|tone| (tone - own).abs() > 0.01);
        if !disc.iter().any(|step| is_other(&step)) {
            far = far.max(darkened.abs());
        }
        let neighbours = [[1, 0], [-1, 0], [0, 1], [0, -1]].map(|[dx, dy]| at([x + dx, y + dy]).unwrap_or(own));
        if own < 0.5 && neighbours.iter().any(|tone| tone - own > 0.1) {
            near += darkened / own;
            count += 1.0;
        }
    }
    assert!(count > 200.0, "{count}");
    [far, near / count]
}

#[test]
fn wet_edges_lie_where_washes_end() {
    let Some((_, mut world)) = hill() else { return };
    for camera in [ACROSS, ABOVE] {
        let pose = world.pose(camera);
        for edge_px in [2.0, 5.0] {
            let drawn = drawing(&mut world, &style(TWO, &water(&[("edge", 1.5), ("edge_px", edge_px)])), pose);
            // An interpolated sample between pixels also reads the next pixel.
            let [far, near] = edges(&drawn, edge_px + 1.5);
            println!("{camera}, edge of {edge_px} px: {far:.4} far from borders, part {near:.3} of the tone at them");
            assert!(far < 1e-3 && near > 0.5, "{camera}, edge of {edge_px} px: {far}, {near}");
            // Planted: edges that reach twice as far as they should, and a wash without edges.
            assert!(edges(&drawn, 0.5 * edge_px)[0] > 0.05);
        }
        let dry = drawing(&mut world, &style(TWO, &water(&[])), pose);
        assert!(edges(&dry, 3.0)[1] < 1e-3);
    }
}

/// Returns the largest change of means over squares of 64 pixels, and the mean change of pixels, by the wash.
fn grain(drawn: &Drawn) -> [f64; 2] {
    let changes: Vec<f64> =
        drawn.tone.iter().zip(&drawn.washed).map(|(tone, washed)| luminance(washed) - luminance(tone)).collect();
    let mut most = 0.0_f64;
    for (first, [x, y]) in pixels() {
        if x % 32 == 0 && y % 32 == 0 && x as usize + 64 <= WIDTH && y as usize + 64 <= HEIGHT {
            let sum: f64 = (0..64 * 64).map(|k| changes[first + k / 64 * WIDTH + k % 64]).sum();
            most = most.max((sum / 4096.0).abs());
        }
    }
    [most, changes.iter().map(|change| change.abs()).sum::<f64>() / changes.len() as f64]
}

#[test]
fn granulation_keeps_the_mean() {
    let Some((_, mut world)) = hill() else { return };
    let pose = world.pose(ABOVE);
    for tone in [TWO, EVEN, "steps = 0"] {
        let mut of = |water: &str| grain(&drawing(&mut world, &style(tone, water), pose));
        let [most, mean] = of(&water(&[("granulation", 1.0)]));
        println!("{tone:?}: grain of {mean:.4}, means are off by {most:.4} at most");
        assert!(most < 0.004 && mean > 0.005, "{tone:?}: {most}, {mean}");
        // Control: water that carries pigment does not keep the mean of a square, and dry paper has no grain.
        assert!(of(&water(&[("flow", 1.0)]))[0] > 0.004);
        assert!(of(&water(&[]))[1] < 0.005);
    }
}

/// Returns, for each pixel, the next picture's pattern at the same point of the land, or `None` off-screen.
fn followed(first: &Drawn, next: &Drawn, pattern: &impl Fn(&Drawn, usize) -> f64) -> Vec<Option<f64>> {
    let values: Vec<f64> = (0..WIDTH * HEIGHT).map(|i| pattern(next, i)).collect();
    let between = |px: DVec2| {
        let (whole, f) = ((px - 0.5).floor(), (px - 0.5).fract());
        let inside = whole.cmpge(DVec2::ZERO).all() && whole.x < WIDTH as f64 - 1.0 && whole.y < HEIGHT as f64 - 1.0;
        inside.then(|| {
            let i = whole.y as usize * WIDTH + whole.x as usize;
            let upper = values[i] * (1.0 - f.x) + values[i + 1] * f.x;
            let lower = values[i + WIDTH] * (1.0 - f.x) + values[i + WIDTH + 1] * f.x;
            upper * (1.0 - f.y) + lower * f.y
        })
    };
    let there = |place_m: &Option<DVec3>| next.view.place_px((*place_m)? - next.view.pose.position_m);
    first.place_m.iter().map(|place_m| there(place_m).and_then(between)).collect()
}

/// Returns how much of a pattern does not move with the land: the mean squared difference at the same point of the
/// land, divided by that at the same pixel.
fn left_behind(first: &Drawn, next: &Drawn, pattern: impl Fn(&Drawn, usize) -> f64) -> f64 {
    let (mut moved, mut stood, mut count) = (0.0, 0.0, 0);
    for (i, there) in followed(first, next, &pattern).into_iter().enumerate() {
        let Some(there) = there else { continue };
        moved += (there - pattern(first, i)).powi(2);
        stood += (pattern(next, i) - pattern(first, i)).powi(2);
        count += 1;
    }
    assert!(count > 5000);
    moved / (stood + 1e-12)
}

/// Cameras and their motion: near and far, across blocks of 4096 m, and from heights at which cells of the noise are
/// larger.
const MOVES: [(&str, [f64; 3]); 7] = [
    ("100,100,+300,0,-90,50", [30.0, 20.0, 0.0]),
    ("4085,4090,+300,0,-90,50", [30.0, 20.0, 0.0]),
    ("-10,-10,+300,0,-90,50", [30.0, 20.0, 0.0]),
    ("100,100,+300,30,-40,50", [20.0, 15.0, 0.0]),
    ("100,100,+300,30,-50,50", [0.0, 0.0, -9.0]),
    ("4000,4090,+9000,0,-90,50", [900.0, 600.0, 0.0]),
    ("-3000,-2000,+300000,0,-90,3", [4000.0, 3000.0, 0.0]),
];

/// Allowed ratio: as the camera approaches, the next size of noise appears.
const LEFT_BEHIND: f64 = 0.12;

#[test]
fn what_runs_does_so_with_the_land() {
    let Some(mut world) = plain() else { return };
    let ink = |drawn: &Drawn, i: usize| luminance(&drawn.washed[i]) - luminance(&drawn.tone[i]);
    // Planted: a pattern of the same size that is fixed to the picture.
    let sheet = |_: &Drawn, i: usize| ((i % WIDTH) as f64 * 0.13).sin() * ((i / WIDTH) as f64 * 0.11).sin();
    for (camera, by_m) in MOVES {
        let pose = world.pose(camera);
        let mut moved = pose;
        moved.position_m += DVec3::from(by_m);
        let style = style(EVEN, &water(&[("flow", 1.0)]));
        let (first, next) = (drawing(&mut world, &style, pose), drawing(&mut world, &style, moved));
        let left = left_behind(&first, &next, ink);
        println!("{camera} by {by_m:?} m: {left:.3} of the pattern is left behind");
        assert!(left < LEFT_BEHIND, "{camera} by {by_m:?} m: {left}");
        assert!(
            left_behind(&first, &next, sheet) > LEFT_BEHIND,
            "{camera}: a planted pattern on the page was not detected"
        );
    }
}

/// Returns the difference between washes of two pictures at the same points of the land, divided by what warping has
/// changed.
fn strays(first: &Drawn, next: &Drawn, washed: impl Fn(&Drawn, usize) -> f64) -> f64 {
    let (mut moved, mut changed, mut count) = (0.0, 0.0, 0);
    for (i, there) in followed(first, next, &washed).into_iter().enumerate() {
        let Some(there) = there else { continue };
        let own = washed(first, i);
        moved += (there - own).powi(2);
        changed += (luminance(&first.tone[i]) - own).powi(2);
        count += 1;
    }
    assert!(count > 5000 && changed > 10.0, "{count}, {changed}");
    moved / changed
}

/// Largest allowed result of [`strays`].
const STRAYS: f64 = 0.1;

#[test]
fn washes_stray_with_the_land() {
    let Some((_, mut world)) = hill() else { return };
    let own = |drawn: &Drawn, i: usize| luminance(&drawn.washed[i]);
    // Planted: a warp of the same size that is fixed to the page.
    let sheet = |drawn: &Drawn, i: usize| {
        let (x, y) = ((i % WIDTH) as f64, (i / WIDTH) as f64);
        let at = [x + 7.0 * (0.3 * y).sin(), y + 7.0 * (0.26 * x).sin()].map(|at| at.max(0.0) as usize);
        luminance(&drawn.tone[at[1].min(HEIGHT - 1) * WIDTH + at[0].min(WIDTH - 1)])
    };
    for (camera, by_m, allowed) in [
        (ABOVE, [150.0, 100.0, 0.0], STRAYS),
        (ABOVE, [0.0, 0.0, -60.0], STRAYS),
        (ACROSS, [60.0, 40.0, 0.0], STRAYS),
        (ABOVE, [0.0, 0.0, -200.0], STRAYS),
    ] {
        let pose = world.pose(camera);
        let mut moved = pose;
        moved.position_m += DVec3::from(by_m);
        let style = style("steps = 2\nsoftness = 0.3", &water(&[("warp_px", 10.0)]));
        let (first, next) = (drawing(&mut world, &style, pose), drawing(&mut world, &style, moved));
        let (right, planted) = (strays(&first, &next, own), strays(&first, &next, sheet));
        println!("{camera} by {by_m:?} m: washes differ by {right:.3} of the warp, on the page by {planted:.3}");
        assert!(right < allowed && planted > allowed, "{camera} by {by_m:?} m: {right}, {planted}");
    }
}

/// Returns an error if the sky is wet, or a number is invalid.
fn check(drawn: &Drawn, dry: &Drawn) -> Result<(), String> {
    for (i, place_m) in drawn.place_m.iter().enumerate() {
        let is_number = |value: &f64| (-1e-6..=1.0 + 1e-6).contains(value);
        if !drawn.washed[i].iter().chain(&drawn.picture[i]).all(is_number) {
            return Err(format!("pixel {i} is {:?} and {:?}", drawn.washed[i], drawn.picture[i]));
        }
        if place_m.is_none() && (drawn.picture[i] != dry.picture[i] || drawn.washed[i] != drawn.tone[i]) {
            return Err(format!("pixel {i} of the sky is wet"));
        }
    }
    Ok(())
}

#[test]
fn the_sky_stays_dry_and_numbers_finite() {
    let Some((_, mut world)) = hill() else { return };
    let most = [("edge", 4.0), ("edge_px", 16.0), ("granulation", 2.0), ("flow", 2.0), ("warp_px", 32.0)];
    for camera in [
        "-900,-1300,200,35,-2,50",
        "-900,-1300,+0.1,35,0,60",
        "0,0,+2,35,-89,60",
        "0,0,1000000,0,-90,1",
        "0,0,500,0,90,60",
    ] {
        let pose = world.pose(camera);
        let [wet, dry] = [&most[..], &[]].map(|values| drawing(&mut world, &style(TWO, &water(values)), pose));
        check(&wet, &dry).unwrap_or_else(|why| panic!("{camera}: {why}"));
        let mut planted = wet.clone();
        planted.washed[77][1] = f64::NAN;
        assert!(check(&planted, &dry).is_err());
        if let Some(sky) = wet.place_m.iter().position(Option::is_none) {
            let mut planted = wet.clone();
            planted.picture[sky][0] *= 0.9;
            assert!(check(&planted, &dry).is_err(), "{camera}: a planted wet sky was not detected");
        }
    }
}
