//! The docked panels: which are shown, where, and how wide. Panels lie over the picture, which fills the whole window.
//!
//! `egui_tiles` lays them out, and moves them when a title is dragged. It divides a window by parts of its size; a panel
//! at a side of the picture keeps its width in points instead, and one above or below it its height, because its rows do
//! not become smaller in a small window.
//!
//! Why: `docs/decisions/docked-panels.md`.

#[cfg(test)]
mod tests;

use egui::{Color32, Id, Rect, Ui, WidgetText};
use egui_tiles::{Behavior, Container, LinearDir, SimplificationOptions, Tabs, Tile, TileId, Tiles, Tree, UiResponse};
use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

/// Width and height of the picture that panels leave free in points, in a window that is large enough.
const LEAST_VIEW: f32 = 120.0;
/// Least width and height of a panel in points.
const LEAST: f32 = 140.0;
/// Height of the titles of panels in points.
const TITLE_HEIGHT: f32 = 20.0;
/// Distance of the content of a panel from its border in points.
const MARGIN: i8 = 8;
/// A panel within this distance of the border of the window is at its side, in points.
const BORDER: f32 = 12.0;
/// Distance from the border of a panel within which the mouse resizes it, in points.
const GRAB: f32 = 5.0;

/// Colour of panels, through which the picture is seen.
const PANEL_FILL: Color32 = Color32::from_black_alpha(205);

/// The content of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Pane {
    /// The picture; it is always shown.
    View,
    /// Controls of the flight.
    Flight,
    /// The inspector of the style.
    Style,
    /// Pictures of the frame.
    Inside,
    /// The cost of the frame.
    Cost,
    /// The camera path.
    Path,
}

impl Pane {
    /// All panes, in their order.
    const ALL: [Self; 6] = [Self::View, Self::Flight, Self::Style, Self::Inside, Self::Cost, Self::Path];
}

impl Pane {
    /// Returns the key that shows or hides a panel.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::View => "",
            Self::Flight => "H",
            Self::Style => "I",
            Self::Inside => "K",
            Self::Cost => "C",
            Self::Path => "V",
        }
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Self::View => "Picture",
            Self::Flight => "Flight",
            Self::Style => "Style",
            Self::Inside => "Look inside",
            Self::Cost => "Cost",
            Self::Path => "Camera path",
        }
    }

    /// Returns the width at which all rows of a panel have room, in points.
    fn width(self) -> f32 {
        match self {
            Self::View => LEAST_VIEW,
            Self::Flight | Self::Inside => 264.0,
            Self::Style => 366.0,
            Self::Cost => 300.0,
            Self::Path => 430.0,
        }
    }

    /// Returns the height of a panel above or below the picture, in points.
    fn height(self) -> f32 {
        if self == Self::Path { 200.0 } else { 260.0 }
    }
}

/// The panels and their places.
pub(super) struct Dock {
    tree: Tree<Pane>,
    /// Sizes of the tiles around the picture in points, as the user has made them: widths at its sides, heights above and
    /// below.
    widths: FxHashMap<TileId, f32>,
    /// The panels of the last frame, with their titles and the borders that resize them.
    rects: Vec<(Pane, Rect)>,
}

/// The layout of the panels as the settings file has it.
#[derive(Serialize, Deserialize)]
struct Saved {
    tree: Tree<Pane>,
    widths: Vec<(TileId, f32)>,
}

/// The panels while they are laid out.
struct Content<'a> {
    show: &'a mut dyn FnMut(&mut Ui, Pane),
    /// Tabs that show only the picture.
    bare: Vec<TileId>,
    closed: Vec<TileId>,
    rects: Vec<(Pane, Rect)>,
}

