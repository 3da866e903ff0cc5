//! `[wind]` of a scene: how trees sway.
//!
//! A tree leans with the wind, in proportion to the square of the wind speed and of the height above the foot: 0.5 m at
//! 20 m in a wind of 10 m/s. Waves move it around that lean: three gusts, which the wind carries over the land
//! unchanged, and two shorter waves, which stand for the trees' own oscillation and differ between neighbours. All of
//! it is a function of position and time: the same on every machine, in every frame, for both eyes.
//! `shaders/shared/wind.wgsl` evaluates it; the phases are computed here in f64, since f32 has too few digits for the
//! origin of a rig and for an hour.

use std::f64::consts::TAU;

use glam::DVec2;
use serde::Deserialize;

use super::forest::{WrongKey, within};
use super::view::Clock;
use crate::gpu::wgsl::shared::wind::MAX_LEAN;
pub(crate) use crate::gpu::wgsl::shared::wind::{Wave as WaveUniform, Wind as WindUniform};

/// Wind over the whole world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wind {
    /// Mean speed at the height of trees; at most [`Wind::FASTEST_M_S`].
    pub speed_m_s: f64,
    /// Direction it comes from, clockwise from north.
    pub from_deg: f64,
}

/// Lean of trees in a wind of 1 m/s, in metres per square metre of height.
const LEAN_PER_M2: f64 = 0.5 / (20.0 * 20.0) / (10.0 * 10.0);
/// Amplitude of the flutter of leaves in a wind of 10 m/s, and its maximum in any wind, in metres.
const FLUTTER_M: f64 = 0.04;
const MAX_FLUTTER_M: f64 = 0.07;

/// A wave: how much it moves a tree along the wind and across it, as shares of the mean lean.
struct Wave {
    kind: Kind,
    along: f64,
    across: f64,
}

/// How a wave moves.
enum Kind {
    /// Carried by the wind: its wavelength, and its direction relative to the wind, counter-clockwise.
    Gust { length_m: f64, turned_deg: f64 },
    /// Stationary oscillation: radians per metre east, north and up, and frequency.
    Swing { per_m: [f64; 3], hz: f64 },
}

const SWAYS: [Wave; 5] = [
    Wave { kind: Kind::Gust { length_m: 230.0, turned_deg: 0.0 }, along: 0.30, across: 0.04 },
    Wave { kind: Kind::Gust { length_m: 97.0, turned_deg: 24.0 }, along: 0.18, across: 0.08 },
    Wave { kind: Kind::Gust { length_m: 41.0, turned_deg: -33.0 }, along: 0.12, across: 0.06 },
    Wave { kind: Kind::Swing { per_m: [1.93, 0.71, 0.0], hz: 0.27 }, along: 0.12, across: 0.05 },
    Wave { kind: Kind::Swing { per_m: [-0.83, 1.57, 0.0], hz: 0.41 }, along: 0.06, across: 0.09 },
];

/// Waves of leaves; their motion across the wind is up and down.
const FLUTTERS: [Wave; 2] = [
    Wave { kind: Kind::Swing { per_m: [4.1, 1.3, 2.2], hz: 1.1 }, along: 0.7, across: 0.3 },
    Wave { kind: Kind::Swing { per_m: [-1.7, 3.9, 3.1], hz: 1.7 }, along: 0.3, across: 0.7 },
];

impl Wind {
    /// Fastest allowed wind: a hurricane.
    pub(crate) const FASTEST_M_S: f64 = 60.0;

    /// Returns the unit vector (east, north) along which the wind blows.
    pub(crate) fn toward(&self) -> DVec2 {
        let (sin, cos) = self.from_deg.to_radians().sin_cos();
        -DVec2::new(sin, cos)
    }

