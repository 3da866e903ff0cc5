//! Separate marks: dashes, dots, curls and dabs, each placed where it makes the tone most even.

use super::chance::Chance;
use super::evenness::Evenness;
use super::growth::Growth;
use super::ink_map::{End, InkMap};
use crate::style::marks::{Kind, Recipe};

/// Number of candidate places if placement is regular, and if it is random.
const CANDIDATES: [f32; 2] = [40.0, 4.0];

/// Largest number of marks, which take some two seconds; what is left open is closed by marks that widen.
const MAX_MARKS: usize = 120_000;

/// A mark around its middle.
struct Shape {
    points: Vec<[f32; 2]>,
    /// Half the width at each point, at mid tone.
    half_px: Vec<f32>,
    /// Distance between points.
    step_px: f32,
}

/// Returns the fraction of the full width at `at`, 0 to 1 along a mark: a stroke begins more abruptly than it ends.
fn thinning(taper: f32, at: f32) -> f32 {
    let ease = |from_end: f32, length: f32| {
        if from_end >= length {
            return 1.0;
        }
        let t = from_end / length;
        t * (2.0 - t)
    };
    ease(at, 0.35 * taper).min(ease(1.0 - at, 0.65 * taper))
}

/// Returns a straight stroke with a slight bend.
fn stroke(recipe: &Recipe, chance: &mut Chance) -> Shape {
    let length_px = recipe.length_px * (1.0 + 0.35 * recipe.jitter * chance.gentle());
    let count = (length_px / 4.0).ceil().max(1.0) as usize;
    let slope = 0.16 * recipe.jitter * chance.gentle();
    let bend_px = 0.6 * recipe.wobble_px * chance.signed();
    let second_px = 0.4 * recipe.wobble_px * chance.signed();
    let points = (0..=count).map(|i| {
        let t = 2.0 * i as f32 / count as f32 - 1.0;
        // A bow, and an S.
        [
            0.5 * length_px * t,
            slope * 0.5 * length_px * t + bend_px * (t * t - 0.33) + second_px * (t * t * t - 0.6 * t),
        ]
    });
    widths(points.collect(), length_px / count as f32, recipe, chance)
}

/// Returns a curl: a pen that circles while it moves on, without being lifted.
fn curl(recipe: &Recipe, chance: &mut Chance) -> Shape {
    const STEP_PX: f32 = 1.5;
    let count = (recipe.length_px / STEP_PX).ceil().max(2.0) as usize;
    let mut way = [1.0_f32, 0.0_f32];
    // Any direction: rotated by a rational rotation, which needs no trigonometric function.
    let turn = |way: [f32; 2], half: f32| {
        let scale = 1.0 / (1.0 + half * half);
        let [cos, sin] = [(1.0 - half * half) * scale, 2.0 * half * scale];
        [way[0] * cos - way[1] * sin, way[0] * sin + way[1] * cos]
    };
    for _ in 0..3 {
        way = turn(way, chance.signed());
    }
    let radius_px = 0.75 * recipe.spacing_px * (1.0 + 0.3 * recipe.jitter * chance.gentle());
    let (mut at, mut points) = ([0.0_f32, 0.0_f32], Vec::with_capacity(count + 1));
    let [mut pace, mut aim] = [1.0_f32, 1.0_f32];
    for i in 0..=count {
        points.push(at);
        if i % 6 == 0 {
            aim = 1.0 + 0.7 * chance.signed();
        }
        pace += 0.25 * (aim - pace);
        way = turn(way, 0.5 * STEP_PX * pace / radius_px);
        // The whole hand moves along the lines.
        at = [at[0] + STEP_PX * (way[0] + 0.28), at[1] + STEP_PX * way[1]];
    }
    let middle = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f32>() / points.len() as f32);
    points.iter_mut().for_each(|point| *point = [point[0] - middle[0], point[1] - middle[1]]);
    widths(points, STEP_PX, recipe, chance)
}

/// Assigns widths to points; their mean is the recipe's width.
fn widths(points: Vec<[f32; 2]>, step_px: f32, recipe: &Recipe, chance: &mut Chance) -> Shape {
    let last = (points.len() - 1).max(1) as f32;
    let profile: Vec<f32> = (0..points.len()).map(|i| thinning(recipe.taper, i as f32 / last).max(0.1)).collect();
    let mean = profile.iter().sum::<f32>() / profile.len() as f32;
    let full_px = recipe.width_px / mean * (1.0 + 0.5 * recipe.pressure * chance.gentle());
    let lean = 0.3 * recipe.pressure * chance.signed();
    let half_px = profile.iter().enumerate().map(|(i, part)| {
        let t = 2.0 * i as f32 / last - 1.0;
        0.5 * full_px * part * (1.0 + lean * t)
    });
    Shape { half_px: half_px.collect(), points, step_px }
}

/// Returns the area of the tile per mark at mid tone.
fn area_px(recipe: &Recipe) -> f32 {
    match recipe.kind {
        Kind::Stipple | Kind::Dots => recipe.spacing_px * recipe.spacing_px,
        _ => recipe.spacing_px * recipe.length_px,
    }
}

/// Draws all marks of a recipe.
pub(super) fn draw(recipe: &Recipe, map: &mut InkMap) {
    let side_px = map.side_px as f32;
    let mid_count = side_px * side_px / area_px(recipe);
    let growth = Growth::new(recipe.mid_darkness(), mid_count, recipe.width_px, recipe.swell);
    let mut chance = Chance::new(recipe.seed, 1);
    let mut evenness = Evenness::new(map.side_px, recipe.width_px);
    // If there are few marks, they are larger, and the place of each matters more.
    let few = (16_000.0 / growth.count() as f32).clamp(1.0, if recipe.kind == Kind::Scribble { 3.0 } else { 8.0 });
    let candidates = (few * (CANDIDATES[0] + (CANDIDATES[1] - CANDIDATES[0]) * recipe.jitter)).round() as usize;
    let first_px = (4.0 * (1.0 - recipe.jitter)).max(0.25);
    let reach_px = 0.5 * recipe.spacing_px + 1.0;
    for before in 0..growth.count().min(MAX_MARKS) {
        let shape = match recipe.kind {
            Kind::Scribble => curl(recipe, &mut chance),
            Kind::Stipple | Kind::Dots => widths(vec![[0.0, 0.0]], 1.0, recipe, &mut chance),
            _ => stroke(recipe, &mut chance),
        };
        let (mut least, mut offset) = (f32::MAX, [0.0; 2]);
        for _ in 0..candidates {
            let candidate = [0; 2].map(|_| side_px * chance.part());
            let under = evenness.under(&shape.points, shape.step_px, candidate);
            if under < least {
                (least, offset) = (under, candidate);
            }
        }
        offset = evenness.slide(&shape.points, shape.step_px, offset, first_px);
        evenness.lay(&shape.points, shape.step_px, offset);
        put(map, &growth, growth.begin(before), &shape, offset, reach_px);
    }
}

fn put(map: &mut InkMap, growth: &Growth, begin: f32, shape: &Shape, offset: [f32; 2], reach_px: f32) {
    let last = shape.points.len() - 1;
    let end = |i: usize| End {
        at: [shape.points[i][0] + offset[0], shape.points[i][1] + offset[1]],
        half_px: shape.half_px[i],
        along: if last == 0 { 0.0 } else { (2.0 * i as f32 / last as f32 - 1.0).abs() },
    };
    if last == 0 {
        map.piece(growth, begin, [end(0), end(0)], reach_px);
    }
    for i in 0..last {
        map.piece(growth, begin, [end(i), end(i + 1)], reach_px);
    }
}