impl Default for Dock {
    /// Returns the panels as they are at the first start: only that of the flight is shown.
    fn default() -> Self {
        let mut tiles = Tiles::default();
        let [view, flight, style, inside, cost, path] = Pane::ALL.map(|pane| tiles.insert_pane(pane));
        let left = tiles.insert_tab_tile(vec![flight, inside]);
        let picture = tiles.insert_tab_tile(vec![view]);
        let below = tiles.insert_tab_tile(vec![path]);
        let middle = tiles.insert_vertical_tile(vec![picture, below]);
        let right = tiles.insert_tab_tile(vec![style, cost]);
        let root = tiles.insert_horizontal_tile(vec![left, middle, right]);
        for hidden in [style, inside, cost, path] {
            tiles.set_visible(hidden, false);
        }
        Self { tree: Tree::new(Id::unique("dock"), root, tiles), widths: FxHashMap::default(), rects: Vec::new() }
    }
}

impl Dock {
    /// Returns the panels that a text of [`Dock::text`] describes; `None` if it does not describe all panels once.
    pub(super) fn of_text(text: &str) -> Option<Self> {
        let Saved { tree, widths } = serde_json::from_str(text).ok()?;
        let widths = widths.into_iter().filter(|(_, width)| width.is_finite() && *width > 0.0).collect();
        let mut dock = Self { tree, widths, rects: Vec::new() };
        dock.add_path();
        dock.is_complete().then_some(dock)
    }

    /// Returns a text that describes the panels.
    pub(super) fn text(&self) -> Option<String> {
        let known: FxHashSet<TileId> = self.tree.tiles.tile_ids().collect();
        let widths = self.widths.iter().filter(|(id, _)| known.contains(id)).map(|(id, width)| (*id, *width));
        serde_json::to_string(&Saved { tree: self.tree.clone(), widths: widths.collect() }).ok()
    }

    /// Adds the panel of the camera path below the picture, if a layout of an earlier version does not have it.
    fn add_path(&mut self) {
        if self.tile(Pane::Path).is_some() {
            return;
        }
        let Some(view) = self.tile(Pane::View) else { return };
        let tiles = &mut self.tree.tiles;
        let is_tabs = |tile: &TileId| matches!(tiles.get_container(*tile), Some(Container::Tabs(_)));
        let picture = tiles.parent_of(view).filter(is_tabs).unwrap_or(view);
        let parent = tiles.parent_of(picture);
        let path = tiles.insert_pane(Pane::Path);
        tiles.set_visible(path, false);
        let below = tiles.insert_tab_tile(vec![path]);
        let middle = tiles.insert_vertical_tile(vec![picture, below]);
        match parent.and_then(|parent| tiles.get_mut(parent)) {
            Some(Tile::Container(container)) => _ = container.replace_child(picture, middle),
            _ => self.tree.root = Some(middle),
        }
    }

    /// Returns whether the tiles form a tree in which each panel and the view occur once.
    fn is_complete(&self) -> bool {
        let mut waiting: Vec<TileId> = self.tree.root().into_iter().collect();
        let mut seen = FxHashSet::default();
        let mut panes = Vec::new();
        while let Some(id) = waiting.pop() {
            match self.tree.tiles.get(id) {
                Some(_) if !seen.insert(id) => return false,
                Some(Tile::Pane(pane)) => panes.push(*pane),
                Some(Tile::Container(container)) => waiting.extend(container.children().copied()),
                None => return false,
            }
        }
        panes.sort();
        panes == Pane::ALL && self.tile(Pane::View).is_some_and(|view| self.tree.is_visible(view))
    }

    fn tile(&self, pane: Pane) -> Option<TileId> {
        self.tree.tiles.find_pane(&pane)
    }

    /// Returns whether a panel is shown: it is not hidden, and no other panel covers it.
    pub(super) fn is_shown(&self, pane: Pane) -> bool {
        self.tile(pane).is_some_and(|tile| self.tree.active_tiles().contains(&tile))
    }

    /// Shows a panel, or hides it.
    pub(super) fn set_shown(&mut self, pane: Pane, is_shown: bool) {
        let Some(tile) = self.tile(pane) else { return };
        self.tree.set_visible(tile, is_shown);
        if is_shown {
            self.tree.make_active(|id, _| id == tile);
        }
    }

    /// Shows a panel if it is not shown, otherwise hides it.
    pub(super) fn toggle(&mut self, pane: Pane) {
        self.set_shown(pane, !self.is_shown(pane));
    }

