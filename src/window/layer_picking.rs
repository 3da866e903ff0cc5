//! Finds the layer that drew a pixel: the inks of the layers around the pixel of the last picture are read back from the
//! GPU without waiting.
//!
//! Why: `docs/decisions/layer-under-the-cursor.md`.

use std::collections::VecDeque;

use glam::DVec2;

use crate::gpu::Gpu;
use crate::gpu::async_readback::{AsyncReadback, ROW_BYTES};
use crate::gpu::target::Target;
use crate::picture::show::planes;
use crate::style::layers::{Channels, Fading, MAX_INKS, StyleInk};

/// Lines are found this far from the cursor, in pixels of the picture.
const RADIUS_PX: u32 = 3;
/// Side of the square of pixels that is read.
const SIDE: u32 = 2 * RADIUS_PX + 1;
/// Pictures that are read besides the inks: distance and water.
const OTHERS: usize = 2;
/// Visible parts of an ink, 0 to 1, that count as drawn. The smaller one counts if nothing in the square has the greater.
const DRAWN: [f32; 2] = [0.25, 0.04];

/// The part of a style that drew a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DrawnPart {
    /// A layer, by its index in the style that was drawn.
    Layer(usize),
    /// The tones of the surface.
    Tone,
    /// The sky behind the land.
    Sky,
}

/// An ink of a style, with the picture that its layer drew.
#[derive(Clone, Debug)]
pub(super) struct InkPicture<'a> {
    pub ink: StyleInk,
    /// The picture of its layer; `None` if the layer drew nothing.
    pub picture: Option<&'a Target>,
}

/// A request for the layer that drew a pixel.
pub(super) struct PickRequest<'a> {
    /// The inks of the style, from the bottom to the top.
    pub inks: Vec<InkPicture<'a>>,
    /// Distances along the view axis.
    pub distance: &'a Target,
    /// Metres to the shore, in a style with water.
    pub water: Option<&'a Target>,
    /// The layer of water, by its index in the style.
    pub water_layer: Option<usize>,
    /// Distance at which haze has taken 63 % of the contrast, in metres.
    pub haze_m: f64,
    /// Position in the picture, 0 to 1 in each direction.
    pub part: DVec2,
}

/// How the texels of a picture are read.
#[derive(Clone, Copy, Debug)]
struct Patch {
    format: wgpu::TextureFormat,
    texel_bytes: usize,
}

/// A request whose texels have not arrived yet.
struct PendingPick {
    /// The inks that were drawn, with the indices of their pictures.
    inks: Vec<(StyleInk, usize)>,
    patches: Vec<Patch>,
    distance: usize,
    water: Option<(usize, usize)>,
    haze_m: f64,
    /// Size of the rectangle that is read, and the requested pixel in it.
    size_px: [usize; 2],
    picked_px: [usize; 2],
}

/// Requests layers and returns them when the GPU has answered.
pub(super) struct LayerPicker {
    readback: AsyncReadback,
    pending: VecDeque<PendingPick>,
}

/// The part of the style that drew the requested pixel or one near it, and the offset of that pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PickedPart {
    pub part: DrawnPart,
    pub offset_px: [i32; 2],
}

impl LayerPicker {
    /// Creates a picker without requests.
    pub(super) fn new() -> Self {
        let pictures = (MAX_INKS + OTHERS) as u64;
        Self { readback: AsyncReadback::new(pictures * u64::from(SIDE) * ROW_BYTES), pending: VecDeque::new() }
    }

    /// Requests the layer that drew a pixel of the last picture. Returns `false` if too many requests are pending.
    pub(super) fn request(&mut self, gpu: &Gpu, request: PickRequest<'_>) -> bool {
        let PickRequest { inks, distance, water, water_layer, haze_m, part } = request;
        let whole_px = distance.size_px();
        let is_whole = |target: &&Target| target.size_px() == whole_px;
        let mut pictures: Vec<&Target> = vec![distance];
        let water = water.filter(is_whole).zip(water_layer).map(|(target, layer)| {
            pictures.push(target);
            (pictures.len() - 1, layer)
        });
        let mut drawn = Vec::new();
        for InkPicture { ink, picture } in inks {
            let Some(picture) = picture.filter(is_whole) else { continue };
            // Inks of the same layer share a picture.
            let known = pictures.iter().position(|known| known.texture == picture.texture);
            let index = known.unwrap_or_else(|| {
                pictures.push(picture);
                pictures.len() - 1
            });
            drawn.push((ink, index));
        }
        let at_px = [0, 1].map(|axis| ((part[axis] * f64::from(whole_px[axis])) as u32).min(whole_px[axis] - 1));
        let first_px = at_px.map(|at| at.saturating_sub(RADIUS_PX));
        let size_px = [0, 1].map(|axis| (at_px[axis] + RADIUS_PX + 1).min(whole_px[axis]) - first_px[axis]);
        let patch = |picture: &&Target| {
            let format = picture.texture.format();
            Patch { format, texel_bytes: format.block_copy_size(None).unwrap_or(4) as usize }
        };
        let patches = pictures.iter().map(patch).collect();
        let is_sent = self.readback.request_patches(gpu, &pictures, first_px, size_px);
        if is_sent {
            self.pending.push_back(PendingPick {
                inks: drawn,
                patches,
                distance: 0,
                water,
                haze_m,
                size_px: size_px.map(|side| side as usize),
                picked_px: [0, 1].map(|axis| (at_px[axis] - first_px[axis]) as usize),
            });
        }
        is_sent
    }

