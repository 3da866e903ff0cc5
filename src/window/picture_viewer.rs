//! Look inside: any picture of the frame, and the ink of each layer, as the view or right of a divider.
//!
//! The chosen picture is read back without waiting, and turned into colours on another thread by the code of
//! `render --show`. So it may lag behind the view by a few frames, and nothing is read while no picture is chosen.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Instant;

use egui::{Color32, ColorImage, RichText, TextureHandle, TextureOptions, Ui};

use crate::gpu::Gpu;
use crate::gpu::async_readback::{AsyncReadback, ROW_BYTES};
use crate::gpu::readback::aspect;
use crate::gpu::target::{Group, Target};
use crate::picture::show;
use crate::studio::rows::{layer_definitions, title};
use crate::style::Style;
use crate::style::parameters::uncapitalised;

/// Indentation of the sentence below a name, as that of the name.
const INDENT: egui::Margin = egui::Margin { left: 8, right: 0, top: 0, bottom: 2 };

/// A picture of the frame that can be shown instead of the drawing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum FramePicture {
    /// The ink of a layer, by its index in the style that is drawn.
    Ink(usize),
    /// A picture, by its name and its number among those of its name.
    Picture(&'static str, usize),
}

/// A line of the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub selected: FramePicture,
    pub group: Group,
    pub label: String,
    /// One sentence that says what the picture shows.
    pub sentence: String,
    /// Size and format, and how to write it to a file.
    pub help: String,
}

/// A picture whose texels have not arrived yet.
struct Readback {
    selected: FramePicture,
    name: &'static str,
    format: wgpu::TextureFormat,
    size_px: [u32; 2],
    /// Rows of the texture, of which the picture may be a part.
    rows: u32,
}

/// A picture converted to colours, or why it has none.
struct Coloured {
    selected: FramePicture,
    size_px: [u32; 2],
    rgba: Result<Vec<u8>, String>,
}

/// The picture that is shown instead of the frame's.
pub(super) struct PictureViewer {
    selected: Option<FramePicture>,
    /// Where the picture begins, as a part of the window's width from its left border.
    divider: f32,
    readback: Option<(AsyncReadback, u64)>,
    pending: Option<Readback>,
    /// The last request, and the number of the window's picture that it was for.
    requested: Option<(FramePicture, u64)>,
    /// Whether colours are being computed.
    is_working: bool,
    sender: Sender<Coloured>,
    done: Receiver<Coloured>,
    texture: Option<(TextureHandle, FramePicture)>,
    error: Option<String>,
    pub(super) next_check: Instant,
}

/// Returns the pictures of a frame that can be shown, by group: the ink of each layer of `style`, and the targets of the
/// frame.
pub(super) fn entries(style: &Style, has_ink: impl Fn(usize) -> bool, pictures: &[(usize, &Target)]) -> Vec<Entry> {
    let inks = (0..style.layers.len()).rev().filter(|layer| has_ink(*layer)).map(|layer| {
        let kind = style.layers[layer].kind();
        let definition = layer_definitions().iter().find(|definition| definition.key == kind);
        Entry {
            selected: FramePicture::Ink(layer),
            group: Group::Ink,
            label: format!("Ink of {}", uncapitalised(&title(&style.layers.key(layer)))),
            sentence: definition
                .map_or_else(String::new, |definition| definition.help.trim_end_matches('.').to_owned()),
            help: "How much of each pixel the layer covers, before haze".to_owned(),
        }
    });
    let mut entries: Vec<Entry> = inks.collect();
    for (number, target) in pictures {
        let selected = FramePicture::Picture(target.name, *number);
        if target.size_px() == [1, 1] || entries.iter().any(|entry| entry.selected == selected) {
            continue;
        }
        let is_last = !pictures.iter().any(|(other, of)| of.name == target.name && other > number);
        let note = if is_last { "" } else { ", which writes the last one of this name" };
        let label = if *number > 0 { format!("{} {}", target.name, number + 1) } else { target.name.to_owned() };
        let [width, height] = target.size_px();
        let format = target.texture.format();
        entries.push(Entry {
            selected,
            group: target.content.group,
            label,
            sentence: target.content.sentence.to_owned(),
            help: format!("{width} × {height}, {format:?}; for a file: render --show \"{}\"{note}", target.name),
        });
    }
    entries.sort_by_key(|entry| entry.group);
    entries
}