    /// Returns the areas of the panels, and of the borders that resize them, in points.
    pub(super) fn rects(&self) -> Vec<Rect> {
        self.rects.iter().map(|(_, rect)| *rect).collect()
    }

    /// Returns whether a position in points is over a panel.
    pub(super) fn is_over_pane(&self, pane: Pane, at: egui::Pos2) -> bool {
        self.rects.iter().any(|(known, rect)| *known == pane && rect.contains(at))
    }

    /// Returns whether a position in points is over a panel, or over a border that resizes one.
    #[cfg(test)]
    fn is_over(&self, at: egui::Pos2) -> bool {
        self.rects.iter().any(|(_, rect)| rect.contains(at))
    }

    /// Returns the part of the window that no panel at its left or right side, or at its bottom, covers.
    pub(super) fn free(&self, window: Rect) -> Rect {
        let mut free = window;
        for (_, rect) in &self.rects {
            let is_side = rect.height() > 0.6 * window.height() && rect.width() < 0.7 * window.width();
            if is_side && rect.left() <= window.left() + BORDER {
                free.min.x = free.min.x.max(rect.right());
            } else if is_side && rect.right() >= window.right() - BORDER {
                free.max.x = free.max.x.min(rect.left());
            } else if !is_side && rect.bottom() >= window.bottom() - BORDER && rect.top() > window.top() + LEAST_VIEW {
                free.max.y = free.max.y.min(rect.top());
            }
        }
        if free.width() < LEAST_VIEW { window } else { free }
    }

    /// Lays out the panels; `content` adds the widgets of one.
    pub(super) fn show(&mut self, ui: &mut Ui, content: &mut dyn FnMut(&mut Ui, Pane)) {
        // A tile that moved may have gained or lost its titles.
        self.tree.simplify(&options());
        let before = self.fit(ui.available_size());
        let tabs = self.tree.tiles.iter().filter_map(|(id, tile)| match tile {
            Tile::Container(Container::Tabs(tabs)) if is_view_alone(&self.tree.tiles, tabs) => Some(*id),
            _ => None,
        });
        let bare = tabs.collect();
        let mut behavior = Content { show: content, bare, closed: Vec::new(), rects: Vec::new() };
        self.tree.ui(&mut behavior, ui);
        let Content { closed, rects, .. } = behavior;
        self.rects = rects;
        self.take_widths(&before);
        for tile in closed {
            self.tree.set_visible(tile, false);
        }
    }

    /// Returns the direction in which a container divides its area, and the tiles that are shown in it.
    fn linear(&self, tile: TileId) -> Option<(LinearDir, Vec<TileId>)> {
        match self.tree.tiles.get_container(tile)? {
            Container::Linear(linear) => {
                let shown = linear.children.iter().copied().filter(|child| self.tree.is_visible_in_layout(*child));
                Some((linear.dir, shown.collect()))
            }
            _ => None,
        }
    }

    /// Returns the panes within a tile.
    fn panes(&self, tile: TileId) -> Vec<Pane> {
        match self.tree.tiles.get(tile) {
            Some(Tile::Pane(pane)) => vec![*pane],
            Some(Tile::Container(container)) => container.children().flat_map(|child| self.panes(*child)).collect(),
            None => Vec::new(),
        }
    }

    /// Gives the tiles around the picture their widths or heights, and the picture the rest. If a window is too small for
    /// them, they are smaller for as long as it is. Returns the widths and heights.
    fn fit(&mut self, available: egui::Vec2) -> FxHashMap<TileId, f32> {
        let mut all = FxHashMap::default();
        let mut available = available;
        let mut next = self.tree.root();
        while let Some(container) = next.take()
            && let Some((dir, shown)) = self.linear(container)
        {
            let is_wide = dir == LinearDir::Horizontal;
            let along = if is_wide { &mut available.x } else { &mut available.y };
            let room = *along - shown.len().saturating_sub(1) as f32;
            let mut sizes = FxHashMap::default();
            for tile in shown {
                let panes = self.panes(tile);
                if panes.contains(&Pane::View) {
                    next = Some(tile);
                    continue;
                }
                let size = |pane: &Pane| if is_wide { pane.width() } else { pane.height() };
                let wanted = panes.iter().map(size).fold(LEAST, f32::max);
                sizes.insert(tile, self.widths.get(&tile).copied().unwrap_or(wanted));
            }
            let sum: f32 = sizes.values().sum();
            let part = ((room - LEAST_VIEW) / sum.max(1.0)).clamp(0.1, 1.0);
            sizes.values_mut().for_each(|size| *size *= part);
            let rest = (room - part * sum).max(1.0);
            *along = rest;
            sizes.extend(next.map(|view| (view, rest)));
            if let Some(Tile::Container(Container::Linear(linear))) = self.tree.tiles.get_mut(container) {
                sizes.iter().for_each(|(tile, size)| linear.shares.set_share(*tile, *size));
            }
            all.extend(sizes);
        }
        all
    }

