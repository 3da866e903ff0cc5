//! Strokes: the visible contour edges of the surface become pieces, chains, ink.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod common;

use common::World;
use common::shot::{Shot, shoot_style};
use glam::DVec2;
use hachure::frame::Frame;
use hachure::gpu::readback::read_buffer;
use hachure::lines::strokes::{Edge, Piece, StrokeCounts};
use hachure::picture::PartRule;
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [640, 360];
const WHOLE: PartRule = PartRule { whole_px: u64::MAX, part_px: 8192, margin_px: 0 };

/// What the passes hand to each other in a frame.
struct Drawn {
    shot: Shot,
    edges: Vec<Edge>,
    pieces: Vec<Piece>,
}

fn draw(world: &mut World, view: &str) -> Drawn {
    let mut style = Style::load("strokes").unwrap();
    // The channels of a shot want LSA contours as well.
    style.lines = Style::load("ink").unwrap().lines;
    let mut frame: Option<Frame> = None;
    let pose = world.pose(view);
    let shot = shoot_style(world, &mut frame, pose, pose, SIZE_PX, &style, &WHOLE);
    let frame = frame.unwrap();
    let lists = frame.strokes().unwrap().lists();
    let counts: StrokeCounts = read_buffer(&world.gpu, lists.counts.buffer(), 1).unwrap()[0];
    println!("{counts:?}");
    let edges = read_buffer(&world.gpu, lists.edges.buffer(), counts.edges as usize).unwrap();
    let pieces = read_buffer(&world.gpu, lists.pieces.buffer(), counts.pieces as usize).unwrap();
    Drawn { shot, edges, pieces }
}

fn px(units: [i32; 2]) -> DVec2 {
    DVec2::new(f64::from(units[0]), f64::from(units[1])) / 16.0
}

#[test]
fn look() {
    let Some(mut world) = World::real("dem/geotiff/N46E008_alps.tif", 1.0) else { return };
    let view = std::env::var("HVIEW").unwrap_or("0,0,+300,30,-8,60".into());
    let drawn = draw(&mut world, &view);
    let mut picture = vec![255_u8; (SIZE_PX[0] * SIZE_PX[1]) as usize];
    for i in 0..drawn.shot.depth_m.len() {
        if drawn.shot.is_sky(i) {
            picture[i] = 200;
        }
    }
    let mut total = 0.0;
    for piece in &drawn.pieces {
        let (a, b) = (px(piece.a), px(piece.b));
        total += (b - a).length();
        for k in 0..=64 {
            let p = a.lerp(b, f64::from(k) / 64.0);
            if p.x >= 0.0 && p.y >= 0.0 && p.x < f64::from(SIZE_PX[0]) && p.y < f64::from(SIZE_PX[1]) {
                picture[p.y as usize * SIZE_PX[0] as usize + p.x as usize] = 0;
            }
        }
        for p in [a, b] {
            if p.x >= 0.0 && p.y >= 0.0 && p.x < f64::from(SIZE_PX[0]) && p.y < f64::from(SIZE_PX[1]) {
                picture[p.y as usize * SIZE_PX[0] as usize + p.x as usize] = 90;
            }
        }
    }
    println!(
        "{} edges, {} pieces, mean {:.2} px",
        drawn.edges.len(),
        drawn.pieces.len(),
        total / drawn.pieces.len() as f64
    );
    std::fs::write(
        "/tmp/pp/pieces.pgm",
        [format!("P5 {} {} 255\n", SIZE_PX[0], SIZE_PX[1]).into_bytes(), picture].concat(),
    )
    .unwrap();
}
