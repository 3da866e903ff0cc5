//! Forests are neither black nor blank, from any distance.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use crate::tests::helpers::forest::of;
use common::World;
use common::draw::{draw, halves, north_west, still};
use common::{grid_of, quantile};
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::scene::forest::{Form, Species};
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [256, 144];

/// Returns the mean darkness of pictures from a distance: 0 is paper, 1 black. Near trees, a single picture varies too
/// much.
fn darkness(world: &mut World, renderer: &mut Renderer, style: &Style, away_m: f64) -> f64 {
    let pitch_deg: f64 = -25.0;
    let up_m = away_m * -pitch_deg.to_radians().sin();
    let light = |[r, g, b, _]: &[f64; 4]| 0.2126 * r + 0.7152 * g + 0.0722 * b;
    let paper = style.paper.color.linear().map(f64::from);
    let views = match away_m {
        ..20.0 => 8,
        ..100.0 if common::full() => 8,
        ..100.0 => 4,
        _ => 1,
    };
    let all = (0..views).map(|i| {
        let i = f64::from(i);
        let camera = format!(
            "{},{},{up_m},{},{pitch_deg},30",
            37.0 + 9.0 * i,
            -0.6 * away_m,
            30.0 + 360.0 / f64::from(views) * i
        );
        let pose = world.pose(&camera);
        // Strokes of another view would disappear only slowly.
        renderer.forget();
        draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), style, &north_west());
        let picture = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
        picture.iter().map(light).sum::<f64>() / picture.len() as f64 / light(&[paper[0], paper[1], paper[2], 1.0])
    });
    1.0 - all.sum::<f64>() / f64::from(views)
}

/// Returns the largest ratio between a number and the median, or its inverse.
fn from_middle(numbers: &[f64]) -> f64 {
    let middle = quantile(&mut numbers.to_vec(), 0.5);
    numbers.iter().map(|number| (number / middle).max(middle / number.max(1e-6))).fold(0.0, f64::max)
}

#[test]
fn ink_of_a_forest_does_not_depend_on_its_distance() {
    let Some(mut world) = World::new(grid_of(1025, 1025, 60.0, |_, _| 0.0), 1.0) else { return };
    let mut forest = of(Form::Conifer, 300.0, 20.0);
    forest.species = Species::mixed(20.0);
    let distances_m = [10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0, 20_000.0];
    // In the fast tier one style each of lines, strokes and marks.
    let names = ["lsa", "strokes", "stipple", "crosshatch", "hachures", "pencil"];
    let names = names.into_iter().take(if common::full() { 6 } else { 3 });
    let styles: Vec<(&str, Style)> = names
        .map(|name| {
            let mut style = Style::load(name).unwrap();
            // Haze is not part of this test.
            style.haze.faintest_tone = 1.0;
            // Level land has no rows of hachures; only their blocks would be computed, up to the horizon.
            (name, if common::full() { style } else { style.without(&["rows"]) })
        })
        .collect();
    let mut of_each = |forest: Option<_>, distances_m: &[f64]| {
        world.surfaces.set_forest(forest);
        let of_style = |(_, style): &(&str, Style)| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            let of = |away_m: &f64| darkness(&mut world, &mut renderer, style, *away_m);
            distances_m.iter().map(of).collect::<Vec<_>>()
        };
        styles.iter().map(of_style).collect::<Vec<_>>()
    };
    let far = 5;
    let (bare, wooded) = (of_each(None, &distances_m[far..]), of_each(Some(forest), &distances_m));
    let mut worst = 0.0_f64;
    for ((name, _), (bare, wooded)) in styles.iter().zip(bare.into_iter().zip(wooded)) {
        let most = from_middle(&wooded);
        // Planted error: a forest that ends before it is far away.
        let ends = [&wooded[..far], &bare].concat();
        assert!(from_middle(&ends) > 2.0, "a forest that ends passes: {ends:?}");
        println!("{name:12} forest {wooded:.3?}, bare land far away {bare:.3?}; at most {most:.2} times the median");
        worst = worst.max(most);
    }
    assert!(worst < 2.0, "the darkness of a forest differs from the median by a factor of {worst}");
}
