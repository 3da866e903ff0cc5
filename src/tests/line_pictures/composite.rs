//! Tests inks, haze and sky of the composite, without the paper's grain.

use glam::{DVec2, DVec3};
use hachure::composite::{self, DrawnInk, PICTURE};
use hachure::frame::Light;
use hachure::gpu::target::TargetKind;
use hachure::lines::threshold::LINE;
use hachure::lines::tone::ink::TONE_INK;
use hachure::style::color::linear_from_srgb;
use hachure::style::layers::{Channels, Fading};
use hachure::style::{Color, Style};
use hachure::surface::DISTANCE;
use hachure::tones::TONE;

use crate::tests::line_pictures::{Bench, SIZE_PX, bits, chance, inside, off, places, view};

/// An ink of the test and the texels of its picture.
#[derive(Clone)]
struct TestInk {
    color: Color,
    fading: Fading,
    channels: Channels,
    texels: Vec<[half::f16; 4]>,
}

/// Pictures that are composited.
struct Layers {
    position: Vec<[f32; 4]>,
    tone: Vec<[half::f16; 4]>,
    /// From the bottom to the top.
    inks: Vec<TestInk>,
}

/// Returns inks of every kind of fading and channels, detected lines among them.
fn inks() -> Vec<TestInk> {
    let part = |x: i64, y: i64, turn: i64, share: f64| (chance(x, y, turn) - 1.0 + share).max(0.0) / share;
    let surface = |faintest, reach, follows_tone| Fading::OnSurface { faintest, reach, follows_tone };
    let kinds = [
        ("#f0e060", surface(0.1, 1.7, false), Channels::One(1), 0.2),
        ("#604020", surface(0.2, 1.0, false), Channels::One(0), 0.2),
        ("#14120f", surface(0.5, 1.0, true), Channels::One(0), 0.5),
        ("#1a1a80", surface(0.4, 1.0, true), Channels::Crossed(3), 0.2),
        ("#1a661a", surface(0.45, 0.6, true), Channels::One(2), 0.3),
        ("#991a4d", Fading::OnNearest { faintest: 0.15, reach: 1.3 }, Channels::One(0), 0.4),
        ("#103050", surface(0.3, 1.0, false), Channels::One(0), 0.2),
        ("#20242e", Fading::AlreadyFaded, Channels::One(0), 0.2),
        // A second one of a kind, above the strokes.
        ("#0a5a8a", surface(0.6, 1.0, true), Channels::Crossed(2), 0.2),
    ];
    (0..)
        .zip(kinds)
        .map(|(number, (color, fading, channels, share))| {
            let texel = |channel: i64, x, y| half::f16::from_f64(part(x, y, 7 + 4 * number + channel, share));
            // A pass that draws fewer families leaves 0 in the other channels.
            let drawn = match channels {
                Channels::One(_) => 4,
                Channels::Crossed(families) => families,
            };
            let texel = |(x, y)| {
                std::array::from_fn(
                    |channel| if channel < drawn { texel(channel as i64, x, y) } else { half::f16::ZERO },
                )
            };
            TestInk { color: color.parse().unwrap(), fading, channels, texels: places().map(texel).collect() }
        })
        .collect()
}

/// Returns a slope that recedes into the distance, sky above it, and some of every ink.
fn layers() -> Layers {
    let view = view();
    let position = places().map(|(x, y)| {
        let depth_m = if y < 12 { 0.0 } else { 40_000.0 / (y - 11) as f64 * (1.0 + 0.3 * chance(x / 9, y / 7, 1)) };
        let at = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) * depth_m;
        let [x, y, z] = at.as_vec3().to_array();
        [x, y, z, depth_m as f32]
    });
    Layers {
        position: position.collect(),
        tone: places().map(|(x, y)| std::array::from_fn(|i| half::f16::from_f64(chance(x, y, 2 + i as i64)))).collect(),
        inks: inks(),
    }
}

fn linear(color: Color) -> DVec3 {
    DVec3::from_array(color.linear().map(f64::from))
}

fn mix(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a + (b - a) * t
}

