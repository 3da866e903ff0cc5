//! The environment of a scene, divided into few lights (Vergne and others 2009, section 6.1: pre-sampled environment
//! lights).
//!
//! The middles of the parts are on a spiral around the sphere, so that each part has about the same solid angle; the
//! radiance of a part is the mean over all directions that are nearer to its middle than to any other. Without an
//! environment picture the environment is a clear sky, with the luminance that CIE S 011/E:2003 gives for its type 12,
//! over bright ground. The sun is not part of that sky, because cast shadows block the sun but not the sky.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use crate::file::hdr::SkyPicture;
use crate::style::Relief;

/// Directions over which means are computed: rows from the zenith down, and columns.
const SAMPLED: [usize; 2] = [48, 96];
/// The golden angle, for the spiral.
const GOLDEN_RAD: f64 = 2.399_963_229_728_653;

/// Luminance of the ground below a clear sky, as a multiple of what level land receives; and linear colours of the sun,
/// of the sky near the sun and away from it, and of the ground.
const GROUND: f64 = 0.3;
const SUN_COLOR: [f64; 3] = [1.14, 0.98, 0.72];
const NEAR_SUN: [f64; 3] = [1.05, 1.0, 0.86];
const AWAY_FROM_SUN: [f64; 3] = [0.74, 1.0, 1.54];
const GROUND_COLOR: [f64; 3] = [1.05, 1.0, 0.88];

/// A part of the environment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartOfSky {
    /// Unit vector toward its middle, in world space.
    pub direction: DVec3,
    /// Linear red, green and blue; level land that sees all parts has the luminance of all light but the sun's.
    pub radiance: [f64; 3],
}

/// The environment of a style in a scene's light.
pub(crate) struct SkyParts {
    lights: u32,
    picture: Option<Arc<SkyPicture>>,
    turn_deg: f32,
    sun_part: f32,
    to_sun: DVec3,
    /// All parts, of about the same solid angle.
    pub parts: Vec<PartOfSky>,
    /// The light of the sun on land that faces it, linear.
    pub sun: [f64; 3],
}

fn luminance([red, green, blue]: [f64; 3]) -> f64 {
    0.2126 * red + 0.7152 * green + 0.0722 * blue
}

/// Returns the linear light of a clear sky in a direction above the horizon, given the sun's direction.
fn clear_sky(direction: DVec3, to_sun: DVec3) -> [f64; 3] {
    let away_rad = direction.angle_between(to_sun);
    let gradation = 1.0 - (-0.32 / direction.z.max(1e-3)).exp();
    let about_sun = 1.0 + 10.0 * ((-3.0 * away_rad).exp() - (-1.5 * PI).exp()) + 0.45 * away_rad.cos().powi(2);
    // A sun below the horizon does not light the sky.
    let is_up = (to_sun.z * 10.0).clamp(0.0, 1.0);
    let luminance = gradation * (1.0 + is_up * (about_sun - 1.0));
    let near = (-1.5 * away_rad).exp() * is_up;
    std::array::from_fn(|i| luminance * (AWAY_FROM_SUN[i] + (NEAR_SUN[i] - AWAY_FROM_SUN[i]) * near))
}

/// Returns the middles of the parts, on a spiral around the sphere.
fn middles(count: u32) -> Vec<DVec3> {
    let middle = |i: u32| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let (sine, cosine) = (GOLDEN_RAD * f64::from(i)).sin_cos();
        let out = (1.0 - z * z).sqrt();
        DVec3::new(out * cosine, out * sine, z)
    };
    (0..count).map(middle).collect()
}

/// Returns directions all over the sphere, each with its solid angle.
fn sphere() -> impl Iterator<Item = (DVec3, f64)> {
    let [rows, columns] = SAMPLED;
    let edge = move |row: usize| (PI * row as f64 / rows as f64).cos();
    (0..rows).flat_map(move |row| {
        let (z, solid_angle) = (0.5 * (edge(row) + edge(row + 1)), (edge(row) - edge(row + 1)) * TAU / columns as f64);
        (0..columns).map(move |column| {
            let (sine, cosine) = (TAU * (column as f64 + 0.5) / columns as f64).sin_cos();
            let out = (1.0 - z * z).sqrt();
            (DVec3::new(out * cosine, out * sine, z), solid_angle)
        })
    })
}

/// Returns the parts with their mean radiance.
fn parts_of(count: u32, radiance: impl Fn(DVec3) -> [f64; 3]) -> Vec<PartOfSky> {
    let middles = middles(count);
    let mut sums = vec![([0.0; 3], 0.0); middles.len()];
    for (direction, solid_angle) in sphere() {
        let nearness = |i: &usize| middles[*i].dot(direction);
        let nearest = (0..middles.len()).max_by(|a, b| nearness(a).total_cmp(&nearness(b))).unwrap_or(0);
        let (sum, angle): &mut ([f64; 3], f64) = &mut sums[nearest];
        for (channel, value) in sum.iter_mut().zip(radiance(direction)) {
            *channel += value * solid_angle;
        }
        *angle += solid_angle;
    }
    let mean = |(sum, angle): ([f64; 3], f64)| sum.map(|channel| channel / f64::max(angle, 1e-9));
    middles
        .iter()
        .zip(sums)
        .map(|(direction, sums)| PartOfSky { direction: *direction, radiance: mean(sums) })
        .collect()
}

