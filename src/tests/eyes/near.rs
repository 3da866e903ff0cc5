//! Objects 0.2 m to 10 m away, on which contours are at different places for each eye.

use std::sync::Arc;

use hachure::mesh::Mesh;
use hachure::mesh::placed::Stance;

use super::*;
use crate::tests::common::{World, all_lines, full, real_data};
use crate::tests::helpers::shapes;

const SIZE_PX: [u32; 2] = [480, 270];
const IPD_M: f64 = 0.065;

/// A camera high above the land, so that the object is seen alone against land and sky.
const CAMERA: &str = "0,0,700,20,-20,60";

/// Distance and radius of the object, in metres.
const PLACES: [(f64, f64); 4] = [(0.2, 0.06), (0.5, 0.12), (2.0, 0.6), (10.0, 3.0)];

const REAL: [&str; 4] = [
    "obj/permissive/suzanne.obj",
    "obj/permissive/spot_triangulated.obj",
    "obj/trees_quaternius/Pine_1.obj",
    "obj/trees_quaternius/DeadTree_3.obj",
];

/// Places an object in front of the camera.
fn place(world: &mut World, mesh: &Arc<Mesh>, (away_m, radius_m): (f64, f64), z_up: bool, yaw_deg: f64) -> Pose {
    let pose = world.pose(CAMERA);
    let middle_m = pose.position_m + pose.forward * away_m;
    let mut stance = Stance { z_up, ..shapes::stance(middle_m, yaw_deg, radius_m / mesh.radius_m) };
    let standing = shapes::place(world, mesh, &stance);
    stance.origin_m += middle_m - standing.middle_m;
    shapes::place(world, mesh, &stance);
    pose
}

/// Least fraction of the ink of `charcoal` that must remain in a cell. Its texture has gaps, whose positions change
/// where a stroke takes over another identity.
const MIN_LEFT: f64 = 0.3;

/// Draws each eye alone, without agreement between them.
fn draw_alone(world: &mut World, style: &Style, rig: &Rig) -> Vec<DrawnFrame> {
    let mut of = |eye: usize| draw(&world.gpu, &mut world.surfaces, style, &Rig::mono(rig.eyes[eye])).remove(0);
    vec![of(0), of(1)]
}

/// Returns the fraction of ink, relative to each eye alone, in the cell of 30 × 30 pixels where it is least.
fn min_left(pair: &[DrawnFrame], alone: &[DrawnFrame]) -> f64 {
    const CELL_PX: u32 = 30;
    // Cells with fewer pixels of ink hold only ends of lines.
    const MIN_INK: f64 = 30.0;
    let cells = |eye: &DrawnFrame| {
        let mut sums = vec![0.0; (SIZE_PX[0] / CELL_PX * (SIZE_PX[1] / CELL_PX)) as usize];
        for (pixel, ink) in (0..).zip(eye.ink.as_ref().unwrap()) {
            let [column, row] = [pixel % SIZE_PX[0] / CELL_PX, pixel / SIZE_PX[0] / CELL_PX];
            sums[(row * (SIZE_PX[0] / CELL_PX) + column) as usize] += f64::from(*ink);
        }
        sums
    };
    let left = pair.iter().zip(alone).flat_map(|(pair, alone)| cells(pair).into_iter().zip(cells(alone)));
    left.filter(|(_, alone)| *alone >= MIN_INK).map(|(pair, alone)| pair / alone).fold(f64::INFINITY, f64::min)
}

/// Leaves out, in the fast tier, what changes no line of a style: marks, streams, water, shadows and crests.
fn with_only_lines(mut style: Style) -> Style {
    if full() {
        return style;
    }
    (style.light.shadow, style.light.occlusion, style.light.crests) = (0.0, 0.0, 0.0);
    style.without(&["hatching", "drainage", "water"])
}

/// Returns a metric; NaN if it was not measured.
fn part(metrics: &Metrics, name: &str) -> f64 {
    metrics[name].unwrap_or(f64::NAN)
}

struct Measured {
    pair: Metrics,
    orphans: f64,
    min_left: f64,
    /// The pair as drawn with agreement.
    eyes: Vec<DrawnFrame>,
}

fn measure(world: &mut World, thing: &str, style: &str, rig: &Rig) -> Measured {
    // Without the limit on crowded lines, which omits lines in both eyes, no contour may be lost to agreement.
    let all = with_only_lines(all_lines(style));
    let all_eyes = draw(&world.gpu, &mut world.surfaces, &all, rig);
    let min_left = min_left(&all_eyes, &draw_alone(world, &all, rig));
    let style = with_only_lines(Style::load(style).unwrap());
    let eyes = draw(&world.gpu, &mut world.surfaces, &style, rig);
    let pair = agreement(&eyes);
    let orphans = part(&pair, "orphans");
    println!(
        "{thing}, {}: coverage {:.3} %, in a cell at least {min_left:.3} of that alone; orphans {:.3} %; correlation \
         of ink {:.3}; other identity {:.2} %, other width {:.2} %",
        style.name,
        100.0 * part(&pair, "line_coverage"),
        100.0 * orphans,
        part(&pair, "line_correlation"),
        100.0 * part(&pair, "other_identity"),
        100.0 * part(&pair, "other_width"),
    );
    Measured { pair, orphans, min_left, eyes }
}

