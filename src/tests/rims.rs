//! Tests the dashed rims of holes that remain in the data: a rim is where the data end, and smooth; its dashes are
//! even; no other line follows it; and land without holes has none.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{NOON, draw, floats, places_m, still};
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::target::TargetKind;
use hachure::lines::rims::RIMLESS;
use hachure::lines::strokes::stroke::INK;
use hachure::lines::threshold::LINE;
use hachure::picture::PictureRequest;
use hachure::picture::strokes::render_strokes;
use hachure::style::Style;
use hachure::surface::rims::RIM;

const SIZE_PX: [u32; 2] = [400, 400];
const SAMPLES: u32 = 257;
const SPACING_M: f64 = 10.0;
const MIDDLE_M: DVec2 = DVec2::new(31.0, -17.0);
const RADIUS_M: f64 = 300.0;
/// Cameras that look straight down from near and from far, and along the land.
const ABOVE: &str = "31,-17,1000,0,-90,50";
const HIGH: &str = "31,-17,3200,0,-90,50";
const ALONG: &str = "31,-1000,+420,0,-24,50";

/// Long waves, which have no contours from above.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    40.0 * (x_m / 700.0).sin() * (y_m / 900.0).cos()
}

/// Returns the land with a circle that is no-data, or raised by `inside_m`.
fn world_with(inside_m: Option<f64>) -> Option<World> {
    let cut = |x_m: f64, y_m: f64| DVec2::new(x_m, y_m).distance(MIDDLE_M) < RADIUS_M;
    let land = |x_m: f64, y_m: f64| height_m(x_m, y_m) + if cut(x_m, y_m) { inside_m.unwrap_or(f64::NAN) } else { 0.0 };
    World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, land), 0.2)
}

fn style(name: &str, change: impl Fn(&mut Style)) -> Style {
    let mut style = common::all_lines(name);
    change(&mut style);
    style
}

/// A pixel of land seen from above: its ink, and its distance and direction from the middle of the hole.
struct Shown {
    ink: f64,
    away_m: f64,
    angle_rad: f64,
}

/// Draws the land from above. Returns its pixels, and the width of a pixel in metres.
fn above(world: &mut World, camera: &str, style: &Style) -> (Vec<Shown>, f64) {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let view = still(pose, SIZE_PX);
    // Rims depend on no other layer.
    let others: &[&str] = if common::full() { &[] } else { &["strokes", "water"] };
    let style = style.clone().without(others);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
    let rim = floats::<2>(&world.gpu, renderer.target(&RIM).unwrap());
    let places = places_m(&world.gpu, &renderer, pose.position_m);
    let shown = rim.iter().zip(&places).filter_map(|([ink, _], place)| {
        let about = place.as_ref()?.truncate() - MIDDLE_M;
        Some(Shown { ink: f64::from(*ink), away_m: about.length(), angle_rad: about.y.atan2(about.x) })
    });
    (shown.collect(), pose.position_m.z / view.focal_px())
}

/// Returns the mean and the standard deviation of (value, weight) pairs.
fn mean_and_spread(values: &[(f64, f64)]) -> [f64; 2] {
    let sum: f64 = values.iter().map(|(_, weight)| weight).sum();
    let mean = values.iter().map(|(value, weight)| value * weight).sum::<f64>() / sum;
    let square = values.iter().map(|(value, weight)| (value - mean).powi(2) * weight).sum::<f64>() / sum;
    [mean, square.sqrt()]
}