/// Returns the luminance of level land under the parts, relative to a white sky.
fn on_level_land(parts: &[PartOfSky]) -> f64 {
    let sum =
        |of: fn([f64; 3]) -> f64| parts.iter().map(|part| part.direction.z.max(0.0) * of(part.radiance)).sum::<f64>();
    sum(luminance) / sum(|_| 1.0).max(1e-9)
}

impl SkyParts {
    /// Creates the environment of a style's relief with the sun in direction `to_sun`.
    pub(crate) fn new(relief: &Relief, to_sun: DVec3) -> Self {
        let turn_rad = f64::from(relief.turn_deg).to_radians();
        let sun_part = if relief.sky.is_some() { 0.0 } else { f64::from(relief.sun) };
        let mut parts = relief.sky.as_ref().map_or_else(
            || {
                let above = parts_of(relief.lights.max(64), |direction| clear_sky(direction, to_sun));
                let ground = GROUND * on_level_land(&above);
                parts_of(relief.lights, |direction| {
                    if direction.z > 0.0 {
                        clear_sky(direction, to_sun)
                    } else {
                        GROUND_COLOR.map(|color| ground * color)
                    }
                })
            },
            |picture| {
                parts_of(relief.lights, |direction| {
                    picture.radiance(glam::DQuat::from_rotation_z(turn_rad) * direction)
                })
            },
        );
        let scale = (1.0 - sun_part) / on_level_land(&parts).max(1e-9);
        parts.iter_mut().for_each(|part| part.radiance = part.radiance.map(|channel| channel * scale));
        let sun = SUN_COLOR.map(|channel| channel * sun_part / luminance(SUN_COLOR));
        Self {
            lights: relief.lights,
            picture: relief.sky.clone(),
            turn_deg: relief.turn_deg,
            sun_part: relief.sun,
            to_sun,
            parts,
            sun,
        }
    }

    /// Returns whether [`SkyParts::new`] would return the same parts.
    pub(crate) fn is_of(&self, relief: &Relief, to_sun: DVec3) -> bool {
        let same_picture = match (&self.picture, &relief.sky) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other) || own == other,
            (own, other) => own.is_none() && other.is_none(),
        };
        let numbers = (self.lights, self.turn_deg, self.sun_part, self.to_sun);
        same_picture && numbers == (relief.lights, relief.turn_deg, relief.sun, to_sun)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a panic fails the test")]

    use super::*;

    #[test]
    fn parts_keep_the_light_of_the_whole() {
        // One half of the sphere is bright: the sum over the parts is the integral over the sphere.
        let radiance = |direction: DVec3| if direction.x > 0.2 { [3.0, 1.0, 0.0] } else { [0.5; 3] };
        let whole: f64 = sphere().map(|(direction, angle)| radiance(direction)[0] * angle).sum();
        for (count, most) in [(54, 0.02), (128, 0.02), (6, 0.2)] {
            let parts = parts_of(count, radiance);
            let sum: f64 = parts.iter().map(|part| part.radiance[0] * 4.0 * PI / f64::from(count)).sum();
            assert!((sum / whole - 1.0).abs() < most, "{count}: {sum} of {whole}");
        }
        let angle: f64 = sphere().map(|(_, angle)| angle).sum();
        assert!((angle - 4.0 * PI).abs() < 1e-9);
    }

    #[test]
    fn level_land_has_what_the_sun_leaves() {
        let relief = |keys: &str| {
            let text = format!(
                "name = \"t\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\n[relief]\n{keys}"
            );
            crate::style::Style::parse("t", &text).unwrap().relief.unwrap()
        };
        let to_sun = DVec3::new(-0.5, 0.5, 0.7).normalize();
        let parts = SkyParts::new(&relief("sun = 0.6"), to_sun);
        assert!((on_level_land(&parts.parts) - 0.4).abs() < 1e-6 && (luminance(parts.sun) - 0.6).abs() < 1e-6);
        assert!(parts.is_of(&relief("sun = 0.6"), to_sun) && !parts.is_of(&relief("sun = 0.5"), to_sun));
        // The sky is bright around the sun, and its parts are finite where the sun is below the horizon.
        let toward = |direction: DVec3| {
            let nearest =
                parts.parts.iter().max_by(|a, b| a.direction.dot(direction).total_cmp(&b.direction.dot(direction)));
            luminance(nearest.unwrap().radiance)
        };
        assert!(toward(to_sun) > 2.0 * toward(DVec3::new(0.5, -0.5, 0.7)));
        let night = SkyParts::new(&relief("lights = 1\nsun = 1.0"), -DVec3::Z);
        assert!(night.parts.iter().all(|part| part.radiance.iter().all(|channel| *channel == 0.0)));
    }
}
