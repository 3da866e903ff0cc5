//! Tests that strokes are the visible contours of the surface as drawn, no more and no less, in long lines.
//!
//! The truth is found by brute force: the drawn triangles, joined by the bits of their vertices, are drawn again into a
//! depth image with four times the resolution.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use std::collections::HashMap;

use crate::tests::helpers::stroke_lines::strokes_left;
use crate::tests::helpers::stroke_lines::{along_strokes, covered, doubled, missed};
use common::World;
use common::draw::{NOON, draw, still};
use common::hill::Hill;
use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::lines::strokes::chain::CHAINS;
use hachure::lines::strokes::points::POINTS;
use hachure::lines::strokes::points::Point;
use hachure::lines::strokes::{COUNTS, SEGMENTS};
use hachure::lines::strokes::{Chain, Segment, StrokeCounts};
use hachure::scene::view::View;
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [640, 360];
const SIDE: usize = 17;
/// Pixels of the brute force's depth image per pixel, on each axis.
const FINER: usize = 4;

/// Results of a frame.
struct Drawn {
    view: View,
    /// 17 × 17 vertices of each patch, relative to the camera, in metres.
    vertices: Vec<[f32; 4]>,
    counts: StrokeCounts,
    segments: Vec<Segment>,
    chains: Vec<Chain>,
    points: Vec<Point>,
}

fn drawing(world: &mut World, camera: &str, change: impl FnOnce(&mut Style)) -> Drawn {
    let mut style = common::all_lines("strokes");
    change(&mut style);
    let view = still(world.pose(camera), SIZE_PX);
    let gpu = &world.gpu;
    let mut renderer = Renderer::new(gpu).unwrap();
    let prepared = draw(gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
    let counts: StrokeCounts = strokes_left(gpu, &renderer, &COUNTS, 1)[0];
    Drawn {
        view,
        vertices: renderer.drawn_vertices(gpu, &prepared).unwrap().unwrap(),
        counts,
        segments: strokes_left(gpu, &renderer, &SEGMENTS, counts.segments as usize),
        chains: strokes_left(gpu, &renderer, &CHAINS, counts.chains as usize),
        points: strokes_left(gpu, &renderer, &POINTS, counts.points as usize),
    }
}

/// Projects a point that is relative to the camera. Returns its pixel position and its depth, or `None` behind the eye.
fn project(view: &View, at_m: DVec3) -> Option<(DVec2, f64)> {
    let depth_m = at_m.dot(view.pose.forward);
    let middle = DVec2::new(f64::from(SIZE_PX[0]), f64::from(SIZE_PX[1])) * 0.5;
    let across = DVec2::new(at_m.dot(view.pose.right), -at_m.dot(view.pose.up));
    (depth_m > 1e-3).then(|| (middle + across * (view.focal_px() / depth_m), depth_m))
}

type Bits = [u32; 3];

/// Returns the triangles that have an area, as bits of their vertices.
fn triangles(drawn: &Drawn) -> Vec<[Bits; 3]> {
    let mut triangles = Vec::new();
    for patch in drawn.vertices.chunks_exact(SIDE * SIDE) {
        let at = |x: usize, y: usize| -> Bits {
            let [x, y, z, _] = patch[y * SIDE + x];
            // Negative zero becomes positive zero.
            [x + 0.0, y + 0.0, z + 0.0].map(f32::to_bits)
        };
        for (x, y) in (0..SIDE - 1).flat_map(|y| (0..SIDE - 1).map(move |x| (x, y))) {
            let (nw, ne, sw, se) = (at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1));
            triangles.extend([[nw, ne, se], [nw, se, sw]]);
        }
    }
    triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    triangles
}

fn place(bits: Bits) -> DVec3 {
    let [x, y, z] = bits.map(|bits| f64::from(f32::from_bits(bits)));
    DVec3::new(x, y, z)
}