#[test]
fn a_round_hole_has_a_round_rim() {
    let Some(mut world) = world_with(None) else { return };
    let style = style("strokes", |style| style.rims_mut().unwrap().gap_px = 0.0);
    // Samples of several pixels, and samples of little more than one.
    for camera in [ABOVE, HIGH] {
        let (shown, pixel_m) = above(&mut world, camera, &style);
        let ink: Vec<(f64, f64)> = shown.iter().map(|own| (own.away_m, own.ink)).collect();
        let [mean_m, spread_m] = mean_and_spread(&ink);
        // The land ends at the first valid samples, on average half the spacing beyond the circle. The middle of the
        // line is half its width farther.
        let width_px = f64::from(style.rims().unwrap().width_px);
        let expected_m = RADIUS_M + 0.5 * SPACING_M + 0.5 * width_px * pixel_m;
        let drawn = ink.iter().filter(|(_, ink)| *ink > 0.25);
        let farthest_m = drawn.map(|(away_m, _)| (away_m - expected_m).abs()).fold(0.0, f64::max);
        let [off_px, spread_px, farthest_px] =
            [mean_m - expected_m, spread_m, farthest_m].map(|metres| metres / pixel_m);
        println!(
            "a sample is {:.1} px: {off_px:.2} px from the circle, spread {spread_px:.2} px, {farthest_px:.2} at most",
            SPACING_M / pixel_m
        );
        // Samples are up to half the spacing away from the circle; a pixel's centre can be half a pixel away from its
        // ink.
        let max_px = 0.5 + 0.5 * SPACING_M / pixel_m;
        assert!(off_px.abs() < 0.5 && spread_px < 1.0 && farthest_px < max_px);
        // Planted: another circle, and the outline of cells that have a no-data corner, which has stairs.
        assert!((off_px + 1.0).abs() > 0.5 && (off_px - 1.0).abs() > 0.5);
        let [_, stairs_m] = mean_and_spread(&stairs());
        println!("stairs: spread {:.2} px", stairs_m / pixel_m);
        assert!(camera == HIGH || stairs_m / pixel_m > 1.3 * spread_px.max(0.9));
        // The rim covers its length once, with its width. Where samples are small its ink is pale.
        if camera == ABOVE {
            let length_px = std::f64::consts::TAU * mean_m / pixel_m;
            let found_px = ink.iter().map(|(_, ink)| ink).sum::<f64>() / length_px;
            println!("{found_px:.2} px wide, requested {width_px:.2}");
            assert!((found_px / width_px - 1.0).abs() < 0.15, "{found_px}");
        }
    }
}

/// Returns the distances from the middle at which cells with a no-data corner end.
fn stairs() -> Vec<(f64, f64)> {
    let half = 0.5 * f64::from(SAMPLES - 1);
    let is_void = |x: f64, y: f64| ((DVec2::new(x, y) - half) * SPACING_M).distance(MIDDLE_M) < RADIUS_M;
    let is_cut = |at_m: DVec2| {
        let cell = (at_m / SPACING_M + half).floor();
        (0..2).any(|x| (0..2).any(|y| is_void(cell.x + f64::from(x), cell.y + f64::from(y))))
    };
    let end_m = |way: DVec2| {
        let steps = (0..1200).map(|step| RADIUS_M - 60.0 + 0.1 * f64::from(step));
        steps.rev().find(|away_m| is_cut(MIDDLE_M + way * *away_m)).unwrap()
    };
    let angles = (0..3600).map(|i| f64::from(i) / 3600.0 * std::f64::consts::TAU);
    angles.map(|angle| (end_m(DVec2::from_angle(angle)), 1.0)).collect()
}

/// Returns mean and standard deviation of the lengths of dashes and of gaps along the circle, in pixels, and the ink
/// relative to a solid line.
fn dashes(shown: &[Shown], pixel_m: f64, width_px: f64) -> ([f64; 2], [f64; 2], f64) {
    let radius_m = RADIUS_M + 0.5 * SPACING_M;
    let length_px = std::f64::consts::TAU * radius_m / pixel_m;
    let bins = (length_px / 0.75) as usize;
    let mut ink = vec![0.0_f64; bins];
    for own in shown.iter().filter(|own| own.ink > 0.0) {
        let bin = ((own.angle_rad / std::f64::consts::TAU + 1.0) * bins as f64) as usize % bins;
        // A pixel is wider than a bin, so it also counts in the neighbouring bins.
        for near in [bin + bins - 1, bin, bin + 1] {
            ink[near % bins] = ink[near % bins].max(own.ink);
        }
    }
    // The bins are rotated so that they begin with the end of a dash.
    let begin = (0..bins).find(|&bin| ink[bin] > 0.5 && ink[(bin + 1) % bins] <= 0.5).unwrap_or(0);
    let is_dash = |bin: usize| ink[(begin + 1 + bin) % bins] > 0.5;
    let mut runs: [Vec<(f64, f64)>; 2] = Default::default();
    let mut at = 0;
    while at < bins {
        let kind = is_dash(at);
        let end = (at..bins).find(|&bin| is_dash(bin) != kind).unwrap_or(bins);
        runs[usize::from(kind)].push(((end - at) as f64 * length_px / bins as f64, 1.0));
        at = end;
    }
    let [gaps, dashes] = runs.map(|runs| if runs.is_empty() { [0.0, 0.0] } else { mean_and_spread(&runs) });
    // Counting neighbouring bins makes dashes longer.
    let longer_px = 2.0 * length_px / bins as f64;
    let (dashes, gaps) = ([dashes[0] - longer_px, dashes[1]], [gaps[0] + longer_px, gaps[1]]);
    let share = shown.iter().map(|own| own.ink).sum::<f64>() / (width_px * length_px);
    (dashes, gaps, share)
}