#[test]
fn near_things_have_the_same_lines_for_both_eyes() {
    let Some((_, mut world)) = shapes::hill() else { return };
    // In the fast tier only the ball, as near as it comes; the last test draws a cube.
    let (of_ball, of_cube): (&[usize], &[usize]) = if full() { (&[0, 1, 2, 3], &[1, 2]) } else { (&[0], &[]) };
    for (shape, soup, places) in [("ball", shapes::sphere(5), of_ball), ("cube", shapes::cube(), of_cube)] {
        let mesh = Arc::new(shapes::mesh(soup));
        for (away_m, radius_m) in places.iter().map(|place| PLACES[*place]) {
            let pose = place(&mut world, &mesh, (away_m, radius_m), true, 45.0);
            let rig = rig(pose, IPD_M, SIZE_PX);
            let thing = format!("{shape} {away_m} m away");
            let lines = measure(&mut world, &thing, "lsa", &rig);
            let strokes = measure(&mut world, &thing, "charcoal", &rig);
            // At a hand's breadth, the whole ball is between the contours of both eyes.
            let most = if away_m < 0.5 { 0.1 } else { 0.01 };
            assert!(lines.orphans <= most && strokes.orphans <= most, "{thing}: lines without a partner");
            assert!(lines.min_left >= 0.8 && strokes.min_left >= MIN_LEFT, "{thing}: a cell lost its ink");
            // Strokes that run off the picture leave it at different places in each eye.
            let correlation = part(&strokes.pair, "line_correlation");
            assert!(away_m < 0.5 || correlation >= 0.93, "{thing}: the correlation of strokes is below 0.93");
            let mut eyes = strokes.eyes;
            // Planted error: a column of cells that one eye lost.
            let mut lost = eyes.clone();
            let columns = (210..270).flat_map(|column| (0..SIZE_PX[1] as usize).map(move |row| (row, column)));
            columns.for_each(|(row, column)| lost[0].ink.as_mut().unwrap()[row * SIZE_PX[0] as usize + column] = 0.0);
            assert!(min_left(&lost, &eyes) < MIN_LEFT && min_left(&eyes, &eyes) == 1.0, "{thing}");
            // Planted error: strokes of the right eye that are four pixels lower.
            eyes[1].ink.as_mut().unwrap().rotate_right(4 * SIZE_PX[0] as usize);
            let lower = agreement(&eyes);
            assert!(lower["orphans"].unwrap() > 0.05 && lower["line_correlation"].unwrap() < 0.9, "{thing}");
        }
    }
}

#[test]
fn models_have_the_same_lines_for_both_eyes() {
    let Some((_, mut world)) = shapes::hill() else { return };
    for (i, name) in REAL.iter().enumerate() {
        let Some(file) = real_data(name) else { continue };
        let mesh = Arc::new(hachure::mesh::obj::read(&file).unwrap());
        // A model and a tree at half a metre, and one of each at two metres.
        for at in &PLACES[1 + i % 2..][..1] {
            let pose = place(&mut world, &mesh, *at, false, 30.0);
            let rig = rig(pose, IPD_M, SIZE_PX);
            let thing = format!("{name} {} m away", at.0);
            // In the fast tier one style of lines, and of strokes the broadest.
            let styles = if full() { &["lsa", "strokes", "charcoal"][..] } else { &["lsa", "charcoal"] };
            for &style in styles {
                let measured = measure(&mut world, &thing, style, &rig);
                let alone = with_only_lines(Style::load(style).unwrap());
                let alone = agreement(&draw_alone(&mut world, &alone, &rig));
                let orphans_alone = part(&alone, "orphans");
                println!(
                    "alone: orphans {:.3} %; correlation of ink {:.3}; coverage of the pair {:.3} of that alone",
                    100.0 * orphans_alone,
                    part(&alone, "line_correlation"),
                    part(&measured.pair, "line_coverage") / part(&alone, "line_coverage"),
                );
                // Broad strokes on needles this near: of several parallel outlines each eye keeps another, whose length
                // gives it another width.
                let most = if style == "charcoal" && at.0 < 1.0 { 0.02 } else { 0.01 };
                assert!(measured.orphans <= most, "{thing}, {style}: lines without a partner");
                let least = if style == "charcoal" { MIN_LEFT } else { 0.8 };
                assert!(measured.min_left >= least, "{thing}, {style}: a cell lost its ink");
                assert!(
                    measured.orphans <= (0.5 * orphans_alone).max(0.001),
                    "{thing}, {style}: agreement does not halve the lines without a partner"
                );
            }
        }
    }
}

/// A side of the cube that only the right eye sees, nearly edge-on: the left eye's contour is the near edge of that
/// side, the right eye's is its far edge.
#[test]
fn a_contour_that_jumps_across_a_face_stays_for_both_eyes() {
    let Some((_, mut world)) = shapes::hill() else { return };
    let mesh = Arc::new(shapes::mesh(shapes::cube()));
    let pose = place(&mut world, &mesh, PLACES[1], true, 30.0);
    let charcoal = with_only_lines(Style::load("charcoal").unwrap());
    let eyes = draw(&world.gpu, &mut world.surfaces, &charcoal, &rig(pose, IPD_M, SIZE_PX));
    // The ink of the side alone: right of the centre, between the cube's upper and lower edge, without the land's
    // horizon.
    let of_side = |eye: &DrawnFrame| {
        let ink = eye.ink.as_ref().unwrap();
        let rows = (110..125).chain(150..160);
        let near = |row: usize| (250..300).map(move |column| row * SIZE_PX[0] as usize + column);
        rows.flat_map(near).map(|pixel| f64::from(ink[pixel])).sum::<f64>()
    };
    let [left, right] = [&eyes[0], &eyes[1]].map(of_side);
    println!("ink of the side: {left:.1} and {right:.1}");
    assert!(left > 30.0 && (0.7..1.4).contains(&(left / right)), "ink of the side: left eye {left}, right eye {right}");
}