impl PictureViewer {
    /// Creates the state in which the frame's own picture is shown.
    pub(super) fn new() -> Self {
        let (sender, done) = channel();
        Self {
            selected: None,
            divider: 0.0,
            readback: None,
            pending: None,
            requested: None,
            is_working: false,
            sender,
            done,
            texture: None,
            error: None,
            next_check: Instant::now(),
        }
    }

    /// Returns the picture that is shown instead of the drawing.
    pub(super) fn selected(&self) -> Option<&FramePicture> {
        self.selected.as_ref()
    }

    /// Shows the frame's own picture again.
    pub(super) fn close(&mut self) {
        self.select(None);
    }

    fn select(&mut self, selected: Option<FramePicture>) {
        self.selected = selected;
        self.requested = None;
        self.error = None;
        if self.selected.is_none() {
            self.texture = None;
        }
    }

    /// Returns whether texels are pending.
    pub(super) fn is_waiting(&self) -> bool {
        self.pending.is_some()
    }

    /// Requests the texels of `target`, the selected picture in picture number `picture` of the window, unless they are
    /// known or pending.
    pub(super) fn request(&mut self, gpu: &Gpu, target: Option<&Target>, picture: u64) {
        let Some(selected) = self.selected.clone() else { return };
        let requested = Some((selected.clone(), picture));
        if self.pending.is_some() || self.is_working || self.requested == requested {
            return;
        }
        let Some(target) = target else {
            self.error = Some("This style has no such picture.".to_owned());
            self.texture = None;
            return;
        };
        // The whole texture is read, because a depth picture cannot be read in part.
        let [width, height] = [target.texture.width(), target.texture.height()];
        let format = target.texture.format();
        let texel = format.block_copy_size(Some(aspect(&target.texture))).unwrap_or(4);
        let bytes = u64::from(width * texel).next_multiple_of(ROW_BYTES) * u64::from(height);
        if self.readback.as_ref().is_none_or(|(_, known)| *known != bytes) {
            self.readback = Some((AsyncReadback::new(bytes), bytes));
        }
        let Some((readback, _)) = &mut self.readback else { return };
        if readback.request_picture(gpu, &target.texture) {
            self.pending =
                Some(Readback { selected, name: target.name, format, size_px: target.size_px(), rows: height });
            self.requested = requested;
        }
    }

    /// Takes texels that have arrived, and begins to turn them into colours; then calls `wake`.
    pub(super) fn take_texels(&mut self, wake: impl Fn() + Send + 'static) {
        let (Some((readback, _)), true) = (&mut self.readback, self.pending.is_some()) else { return };
        let bytes = readback.take();
        if bytes.is_none() && !readback.is_waiting() {
            // The device is lost.
            self.pending = None;
        }
        let Some((bytes, question)) = bytes.zip(self.pending.take_if(|_| !readback.is_waiting())) else { return };
        let sender = self.sender.clone();
        self.is_working = true;
        rayon::spawn(move || {
            // The receiver is gone if the window was closed.
            let _ = sender.send(colours(question, &bytes));
            wake();
        });
    }

    /// Takes colours that are finished. Returns whether the view changes.
    pub(super) fn take_colours(&mut self, context: &egui::Context) -> bool {
        let Ok(Coloured { selected, size_px, rgba }) = self.done.try_recv() else { return false };
        self.is_working = false;
        if self.selected.as_ref() != Some(&selected) {
            return true;
        }
        match rgba {
            Ok(rgba) => {
                let image = ColorImage::from_rgba_unmultiplied(size_px.map(|side| side as usize), &rgba);
                match &mut self.texture {
                    Some((texture, of)) => {
                        texture.set(image, TextureOptions::NEAREST);
                        *of = selected;
                    }
                    None => {
                        self.texture = Some((context.load_texture("inside", image, TextureOptions::NEAREST), selected));
                    }
                }
                self.error = None;
            }
            Err(error) => {
                self.error = Some(error);
                self.texture = None;
            }
        }
        true
    }