    /// Returns whether requests are pending.
    pub(super) fn is_waiting(&self) -> bool {
        self.readback.is_waiting()
    }

    /// Drops all requests.
    pub(super) fn forget(&mut self) {
        self.readback.forget();
        self.pending.clear();
    }

    /// Takes the oldest answer that has arrived.
    pub(super) fn take(&mut self) -> Option<PickedPart> {
        let bytes = self.readback.take();
        if bytes.is_none() && !self.readback.is_waiting() {
            // The device dropped the rest.
            self.pending.clear();
        }
        let bytes = bytes?;
        Some(self.pending.pop_front()?.answer(&bytes))
    }
}

impl PendingPick {
    /// Returns the channels of a picture: for each, its texels row by row.
    fn planes(&self, bytes: &[u8], picture: usize) -> Vec<Vec<f32>> {
        let [width, height] = self.size_px;
        let Patch { format, texel_bytes } = self.patches[picture];
        let rows = bytes.chunks_exact(ROW_BYTES as usize).skip(picture * height).take(height);
        let texels: Vec<u8> = rows.flat_map(|row| &row[..width * texel_bytes]).copied().collect();
        planes(format, &texels).unwrap_or_default()
    }

    /// Returns the answer from the texels of all pictures.
    fn answer(&self, bytes: &[u8]) -> PickedPart {
        let [width, height] = self.size_px;
        let count = width * height;
        let distance_m = self.planes(bytes, self.distance).pop().unwrap_or_else(|| vec![0.0; count]);
        let amounts: Vec<Vec<f32>> = self
            .inks
            .iter()
            .map(|(ink, picture)| {
                let planes = self.planes(bytes, *picture);
                (0..count).map(|pixel| self.amount(ink, &planes, &distance_m, pixel)).collect()
            })
            .collect();
        let offset_px = |pixel: usize| {
            let at = [pixel % width, pixel / width];
            [0, 1].map(|axis| at[axis] as i32 - self.picked_px[axis] as i32)
        };
        let mut pixels: Vec<usize> = (0..count).collect();
        pixels.sort_by_key(|pixel| offset_px(*pixel).map(|off| off * off).iter().sum::<i32>());
        for least in DRAWN {
            for &pixel in &pixels {
                // Fraction of the lower inks that shows through the inks examined so far.
                let mut visible = 1.0;
                for ((ink, _), amounts) in self.inks.iter().zip(&amounts).rev() {
                    if visible * amounts[pixel] >= least {
                        let part = ink.layer.map_or(DrawnPart::Sky, DrawnPart::Layer);
                        return PickedPart { part, offset_px: offset_px(pixel) };
                    }
                    visible *= 1.0 - amounts[pixel];
                }
            }
        }
        let pixel = self.picked_px[1] * width + self.picked_px[0];
        let in_water = self.water.filter(|(picture, _)| {
            self.planes(bytes, *picture).first().is_some_and(|shore_m| shore_m.get(pixel).is_some_and(|it| *it > 0.0))
        });
        let part = match in_water {
            Some((_, layer)) => DrawnPart::Layer(layer),
            None if distance_m.get(pixel).is_some_and(|it| *it > 0.0) => DrawnPart::Tone,
            None => DrawnPart::Sky,
        };
        PickedPart { part, offset_px: [0, 0] }
    }

    /// Returns how much of a pixel an ink covers, 0 to 1, after haze.
    fn amount(&self, StyleInk { ink, .. }: &StyleInk, planes: &[Vec<f32>], distance_m: &[f32], pixel: usize) -> f32 {
        let channel = |index: usize| planes.get(index).and_then(|plane| plane.get(pixel)).copied().unwrap_or_default();
        let drawn = match ink.channels {
            Channels::One(index) => channel(index),
            Channels::Crossed(count) => 1.0 - (0..count).map(|index| 1.0 - channel(index)).product::<f32>(),
        };
        let (faintest, reach, on_m) = match ink.fading {
            Fading::AlreadyFaded => return drawn.clamp(0.0, 1.0),
            Fading::OnSurface { faintest, reach, .. } => (faintest, reach, distance_m[pixel]),
            Fading::OnNearest { faintest, reach } => (faintest, reach, self.nearest_m(distance_m, pixel)),
        };
        let t = if on_m > 0.0 { f64::from(on_m) / (self.haze_m * f64::from(reach)) } else { 0.0 };
        let clear = (-t * t).exp() as f32;
        (drawn * (faintest + (1.0 - faintest) * clear)).clamp(0.0, 1.0)
    }

