//! Tests that marks keep their width and their spacing in the picture, from 2 m to 20 km and at grazing angles.

use glam::DVec2;
use hachure::style::Style;

use crate::tests::common::full;
use crate::tests::hatching::plane::{Inked, Plane, fixed, style};

/// Relative tolerance of widths and spacings.
const ALLOWED: f64 = 0.25;

/// Returns the distances of the pictures; in the fast tier the nearest, the middle and the farthest.
fn distances_m() -> Vec<f64> {
    let all = [2.0, 6.3, 20.0, 63.0, 200.0, 630.0, 2000.0, 6300.0, 20_000.0];
    all.into_iter().step_by(if full() { 1 } else { 4 }).collect()
}

/// Width and spacing of marks, measured in a picture.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// The mean wavelength across the marks, weighted by power.
    pub spacing_px: f64,
    pub strongest_px: f64,
    /// Ink per mark, and the distance between marks, both from counting marks.
    pub width_px: f64,
    pub counted_spacing_px: f64,
}

/// Returns the mean wavelength along `across` (unit), weighted by power, and the strongest one, over lines of 128
/// pixels about the middle. Only wavelengths of half to twice `about_px` count: marks have overtones, and rows that
/// differ have undertones, which are other waves.
pub fn waves_px(shot: &Inked, across: DVec2, about_px: f64) -> (f64, f64) {
    const SAMPLES: usize = 128;
    let middle = DVec2::new(shot.size_px[0] as f64, shot.size_px[1] as f64) * 0.5;
    let along = across.perp();
    let waves: Vec<f64> = (0..120).map(|i| about_px * 2.0 * 0.25_f64.powf(f64::from(i) / 119.0)).collect();
    let mut power = vec![0.0; waves.len()];
    for line in -24..=24 {
        let samples: Vec<f64> = (0..SAMPLES)
            .map(|i| {
                let at = middle + across * (i as f64 - 0.5 * SAMPLES as f64) + along * (f64::from(line) * 2.0);
                shot.between(at).unwrap_or(0.0)
            })
            .collect();
        let mean = samples.iter().sum::<f64>() / SAMPLES as f64;
        for (power, wave) in power.iter_mut().zip(&waves) {
            let (mut re, mut im) = (0.0, 0.0);
            for (i, sample) in samples.iter().enumerate() {
                let window = (std::f64::consts::PI * (i as f64 + 0.5) / SAMPLES as f64).sin().powi(2);
                let angle = std::f64::consts::TAU * i as f64 / wave;
                re += (sample - mean) * window * angle.cos();
                im += (sample - mean) * window * angle.sin();
            }
            *power += re * re + im * im;
        }
    }
    let strongest = (0..waves.len()).max_by(|a, b| power[*a].total_cmp(&power[*b])).unwrap();
    // The wavelengths are in steps of even ratios, so the mean is that of their logarithms.
    let whole: f64 = power.iter().zip(&waves).map(|(power, wave)| power / wave).sum();
    let mean: f64 = power.iter().zip(&waves).map(|(power, wave)| power / wave * wave.ln()).sum();
    ((mean / whole).exp(), waves[strongest])
}

/// Counts the marks crossed along `across`; returns their mean width (ink per mark) and spacing, in pixels.
fn counted(shot: &Inked, across: DVec2) -> (f64, f64) {
    let middle = DVec2::new(shot.size_px[0] as f64, shot.size_px[1] as f64) * 0.5;
    let along = across.perp();
    let (mut crossed, mut ink, mut length) = (0.0, 0.0, 0.0);
    for line in -30..=30 {
        let mut last = None;
        for i in -280..=280 {
            let Some(here) = shot.between(middle + across * (f64::from(i) * 0.25) + along * (f64::from(line) * 2.0))
            else {
                continue;
            };
            if last.is_some_and(|last: f64| last < 0.5 && here >= 0.5) {
                crossed += 1.0;
            }
            last = Some(here);
            ink += here * 0.25;
            length += 0.25;
        }
    }
    (ink / crossed, length / crossed)
}