/// Returns the nearest depth at each pixel of the finer picture.
fn depth_image(view: &View, triangles: &[[Bits; 3]]) -> Vec<f64> {
    let (width, height) = (SIZE_PX[0] as usize * FINER, SIZE_PX[1] as usize * FINER);
    let mut depth_m = vec![f64::INFINITY; width * height];
    for triangle in triangles {
        let corners = triangle.map(|corner| project(view, place(corner)));
        let [Some((a, za)), Some((b, zb)), Some((c, zc))] = corners else { continue };
        let [a, b, c] = [a, b, c].map(|px| px * FINER as f64);
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            continue;
        }
        let low = a.min(b).min(c).max(DVec2::ZERO);
        let high = a.max(b).max(c).min(DVec2::new(width as f64, height as f64));
        let columns = |v: f64, most: usize| (v.max(0.0) as usize).min(most);
        for y in columns(low.y, height)..columns(high.y.ceil(), height) {
            for x in columns(low.x, width)..columns(high.x.ceil(), width) {
                let p = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let wa = (b - p).perp_dot(c - p) / area;
                let wb = (c - p).perp_dot(a - p) / area;
                let wc = 1.0 - wa - wb;
                if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                    let z = 1.0 / (wa / za + wb / zb + wc / zc);
                    let pixel = &mut depth_m[y * width + x];
                    *pixel = pixel.min(z);
                }
            }
        }
    }
    depth_m
}

/// Returns points along the visible contours and borders of the mesh, a quarter of a pixel apart.
fn true_contours(drawn: &Drawn) -> Vec<DVec2> {
    let view = &drawn.view;
    let triangles = triangles(drawn);
    let depth_m = depth_image(view, &triangles);
    let (width, height) = ((SIZE_PX[0] as usize * FINER) as i64, (SIZE_PX[1] as usize * FINER) as i64);
    let mut edges: HashMap<[Bits; 2], Vec<bool>> = HashMap::new();
    for [a, b, c] in &triangles {
        let [pa, pb, pc] = [*a, *b, *c].map(place);
        let normal = (pc - pa).cross(pb - pa);
        let longest = (pb - pa).length_squared().max((pc - pa).length_squared()).max((pc - pb).length_squared());
        // Rows run south, so the normal is up. The side that a sliver triangle shows depends on rounding, so slivers
        // are skipped.
        if normal.length() < 2e-3 * longest {
            continue;
        }
        let faces = normal.dot(pa) < 0.0;
        for [from, to] in [[a, b], [b, c], [c, a]] {
            edges.entry(if from < to { [*from, *to] } else { [*to, *from] }).or_default().push(faces);
        }
    }
    let mut seen = Vec::new();
    for ([a, b], sides) in edges {
        if sides.len() == 2 && sides[0] == sides[1] {
            continue;
        }
        // The rim of the selected patches is not a contour, and only few pixels of the land's own border are in view.
        if sides.len() != 2 {
            continue;
        }
        let (Some((pa, za)), Some((pb, zb))) = (project(view, place(a)), project(view, place(b))) else { continue };
        let steps = ((pb - pa).length() * 4.0).ceil().max(1.0) as usize;
        for step in 0..=steps {
            let t = step as f64 / steps as f64;
            let px = pa.lerp(pb, t);
            if px.x < 0.0 || px.y < 0.0 || px.x >= f64::from(SIZE_PX[0]) || px.y >= f64::from(SIZE_PX[1]) {
                continue;
            }
            let z = 1.0 / ((1.0 - t) / za + t / zb);
            let (x, y) = ((px.x * FINER as f64) as i64, (px.y * FINER as f64) as i64);
            let farthest = (-1..=1)
                .flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)))
                .filter(|(x, y)| (0..width).contains(x) && (0..height).contains(y))
                .map(|(x, y)| depth_m[(y * width + x) as usize])
                .fold(0.0, f64::max);
            if z <= farthest * (1.0 + 2e-4) {
                seen.push(px);
            }
        }
    }
    seen
}

