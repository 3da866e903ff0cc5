//! The margin of bare paper and the line around the picture: they are where the style places them, over everything that
//! is drawn, and the same in pictures in parts, in frames with temporal anti-aliasing, and in drawings of lines.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use crate::tests::helpers::shapes;
use common::World;
use common::draw::{draw, halves, north_west, still};
use common::shot::{ink, shoot_style};
use hachure::composite::PICTURE;
use hachure::frame::{Antialias, Renderer};
use hachure::picture::strokes::render_strokes;
use hachure::picture::{PartRule, PictureRequest};
use hachure::style::{Color, Paper, Style, Typeface};
use hachure::vector::border::bordered;
use hachure::vector::{Group, groups};

const SIZE_PX: [u32; 2] = [160, 96];
const MARGIN_PX: usize = 11;
const BORDER_PX: usize = 3;
const FOOT_PX: usize = 7;
const CAMERA: &str = "900,-900,+20,315,3,60";

fn paper() -> Paper {
    let [color, border] = [[1.0, 0.9, 0.6], [0.25, 0.125, 0.0625]].map(Color::from_srgb);
    let [margin_px, border_px, foot_px] = [MARGIN_PX, BORDER_PX, FOOT_PX].map(|px| px as f32);
    Paper { color, grain: 0.0, margin_px, border_px, border, foot_px, typeface: Typeface::Strokes }
}

/// Returns how far a pixel is from the nearest edge of the page without its foot, in pixels.
fn from_edge(pixel: usize) -> usize {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let (x, y) = (pixel % width, pixel / width);
    x.min(y).min(width - 1 - x).min((height - 1 - y).saturating_sub(FOOT_PX))
}

fn picture(world: &mut World, style: &Style, antialias: Antialias) -> Vec<[f64; 4]> {
    let view = still(world.pose(CAMERA), SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_antialias(antialias);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &north_west());
    halves(&world.gpu, renderer.target(&PICTURE).unwrap())
}

/// Returns the number of pixels that differ from what the border requires.
fn wrong(drawn: &[[f64; 4]], bare: &[[f64; 4]], paper: &Paper) -> usize {
    let [sheet, line] = [paper.color, paper.border].map(|color| color.linear().map(f64::from));
    let is_wrong = |pixel: &usize| {
        let wanted = match from_edge(*pixel) {
            edge if edge < MARGIN_PX => sheet,
            edge if edge < MARGIN_PX + BORDER_PX => line,
            _ => [bare[*pixel][0], bare[*pixel][1], bare[*pixel][2]],
        };
        // The tolerance is the rounding of half floats.
        (0..3).any(|i| (drawn[*pixel][i] - wanted[i]).abs() > 1e-3)
    };
    (0..drawn.len()).filter(is_wrong).count()
}

#[test]
fn the_border_lies_where_it_is_asked_to() {
    let Some((_, mut world)) = shapes::hill() else { return };
    let (none, temporal) = (Antialias::None, Antialias::Temporal);
    let cases = [("lsa", none), ("strokes", temporal), ("lsa", temporal), ("strokes", none)];
    for (name, antialias) in cases.into_iter().take(if common::full() { 4 } else { 2 }) {
        let style = Style { paper: paper(), ..Style::load(name).unwrap() };
        let mut bare = style.clone();
        (bare.paper.margin_px, bare.paper.border_px, bare.paper.foot_px) = (0.0, 0.0, 0.0);
        let [drawn, without] = [&style, &bare].map(|style| picture(&mut world, style, antialias));
        assert_eq!(
            wrong(&drawn, &without, &style.paper),
            0,
            "{name}: pixels that the border should have set differently"
        );
        // Planted errors: no border, and a border one pixel farther in.
        assert!(wrong(&without, &without, &style.paper) > 1000, "{name}: a missing border is not found");
        if !common::full() && name != "lsa" {
            continue;
        }
        let mut farther = style.clone();
        farther.paper.margin_px += 1.0;
        let farther = picture(&mut world, &farther, antialias);
        assert!(wrong(&farther, &without, &style.paper) > 300, "{name}: a border one pixel farther in is not found");
        // Planted error: a foot that is one pixel too high.
        let mut higher = style.clone();
        higher.paper.foot_px += 1.0;
        let higher = picture(&mut world, &higher, antialias);
        assert!(wrong(&higher, &without, &style.paper) > 100, "{name}: a foot one pixel too high is not found");
    }
}

#[test]
fn parts_have_one_border() {
    let Some((_, mut world)) = shapes::hill() else { return };
    let style = Style { paper: Paper { grain: 0.1, ..paper() }, ..ink("footprint") };
    let pose = world.pose(CAMERA);
    let mut shoot = |parts: &PartRule| shoot_style(&mut world, &mut None, pose, pose, SIZE_PX, &style, parts);
    let whole = shoot(&PartRule::default());
    let part_px = if common::full() { 64 } else { 96 };
    let parts = shoot(&PartRule { whole_px: 0, part_px, margin_px: 12 });
    assert!(parts.report.parts > 1);
    let edge: Vec<usize> = (0..whole.picture.len()).filter(|at| from_edge(*at) < MARGIN_PX + BORDER_PX).collect();
    let differs = |shift: usize| {
        edge.iter().filter(|at| parts.picture[(**at + shift) % whole.picture.len()] != whole.picture[**at]).count()
    };
    assert_eq!(differs(0), 0);
    // Planted error: the picture shifted by a row.
    assert!(differs(SIZE_PX[0] as usize) > 100);
}

#[test]
fn lines_of_a_drawing_end_at_the_border() {
    let Some((_, mut world)) = shapes::hill() else { return };
    // Without these marks, a drawing is made at half the resolution, where strokes have half as many points.
    let (left_out, least): (&[&str], usize) = if common::full() { (&[], 10) } else { (&["height_lines", "water"], 5) };
    let style = Style { paper: paper(), ..common::all_lines("strokes").without(left_out) };
    let request = PictureRequest::still(world.pose(CAMERA), SIZE_PX, &style, north_west());
    let drawn = render_strokes(&world.gpu, &mut None, &mut world.surfaces, &request, None).unwrap();
    let mut drawing = groups(&drawn.strokes[0], style.strokes().unwrap().ink);
    let low_px = MARGIN_PX as f32 + 0.5 * BORDER_PX as f32;
    let outside = |drawing: &[Group]| {
        let places = drawing.iter().flat_map(|group| &group.lines).flat_map(|line| &line.points);
        let is_out = |at: &[f32; 2]| {
            (0..2).any(|i| {
                at[i] < low_px - 0.01 || at[i] > [SIZE_PX[0], SIZE_PX[1] - FOOT_PX as u32][i] as f32 - low_px + 0.01
            })
        };
        places.filter(|at| is_out(&at.px)).count()
    };
    assert!(outside(&drawing) > least, "planted error: lines without the border's clipping");
    bordered(&mut drawing, &style.paper, SIZE_PX);
    assert_eq!(outside(&drawing), 0);
    assert!(drawing.len() >= 2 && drawing.last().is_some_and(|group| group.id == "border"));
}