    /// Paints the picture over that of the frame, right of the divider.
    pub(super) fn paint(&self, context: &egui::Context) {
        let Some((texture, _)) = self.texture.as_ref().filter(|(_, of)| self.selected.as_ref() == Some(of)) else {
            return;
        };
        let whole = context.viewport_rect();
        let left = whole.left() + self.divider.clamp(0.0, 1.0) * whole.width();
        let part = egui::Rect::from_min_max(egui::pos2(left, whole.top()), whole.max);
        let uv = egui::Rect::from_min_max(egui::pos2(self.divider.clamp(0.0, 1.0), 0.0), egui::pos2(1.0, 1.0));
        let painter = context.layer_painter(egui::LayerId::background());
        painter.image(texture.id(), part, uv, Color32::WHITE);
        if self.divider > 0.0 {
            painter.vline(left, whole.y_range(), (1.0, Color32::WHITE));
        }
    }

    /// Adds the list of pictures.
    pub(super) fn show(&mut self, ui: &mut Ui, entries: &[Entry]) {
        ui.label(RichText::new("A picture of the frame, instead of the drawing.").weak());
        let mut divider = 100.0 * self.divider;
        let slider = egui::Slider::new(&mut divider, 0.0..=95.0).suffix(" %").max_decimals(0);
        let hint = "The drawing stays on this part of the window, at the left; 0 shows the picture everywhere";
        super::panel::labelled(ui, "Drawing on the left", hint, slider);
        self.divider = divider / 100.0;
        ui.separator();
        let mut chosen = None;
        if ui.selectable_label(self.selected.is_none(), "The drawing").clicked() {
            chosen = Some(None);
        }
        if let Some(error) = &self.error {
            ui.colored_label(super::panel::WARNING, error);
        }
        egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            for group in entries.chunk_by(|a, b| a.group == b.group) {
                let heading = RichText::new(group[0].group.heading()).strong();
                egui::CollapsingHeader::new(heading).default_open(true).show_unindented(ui, |ui| {
                    for Entry { selected, label, sentence, help, .. } in group {
                        let is_shown = self.selected.as_ref() == Some(selected);
                        if ui.selectable_label(is_shown, label).on_hover_text(help).clicked() {
                            chosen = Some((!is_shown).then(|| selected.clone()));
                        }
                        let sentence = egui::Label::new(RichText::new(sentence).weak().small()).wrap();
                        egui::Frame::new().inner_margin(INDENT).show(ui, |ui| ui.add(sentence));
                    }
                });
            }
        });
        if let Some(selected) = chosen {
            self.select(selected);
        }
    }
}

