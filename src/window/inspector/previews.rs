//! Pictures of hatching marks and stroke textures next to their names. They are drawn in the background.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use egui::{Color32, ColorImage, Id, TextureHandle, TextureOptions, Ui, Vec2};

use crate::studio::swatch::RecipeKind;

/// Size of a picture in points.
pub(super) const SIZE: Vec2 = Vec2::new(150.0, 24.0);
/// Interval at which the program checks whether pictures have been drawn.
const LOOK: Duration = Duration::from_millis(60);
/// Colours of paper and ink.
const COLORS: [[f32; 3]; 2] = [[246.0, 242.0, 232.0], [28.0, 26.0, 24.0]];

/// A recipe: its kind, its name, the folder of the style, and the revision of the style that names it, because the file of
/// a recipe may change.
type Key = (RecipeKind, String, PathBuf, u64);

#[derive(Clone)]
enum Preview {
    /// The picture is being drawn.
    Begun,
    /// The picture has been drawn, but is not on the GPU yet.
    Drawn(ColorImage),
    Shown(TextureHandle),
    /// The recipe cannot be read; the style says why.
    Missing,
}

/// The pictures that have been requested.
#[derive(Clone, Default)]
struct Previews(Arc<Mutex<HashMap<Key, Preview>>>);

/// Adds the picture of a recipe, or its room while it is being drawn. `folder` and `revision` are those of the style.
pub(super) fn show(ui: &mut Ui, kind: RecipeKind, name: &str, (folder, revision): (&Path, u64)) {
    let is_built_in = kind.names().contains(&name);
    let key = match is_built_in {
        true => (kind, name.to_owned(), PathBuf::new(), 0),
        false => (kind, name.to_owned(), folder.to_owned(), revision),
    };
    let previews = ui.data_mut(|data| data.get_temp_mut_or_default::<Previews>(Id::unique("previews")).clone());
    let preview = previews.get(ui, key);
    match preview {
        Preview::Shown(texture) => {
            let image = egui::Image::new(&texture).fit_to_exact_size(SIZE).corner_radius(2);
            let words = match kind {
                RecipeKind::Marks => format!("{name}, from light to dark"),
                RecipeKind::Stroke => format!("{name}, from heavy to light pressure"),
            };
            ui.add(image.alt_text(&words)).on_hover_text(words);
        }
        Preview::Begun | Preview::Drawn(_) => {
            ui.allocate_space(SIZE);
            ui.ctx().request_repaint_after(LOOK);
        }
        Preview::Missing => {}
    }
}

impl Previews {
    /// Returns the picture of a recipe, and begins to draw it at the first request.
    fn get(&self, ui: &Ui, key: Key) -> Preview {
        let scale = ui.ctx().pixels_per_point();
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match all.get_mut(&key) {
            Some(preview) => {
                if let Preview::Drawn(image) = preview {
                    let texture = ui.ctx().load_texture(&key.1, std::mem::take(image), TextureOptions::LINEAR);
                    *preview = Preview::Shown(texture);
                }
                preview.clone()
            }
            None => {
                // Files that have changed are drawn again; their old pictures are of no use.
                all.retain(|known, _| known.0 != key.0 || known.1 != key.1 || known.2 != key.2);
                all.insert(key.clone(), Preview::Begun);
                drop(all);
                let all = self.clone();
                rayon::spawn(move || {
                    let size_px = [SIZE.x, SIZE.y].map(|side| (side * scale).round().max(1.0) as usize);
                    let drawn = key.0.draw(&key.1, &key.2, size_px).map(|ink| image(&ink, size_px));
                    let preview = drawn.map_or(Preview::Missing, Preview::Drawn);
                    all.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key, preview);
                });
                Preview::Begun
            }
        }
    }
}

/// Returns ink on paper.
fn image(ink: &[u8], size_px: [usize; 2]) -> ColorImage {
    let color = |ink: &u8| {
        let part = f32::from(*ink) / 255.0;
        let [red, green, blue] = [0, 1, 2].map(|i| (COLORS[0][i] + (COLORS[1][i] - COLORS[0][i]) * part) as u8);
        Color32::from_rgb(red, green, blue)
    };
    ColorImage::new(size_px, ink.iter().map(color).collect())
}
