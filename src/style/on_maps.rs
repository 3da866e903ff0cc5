//! Values that a style has on maps only: the list `on_maps` of a style file.
//!
//! What reads well from a camera may not read well from straight above: rows of hachures that are large enough for a near
//! slope merge into a fur-like texture at the scale of a map. A style lists the values that differ on maps, each as the
//! option `--set` has it: `on_maps = ["rows.spacing_px=3", "light.shadow=0"]`. Entries for a layer or section that the
//! style lacks are ignored, so that a layer can be removed without them. Indices of lists count as in [`Style::text`],
//! whose sets of hatching marks are sorted.
//!
//! Why: `docs/decisions/maps.md`.

use toml_edit::Value;

use super::layers::{Layer, is_kind};
use super::parameters::{self, Definition, Parameter, Setting, ValueKind, parameters_of};
use super::set::{SetValue, value_of};
use super::{Style, StyleError};
use crate::file::message::shown;
use crate::file::toml_text::{TomlError, Wrong};

impl Setting for SetValue {
    fn kind() -> ValueKind {
        ValueKind::Text
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

/// Checks an entry whether or not a style has its layer or section.
///
/// # Errors
/// Returns the message about an unknown key, a value of another kind or a value out of range.
fn check_alone(set: &SetValue) -> Result<(), String> {
    let Some(Definition { kind, range, .. }) = definition(&set.key) else {
        // The whole style names similar keys.
        let unknown = Style::load("plain").and_then(|plain| Ok(plain.with_known(std::slice::from_ref(set))?));
        return unknown.map(drop).map_err(|error| match error {
            StyleError::Parse(error) => error.cause,
            other => other.to_string(),
        });
    };
    let number = |text: &str| match value_of(Some(&kind), text) {
        Value::Float(number) => Some(*number.value() as f32),
        Value::Integer(number) => Some(*number.value() as f32),
        _ => None,
    };
    let checked = match &kind {
        _ if set.key == "tone.kind" => {
            return Err("tone.kind is the same on maps: other kinds have other keys".to_owned());
        }
        ValueKind::Number | ValueKind::Whole => match (number(&set.text), &kind) {
            (None, _) => return Err(format!("{} must be a number, but it is {}", set.key, shown(&set.text))),
            (Some(number), ValueKind::Whole) => (number.max(0.0) as u32).check(&set.key, &range),
            (Some(number), _) => number.check(&set.key, &range),
        },
        ValueKind::Text | ValueKind::List(_) | ValueKind::Section(_) | ValueKind::Layers(_) => {
            return Err(format!(
                "{} is the same on maps; only numbers, switches, colours and choices can differ",
                set.key
            ));
        }
        _ => Ok(()),
    };
    checked.map_err(|wrong| wrong.message)
}

impl Style {
    /// Returns the style with the values that it has on maps, and without a list of them; its recipes and images are those
    /// that it has loaded. Lengths are those of the file, so a style is scaled afterwards.
    ///
    /// # Errors
    /// A value that the style cannot have. Files with such values are refused when they are read.
    pub(crate) fn on_map(self) -> Result<Self, StyleError> {
        if self.on_maps.is_empty() {
            return Ok(self);
        }
        let mut style = self.with_set(&self.on_maps)?;
        style.take_loaded(self);
        style.on_maps.clear();
        Ok(style)
    }

    /// Returns the style with those values whose layer or section it has. Its recipes and images are not loaded.
    fn with_set(&self, values: &[SetValue]) -> Result<Self, TomlError> {
        let held: Vec<SetValue> = values.iter().filter(|set| self.has_section_of(&set.key)).cloned().collect();
        self.with_known(&held)
    }

    /// Does the same with all values, which may add a layer.
    fn with_known(&self, values: &[SetValue]) -> Result<Self, TomlError> {
        let values = values.iter().map(|set| {
            let kind = definition(&set.key).map(|known| known.kind);
            (set.key.clone(), value_of(kind.as_ref(), &set.text))
        });
        let text = parameters::set_all::<Self>(&self.name, &self.text(), values.collect())?;
        parameters::read(&self.name, &text)
    }

    /// Returns whether the style has the layer or section of a key.
    fn has_section_of(&self, key: &str) -> bool {
        let section = key.split('.').next().unwrap_or(key);
        let is_of_layer = is_kind(section.split('[').next().unwrap_or(section));
        let has_layer = || (0..self.layers.len()).any(|index| self.layers.key(index) == section);
        if is_of_layer { has_layer() } else { self.item().is_some_and(|item| item.get(section).is_some()) }
    }

    /// Checks the values of `on_maps`. The style's other values must be valid, and its lists sorted.
    ///
    /// # Errors
    /// The key of the entry, and what is wrong with it.
    pub(super) fn check_values_of_maps(&self) -> Result<(), Wrong> {
        let wrong_at = |number: usize, words: &str| Wrong::new(format!("on_maps[{number}]"), format!(": {words}"));
        for (number, set) in self.on_maps.iter().enumerate() {
            check_alone(set).map_err(|words| wrong_at(number, &words))?;
        }
        // Values may be valid together and not one by one, but if they are wrong together, one alone may say why.
        let Err(together) = self.with_set(&self.on_maps) else { return Ok(()) };
        let alone = |set: &SetValue| self.with_set(std::slice::from_ref(set)).err();
        let found = self.on_maps.iter().enumerate().find_map(|(number, set)| Some((number, alone(set)?)));
        Err(found.map_or_else(
            || Wrong::new("on_maps", format!(": {}", together.cause)),
            |(number, error)| wrong_at(number, &error.cause),
        ))
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
    fn values_of_maps_are_scaled_for_paper_as_others_are() {
        let style = parsed("[\"light.form_px=8\", \"light.shadow=0.5\", \"hatching.sets[0].size=2\"]").unwrap();
        let map = style.clone().on_map().unwrap().scaled(2.0).for_map(10.0).unwrap();
        assert_eq!((map.light.form_px, map.light.shadow, map.hatching().unwrap().sets[0].size), (16.0, 0.5, 4.0));
        // Planted: scaled first, the values of maps are those of the file.
        assert_eq!(style.scaled(2.0).for_map(10.0).unwrap().light.form_px, 8.0);
    }

    #[test]
    fn indices_are_those_of_the_sorted_list() {
        let sets = "name = \"x\"\ndescription = \"\"\non_maps = [\"hatching.sets[0].size=2\"]\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\nlightest = 1\n\
                    [[layers]]\nkind = \"hatching\"\n[[layers.sets]]\nmarks = \"line\"\nfrom = 0.6\n\
                    [[layers.sets]]\nmarks = \"dash\"\n";
        let map = Style::parse("x.toml", sets).unwrap().for_map(10.0).unwrap();
        let sizes: Vec<_> = map.hatching().unwrap().sets.iter().map(|set| (set.marks.clone(), set.size)).collect();
        assert_eq!(sizes, [("dash".to_owned(), 2.0), ("line".to_owned(), 1.0)]);
        assert!(map.hatching().unwrap().sets.iter().all(|set| set.recipe.is_some()));
    }

    #[test]
    fn a_wrong_value_of_maps_is_refused_where_it_is() {
        for (on_maps, words) in [
            ("[\"light.shadow=0\", \"light.shadwo=0\"]", "on_maps: there is no parameter light.shadwo; did you mean"),
            ("[\"light.shadow=2\"]", "on_maps: light.shadow is 2, not between 0 and 1"),
            ("[\"light.shadow\"]", "it must be KEY=VALUE"),
            ("[\"strokes.texture=brush\"]", "on_maps: strokes.texture is the same on maps"),
            ("[\"strokes=1\"]", "on_maps: strokes is the same on maps"),
            ("[\"on_maps=[]\"]", "on_maps: on_maps is the same on maps"),
            ("[\"tone.kind=plain\"]", "on_maps: tone.kind is the same on maps"),
            // The style has no rows.
            ("[\"rows.spacing_px=-5\"]", "on_maps: rows.spacing_px is -5, not between 2 and 64"),
            ("[\"rows.spacing_px=wide\"]", "on_maps: rows.spacing_px must be a number, but it is wide"),
            ("[\"rows.nonsense=3\"]", "on_maps: there is no parameter rows.nonsense"),
            ("\"light.shadow=0\"", "on_maps"),
        ] {
            let error = parsed(on_maps).unwrap_err();
            assert!(error.starts_with("x.toml:3:") && error.contains(words), "{error}");
        }
        assert!(parsed("[]").unwrap().on_maps.is_empty());
        let second = parsed("[\n  \"light.shadow=0\",\n  \"light.shadow=2\",\n]").unwrap_err();
        assert!(second.starts_with("x.toml:5:3: on_maps: light.shadow is 2"), "{second}");
        // The first layer of a kind may be called by its number, too.
        let numbered = parsed("[\"strokes[0].width_px=9\"]").unwrap().for_map(10.0).unwrap();
        assert_eq!(numbered.strokes().unwrap().width_px, 9.0);
    }
}