    /// Returns the lean (east, north) of a tree at `up_m` above its foot at `foot_m`, in metres. The same formula as in
    /// the shader, in f64.
    #[cfg(test)]
    pub(crate) fn lean_m(&self, foot_m: DVec2, up_m: f64, time_s: f64) -> DVec2 {
        let toward = self.toward();
        let (along, across) = SWAYS.iter().fold((1.0, 0.0), |(along, across), wave| {
            let (_, phase) = wave.phase(self, foot_m, time_s);
            (along + wave.along * phase.sin(), across + wave.across * phase.sin())
        });
        let sway = (toward * along + toward.perp() * across) * self.mean_lean();
        sway * up_m * up_m / (1.0 + (sway.length() * up_m / f64::from(MAX_LEAN)).powi(2)).sqrt()
    }

    /// Returns an upper bound of how far any part of a tree `tall_m` high moves aside, leaves included, in metres.
    pub(crate) fn reach_m(&self, tall_m: f64) -> f64 {
        let (along, across) =
            SWAYS.iter().fold((1.0, 0.0), |(along, across), wave| (along + wave.along, across + wave.across));
        let most = self.mean_lean() * DVec2::new(along, across).length() * tall_m * tall_m;
        most.min(f64::from(MAX_LEAN) * tall_m) + 2.0 * self.flutter_m()
    }

    /// Returns the uniform for shaders, with positions relative to `origin_m`, the rig's origin.
    pub(crate) fn uniform(&self, origin_m: DVec2, clock: Clock) -> WindUniform {
        let wave = |wave: &Wave| {
            let (per_m, now) = wave.phase(self, origin_m, clock.now_s);
            let (_, before) = wave.phase(self, origin_m, clock.before_s);
            let [east, north, up] = per_m.map(|along| along as f32);
            WaveUniform {
                per_m: [east, north],
                now: now.rem_euclid(TAU) as f32,
                before: before.rem_euclid(TAU) as f32,
                along: wave.along as f32,
                across: wave.across as f32,
                per_m_up: up,
                padding: 0.0,
            }
        };
        WindUniform {
            toward: self.toward().as_vec2().to_array(),
            mean_lean: self.mean_lean() as f32,
            flutter_m: self.flutter_m() as f32,
            sways: SWAYS.each_ref().map(wave),
            flutters: FLUTTERS.each_ref().map(wave),
            ..WindUniform::default()
        }
    }

    fn mean_lean(&self) -> f64 {
        LEAN_PER_M2 * self.speed_m_s * self.speed_m_s
    }

    fn flutter_m(&self) -> f64 {
        (FLUTTER_M * self.speed_m_s / 10.0).min(MAX_FLUTTER_M)
    }
}

