//! Thresholds from a user's pictures, from light to dark.
//!
//! A texel belongs to the first picture that inks it, so pictures that are not nested become nested: each contains the
//! marks of all lighter ones. Within a picture marks appear one after another, each (a group of touching texels) from
//! its middle to its border; in scanned pictures darker texels come first. Texels that no picture inks follow by their
//! distance from ink. All values are replaced by their ranks, so a picture appears exactly at its own darkness, and in
//! between a part of its marks.

use super::TonalArtMap;
use super::chance::Chance;
use crate::file::png::Picture;
use crate::style::StyleError;
use crate::style::images::darkness;
use crate::style::marks::{Recipe, pictures};

/// Texels at least this dark are ink.
const INK: f32 = 0.5;

/// One picture's darkness, 0 to 1, by rows.
struct Image {
    side_px: usize,
    darkness: Vec<f32>,
}

/// Reads the pictures of a recipe and returns their map.
pub(super) fn read(recipe: &Recipe) -> Result<TonalArtMap, StyleError> {
    let images: Vec<Image> = pictures::read(recipe)?.iter().map(image).collect();
    let side_px = images.first().map_or(recipe.side_px as usize, |image| image.side_px);
    Ok(TonalArtMap::of_ranks(side_px as u32, &super::equalise::ranks(&order(&images, side_px, recipe.seed))))
}

fn image(picture: &Picture) -> Image {
    Image { side_px: picture.width as usize, darkness: darkness(picture).collect() }
}

/// Returns a number for each texel that rises in the order in which texels are inked.
fn order(images: &[Image], side_px: usize, seed: u32) -> Vec<f32> {
    let count = side_px * side_px;
    // The first picture that inks each texel.
    let first: Vec<usize> = (0..count)
        .map(|place| images.iter().position(|image| image.darkness[place] >= INK).unwrap_or(images.len()))
        .collect();
    let mut chance = Chance::new(seed, 1);
    let mut order = vec![0.0; count];
    let mut seen = vec![false; count];
    for start in 0..count {
        if seen[start] || first[start] == images.len() {
            continue;
        }
        let mark = touching(&first, &mut seen, start, side_px);
        let turn = chance.part();
        let depths = depths(&mark, &first, side_px);
        for (place, depth) in mark.iter().zip(depths) {
            let darkness = images[first[*place]].darkness[*place];
            // Marks appear one after another; within a mark the middle comes first.
            order[*place] = first[*place] as f32 + 0.9 * turn - 0.04 * depth.min(1.0) - 0.02 * darkness;
        }
    }
    close_up(&mut order, &first, images.len(), side_px);
    order
}

/// Returns the four neighbours of a texel; the tile repeats.
fn neighbours(place: usize, side_px: usize) -> [usize; 4] {
    let (x, y) = (place % side_px, place / side_px);
    [
        y * side_px + (x + 1) % side_px,
        y * side_px + (x + side_px - 1) % side_px,
        (y + 1) % side_px * side_px + x,
        (y + side_px - 1) % side_px * side_px + x,
    ]
}

/// Returns the connected texels of one picture that contain `start`.
fn touching(first: &[usize], seen: &mut [bool], start: usize, side_px: usize) -> Vec<usize> {
    let mut mark = vec![start];
    seen[start] = true;
    let mut next = 0;
    while let Some(&place) = mark.get(next) {
        next += 1;
        for other in neighbours(place, side_px) {
            if !seen[other] && first[other] == first[start] {
                seen[other] = true;
                mark.push(other);
            }
        }
    }
    mark
}

/// Returns the depth of each texel in a mark: the fraction of its surroundings that belongs to the mark.
fn depths(mark: &[usize], first: &[usize], side_px: usize) -> Vec<f32> {
    let inside = |place: usize, other: usize| first[other] == first[place];
    let depth = |&place: &usize| {
        let near = neighbours(place, side_px);
        let far = near.iter().flat_map(|other| neighbours(*other, side_px));
        let inner = near.iter().filter(|other| inside(place, **other)).count() as f32 / 4.0;
        let outer = far.filter(|other| inside(place, *other)).count() as f32 / 16.0;
        0.5 * (inner + outer)
    };
    mark.iter().map(depth).collect()
}

/// Orders the texels that no picture inks, by steps from ink.
fn close_up(order: &mut [f32], first: &[usize], images: usize, side_px: usize) {
    let mut border: Vec<usize> = (0..order.len()).filter(|place| first[*place] < images).collect();
    let mut reached: Vec<bool> = first.iter().map(|first| *first < images).collect();
    let mut height = images as f32;
    while !border.is_empty() {
        height += 1.0;
        let mut next = Vec::new();
        for place in border {
            for other in neighbours(place, side_px) {
                if !reached[other] {
                    reached[other] = true;
                    order[other] = height;
                    next.push(other);
                }
            }
        }
        border = next;
    }
}
