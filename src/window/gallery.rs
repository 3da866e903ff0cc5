//! The gallery: all styles as thumbnails of the current view, by family. A click switches the style.
//!
//! Why: `docs/decisions/gallery.md`.

pub(super) mod thumbnails;

#[cfg(test)]
mod tests;

use egui::{Align, Align2, Color32, Layout, RichText, Stroke, Ui, vec2};

use self::thumbnails::Thumbnails;
use super::settings::Styles;
use crate::studio::favourites::{COUNT, Favourites};
use crate::style::families::Family;

/// Width of a thumbnail in points.
const WIDTH: f32 = 132.0;
/// Distance between thumbnails in points.
const GAP: f32 = 8.0;
/// Most thumbnails in a row.
const MOST_COLUMNS: f32 = 8.0;
/// The least width next to the inspector in points; a narrower gallery covers the inspector.
const LEAST_WIDTH: f32 = 3.5 * WIDTH;
/// Greatest and least ratio of a thumbnail's height to its width.
const SHAPES: [f32; 2] = [0.4, 0.9];
/// Distance from the border of the window in points.
const MARGIN: f32 = 8.0;

/// A request of the user in the gallery.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Choice {
    /// Switch to a style.
    Style(usize),
    /// Make a style the favourite of a digit, which is counted from 0, or of none.
    Favourite(usize, Option<usize>),
    /// Close the gallery.
    Close,
}

/// The gallery without its thumbnails.
#[derive(Debug, Default)]
pub(super) struct Gallery {
    pub is_open: bool,
    /// Width in points that the inspector takes at the right border.
    pub inspector_width: f32,
    /// The words that are searched for.
    search: String,
    /// The style under the mouse, in the last frame.
    hovered: Option<usize>,
}

impl Gallery {
    /// Returns the style under the mouse.
    pub(super) fn hovered(&self) -> Option<usize> {
        self.hovered.filter(|_| self.is_open)
    }

    /// Lays out the gallery and returns the user's choices. `present` is the style that is drawn.
    pub(super) fn show(
        &mut self,
        context: &egui::Context,
        styles: &Styles,
        favourites: &Favourites,
        thumbnails: &Thumbnails,
        present: usize,
    ) -> Vec<Choice> {
        let mut choices = Vec::new();
        self.hovered = None;
        let free = context.content_rect();
        // The inspector stays visible where both have room.
        let beside = free.width() - self.inspector_width;
        let width = if beside > LEAST_WIDTH { beside } else { free.width() } - 4.0 * MARGIN;
        let columns = ((width + GAP) / (WIDTH + GAP)).floor().clamp(1.0, MOST_COLUMNS);
        let size = vec2(columns * (WIDTH + GAP), free.height() - 4.0 * MARGIN);
        let mut is_open = true;
        let window = egui::Window::new("Styles")
            .id(egui::Id::unique("gallery"))
            .anchor(Align2::LEFT_TOP, [MARGIN, MARGIN])
            .order(egui::Order::Foreground)
            .title_bar(false)
            .fixed_size(size);
        let shape = shape(context);
        window.show(context, |ui| {
            ui.set_width(size.x);
            ui.horizontal(|ui| {
                ui.label(RichText::new("Styles").heading().strong());
                let hint = "Click a style to use it. Press 1 to 9 over it to make it a favourite.";
                ui.label(RichText::new(hint).weak());
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let close = ui.button("Close").on_hover_text("Close the gallery (G, Esc)");
                    // Tabs of panels have buttons of the same name.
                    context.accesskit_node_builder(close.id, |node| node.set_label("Close the gallery"));
                    is_open = !close.clicked();
                });
            });
            let field = egui::TextEdit::singleline(&mut self.search).hint_text("Search").desired_width(170.0);
            let field = ui.add(field).on_hover_text("Name, description or family of a style");
            context.accesskit_node_builder(field.id, |node| node.set_label("Search styles"));
            ui.separator();
            let groups = found(styles, self.search.trim());
            if groups.is_empty() {
                ui.label(RichText::new("No style has these words.").weak());
            }
            egui::ScrollArea::vertical().auto_shrink([false, true]).show(ui, |ui| {
                for (family, group) in groups {
                    ui.label(RichText::new(family.name()).strong());
                    for row in group.chunks(columns as usize) {
                        ui.horizontal(|ui| {
                            ui.spacing_mut().item_spacing = vec2(GAP, 2.0);
                            for &style in row {
                                let digit = favourites.digit(&styles.lasting_name(style));
                                let texture = thumbnails.get(style);
                                let cell = Cell { style, digit, texture, shape, is_present: style == present };
                                if self.cell(ui, styles, cell, &mut choices) {
                                    self.hovered = Some(style);
                                }
                            }
                        });
                    }
                    ui.add_space(6.0);
                }
            });
        });
        if !is_open {
            choices.push(Choice::Close);
        }
        choices
    }

    /// Adds a thumbnail with its name. Returns whether the mouse is over it.
    fn cell(&self, ui: &mut Ui, styles: &Styles, cell: Cell, choices: &mut Vec<Choice>) -> bool {
        let Cell { style, digit, texture, shape, is_present } = cell;
        let drawn = &styles.list()[style];
        let size = vec2(WIDTH, WIDTH * shape);
        let response = ui.push_id(style, |ui| {
            ui.vertical(|ui| {
                ui.set_width(WIDTH);
                let (rect, response) = ui.allocate_exact_size(size, egui::Sense::click());
                let visuals = ui.style().interact_selectable(&response, is_present);
                ui.painter().rect_filled(rect, 2.0, Color32::from_gray(60));
                if texture.is_none() {
                    let at = Align2::CENTER_CENTER;
                    let font = egui::TextStyle::Body.resolve(ui.style());
                    ui.painter().text(rect.center(), at, "…", font, Color32::from_gray(140));
                }
                if let Some(texture) = texture {
                    let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
                    ui.painter().image(texture, rect, whole, Color32::WHITE);
                }
                let is_marked = is_present || response.hovered() || response.has_focus();
                let width = if is_marked { 2.0 } else { 1.0 };
                let color = if is_present { Color32::WHITE } else { visuals.bg_stroke.color };
                ui.painter().rect_stroke(rect, 2.0, Stroke::new(width, color), egui::StrokeKind::Outside);
                let name = match digit {
                    Some(digit) => format!("{}  {}", digit + 1, drawn.name),
                    None => drawn.name.clone(),
                };
                ui.add(egui::Label::new(RichText::new(name)).truncate().selectable(false));
                response
            })
            .inner
        });
        let response = response.inner;
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, true, is_present, format!("Style {}", drawn.name))
        });
        if response.clicked() {
            choices.push(Choice::Style(style));
        }
        let is_hovered = response.hovered();
        response.context_menu(|ui| {
            for place in 0..COUNT {
                if ui.selectable_label(digit == Some(place), format!("Favourite {}", place + 1)).clicked() {
                    choices.push(Choice::Favourite(style, Some(place)));
                    ui.close();
                }
            }
            if ui.add_enabled(digit.is_some(), egui::Button::new("No favourite")).clicked() {
                choices.push(Choice::Favourite(style, None));
                ui.close();
            }
        });
        let hint = format!("{}\n{}", drawn.description, styles.name(style));
        response.on_hover_text(hint);
        is_hovered
    }
}