    /// Takes the widths and heights that the user has changed since [`Dock::fit`].
    fn take_widths(&mut self, before: &FxHashMap<TileId, f32>) {
        let linears = self.tree.tiles.tiles().filter_map(|tile| match tile {
            Tile::Container(Container::Linear(linear)) => Some(linear),
            _ => None,
        });
        let shares: Vec<(TileId, f32)> =
            linears.flat_map(|linear| linear.shares.iter().map(|(tile, share)| (*tile, *share))).collect();
        for (tile, share) in shares {
            let is_changed = before.get(&tile).is_some_and(|size| (size - share).abs() > 0.5);
            if is_changed && !self.panes(tile).contains(&Pane::View) {
                self.widths.insert(tile, share.max(LEAST));
            }
        }
    }
}

fn options() -> SimplificationOptions {
    SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
}

fn is_view_alone(tiles: &Tiles<Pane>, tabs: &Tabs) -> bool {
    let shown: Vec<TileId> = tabs.children.iter().copied().filter(|tile| tiles.is_visible(*tile)).collect();
    matches!(shown.as_slice(), [only] if tiles.get_pane(only) == Some(&Pane::View))
}

impl Behavior<Pane> for Content<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _: TileId, pane: &mut Pane) -> UiResponse {
        if *pane == Pane::View {
            return UiResponse::None;
        }
        let rect = ui.max_rect();
        let with_title = Rect::from_min_max(rect.min - egui::vec2(0.0, TITLE_HEIGHT), rect.max);
        self.rects.push((*pane, with_title.expand(GRAB)));
        ui.painter().rect_filled(rect, 0.0, PANEL_FILL);
        egui::Frame::new().inner_margin(MARGIN).show(ui, |ui| {
            ui.set_clip_rect(ui.clip_rect().intersect(rect));
            let needed = pane.width() - 2.0 * f32::from(MARGIN);
            if ui.available_width() >= needed - 1.0 {
                (self.show)(ui, *pane);
                return;
            }
            // Rows that are cut cannot be read.
            egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
                ui.set_width(needed);
                (self.show)(ui, *pane);
            });
        });
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.title().into()
    }

    fn is_tab_closable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        tiles.get_pane(&tile).is_some_and(|pane| *pane != Pane::View)
    }

    fn on_tab_close(&mut self, _: &mut Tiles<Pane>, tile: TileId) -> bool {
        // The panel is hidden, and keeps its place.
        self.closed.push(tile);
        false
    }

    fn is_tab_bar_visible(&self, tile: TileId, _: &Tabs) -> bool {
        // Panels have a title; the picture alone has none.
        !self.bare.contains(&tile)
    }

    fn tab_bar_height(&self, _: &egui::Style) -> f32 {
        TITLE_HEIGHT
    }

    fn tab_bar_color(&self, _: &egui::Visuals) -> Color32 {
        PANEL_FILL
    }

    fn min_size(&self) -> f32 {
        LEAST
    }

    fn simplification_options(&self) -> SimplificationOptions {
        options()
    }

    fn is_tile_draggable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        match tiles.get(tile) {
            Some(Tile::Pane(pane)) => *pane != Pane::View,
            Some(Tile::Container(Container::Tabs(tabs))) => !is_view_alone(tiles, tabs),
            _ => true,
        }
    }
}
