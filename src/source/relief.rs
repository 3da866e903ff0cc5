//! The rock of the procedural world before any water runs: where the land rises, how hard the rock is, and the
//! roughness from which the first streams start. All of these are noise over the plane, in metres, so that every level
//! of detail evaluates the same world.

use noise::{Fbm, MultiFractal, NoiseFn, Perlin, RidgedMulti};

/// The noise fields of one seed.
pub(super) struct Relief {
    warp_x: Fbm<Perlin>,
    warp_y: Fbm<Perlin>,
    massifs: RidgedMulti<Perlin>,
    hills: Fbm<Perlin>,
    rock: Fbm<Perlin>,
    detail: Perlin,
    axis: (f64, f64),
    offset_m: f64,
    bend_per_m: f64,
}

impl Relief {
    /// Builds the noise fields of `seed`.
    pub(super) fn new(seed: u32) -> Self {
        let sub_seed = |stream: u32| hash(seed.wrapping_mul(0x9E37_79B9) ^ hash(stream));
        // The axis avoids the directions of the grid.
        let angle = (0.12 + 0.26 * unit(sub_seed(1))) * std::f64::consts::PI;
        let mirrored = if sub_seed(2) & 1 == 0 { 1.0 } else { -1.0 };
        let side = if sub_seed(3) & 1 == 0 { 1.0 } else { -1.0 };
        Self {
            warp_x: Fbm::new(sub_seed(4)).set_octaves(3),
            warp_y: Fbm::new(sub_seed(5)).set_octaves(3),
            massifs: RidgedMulti::new(sub_seed(6)).set_octaves(4),
            hills: Fbm::new(sub_seed(7)).set_octaves(3),
            rock: Fbm::new(sub_seed(8)).set_octaves(4),
            detail: Perlin::new(sub_seed(9)),
            axis: (angle.cos() * side, angle.sin() * mirrored * side),
            offset_m: 2_500.0 * unit(sub_seed(10)),
            bend_per_m: (unit(sub_seed(11)) - 0.5) * 3.0e-5,
        }
    }

    /// Returns how fast the land rises at a position, 0 (plain) to about 1 (the heart of the main range).
    pub(super) fn uplift(&self, x_m: f64, y_m: f64) -> f32 {
        let warp_at = [x_m / 13_000.0, y_m / 13_000.0];
        let x_m = x_m + 4_200.0 * self.warp_x.get(warp_at);
        let y_m = y_m + 4_200.0 * self.warp_y.get(warp_at);
        let along_m = x_m * self.axis.0 + y_m * self.axis.1;
        let across_m = -x_m * self.axis.1 + y_m * self.axis.0 - self.offset_m + self.bend_per_m * along_m * along_m;
        let bell = |centre_m: f64, half_width_m: f64| (-((across_m - centre_m) / half_width_m).powi(2)).exp();
        let hills = self.hills.get([x_m / 7_000.0, y_m / 7_000.0]);
        let massifs = self.massifs.get([x_m / 10_500.0, y_m / 10_500.0]) * 0.5 + 0.5;
        let main = bell(0.0, 5_200.0) * (0.38 + 0.78 * massifs);
        let second = bell(-11_000.0, 3_200.0) * (0.22 + 0.4 * massifs);
        let foothills = bell(8_500.0, 4_500.0) * 0.22 * (0.55 + hills).max(0.0);
        let plain = 0.035 * (0.6 + hills).max(0.1);
        (main + second + foothills + plain).max(0.0) as f32
    }

    /// Returns how strongly the rock resists water and gravity: 1 is common, about 0.6 soft, about 1.7 hard.
    pub(super) fn hardness(&self, x_m: f64, y_m: f64) -> f32 {
        // Beds cross the range at a slant and are folded by the noise itself.
        let folded = self.rock.get([x_m / 5_200.0, y_m / 5_200.0]);
        let beds = (folded * 9.0 + (x_m * self.axis.0 - y_m * self.axis.1) / 2_300.0).sin();
        (0.45 * folded + 0.2 * beds).exp() as f32
    }

    /// Returns the initial ground before stream erosion, in -1 to 1: a ridged multifractal.
    pub(super) fn first_ground(&self, x_m: f64, y_m: f64) -> f32 {
        self.massifs.get([x_m / 3_100.0 + 7.3, y_m / 3_100.0 - 2.9]) as f32
    }

    /// Returns roughness with features of about `wavelength_m`, in -1 to 1; different values of `stream` give
    /// independent noise.
    pub(super) fn roughness(&self, x_m: f64, y_m: f64, wavelength_m: f64, stream: u32) -> f64 {
        // The noise is rotated against the grid, so that its lattice does not show along the grid; the angle differs
        // from stream to stream, so that no two lattices agree.
        let (sin, cos) = (0.6 + 1.1 * f64::from(stream)).sin_cos();
        let shift = 31.7 * f64::from(stream);
        let (u, v) = (x_m * cos - y_m * sin, x_m * sin + y_m * cos);
        self.detail.get([u / wavelength_m + shift, v / wavelength_m - shift])
    }
}

/// Converts the upper bits of a hash to a number in 0 to 1.
fn unit(bits: u32) -> f64 {
    f64::from(bits >> 8) / f64::from(1u32 << 24)
}

/// Mixes 32 bits so that every bit of the input changes half of the output.
pub(super) fn hash(mut bits: u32) -> u32 {
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x7FEB_352D);
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x846C_A68B);
    bits ^ (bits >> 16)
}
