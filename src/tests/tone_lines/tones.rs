//! Tests `beta`, thresholds, counterchange, specular tones and lengths, and tones that have no lines.

use super::*;

/// Thresholds between curvatures that an edge has.
const EDGE_RAMP: [f32; 2] = [0.008, 0.01];

/// Draws a step of tone; returns the width in pixels of its dark line and of its highlight line for a `beta`.
fn edge(bench: &mut Bench, beta: f32, height: f64) -> [f64; 2] {
    let style = ToneLines { beta, dark_ramp: EDGE_RAMP, highlight_ramp: EDGE_RAMP, ..bare(4.0) };
    let across = DVec2::from_angle(0.3);
    let curve = |at: DVec2| (at - middle()).dot(across);
    let ink = bench.lines(&style, |at| Some([0.5 + height * (f64::from(u8::from(curve(at) > 0.0)) - 0.5), 0.0]));
    [DARK, LIGHT]
        .map(|kind| judge(&ink.of(kind), &curve, &|at| (at - middle()).dot(across.perp()), 9.0, |_| true).wide_px)
}

/// Returns whether the ink follows Figure 4 of the paper: small betas draw edges, large ones none, and those in between
/// only strong edges.
fn follows_figure_4(strong: [[f64; 2]; 3], weak: [[f64; 2]; 3]) -> bool {
    let is_drawn = |ink: [f64; 2]| ink.iter().all(|ink| *ink > 0.6);
    let is_none = |ink: [f64; 2]| ink.iter().all(|ink| *ink == 0.0);
    is_drawn(strong[0])
        && is_drawn(weak[0])
        && is_drawn(strong[1])
        && !is_drawn(weak[1])
        && is_none(strong[2])
        && is_none(weak[2])
}

#[test]
fn beta_decides_about_edges() {
    let Some(mut bench) = Bench::new() else { return };
    const BETAS: [f32; 3] = [0.0, 0.2, 1.0];
    const WEAK: f64 = 0.05;
    let strong = BETAS.map(|beta| edge(&mut bench, beta, 0.8));
    let weak = BETAS.map(|beta| edge(&mut bench, beta, WEAK));
    println!("ink across an edge of 0.8 and of {WEAK}, for beta of {BETAS:?}: {strong:.2?} {weak:.2?}");
    assert!(follows_figure_4(strong, weak));
    for beta in [0.0, 0.1, 0.2, 0.3, 0.5] {
        let inks = [0.05, 0.1, 0.2, 0.4, 0.8].map(|height| edge(&mut bench, beta, height)[DARK]);
        println!("ink of edges of 0.05 to 0.8 for a beta of {beta}: {inks:.1?}");
    }
    // Planted: beta has no effect, whichever value is used.
    for ignored in 0..3 {
        assert!(!follows_figure_4([strong[ignored]; 3], [weak[ignored]; 3]));
    }
    // The dark line must be on the darker side; planted is the other side.
    let style = ToneLines { beta: 0.1, ..bare(4.0) };
    let tone = |at: DVec2| Some([if at.x > middle().x { 0.9 } else { 0.1 }, 0.0]);
    let ink = bench.lines(&style, tone);
    let on_dark_side =
        |kind| places().zip(ink.of(kind)).filter(|(at, _)| at.x < middle().x).map(|(_, ink)| ink).sum::<f64>();
    assert!(on_dark_side(DARK) > 0.95 * ink.sum(DARK) && on_dark_side(LIGHT) < 0.05 * ink.sum(LIGHT));
    // Without edges nothing is drawn, whatever beta is.
    assert!(bench.lines(&ToneLines { edges: false, ..style }, tone).sum(DARK) == 0.0);
}

/// Returns the ink in the middle of a valley for a ramp of curvatures.
fn ramped(bench: &mut Bench, dark_ramp: [f32; 2], depth: f64) -> f64 {
    let tone = |at: DVec2| Some([0.8 - depth * bell(at.x - middle().x, 4.0), 0.0]);
    let ink = bench.lines(&ToneLines { dark_ramp, ..bare(4.0) }, tone).of(DARK);
    places().zip(ink).filter(|(at, _)| at.x == middle().x).map(|(_, ink)| ink).fold(0.0, f64::max)
}

#[test]
fn opacity_rises_between_the_thresholds() {
    let Some(mut bench) = Bench::new() else { return };
    let ramp = [0.02, 0.08];
    let depths = [0.02, 0.1, 0.15, 0.2, 0.5];
    let mut inks = |ramp: [f32; 2]| depths.map(|depth| ramped(&mut bench, ramp, depth));
    let right = inks(ramp);
    println!("ink of valleys {depths:?} deep: {right:.3?}");
    // Curvature grows with depth, and so does ink between the thresholds.
    let rises = |ink: [f64; 5]| {
        let steps = [ink[2] - ink[1], ink[3] - ink[2]];
        ink[0] == 0.0 && ink[1] > 0.05 && ink[3] < 0.95 && ink[4] == 1.0 && (steps[0] - steps[1]).abs() < 0.02
    };
    assert!(rises(right));
    // Planted: swapped thresholds, and a single threshold, which makes no ramp.
    assert!(!rises(inks([ramp[1], ramp[0]])));
    assert!(!rises(inks([ramp[0], 1.01 * ramp[0]])));
}

