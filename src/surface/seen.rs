//! The meaning of the two pictures of the visible surface, on the CPU: the twin of `shaders/shared/seen.wgsl`.
//!
//! Why: `docs/decisions/bytes-of-a-frame.md`.

use glam::{Vec2, Vec3};

use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::shared::seen::{NORMAL_OFFSET, NORMAL_SCALE};
use crate::gpu::wgsl::shared::view::View;

/// Distance of the visible surface along the view axis, in metres; 0 in the sky.
pub const DISTANCE: TargetKind = TargetKind::storage(
    "distance",
    wgpu::TextureFormat::R32Float,
    Group::Surface.shows("Distance along the view axis, in metres; 0 is the sky"),
);
/// Normal of the visible surface as a word ([`surface_of`]); 0 in the sky.
pub(crate) const NORMAL: TargetKind = TargetKind::storage(
    "normal",
    wgpu::TextureFormat::R32Uint,
    Group::Surface.shows("Normal of the surface, as red, green and blue"),
);
/// As [`NORMAL`], with the lightness as a second word, in scenes with models or trees.
pub(crate) const NORMAL_AND_LIGHTNESS: TargetKind = TargetKind::storage(
    "normal and lightness",
    wgpu::TextureFormat::Rg32Uint,
    Group::Surface
        .shows("Normal of the surface, as red, green and blue, in scenes with models or trees")
        .with_float_words(0b10),
);

/// Returns whether the picture `name` holds words of normals.
pub(crate) fn holds_normals(name: &str) -> bool {
    [NORMAL.name, NORMAL_AND_LIGHTNESS.name, super::trees::marks::MARK_SURFACE.name].contains(&name)
}

/// Returns the definitions of a shader that writes normals into a picture of [`NORMAL`] or [`NORMAL_AND_LIGHTNESS`].
pub(crate) fn definitions(normal: &Target) -> &'static [&'static str] {
    if normal.texture.format() == NORMAL.format { &[] } else { &["LIGHTNESS"] }
}

/// Returns the position that a pixel of the targets sees, in metres from the rig's origin, and its distance along the
/// view axis; all 0 in the sky.
pub(crate) fn place_at(view: &View, pixel: [u32; 2], along_m: f32) -> [f32; 4] {
    if along_m <= 0.0 {
        return [0.0; 4];
    }
    let [x, y] = [0, 1].map(|i| (pixel[i] as i32 + view.origin_px[i]) as f32 + 0.5);
    let ray = Vec3::from(view.ray_corner) + x * Vec3::from(view.ray_dx) + y * Vec3::from(view.ray_dy);
    (ray * along_m + Vec3::from(view.eye_m)).extend(along_m).to_array()
}

/// Returns the unit normal and the lightness that two words stand for; all 0 in the sky.
pub(crate) fn surface_of([normal, lightness]: [u32; 2]) -> [f32; 4] {
    if normal == 0 {
        return [0.0; 4];
    }
    let at = (Vec2::new((normal & 0xffff) as f32, (normal >> 16) as f32) - NORMAL_OFFSET) / NORMAL_SCALE;
    let z = 1.0 - at.x.abs() - at.y.abs();
    let below = (-z).max(0.0);
    let outward = |value: f32| if value >= 0.0 { value - below } else { value + below };
    let n = Vec3::new(outward(at.x), outward(at.y), z).normalize();
    n.extend(if lightness == 0 { 1.0 } else { f32::from_bits(lightness) }).to_array()
}

/// Returns the words of a unit normal and a lightness; 0 for a normal of 0, the sky.
#[cfg(test)]
pub(crate) fn words_of([x, y, z, lightness]: [f32; 4]) -> [u32; 2] {
    if [x, y, z] == [0.0; 3] {
        return [0; 2];
    }
    let at = Vec2::new(x, y) / (x.abs() + y.abs() + z.abs());
    let sign = |value: f32| if value >= 0.0 { 1.0 } else { -1.0 };
    let folded = Vec2::new((1.0 - at.y.abs()) * sign(at.x), (1.0 - at.x.abs()) * sign(at.y));
    let place = if z < 0.0 { folded } else { at }.clamp(Vec2::NEG_ONE, Vec2::ONE);
    let [x, y] = (place * NORMAL_SCALE).to_array().map(|value| (value.round_ties_even() + NORMAL_OFFSET) as u32);
    let lightness = if lightness == 0.0 { crate::gpu::wgsl::shared::seen::ZERO_LIGHTNESS } else { lightness.to_bits() };
    [x | y << 16, lightness]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns directions all over the sphere, by Fibonacci's lattice, and the axes.
    fn directions() -> impl Iterator<Item = Vec3> {
        let count = 20_000;
        let golden = std::f32::consts::PI * (3.0 - 5.0_f32.sqrt());
        let lattice = (0..count).map(move |i| {
            let z = 1.0 - (2.0 * i as f32 + 1.0) / count as f32;
            let (sin, cos) = (golden * i as f32).sin_cos();
            Vec3::new(cos * (1.0 - z * z).sqrt(), sin * (1.0 - z * z).sqrt(), z).normalize()
        });
        lattice.chain([Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [axis, -axis]))
    }

    /// Returns the largest angle between directions and what words of `bits` bits per coordinate make of them.
    fn largest_rad(bits: u32) -> f32 {
        let lost = 16 - bits;
        let turned = |n: Vec3| {
            let [word, lightness] = words_of(n.extend(0.25).to_array());
            // The middle, 0x8000, and both ends of the remaining range are unchanged.
            let shortened = |part: u32| (((part.wrapping_sub(0x8000) as i32) >> lost << lost) + 0x8000).max(1) as u32;
            let word = shortened(word & 0xffff) | shortened(word >> 16) << 16;
            let [x, y, z, left] = surface_of([word, lightness]);
            assert_eq!(left, 0.25);
            let found = Vec3::new(x, y, z);
            n.cross(found).length().atan2(n.dot(found))
        };
        directions().map(turned).fold(0.0, f32::max)
    }

    #[test]
    fn a_normal_survives_its_word() {
        assert!(largest_rad(16) < 7e-5, "{}", largest_rad(16));
        // Planted error: coordinates of 14 bits.
        assert!(largest_rad(14) > 1e-4);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z] {
            assert_eq!(surface_of(words_of(axis.extend(1.0).to_array())), axis.extend(1.0).to_array());
        }
        // No normal is the sky, black is not white, and bare land needs no second word.
        assert!(directions().all(|n| words_of(n.extend(1.0).to_array())[0] != 0));
        assert_eq!(surface_of(words_of([0.0, 0.0, 1.0, 0.0]))[3], 0.0);
        assert_eq!(surface_of([words_of([0.0, 0.0, 1.0, 0.5])[0], 0])[3], 1.0);
        assert_eq!(surface_of([0, 0]), [0.0; 4]);
    }
}
