//! Tests the five controls on drawings: every preset has them, and those that have an effect change the drawing in the
//! direction that their names say.
#![cfg(feature = "window")]

use crate::tests::common;

use common::draw::north_west;
use common::{World, full, grid_of, rough_height_m};
use hachure::frame::Renderer;
use hachure::picture::{self, PictureRequest};
use hachure::studio::document::StyleDocument;
use hachure::style::controls::{Control, END, RULES};
use hachure::style::{Style, Tone, names};

const CAMERA: &str = "-1500,-3600,+450,20,-9,50";
/// The presets and controls that the fast tier draws: every control, on a preset of lines, strokes, marks or washes.
const DRAWN: [(&str, Control); 6] = [
    ("lsa", Control::Density),
    ("strokes", Control::Weight),
    ("crosshatch", Control::Weight),
    ("strokes", Control::Contrast),
    ("wash", Control::Softness),
    ("wash", Control::Warmth),
];

fn size_px() -> [u32; 2] {
    if full() { [200, 120] } else { [120, 72] }
}

/// Draws small pictures of a world.
struct Studio {
    world: World,
    renderer: Option<Renderer>,
}

/// A picture: red, green and blue of each pixel, 0 to 1, in sRGB.
type Pixels = Vec<[f64; 3]>;

impl Studio {
    fn open() -> Option<Self> {
        let world = World::new(grid_of(257, 257, 30.0, |x, y| 0.5 * rough_height_m(x, y)), 0.5)?;
        Some(Self { world, renderer: None })
    }

    fn draw(&mut self, style: &Style) -> Pixels {
        let pose = self.world.pose(CAMERA);
        let request = PictureRequest::still(pose, size_px(), style, north_west());
        let mut pixels = Pixels::new();
        let (gpu, surfaces) = (&self.world.gpu, &mut self.world.surfaces);
        picture::render(gpu, &mut self.renderer, surfaces, &request, |band| {
            let bytes = picture::srgb8(&band.picture);
            let channels = bytes.len() / band.picture.len();
            let texels = bytes.chunks_exact(channels).map(|texel| [texel[0], texel[1], texel[2]]);
            pixels.extend(texels.map(|texel| texel.map(|byte| f64::from(byte) / 255.0)));
            Ok::<(), std::convert::Infallible>(())
        })
        .unwrap();
        pixels
    }

    /// Returns how much the layers whose key is chosen change the picture.
    fn ink(&mut self, style: &Style, is_chosen: impl Fn(&str) -> bool) -> f64 {
        let drawn = self.draw(style);
        let bare = self.draw(&style.clone().without_layers(is_chosen));
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
        drawn.iter().zip(&bare).map(apart).sum::<f64>() / drawn.len() as f64
    }

    /// Measures what a control should increase.
    fn measure(&mut self, control: Control, style: &Style) -> f64 {
        match control {
            // Water does not follow the density, and its tint would count as ink.
            Control::Density => self.ink(style, |key| key != "water"),
            Control::Weight => self.ink(style, |_| true),
            Control::Contrast => deviation(&self.tones(style)),
            Control::Softness => -roughness(&self.tones(style)),
            Control::Warmth => warmth(&self.draw(style)),
        }
    }

    /// Draws only the tones of a style, with the whole tone as colour.
    fn tones(&mut self, style: &Style) -> Pixels {
        let mut style = style.clone().without_layers(|_| true);
        if let Tone::Toon(toon) = &mut style.tone {
            toon.wash = 1.0;
        }
        self.draw(&style)
    }
}

fn brightness(pixel: &[f64; 3]) -> f64 {
    pixel.iter().sum::<f64>() / 3.0
}

/// Returns the standard deviation of brightness.
fn deviation(pixels: &Pixels) -> f64 {
    let count = pixels.len() as f64;
    let mean = pixels.iter().map(brightness).sum::<f64>() / count;
    (pixels.iter().map(|pixel| (brightness(pixel) - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Returns the mean of the squared differences between neighbouring pixels.
fn roughness(pixels: &Pixels) -> f64 {
    let width = size_px()[0] as usize;
    let rows: Vec<Vec<f64>> = pixels.chunks(width).map(|row| row.iter().map(brightness).collect()).collect();
    let across = rows.iter().flat_map(|row| row.windows(2)).map(|pair| (pair[0] - pair[1]).powi(2));
    1000.0 * across.sum::<f64>() / pixels.len() as f64
}

/// Returns the mean difference between red and blue.
fn warmth(pixels: &Pixels) -> f64 {
    pixels.iter().map(|pixel| pixel[0] - pixel[2]).sum::<f64>() / pixels.len() as f64
}

/// Returns the style at a position of a control.
fn style_at(name: &str, control: Control, position: i8) -> Style {
    let mut document = StyleDocument::open(name).unwrap();
    document.set_control(control, position).unwrap();
    document.style().clone()
}

#[test]
fn controls_change_the_drawing_in_their_direction() {
    let Some(mut studio) = Studio::open() else { return };
    let mut wrong = Vec::new();
    let mut effective = 0;
    let presets = common::presets();
    for name in &presets {
        let plain = StyleDocument::open(name).unwrap();
        assert_eq!(Control::ALL.len(), 5);
        for control in Control::ALL {
            if let Some(why) = control.without_effect(plain.style()) {
                assert!(why.ends_with('.'), "{why}");
                assert_eq!(&style_at(name, control, END), plain.style(), "{name} {control:?}");
                continue;
            }
            effective += 1;
            if !full() && !DRAWN.contains(&(*name, control)) {
                continue;
            }
            let ends = [-END, END].map(|position| style_at(name, control, position));
            assert!(ends.iter().all(|end| end != plain.style()), "{name} {control:?} changes nothing");
            let [low, high] = [&ends[0], &ends[1]].map(|style| studio.measure(control, style));
            println!("{name} {control:?}: {low:.4} to {high:.4}");
            let width = (high - low) / low.abs().max(0.02);
            if width < 0.03 {
                wrong.push(format!("{name} {control:?}: {low:.4} to {high:.4}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    let controls = Control::ALL.len() * presets.len();
    assert!(9 * effective > 8 * controls, "{effective} of {controls} controls have an effect");
    // Planted: a control that is turned round.
    let [low, high] = [END, -END].map(|position| style_at("wash", Control::Warmth, position));
    assert!(studio.measure(Control::Warmth, &high) < studio.measure(Control::Warmth, &low));
}

#[test]
fn every_rule_names_a_parameter_of_some_preset() {
    let mut used = vec![0; RULES.len()];
    for name in names() {
        let document = StyleDocument::open(name).unwrap();
        for (rule, used) in RULES.iter().zip(&mut used) {
            let rows = document.sections().iter().flat_map(|section| &section.rows);
            *used += rows.filter(|row| hachure::style::controls::bare(&row.key) == rule.key).count();
        }
    }
    let unused: Vec<&str> = RULES.iter().zip(&used).filter(|(_, used)| **used == 0).map(|(rule, _)| rule.key).collect();
    assert!(unused.is_empty(), "{unused:?}");
}