/// The content of a cell of the gallery.
#[derive(Clone, Copy)]
struct Cell {
    style: usize,
    digit: Option<usize>,
    texture: Option<egui::TextureId>,
    shape: f32,
    is_present: bool,
}

/// Returns the families with the styles that a search for `words` finds, by name, description or family.
fn found(styles: &Styles, words: &str) -> Vec<(Family, Vec<usize>)> {
    let words = words.to_lowercase();
    let is_found = |family: Family, style: &usize| {
        let drawn = &styles.list()[*style];
        let all = format!("{} {} {}", drawn.name, drawn.description, family.name()).to_lowercase();
        words.split_whitespace().all(|word| all.contains(word))
    };
    let mut groups = families(styles);
    groups.iter_mut().for_each(|(family, group)| group.retain(|style| is_found(*family, style)));
    groups.retain(|(_, group)| !group.is_empty());
    groups
}

/// Returns the ratio of the height of thumbnails to their width: that of the window.
fn shape(context: &egui::Context) -> f32 {
    let size = context.content_rect().size();
    (size.y / size.x.max(1.0)).clamp(SHAPES[0], SHAPES[1])
}

/// Returns the size of thumbnails in pixels of the window.
pub(super) fn thumbnail_px(context: &egui::Context) -> [f32; 2] {
    let scale = context.pixels_per_point();
    [WIDTH * scale, WIDTH * shape(context) * scale]
}

/// Returns the families that have styles, each with the indices of its styles.
pub(super) fn families(styles: &Styles) -> Vec<(Family, Vec<usize>)> {
    let of = |family: Family| {
        let count = styles.list().len();
        let mut group: Vec<usize> = (0..count).filter(|style| Family::of(styles.name(*style)) == family).collect();
        group.sort_by_key(|style| family.place(styles.name(*style)));
        (family, group)
    };
    Family::ALL.into_iter().map(of).filter(|(_, group)| !group.is_empty()).collect()
}
