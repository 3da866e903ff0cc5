//! Values that a style has on maps only: the list `on_maps` of a style file.
//!
//! What reads well from a camera need not do so from straight above: rows of hachures that are large enough for a near
//! slope are a fur at the scale of a map. A style lists the values that differ on maps, each as the option `--set` has it:
//! `on_maps = ["rows.spacing_px=3", "light.shadow=0"]`. Values of a layer or section that the style does not have do
//! nothing, so that a layer can be removed without them.
//!
//! Why: `docs/decisions/maps.md`.

use super::layers::{Layer, is_kind};
use super::parameters::{self, Definition, Parameter, Range, Setting, ValueKind, parameters_of};
use super::set::{SetValue, value_of};
use super::{Style, StyleError};
use crate::file::toml_text::{TomlError, Wrong};

impl Setting for SetValue {
    fn kind() -> ValueKind {
        ValueKind::Text
    }

    fn scale_lengths(&mut self, factor: f32, _: Option<&str>, _: &Range) {
        let Some(definition) = definition(&self.key).filter(|known| known.unit == Some("px")) else { return };
        if let Ok(mut length_px) = self.text.parse::<f32>() {
            length_px.scale_lengths(factor, Some("px"), &definition.range);
            self.text = parameters::shortest(length_px).to_string();
        }
    }

    fn item(&self) -> Option<toml_edit::Item> {
        Some(toml_edit::value(self.to_string()))
    }
}

/// Returns the definition of a parameter of a style. Indices of list entries in the key do not matter.
fn definition(key: &str) -> Option<Definition> {
    let key = parameters::without_indices(key);
    let all = parameters_of(&Style::kind(), None);
    let is_meant = |known: &Parameter| parameters::without_indices(&known.key) == key;
    all.into_iter().find(is_meant).map(|known| known.definition)
}

impl Style {
    /// Returns the style with the values that it has on maps; its recipes and images are those that it has loaded.
    ///
    /// # Errors
    /// A value that the style cannot have. Files with such values are refused when they are read.
    pub(super) fn with_values_of_maps(self) -> Result<Self, StyleError> {
        if self.on_maps.is_empty() {
            return Ok(self);
        }
        let mut style = self.with_set(&self.on_maps)?;
        style.take_loaded(self);
        Ok(style)
    }

    /// Returns the style with those values whose layer or section it has. Its recipes and images are not loaded.
    fn with_set(&self, values: &[SetValue]) -> Result<Self, TomlError> {
        let values = values.iter().filter(|set| self.has_section_of(&set.key)).map(|set| {
            let kind = definition(&set.key).map(|known| known.kind);
            (set.key.clone(), value_of(kind.as_ref(), &set.text))
        });
        let text = parameters::set_all::<Self>(&self.name, &self.text(), values.collect())?;
        parameters::read(&self.name, &text)
    }

    /// Returns whether the style has the layer or section of a key, or no style could have it.
    fn has_section_of(&self, key: &str) -> bool {
        let section = key.split('.').next().unwrap_or(key);
        let is_of_layer = is_kind(section.split('[').next().unwrap_or(section));
        let has_layer = (0..self.layers.len()).any(|index| self.layers.key(index) == section);
        let has_section = self.item().is_some_and(|item| item.get(section).is_some());
        if is_of_layer { has_layer } else { has_section || definition(key).is_none() }
    }

    /// Checks each value of `on_maps`. The style's other values must be valid.
    ///
    /// # Errors
    /// The key of the entry, and what is wrong with it.
    pub(super) fn check_values_of_maps(&self) -> Result<(), Wrong> {
        for (number, set) in self.on_maps.iter().enumerate() {
            let wrong = |words: String| Wrong::new(format!("on_maps[{number}]"), format!(": {words}"));
            let kind = definition(&set.key).map(|known| known.kind);
            if matches!(kind, Some(ValueKind::Text | ValueKind::List(_))) {
                return Err(wrong(format!(
                    "{} is the same on maps; only numbers, colours and choices differ",
                    set.key
                )));
            }
            self.with_set(std::slice::from_ref(set)).map_err(|error| wrong(error.cause))?;
        }
        // Values may be valid one by one and not together.
        self.with_set(&self.on_maps).map(drop).map_err(|error| Wrong::new("on_maps", format!(": {}", error.cause)))
    }