impl Wave {
    /// Returns the wave vector in radians per metre, and the phase at a point of the ground in radians.
    fn phase(&self, wind: &Wind, at_m: DVec2, time_s: f64) -> ([f64; 3], f64) {
        match self.kind {
            Kind::Gust { length_m, turned_deg } => {
                let toward = wind.toward();
                let per_m = DVec2::from_angle(turned_deg.to_radians()).rotate(toward) * (TAU / length_m);
                // The wind carries the wave.
                let carried_m = toward * wind.speed_m_s * time_s;
                ([per_m.x, per_m.y, 0.0], per_m.dot(at_m - carried_m))
            }
            Kind::Swing { per_m, hz } => {
                let [east, north, _] = per_m;
                (per_m, east * at_m.x + north * at_m.y - TAU * hz * time_s)
            }
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WindToml {
    speed_m_s: Option<f64>,
    from_deg: Option<f64>,
}

impl WindToml {
    /// Validates the section; `None` for a wind speed of 0.
    ///
    /// # Errors
    /// The first wrong key.
    pub(super) fn checked(&self) -> Result<Option<Wind>, WrongKey> {
        let number = |key, value, default, range| within("wind.", key, value, default, range);
        let speed_m_s = number("speed_m_s", self.speed_m_s, 5.0, 0.0..=Wind::FASTEST_M_S)?;
        let from_deg = number("from_deg", self.from_deg, 270.0, -360.0..=360.0)?;
        Ok((speed_m_s > 0.0).then_some(Wind { speed_m_s, from_deg }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIND: Wind = Wind { speed_m_s: 10.0, from_deg: 240.0 };

    /// Leans of many trees at many times.
    fn leans(wind: Wind, up_m: f64) -> Vec<DVec2> {
        let place = |i: u32| DVec2::new(f64::from(i % 50) * 13.7, f64::from(i / 50) * 17.3);
        (0..2000).map(|i| wind.lean_m(place(i), up_m, f64::from(i) * 0.37)).collect()
    }

    fn mean(leans: &[DVec2]) -> DVec2 {
        leans.iter().sum::<DVec2>() / leans.len() as f64
    }

    #[test]
    fn a_tree_of_20_m_bends_by_half_a_metre_in_a_wind_of_10_m_s() {
        let at_top = leans(WIND, 20.0);
        let max_m = at_top.iter().map(|lean| lean.length()).fold(0.0, f64::max);
        assert!((mean(&at_top).dot(WIND.toward()) - 0.5).abs() < 0.03, "{}", mean(&at_top));
        assert!((0.6..1.0).contains(&max_m) && max_m <= WIND.reach_m(20.0), "{max_m}");
        // It grows with the square of the height and is 0 at the foot.
        let half = mean(&leans(WIND, 10.0)).length() / mean(&at_top).length();
        assert!((half - 0.25).abs() < 0.01 && mean(&leans(WIND, 0.0)) == DVec2::ZERO, "{half}");
        // Planted: twice the wind speed, and another wind direction.
        assert!(mean(&leans(Wind { speed_m_s: 20.0, ..WIND }, 20.0)).length() > 1.5);
        assert!(mean(&leans(Wind { from_deg: 60.0, ..WIND }, 20.0)).dot(WIND.toward()) < -0.4);
        // The lean stays bounded in a storm.
        for lean in leans(Wind { speed_m_s: 60.0, ..WIND }, 40.0) {
            assert!(lean.length() < f64::from(MAX_LEAN) * 40.0 && lean.length() > 6.0, "{lean}");
        }
    }

    #[test]
    fn gusts_travel_with_the_wind() {
        let gust = |at_m: DVec2, time_s: f64| SWAYS[1].phase(&WIND, at_m, time_s).1;
        let (at_m, carried_m) = (DVec2::new(1e5, -2e5), WIND.toward() * 30.0);
        assert!((gust(at_m + carried_m, 3.0) - gust(at_m, 0.0)).abs() < 1e-6);
        // Planted: carried the other way.
        assert!((gust(at_m - carried_m, 3.0) - gust(at_m, 0.0)).abs() > 1.0);
    }

    #[test]
    fn phases_do_not_depend_on_the_origin_of_the_rig() {
        let clock = Clock { now_s: 4000.0, before_s: 4000.0 - 1.0 / 60.0 };
        let at_m = DVec2::new(123_456.7, -98_765.4);
        for from_origin_m in [DVec2::new(40.0, 25.0), DVec2::new(-300.0, 1000.0)] {
            let uniform = WIND.uniform(at_m - from_origin_m, clock);
            for (wave, uploaded) in SWAYS.iter().zip(&uniform.sways) {
                let there = from_origin_m.as_vec2();
                let phase = there.x * uploaded.per_m[0] + there.y * uploaded.per_m[1] + uploaded.now;
                let exact = wave.phase(&WIND, at_m, clock.now_s).1;
                assert!((f64::from(phase).sin() - exact.sin()).abs() < 1e-3);
                // Planted: a point 10 m away.
                let off = wave.phase(&WIND, at_m + 10.0, clock.now_s).1;
                assert!((f64::from(phase).sin() - off.sin()).abs() > 1e-3);
            }
        }
    }
}
