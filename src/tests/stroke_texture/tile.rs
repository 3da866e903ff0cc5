//! Tests that stroke textures have no seam and are the same on every machine.

use hachure::lines::strokes::texture::{Level, grow};
use hachure::style::texture::Recipe;

use crate::tests::stroke_texture::{RECIPE, recipes};

/// Returns the root mean square difference between neighbouring columns, for each step from a column to the next and
/// finally back to the first; for both channels.
fn steps(level: &Level, columns: usize) -> Vec<[f64; 2]> {
    let width = level.size_px[0] as usize;
    let step = |x: usize| {
        let next = (x + 1) % columns;
        [0, 1].map(|channel| {
            let squares = level.texels.chunks_exact(width).map(|row| {
                let difference = f64::from(row[next][channel]) - f64::from(row[x][channel]);
                difference * difference
            });
            (squares.sum::<f64>() / f64::from(level.size_px[1])).sqrt()
        })
    };
    (0..columns).map(step).collect()
}

/// Returns whether the last step is larger than all others.
fn has_seam(level: &Level, columns: usize) -> bool {
    let steps = steps(level, columns);
    let (seam, inside) = steps.split_last().unwrap();
    [0, 1].into_iter().any(|channel| seam[channel] > inside.iter().map(|step| step[channel]).fold(0.0, f64::max))
}

/// Returns the transposed level.
fn turned(level: &Level) -> Level {
    let [width, height] = level.size_px.map(|side| side as usize);
    let texels = (0..width).flat_map(|x| (0..height).map(move |y| (x, y)));
    Level {
        size_px: [level.size_px[1], level.size_px[0]],
        texels: texels.map(|(x, y)| level.texels[y * width + x]).collect(),
    }
}

#[test]
fn tiles_have_no_seam() {
    for (name, recipe) in recipes() {
        for level in &grow(&recipe)[..3] {
            let columns = level.size_px[0] as usize;
            assert!(!has_seam(level, columns), "{name}, along");
            assert!(!has_seam(&turned(level), level.size_px[1] as usize), "{name}, across");
        }
        // Planted: a texture that is cut off has a seam.
        let level = &grow(&recipe)[0];
        assert!(has_seam(level, level.size_px[0] as usize * 3 / 4 + 5), "{name}: a planted cut was not detected");
    }
}

#[test]
fn tiles_are_the_same_everywhere() {
    let recipe = Recipe::parse("test", RECIPE).unwrap();
    let bits = |recipe: &Recipe| {
        let levels = grow(recipe);
        let bytes: Vec<u8> = levels.iter().flat_map(|level| level.texels.iter().flatten().copied()).collect();
        (levels.len(), crc32fast::hash(&bytes))
    };
    let here = bits(&recipe);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| bits(&recipe)), here);
    }
    assert_eq!(here, (6, HERE));
    // Planted: another seed gives another texture.
    let mut other = recipe.clone();
    other.tile.seed += 1;
    assert_ne!(bits(&other), here);
}

/// Checksum of [`RECIPE`]'s texture on every machine.
const HERE: u32 = 3_348_655_921;