/// Turns the rows of a picture, which are padded, into colours.
fn colours(question: Readback, bytes: &[u8]) -> Coloured {
    let Readback { selected, name, format, size_px, rows } = question;
    let [width, height] = size_px.map(|side| side as usize);
    let padded = bytes.len() / (rows as usize).max(1);
    let texel = if format.is_depth_stencil_format() { 4 } else { format.block_copy_size(None).unwrap_or(4) as usize };
    let rows = bytes.chunks_exact(padded.max(1)).take(height);
    let texels: Vec<u8> = rows.flat_map(|row| &row[..(width * texel).min(row.len())]).copied().collect();
    let shown = show::of_bytes(name, format, size_px, &texels);
    let rgba = shown.map(|shown| shown.rgba8());
    Coloured {
        selected,
        size_px,
        rgba: rgba.ok_or_else(|| format!("Pictures in the format {format:?} cannot be shown.")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use std::collections::BTreeSet;
    use std::time::Duration;

    use super::*;
    use crate::frame::Renderer;
    use crate::tests::common::draw::{draw, north_west, still};
    use crate::tests::common::{World, grid_of, rough_height_m};

    const SIZE_PX: [u32; 2] = [120, 72];

    /// Returns what a target looks like, through the whole way: readback, colours, texture.
    fn selected(
        world: &World,
        context: &egui::Context,
        target: &Target,
        selected: FramePicture,
    ) -> Result<usize, String> {
        let mut inside = PictureViewer::new();
        inside.select(Some(selected));
        inside.request(&world.gpu, Some(target), 1);
        assert!(inside.is_waiting());
        world.gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let (sender, woken) = channel();
        inside.take_texels(move || _ = sender.send(()));
        woken.recv_timeout(Duration::from_secs(30)).unwrap();
        assert!(inside.take_colours(context) && !inside.is_waiting());
        // The same picture is not read twice.
        inside.request(&world.gpu, Some(target), 1);
        assert!(!inside.is_waiting());
        match (inside.texture, inside.error) {
            (Some((texture, _)), None) => Ok(texture.size()[0] * texture.size()[1]),
            (_, error) => Err(error.unwrap()),
        }
    }

    #[test]
    fn every_picture_of_every_layer_can_be_looked_at() {
        let grid = grid_of(100, 100, 30.0, |x, y| f64::from(rough_height_m(x, y) as f32));
        let Some(mut world) = World::new(grid, 1.0) else { return };
        let context = egui::Context::default();
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let view = still(world.pose("0,-1800,+700,0,-18,50"), SIZE_PX);
        let mut names = BTreeSet::new();
        for name in ["crosshatch", "lsa", "tone-lines"] {
            let style = Style::load(name).unwrap();
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
            let pictures = renderer.eye_targets(0);
            let list = entries(&style, |layer| renderer.ink_target(0, layer).is_some(), &pictures);
            let labels: BTreeSet<&String> = list.iter().map(|entry| &entry.label).collect();
            assert_eq!(labels.len(), list.len(), "{list:?}");
            for entry in &list {
                let target = match &entry.selected {
                    FramePicture::Ink(layer) => renderer.ink_target(0, *layer).unwrap(),
                    FramePicture::Picture(name, number) => {
                        let found = pictures.iter().find(|(known, it)| known == number && it.name == *name);
                        names.insert(*name);
                        found.unwrap().1
                    }
                };
                let size_px = target.size_px();
                match selected(&world, &context, target, entry.selected.clone()) {
                    Ok(texels) => assert_eq!(texels, (size_px[0] * size_px[1]) as usize),
                    // Formats for which render --show has no colours either.
                    Err(error) => assert!(error.contains("cannot be shown"), "{}: {error}", entry.label),
                }
            }
            assert!(list.iter().any(|entry| matches!(entry.selected, FramePicture::Ink(_))), "{name}");
            assert!(list.is_sorted_by_key(|entry| entry.group), "a group is listed twice");
            let is_sentence = |text: &str| {
                text.starts_with(char::is_uppercase) && text.split_whitespace().count() > 2 && !text.contains('\n')
            };
            let mute: Vec<&Entry> = list.iter().filter(|entry| !is_sentence(&entry.sentence)).collect();
            assert!(mute.is_empty(), "{mute:?}");
            assert!(!is_sentence("A picture") && !is_sentence(""), "planted: these say nothing");
        }
        for wanted in ["depth", "distance", "errors", "stroke ids", "edge ids", "tone", "picture"] {
            assert!(names.contains(wanted), "{wanted}: {names:?}");
        }
        // Planted: a picture of another number does not exist.
        let mut inside = PictureViewer::new();
        inside.select(Some(FramePicture::Picture("depth", 7)));
        inside.request(&world.gpu, None, 1);
        assert_eq!(inside.error.as_deref(), Some("This style has no such picture."));
    }
}