#[test]
fn dashes_are_even_and_have_their_share_of_ink() {
    let Some(mut world) = world_with(None) else { return };
    for (dash_px, gap_px) in [(6.0, 5.0), (14.0, 8.0)] {
        let dashed = |dash_px: f32, gap_px: f32| {
            style("strokes", |style| {
                style.rims_mut().unwrap().width_px = 1.5;
                style.rims_mut().unwrap().dash_px = dash_px;
                style.rims_mut().unwrap().gap_px = gap_px;
            })
        };
        let (shown, pixel_m) = above(&mut world, ABOVE, &dashed(dash_px, gap_px));
        let (found, gaps, share) = dashes(&shown, pixel_m, 1.5);
        println!("requested {dash_px} and {gap_px} px: dashes {found:.1?}, gaps {gaps:.1?}, share {share:.2}");
        let asked = f64::from(dash_px / (dash_px + gap_px));
        let is_right = |found: [f64; 2], gaps: [f64; 2], share: f64| {
            let period_px = found[0] + gaps[0];
            (period_px / f64::from(dash_px + gap_px) - 1.0).abs() < 0.1
                && (found[0] / f64::from(dash_px) - 1.0).abs() < 0.15
                && found[1] < 0.25 * f64::from(dash_px)
                && (share / asked - 1.0).abs() < 0.15
        };
        assert!(is_right(found, gaps, share));
        // Planted: a solid line, and dashes of other lengths.
        for planted in [dashed(dash_px, 0.0), dashed(2.0 * dash_px, gap_px)] {
            let (shown, pixel_m) = above(&mut world, ABOVE, &planted);
            let (found, gaps, share) = dashes(&shown, pixel_m, 1.5);
            assert!(!is_right(found, gaps, share), "{found:?} {gaps:?} {share}");
        }
    }
}

/// Returns the share of points on the rim that have a line of `kind` within two pixels, and the number of points inside
/// the circle with such a line.
fn lines_along(world: &mut World, style: &Style, kind: &TargetKind) -> [f64; 2] {
    let pose = world.pose(ALONG);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let view = still(pose, SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &NOON);
    let target = renderer.target(kind).unwrap();
    let line: Vec<f64> = match kind.format {
        wgpu::TextureFormat::R16Float => halves_of_one(&world.gpu, target),
        _ => floats::<1>(&world.gpu, target).into_iter().map(|[line]| line.into()).collect(),
    };
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let [mut rim, mut covered, mut inside] = [0.0, 0.0, 0.0];
    let clip = view.still_uniform(pose.position_m).clip_from_camera;
    let clip = glam::Mat4::from_cols_array_2d(&clip);
    let on_picture = |way: DVec2, away_m: f64| {
        let at_m = MIDDLE_M + way * away_m;
        let at_m = DVec3::new(at_m.x, at_m.y, height_m(at_m.x, at_m.y)) - pose.position_m;
        let at = clip * at_m.as_vec3().extend(1.0);
        let x = (0.5 + 0.5 * at.x / at.w) * width as f32;
        let y = (0.5 - 0.5 * at.y / at.w) * height as f32;
        let is_inside = at.w > 0.0 && x >= 3.0 && y >= 3.0 && x < width as f32 - 3.0 && y < height as f32 - 3.0;
        is_inside.then_some([x as usize, y as usize])
    };
    let most = |[x, y]: [usize; 2], reach: usize| {
        let around = (y - reach..=y + reach).flat_map(|y| (x - reach..=x + reach).map(move |x| y * width + x));
        around.map(|i| line[i]).fold(0.0, f64::max)
    };
    for way in (0..1440).map(|i| DVec2::from_angle(f64::from(i) / 1440.0 * std::f64::consts::TAU)) {
        if let Some(at) = on_picture(way, RADIUS_M + 0.5 * SPACING_M) {
            rim += 1.0;
            covered += f64::from(u8::from(most(at, 2) > 0.2));
        }
        for part in [0.2, 0.5, 0.8, 0.9] {
            inside += on_picture(way, part * RADIUS_M).map_or(0.0, |at| f64::from(u8::from(most(at, 0) > 0.2)));
        }
    }
    assert!(rim > 1000.0);
    [covered / rim, inside]
}