/// Returns recall and precision.
fn exactness(name: &str, drawn: &Drawn) -> (f64, f64) {
    let (truth, strokes) = (true_contours(drawn), along_strokes(&drawn.points, SIZE_PX));
    let (recall, precision) = (covered(&truth, &strokes), covered(&strokes, &truth));
    println!(
        "{name}: recall {recall:.4}, {} points missed by 8 px, precision {precision:.4}, {:.0} px of contour, \
         {:.0} px of strokes",
        missed(&truth, &strokes, 8.0).len(),
        truth.len() as f64 / 4.0,
        strokes.len() as f64 / 4.0
    );
    (recall, precision)
}

const HILL: &[&str] = &["0,-1450,+60,0,-2,50", "900,-900,+20,315,3,60", "-300,-1200,+400,10,-18,55"];
const RAINIER: &[&str] = &["0,0,+300,30,-8,60", "-12000,9000,+900,120,-12,50", "20000,-15000,+100,300,2,40"];

/// Returns the views of Mount Rainier; in the fast tier one of them.
fn of_rainier() -> &'static [&'static str] {
    if common::full() { RAINIER } else { &RAINIER[1..2] }
}

fn hill() -> Option<World> {
    World::new(Hill::square(321, 10.0).1, 1.0)
}

/// Returns Mount Rainier with its few holes filled, which brute force does not handle.
fn rainier() -> Option<World> {
    real("dem/geotiff/mt_rainier_90m.tif")
}

fn real(name: &str) -> Option<World> {
    let path = common::real_data(name)?;
    let mut grid = hachure::source::open(&path, &hachure::source::Silent).unwrap();
    for i in 1..grid.heights_m.len() {
        if grid.heights_m[i].is_nan() {
            grid.heights_m[i] = grid.heights_m[i - 1];
        }
    }
    World::new(grid, 1.0)
}

#[test]
fn contours_are_drawn_and_nothing_else() {
    // In the fast tier, the next test draws the hill.
    let hill = common::full().then(hill).flatten();
    for (name, world, views) in [("hill", hill, HILL), ("Rainier", rainier(), of_rainier())] {
        let Some(mut world) = world else { continue };
        let all: Vec<(f64, f64)> = views
            .iter()
            .map(|camera| {
                let drawn = drawing(&mut world, camera, |style| style.strokes_mut().unwrap().borders = false);
                exactness(&format!("{name} {camera}"), &drawn)
            })
            .collect();
        assert!(all.iter().all(|(recall, precision)| *recall >= 0.98 && *precision >= 0.98), "{all:?}");
    }
}

#[test]
fn a_stroke_that_is_missing_or_astray_is_noticed() {
    let Some(mut world) = hill() else { return };
    let mut drawn = drawing(&mut world, HILL[0], |style| style.strokes_mut().unwrap().borders = false);
    let truth = true_contours(&drawn);
    let strokes = along_strokes(&drawn.points, SIZE_PX);
    assert!(covered(&truth, &strokes) >= 0.98 && covered(&strokes, &truth) >= 0.98);
    // Planted: all strokes five pixels lower, then a third of the chains missing.
    let points = drawn.points.clone();
    drawn.points.iter_mut().for_each(|point| point.px[1] += 5.0);
    assert!(covered(&truth, &along_strokes(&drawn.points, SIZE_PX)) < 0.9);
    assert!(covered(&along_strokes(&drawn.points, SIZE_PX), &truth) < 0.9);
    let chains = drawn.counts.chains;
    let kept: Vec<Point> = points.into_iter().filter(|point| chains > 0 && point.chain % 3 != 0).collect();
    assert!(covered(&truth, &along_strokes(&kept, SIZE_PX)) < 0.98);
}