    /// Returns the least distance among a pixel and its neighbours; 0 in the sky.
    fn nearest_m(&self, distance_m: &[f32], pixel: usize) -> f32 {
        let [width, height] = self.size_px;
        let (x, y) = (pixel % width, pixel / width);
        let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let places = around(y, height).flat_map(|y| around(x, width).map(move |x| y * width + x));
        let nearest_m = places.map(|at| distance_m[at]).filter(|it| *it > 0.0).fold(f32::INFINITY, f32::min);
        if nearest_m.is_finite() { nearest_m } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::composite::PICTURE;
    use crate::frame::{DISTANCE, Renderer};
    use crate::scene::view::View;
    use crate::style::Style;
    use crate::style::layers::Layer;
    use crate::surface::water::WATER;
    use crate::tests::common::draw::{draw, halves, north_west, still};
    use crate::tests::common::{World, full, grid_of, rough_height_m};

    const SIZE_PX: [u32; 2] = [160, 96];

    /// Returns the picture of a style, as lightness of each pixel.
    fn lightness(world: &mut World, renderer: &mut Renderer, view: &View, style: &Style) -> Vec<f64> {
        for _ in 0..3 {
            renderer.forget();
            draw(&world.gpu, &mut world.surfaces, renderer, view, style, &north_west());
        }
        let texels = halves(&world.gpu, renderer.target(&PICTURE).unwrap());
        texels.into_iter().map(|[red, green, blue, _]| red + green + blue).collect()
    }

    fn answer(world: &World, renderer: &Renderer, style: &Style, pixel: [u32; 2]) -> PickedPart {
        let mut picker = LayerPicker::new();
        let inks = style.inks().into_iter().map(|ink| {
            let picture = ink.layer.and_then(|layer| renderer.ink_target(0, layer));
            InkPicture { ink, picture }
        });
        let request = PickRequest {
            inks: inks.collect(),
            distance: renderer.target(&DISTANCE).unwrap(),
            water: renderer.target(&WATER),
            water_layer: style.layers.iter().position(|layer| matches!(layer, Layer::Water(_))),
            haze_m: north_west().haze_m,
            part: DVec2::new(0.5 + f64::from(pixel[0]), 0.5 + f64::from(pixel[1])) / DVec2::new(160.0, 96.0),
        };
        assert!(picker.request(&world.gpu, request));
        world.gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let answer = picker.take().unwrap();
        assert!(!picker.is_waiting());
        answer
    }

    #[test]
    fn without_the_layer_the_pixel_would_differ() {
        let grid = grid_of(160, 160, 30.0, |x, y| f64::from(rough_height_m(x, y) as f32));
        let Some(mut world) = World::new(grid, 1.0) else { return };
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let pose = world.pose("0,-1800,+700,0,-18,50");
        let view = still(pose, SIZE_PX);
        let mut kinds = std::collections::BTreeMap::<&str, [u32; 2]>::new();
        let mut planted = [0, 0];
        let (names, least, least_kinds) = match full() {
            true => (&["crosshatch", "ink", "hachures", "tone-lines", "panorama"][..], 100, 5),
            false => (&["crosshatch", "tone-lines", "lsa"][..], 60, 4),
        };
        for name in names {
            let style = Style::load(name).unwrap();
            let picture = lightness(&mut world, &mut renderer, &view, &style);
            let asked: Vec<[u32; 2]> =
                (0..160).step_by(7).flat_map(|x| (0..96).step_by(7).map(move |y| [x, y])).collect();
            let answers: Vec<PickedPart> =
                asked.iter().map(|pixel| answer(&world, &renderer, &style, *pixel)).collect();
            let without: Vec<Vec<f64>> = (0..style.layers.len())
                .map(|layer| {
                    let key = style.layers.key(layer);
                    let less = style.clone().without_layers(|known| known == key);
                    lightness(&mut world, &mut renderer, &view, &less)
                })
                .collect();
            for (pixel, PickedPart { part, offset_px }) in asked.iter().zip(answers) {
                let DrawnPart::Layer(layer) = part else { continue };
                let at = [0, 1].map(|axis| (pixel[axis] as i32 + offset_px[axis]) as usize);
                let at = at[1] * 160 + at[0];
                let changes = |layer: usize| (without[layer][at] - picture[at]).abs() > 0.02;
                let counts = kinds.entry(style.layers[layer].kind()).or_default();
                counts[usize::from(changes(layer))] += 1;
                // Planted error: the layer above.
                planted[usize::from(changes((layer + 1) % style.layers.len()))] += 1;
            }
        }
        let [wrong, right] = kinds.values().fold([0, 0], |sum, it| [sum[0] + it[0], sum[1] + it[1]]);
        assert!(right > least && wrong * 50 <= right, "{wrong} of {} are not of the layer: {kinds:?}", wrong + right);
        assert!(planted[0] > planted[1], "{planted:?}");
        assert!(kinds.len() >= least_kinds, "{kinds:?}");
    }
}