fn halves_of_one(gpu: &hachure::gpu::Gpu, target: &hachure::gpu::target::Target) -> Vec<f64> {
    let bytes = hachure::gpu::readback::read(gpu, target, [0, 0], target.size_px()).unwrap();
    bytes.chunks_exact(2).map(|texel| half::f16::from_le_bytes([texel[0], texel[1]]).to_f64()).collect()
}

#[test]
fn no_other_line_follows_a_rim() {
    let Some(mut world) = world_with(None) else { return };
    let Some(mut pit) = world_with(Some(-250.0)) else { return };
    let all = [("lsa", &RIMLESS), ("strokes", &INK), ("sobel", &RIMLESS), ("roystan", &RIMLESS)];
    for (name, kind) in all.into_iter().take(if common::full() { 4 } else { 2 }) {
        let style = style(name, |_| {});
        let [along, inside] = lines_along(&mut world, &style, kind);
        // Planted: the lines before those along rims are removed, or the strokes of a pit that is land.
        let [line, _] = if name == "strokes" {
            lines_along(&mut pit, &style, kind)
        } else {
            lines_along(&mut world, &style, &LINE)
        };
        println!(
            "{name}: {:.1} % of the rim have a line, {inside} points in the hole; planted {:.0} %",
            100.0 * along,
            100.0 * line
        );
        assert!(along < 0.02 && inside < 1.0, "{name}: {along} {inside}");
        assert!(line > 0.3, "{name}: {line}");
    }
}

/// Tests a ridge in front of land that ends at a hole: the ridge's contour is next to land that borders on the hole,
/// and must stay.
#[test]
fn a_ridge_before_a_hole_keeps_its_line() {
    let ridge_m = |x_m: f64, y_m: f64| height_m(x_m, y_m) + 120.0 * (-((y_m + 420.0) / 40.0).powi(2)).exp();
    let is_hole = |x_m: f64, y_m: f64| DVec2::new(x_m, y_m).distance(MIDDLE_M) < RADIUS_M;
    let with_hole = |x_m: f64, y_m: f64| if is_hole(x_m, y_m) { f64::NAN } else { ridge_m(x_m, y_m) };
    let [whole, holed] = [
        World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, ridge_m), 0.2),
        World::new(grid_of(SAMPLES, SAMPLES, SPACING_M, with_hole), 0.2),
    ];
    let (Some(mut whole), Some(mut holed)) = (whole, holed) else { return };
    // From here the near rim is just behind the crest.
    let pose = whole.pose("31,-1000,240,0,-14,50");
    for name in ["lsa", "sobel"].into_iter().take(if common::full() { 2 } else { 1 }) {
        let style = Style::load(name).unwrap();
        let seen = |world: &mut World, kind: &TargetKind| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &NOON);
            let line = floats::<1>(&world.gpu, renderer.target(kind).unwrap());
            let rim = renderer.target(&RIM).map(|rim| floats::<2>(&world.gpu, rim));
            (line, rim)
        };
        let (crest, _) = seen(&mut whole, &LINE);
        let (kept, rim) = seen(&mut holed, &RIMLESS);
        let rim = rim.unwrap();
        let width = SIZE_PX[0] as usize;
        let is_near_rim = |pixel: usize| {
            let around = (-2..=2_i64).flat_map(|y| (-2..=2_i64).map(move |x| y * width as i64 + x));
            around
                .filter_map(|by| rim.get(usize::try_from(pixel as i64 + by).ok()?))
                .any(|[_, next_to_hole]| *next_to_hole > 0.0)
        };
        let lines: Vec<usize> = (0..crest.len()).filter(|pixel| crest[*pixel][0] > 0.5).collect();
        let is_kept = |pixel: usize| [pixel - width, pixel, pixel + width].iter().any(|near| kept[*near][0] > 0.5);
        let left = lines.iter().filter(|pixel| is_kept(**pixel)).count();
        let near_rim = lines.iter().filter(|pixel| is_near_rim(**pixel)).count();
        println!("{name}: {left} of {} pixels of the crest's line are left, {near_rim} are near a rim", lines.len());
        assert!(left as f64 > 0.98 * lines.len() as f64);
        // Planted: the line without its pixels near land that borders on a hole.
        assert!(lines.len() - near_rim < (0.98 * lines.len() as f64) as usize, "no part of the line is near a rim");
    }
}