    /// Takes what another version of the style has loaded; it has the same layers and names the same files.
    fn take_loaded(&mut self, from: Self) {
        for (layer, from) in self.layers.iter_mut().zip(from.layers.iter()) {
            match (layer, from) {
                (Layer::Hatching(hatching), Layer::Hatching(from)) => hatching.take_recipes(from),
                (Layer::Strokes(strokes), Layer::Strokes(from)) => strokes.texture.clone_from(&from.texture),
                (Layer::Cuts(cuts), _) => cuts.sort(),
                _ => {}
            }
        }
        self.curvature.texture = from.curvature.texture;
        if let (Some(relief), Some(from)) = (&mut self.relief, from.relief) {
            (relief.environment, relief.sky) = (from.environment, from.sky);
        }
        self.files = from.files;
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::style::preset_text;

    fn parsed(on_maps: &str) -> Result<Style, String> {
        let own = preset_text("crosshatch").unwrap().lines().find(|line| line.starts_with("on_maps")).unwrap();
        let text = preset_text("crosshatch").unwrap().replacen(own, &format!("on_maps = {on_maps}"), 1);
        Style::parse("x.toml", &text).map_err(|error| error.to_string())
    }

    #[test]
    fn values_of_maps_are_those_of_maps_alone() {
        let style = parsed(
            "[\"light.shadow=0.25\", \"hatching.sets[0].size=2\", \"height_lines.line_px=2\", \"paper.color=#ffee00\"]",
        )
        .unwrap();
        let map = style.clone().for_map(10.0).unwrap();
        assert_eq!((map.light.shadow, map.hatching().unwrap().sets[0].size), (0.25, 2.0));
        assert!(map.lowest_height_lines().is_none(), "the style has no such layer");
        assert_eq!(map.paper.color.to_string(), "#ffee00");
        // Everything else is that of the style.
        assert!(style.light.shadow != 0.25);
        let recipes =
            |style: &Style| style.hatching().unwrap().sets.iter().map(|set| set.recipe.clone()).collect::<Vec<_>>();
        assert!(recipes(&style).iter().all(Option::is_some));
        assert_eq!(recipes(&map), recipes(&style));
        assert_eq!(map.strokes().unwrap().texture, style.strokes().unwrap().texture);
        // The text of the style says the same.
        assert_eq!(Style::parse("y.toml", &style.text()).unwrap(), style);
    }

    #[test]
    fn lengths_of_maps_are_scaled_for_paper() {
        let style = parsed("[\"light.form_px=8\", \"light.shadow=0.5\", \"strokes.width_px=3\"]").unwrap();
        let map = style.scaled(2.0).for_map(10.0).unwrap();
        let strokes = map.strokes().unwrap();
        assert_eq!((map.light.form_px, map.light.shadow, strokes.width_px), (16.0, 0.5, 6.0));
    }

    #[test]
    fn a_wrong_value_of_maps_is_refused_where_it_is() {
        for (on_maps, words) in [
            ("[\"light.shadow=0\", \"light.shadwo=0\"]", "on_maps: there is no parameter light.shadwo; did you mean"),
            ("[\"light.shadow=2\"]", "on_maps: light.shadow is 2, not between 0 and 1"),
            ("[\"light.shadow\"]", "it must be KEY=VALUE"),
            ("[\"strokes.texture=brush\"]", "on_maps: strokes.texture is the same on maps"),
            ("[\"strokes=1\"]", "on_maps: there is no parameter strokes"),
            ("\"light.shadow=0\"", "on_maps"),
        ] {
            let error = parsed(on_maps).unwrap_err();
            assert!(error.starts_with("x.toml:3:") && error.contains(words), "{error}");
        }
        assert!(parsed("[]").unwrap().on_maps.is_empty());
    }
}