/// Tests that strokes do not run side by side, as a pen draws no line twice. Planted: edges that are not merged.
#[test]
fn strokes_run_alone() {
    let Some(mut world) = rainier() else { return };
    for camera in of_rainier() {
        let [alone, planted] = [None, Some(0.0)].map(|merge_px| {
            let drawn = drawing(&mut world, camera, |style| {
                let strokes = style.strokes_mut().unwrap();
                strokes.merge_px = merge_px.unwrap_or(strokes.merge_px);
            });
            doubled(&drawn.points, SIZE_PX, 1.0)
        });
        println!(
            "{camera}: {:.1} % has another stroke within a pixel; not merged {:.1} %",
            100.0 * alone,
            100.0 * planted
        );
        assert!(alone <= 0.12 && planted > 0.3, "{camera}: {alone} {planted}");
    }
}

/// Measures twenty views of real land; run with `cargo test --release --lib tests::strokes -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement that takes a minute"]
fn twenty_views() {
    const WORLDS: [&str; 4] = ["mt_rainier_90m.tif", "N46E008_alps.tif", "N49W123.tif", "mt_everest_90m.tif"];
    const VIEWS: [&str; 5] = [
        "0,0,+300,30,-8,60",
        "-12000,9000,+900,120,-12,50",
        "14000,-15000,+100,300,2,40",
        "3000,-30000,+2500,-6,-9,38",
        "-9000,-7000,+1500,75,-20,70",
    ];
    let mut worst: [f64; 4] = [1.0, 1.0, 0.0, 0.0];
    for name in WORLDS {
        let Some(mut world) = real(&format!("dem/geotiff/{name}")) else { continue };
        for camera in VIEWS {
            let drawn = drawing(&mut world, camera, |style| style.strokes_mut().unwrap().borders = false);
            let (recall, precision) = exactness(&format!("{name} {camera}"), &drawn);
            let far = missed(&true_contours(&drawn), &along_strokes(&drawn.points, SIZE_PX), 8.0).len() as f64;
            let twice = doubled(&drawn.points, SIZE_PX, 1.0);
            println!("    {:.1} % has another stroke within a pixel", 100.0 * twice);
            worst = [worst[0].min(recall), worst[1].min(precision), worst[2].max(far), worst[3].max(twice)];
        }
    }
    println!(
        "worst: recall {:.4}, precision {:.4}, {} points missed by 8 px, doubled {:.3}",
        worst[0], worst[1], worst[2], worst[3]
    );
}

#[test]
fn strokes_are_long() {
    let Some(mut world) = rainier() else { return };
    let mut times = Vec::new();
    for camera in RAINIER {
        let drawn = drawing(&mut world, camera, |_| {});
        let length = |segment: &Segment| {
            let [dx, dy] = [0, 1].map(|i| f64::from(segment.b[i] - segment.a[i]) / 16.0);
            dx.hypot(dy)
        };
        let edge_px = drawn.segments.iter().map(length).sum::<f64>() / drawn.segments.len() as f64;
        let lengths: Vec<f64> = drawn.chains.iter().map(|chain| f64::from(chain.length_units) / 16.0).collect();
        let total: f64 = lengths.iter().sum();
        let stroke_px = total / lengths.len() as f64;
        let single: f64 = drawn.chains.iter().zip(&lengths).filter(|(c, _)| c.count == 1).map(|(_, px)| px).sum();
        println!(
            "{camera}: {} edges, {} segments of {edge_px:.2} px, {} strokes of {stroke_px:.1} px ({:.1} times), {:.1} % \
             of the length in strokes of one edge",
            drawn.counts.edges,
            drawn.segments.len(),
            lengths.len(),
            stroke_px / edge_px,
            100.0 * single / total
        );
        assert!(single < 0.1 * total);
        // Control: without chaining, a stroke would be a single edge.
        assert!(stroke_px > 2.0 * total / drawn.segments.len() as f64);
        times.push(stroke_px / edge_px);
    }
    // Where the camera is near the ground, the edges themselves are long.
    assert!(
        times.iter().all(|times| *times >= 4.0) && times.iter().sum::<f64>() >= 5.0 * times.len() as f64,
        "{times:?}"
    );
}