#[test]
fn lines_stand_against_their_tone() {
    let Some(mut bench) = Bench::new() else { return };
    // A dark line in a light tone is paler than one in a dark tone; for a highlight line it is the opposite.
    let mut ink = |ground: f64, counterchange: f32| {
        let style = ToneLines { counterchange, ..bare(4.0) };
        let at = |sign: f64| move |at: DVec2| Some([ground + sign * 0.15 * bell(at.x - middle().x, 4.0), 0.0]);
        [bench.lines(&style, at(-1.0)).sum(DARK), bench.lines(&style, at(1.0)).sum(LIGHT)]
    };
    let stands = |[in_dark, in_light]: [[f64; 2]; 2]| {
        in_dark[DARK] > 1.5 * in_light[DARK] && in_light[LIGHT] > 1.5 * in_dark[LIGHT]
    };
    let right = [ink(0.25, 1.0), ink(0.75, 1.0)];
    assert!(stands(right), "{right:?}");
    // Planted: no counterchange, and the opposite one.
    assert!(!stands([ink(0.25, 0.0), ink(0.75, 0.0)]));
    assert!(!stands([right[1], right[0]]));
}

#[test]
fn specular_highlights_have_lines_of_their_own() {
    let Some(mut bench) = Bench::new() else { return };
    // A uniform bright tone would hide a highlight in the diffuse channel.
    let style = ToneLines { specular: 1.0, ..bare(4.0) };
    let tone = |at: DVec2| Some([0.9, 0.6 * bell(at.y - middle().y, 5.0)]);
    let found = bench.lines(&style, tone);
    let curve = |at: DVec2| at.y - middle().y;
    let line = judge(&found.of(LIGHT), &curve, &|at| at.x, 6.0, |_| true);
    assert!(line.is_right() && found.sum(DARK) == 0.0, "{line:?}");
    // Planted: styles without the channel.
    assert!(bench.lines(&ToneLines { specular: 0.0, ..style.clone() }, tone).sum(LIGHT) == 0.0);
    assert!(bench.lines(&ToneLines { highlights: false, ..style }, tone).sum(LIGHT) == 0.0);
}

#[test]
fn short_lines_go_and_long_ones_stay() {
    let Some(mut bench) = Bench::new() else { return };
    let mut ink = |long_px: f64, shortest_px: f32| {
        let style = ToneLines { shortest_px, ..bare(3.0) };
        let tone = |at: DVec2| {
            let off = at - middle();
            let beyond = (off.x.abs() - 0.5 * long_px).max(0.0);
            Some([0.8 - 0.5 * bell(off.y.hypot(beyond), 3.0), 0.0])
        };
        bench.lines(&style, tone).sum(DARK)
    };
    let left = [4.0, 60.0].map(|long_px| ink(long_px, 32.0) / ink(long_px, 0.0));
    assert!(left[0] < 0.1 && left[1] > 0.9, "{left:?}");
    // Planted: short fragments are kept.
    assert!(ink(4.0, 2.0) > 0.5 * ink(4.0, 0.0));
}

#[test]
fn where_nothing_is_to_be_seen_there_are_no_lines() {
    let Some(mut bench) = Bench::new() else { return };
    let tones: [(&str, Tones); 6] = [
        ("black", Box::new(|_| Some([0.0, 0.0]))),
        ("white", Box::new(|_| Some([1.0, 1.0]))),
        ("sky", Box::new(|_| None)),
        ("a slope of tone", Box::new(|at| Some([0.1 + 0.8 * at.x / f64::from(SIZE_PX[0]), 0.0]))),
        ("rounding", Box::new(|at| Some([0.5 + 3e-4 * f64::from((at.x * 7.0 + at.y * 13.0) as i32 % 3), 0.0]))),
        ("half of it sky", Box::new(|at| (at.y > 70.0).then_some([0.4, 0.2]))),
    ];
    for (name, tone) in &tones {
        for width_px in [1.0, 4.0, 16.0] {
            for beta in [0.0, 0.2, 1.0] {
                let style =
                    ToneLines { beta, specular: 1.0, skyline: false, blur: 1.0, shortest_px: 16.0, ..bare(width_px) };
                let ink = bench.lines(&style, tone);
                assert!(ink.0.iter().flatten().all(|ink| ink.is_finite()), "{name}");
                assert!(ink.sum(DARK) == 0.0 && ink.sum(LIGHT) == 0.0, "{name}, {width_px} px, beta {beta}");
            }
        }
    }
    // Control: an image with a feature, and a skyline where the sky is white.
    assert!(bench.lines(&bare(4.0), |at| Some([0.5 - 0.4 * bell(at.y - 60.0, 4.0), 0.0])).sum(DARK) > 100.0);
    let skyline = |at: DVec2| (at.y > 70.0).then_some([0.4, 0.0]);
    assert!(bench.lines(&bare(4.0), skyline).sum(DARK) > 100.0);
}