pub fn measure(
    plane: &mut Plane,
    style: &Style,
    distance_m: f64,
    [from_normal_deg, around_deg]: [f64; 2],
    about_px: f64,
) -> Measured {
    let pose = plane.eye(3.0, distance_m, from_normal_deg, around_deg, 20.0);
    let shot = plane.shoot(pose, [256, 256], style);
    // Marks point north in plan, so rows of marks differ toward the east.
    let middle = DVec2::splat(128.0);
    let east_m = |px: DVec2| plane.hit(&shot.view, px).x;
    let across = DVec2::new(
        east_m(middle + DVec2::X) - east_m(middle - DVec2::X),
        east_m(middle + DVec2::Y) - east_m(middle - DVec2::Y),
    )
    .normalize();
    let (width_px, counted_spacing_px) = counted(&shot, across);
    let (spacing_px, strongest_px) = waves_px(&shot, across, about_px);
    Measured { spacing_px, strongest_px, width_px, counted_spacing_px }
}

fn holds(value: f64, wanted: f64) -> bool {
    (value / wanted - 1.0).abs() <= ALLOWED
}

/// Returns what each picture of the plane measures, in the order of the distances: from above, obliquely, and at a
/// grazing angle both along and across the marks.
fn everywhere(plane: &mut Plane, style: &Style, distances_m: &[f64], about_px: f64) -> Vec<(String, Measured)> {
    let mut all = Vec::new();
    for distance_m in distances_m {
        for (from_normal_deg, around_deg) in [(0.0, 0.0), (50.0, 40.0), (80.0, 0.0), (80.0, 90.0)] {
            let measured = measure(plane, style, *distance_m, [from_normal_deg, around_deg], about_px);
            all.push((format!("{distance_m} m, {from_normal_deg}° from the normal, turned {around_deg}°"), measured));
        }
    }
    all
}

fn hold_at(all: &[(String, Measured)], wanted: [f64; 2]) -> Result<(), String> {
    for (place, measured) in all {
        let [spacing_px, width_px] = wanted;
        if !holds(measured.spacing_px, spacing_px) || !holds(measured.width_px, width_px) {
            return Err(format!("{place}: {measured:?}, wanted {spacing_px} and {width_px} px"));
        }
    }
    Ok(())
}

fn report(what: &str, all: &[(String, Measured)]) {
    let range = |value: fn(&Measured) -> f64| {
        let values = all.iter().map(|(_, measured)| value(measured));
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        format!("{low:.2} to {high:.2}")
    };
    println!(
        "{what}: mean wave {} px, strongest {} px, spacing by count {} px, width {} px",
        range(|m| m.spacing_px),
        range(|m| m.strongest_px),
        range(|m| m.counted_spacing_px),
        range(|m| m.width_px)
    );
}

#[test]
fn blended_marks_keep_their_size() {
    let Some(mut plane) = Plane::new(12.0) else { return };
    let marks = hachure::style::marks::Recipe::load("engraving", std::path::Path::new("")).unwrap();
    let (darkness, spacing_px, distances_m) = (0.4, f64::from(marks.spacing_px), distances_m());
    let all = everywhere(&mut plane, &style("blend", darkness, &fixed("engraving", 0.0)), &distances_m, spacing_px);
    report("blend", &all);
    hold_at(&all, [spacing_px, spacing_px * darkness]).unwrap();
    // Planted error: an octave off by one, so marks are twice as large from one of the distances on.
    let twice = everywhere(
        &mut plane,
        &style("blend", darkness, &format!("{}size = 2.0\n", fixed("engraving", 0.0))),
        &distances_m[distances_m.len() / 2 + 1..],
        spacing_px,
    );
    let mut planted = all;
    planted.truncate(planted.len() - twice.len());
    planted.extend(twice);
    assert!(hold_at(&planted, [spacing_px, spacing_px * darkness]).is_err());
}

#[test]
fn added_marks_keep_their_width_and_number() {
    let Some(mut plane) = Plane::new(12.0) else { return };
    let marks = hachure::style::marks::Recipe::load("line", std::path::Path::new("")).unwrap();
    // At this darkness no two marks touch, so spacing is width divided by darkness.
    let (darkness, width_px) = (0.25, f64::from(marks.width_px));
    let style = style("add", darkness, &fixed("line", 0.0));
    let all = everywhere(&mut plane, &style, &distances_m(), width_px / darkness);
    report("add", &all);
    for (place, measured) in &all {
        assert!(
            holds(measured.width_px, width_px),
            "{place}: expected a width of {width_px} px, measured {measured:?}"
        );
        assert!(holds(measured.counted_spacing_px, width_px / darkness), "{place}: wrong spacing: {measured:?}");
    }
}