#[test]
fn land_without_holes_has_no_rim() {
    let Some(mut world) = world_with(Some(0.0)) else { return };
    for name in ["lsa", "pen"].into_iter().take(if common::full() { 2 } else { 1 }) {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let view = still(world.pose(ALONG), SIZE_PX);
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &Style::load(name).unwrap(), &NOON);
        assert!(renderer.target(&RIM).is_none() && renderer.target(&RIMLESS).is_none());
    }
    // Control: a single no-data sample causes a rim.
    let mut grid = grid_of(SAMPLES, SAMPLES, SPACING_M, height_m);
    grid.heights_m[128 * 257 + 128] = f32::NAN;
    let Some(mut world) = World::new(grid, 0.2) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let view = still(world.pose(ABOVE), SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &Style::load("lsa").unwrap(), &NOON);
    assert!(renderer.target(&RIM).is_some());
}

#[test]
fn rims_are_a_layer_of_lines() {
    let Some(mut world) = world_with(None) else { return };
    let style = style("strokes", |style| style.set_water(None));
    let request = PictureRequest::still(world.pose(ABOVE), SIZE_PX, &style, NOON);
    let drawn = render_strokes(&world.gpu, &mut None, &mut world.surfaces, &request, None).unwrap();
    let group = drawn.marks.iter().find(|group| group.id == "rims").unwrap();
    assert_eq!(group.kind, hachure::vector::GroupKind::Ink(hachure::vector::InkKind::Rim));
    let length = |pair: &[hachure::lines::strokes::polylines::PolylinePoint]| {
        f64::from((pair[1].px[0] - pair[0].px[0]).hypot(pair[1].px[1] - pair[0].px[1]))
    };
    let length_px: f64 = group.lines.iter().flat_map(|line| line.points.windows(2)).map(length).sum();
    let focal_px = still(world.pose(ABOVE), SIZE_PX).focal_px();
    let whole_px = std::f64::consts::TAU * RADIUS_M * focal_px / 1000.0;
    let dashes = whole_px / f64::from(style.rims().unwrap().dash_px + style.rims().unwrap().gap_px);
    println!("{} lines for {dashes:.0} dashes, {length_px:.0} px of {whole_px:.0}", group.lines.len());
    assert!((group.lines.len() as f64 / dashes - 1.0).abs() < 0.2);
    let share = length_px / whole_px;
    assert!(share > 0.25 && share < 0.7, "{share}");
}

/// Tests that land ends at the rim: nothing is drawn farther from a sample than half the spacing.
#[test]
fn nothing_is_drawn_in_a_hole() {
    let Some(mut world) = world_with(None) else { return };
    let pose = world.pose(ABOVE);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(
        &world.gpu,
        &mut world.surfaces,
        &mut renderer,
        &still(pose, SIZE_PX),
        &Style::load("strokes").unwrap(),
        &NOON,
    );
    let places = places_m(&world.gpu, &renderer, pose.position_m);
    let nearest_m =
        places.iter().flatten().map(|at_m| at_m.truncate().distance(MIDDLE_M)).fold(f64::INFINITY, f64::min);
    println!("the nearest land is {nearest_m:.1} m from the middle");
    assert!(nearest_m > RADIUS_M - 0.5 * SPACING_M, "{nearest_m}");
}
