//! Conversions of pixels between sRGB and linear light.

use std::sync::LazyLock;

use super::Rgba;

/// Linear light of each sRGB shade.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|shade| {
        let shade = shade as f32 / 255.0;
        if shade <= 0.04045 { shade / 12.92 } else { ((shade + 0.055) / 1.055).powf(2.4) }
    })
});

/// Number of steps of linear light whose shades are in a table. The darkest shades are further apart than two steps.
const STEPS: usize = 1 << 13;

/// The sRGB shade of linear light.
static SHADES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let shade = |step: usize| {
        let light = step as f32 / STEPS as f32;
        let shade = if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        (255.0 * shade).round() as u8
    };
    (0..=STEPS).map(shade).collect()
});

/// Returns the linear light of an sRGB shade, 0 to 1.
fn linear_of(shade: u8) -> f32 {
    LINEAR[usize::from(shade)]
}

/// Returns the sRGB shade of linear light.
fn shade_of(light: f32) -> u8 {
    SHADES[(light.clamp(0.0, 1.0) * STEPS as f32).round() as usize]
}

/// Linear colour times opacity, and opacity, so that means are those of light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Premultiplied([f32; 4]);

impl Premultiplied {
    pub(crate) fn of([red, green, blue, alpha]: Rgba) -> Self {
        let alpha = f32::from(alpha) / 255.0;
        Self([linear_of(red) * alpha, linear_of(green) * alpha, linear_of(blue) * alpha, alpha])
    }

    pub(crate) fn add(&mut self, other: Self, weight: f32) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, value)| *sum += weight * value);
    }

    /// Returns this colour over another one.
    pub(crate) fn over(self, below: Self) -> Self {
        let mut sum = self;
        sum.add(below, 1.0 - self.0[3]);
        sum
    }

    pub(crate) fn alpha(self) -> f32 {
        self.0[3]
    }

    /// Returns the pixel of this colour, not premultiplied.
    pub(crate) fn pixel(self) -> Rgba {
        let [red, green, blue, alpha] = self.0;
        if alpha <= 0.0 {
            return [0; 4];
        }
        let [red, green, blue] = [red, green, blue].map(|light| shade_of(light / alpha));
        [red, green, blue, (255.0 * alpha.min(1.0)).round() as u8]
    }

    /// Returns the texel of an sRGB texture with linear colour times opacity.
    pub(crate) fn texel(self) -> Rgba {
        let [red, green, blue, alpha] = self.0;
        let [red, green, blue] = [red, green, blue].map(shade_of);
        [red, green, blue, (255.0 * alpha.clamp(0.0, 1.0)).round() as u8]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shades_and_light_are_inverse() {
        for shade in 0..=255 {
            assert!(shade_of(linear_of(shade)).abs_diff(shade) <= 1, "{shade}");
            assert_eq!(Premultiplied::of([shade, shade, shade, 255]).pixel()[0].abs_diff(shade) / 2, 0);
        }
        assert_eq!(Premultiplied::of([200, 10, 30, 0]).pixel(), [0; 4]);
        // Planted: a mean of shades is darker than that of light.
        let mut mean = Premultiplied::default();
        [[0, 0, 0, 255], [255; 4]].into_iter().for_each(|pixel| mean.add(Premultiplied::of(pixel), 0.5));
        assert!(mean.pixel()[0] > 180 && mean.pixel()[0] != 128);
    }
}