/// The CPU twin of the composite. A pixel whose distance is more than `behind` times that of its nearest neighbour is
/// behind a line.
fn twin(layers: &Layers, style: &Style, light: &Light, behind: f64) -> Vec<f64> {
    let view = view();
    let at = |x: i64, y: i64| layers.position[inside(x, y)].map(f64::from);
    let away = |[x, y, z, _]: [f64; 4]| DVec3::new(x, y, z).length();
    let clearness = |distance_m: f64, reach: f64| (-(distance_m / (light.haze_m * reach)).powi(2)).exp();
    let haze = light.haze_srgb.map_or(linear(style.haze.color), |color| {
        DVec3::from_array(color.map(|value| f64::from(linear_from_srgb(value))))
    });
    let left = |faintest: f32, clear: f64| f64::from(faintest) + (1.0 - f64::from(faintest)) * clear;
    places()
        .flat_map(|(x, y)| {
            let i = inside(x, y);
            let here = at(x, y);
            let is_sky = here[3] <= 0.0;
            let mut color = if is_sky {
                let up = view.ray(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)).normalize().z;
                mix(linear(style.sky.horizon), linear(style.sky.zenith), (2.0 * up).clamp(0.0, 1.0))
            } else {
                let [red, green, blue, _] = layers.tone[i].map(half::f16::to_f64);
                let clear = clearness(away(here), 1.0);
                mix(haze, DVec3::new(red, green, blue), left(style.haze.faintest_tone, clear))
            };
            color *= linear(style.paper.color);
            for ink in &layers.inks {
                let texel = ink.texels[i].map(half::f16::to_f64);
                let amount = match ink.channels {
                    Channels::One(channel) => texel[channel],
                    Channels::Crossed(_) => 1.0 - texel[..3].iter().map(|ink| 1.0 - ink).product::<f64>(),
                };
                let faded = match ink.fading {
                    Fading::AlreadyFaded => 1.0,
                    Fading::OnSurface { faintest, reach, .. } => {
                        if is_sky {
                            1.0
                        } else {
                            left(faintest, clearness(away(here), reach.into()))
                        }
                    }
                    Fading::OnNearest { faintest, reach } => {
                        let around = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (x + i, y + j)));
                        let around = around.map(|(x, y)| at(x, y));
                        let nearest = around.filter(|at| at[3] > 0.0).map(away).fold(1e30, f64::min);
                        let clear = clearness(nearest, reach.into());
                        let side = if is_sky || away(here) > behind * nearest { clear } else { 1.0 };
                        side * left(faintest, clear)
                    }
                };
                color = mix(color, linear(ink.color), amount * faded);
            }
            color.to_array()
        })
        .collect()
}

#[test]
fn the_composite_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    let mut style = Style::load("lsa").unwrap();
    style.paper.grain = 0.0;
    let layers = layers();
    let distances_m: Vec<f32> = layers.position.iter().map(|at| at[3]).collect();
    let distance = bench.picture(&DISTANCE, SIZE_PX, &distances_m);
    let tone = bench.picture(&TONE, SIZE_PX, &bits(&layers.tone));
    let drawn: Vec<DrawnInk> = layers
        .inks
        .iter()
        .map(|ink| {
            // Detected lines have one channel of 32 bits.
            let (line, half): (&TargetKind, _) = (&LINE, &TONE_INK);
            let picture = match ink.fading {
                Fading::OnNearest { .. } => {
                    let texels: Vec<f32> = ink.texels.iter().map(|texel| texel[0].to_f32()).collect();
                    bench.picture(line, SIZE_PX, &texels)
                }
                _ => bench.picture(half, SIZE_PX, &bits(&ink.texels)),
            };
            DrawnInk { color: ink.color, fading: ink.fading, channels: ink.channels, picture }
        })
        .collect();
    for haze_srgb in [None, Some([0.7, 0.75, 0.9])] {
        let light = Light { to_sun: DVec3::Z, haze_m: 9_000.0, haze_srgb, focus: None };
        let picture = bench.out(&PICTURE);
        bench.run(|recorder| {
            let view = &recorder.uniform("view", &view().uniform(DVec3::ZERO));
            let (style, light, distance, tone) = (&style, &light, &distance, &tone);
            let (sky, inks, is_sample, picture) = (None, drawn.as_slice(), false, &picture);
            composite::run(
                recorder,
                &composite::Inputs { view, style, light, distance, tone, sky, inks, is_sample, picture },
            );
        });
        let found: Vec<f64> =
            bench.halves(&picture).into_iter().flat_map(|[red, green, blue, _]| [red, green, blue]).collect();
        let differing =
            |layers: &Layers, behind: f64, light: &Light| off(&found, &twin(layers, &style, light, behind), 2e-3);
        assert_eq!(differing(&layers, 1.01, &light), 0);
        // Planted errors: lines that keep both of their sides in the distance, and nearer haze.
        assert!(differing(&layers, 1e9, &light) > 50);
        assert!(differing(&layers, 1.01, &Light { haze_m: 8_000.0, ..light }) > 500);
        let planted = |change: &dyn Fn(&mut Vec<TestInk>)| {
            let mut inks = layers.inks.clone();
            change(&mut inks);
            let Layers { position, tone, .. } = &layers;
            differing(&Layers { position: position.clone(), tone: tone.clone(), inks }, 1.01, &light)
        };
        for number in 0..layers.inks.len() {
            // Planted errors: an ink that does not fade, an ink that is lacking, and one in the color of another.
            let has_faded = layers.inks[number].fading != Fading::AlreadyFaded;
            assert!(!has_faded || planted(&|inks| inks[number].fading = Fading::AlreadyFaded) > 300, "ink {number}");
            assert!(planted(&|inks| drop(inks.remove(number))) > 300, "ink {number}");
            assert!(planted(&|inks| inks[number].color = "#ff00ff".parse().unwrap()) > 300, "ink {number}");
        }
        // Planted errors: two inks in the other order, families that do not cross, and another channel.
        assert!(planted(&|inks| inks.swap(2, 3)) > 100);
        assert!(planted(&|inks| inks.swap(7, 8)) > 100);
        assert!(planted(&|inks| inks[3].channels = Channels::One(0)) > 300);
        assert!(planted(&|inks| inks[4].channels = Channels::One(0)) > 300);
    }
}
