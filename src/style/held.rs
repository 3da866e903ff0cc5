//! A style with its recipes as text. A picture stores both, so that it can be redrawn after the files have changed.

use std::collections::BTreeMap;
use std::path::Path;

use super::layers::RecipeSource;
use super::{Layer, Style, StyleError, marks, parameters, texture};

/// The recipes of a style that are files, as text, by the names that the style uses.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct StyleFiles {
    /// Recipes of hatching marks. Images in them are named by the paths from which they were read.
    pub marks: BTreeMap<String, String>,
    /// Recipes of stroke textures.
    pub textures: BTreeMap<String, String>,
}

impl Style {
    /// Returns the recipes of the style that are files.
    pub(crate) fn recipe_files(&self) -> StyleFiles {
        let here = Path::new("");
        let sets = self.layers.iter().flat_map(|layer| match layer {
            Layer::Hatching(hatching) => hatching.sets.as_slice(),
            _ => &[],
        });
        let sets = sets.filter(|set| marks::file(&set.marks, here).is_some());
        let marks = sets.filter_map(|set| Some((set.marks.clone(), parameters::text(set.recipe.as_ref()?))));
        let of_strokes = self.layers.iter().filter_map(|layer| match layer {
            Layer::Strokes(strokes) => Some((&strokes.texture_name, &strokes.texture)),
            _ => None,
        });
        let textures = of_strokes.chain([(&self.curvature.texture_name, &self.curvature.texture)]);
        let textures = textures.filter_map(|(name, recipe)| {
            let name = name.as_ref().filter(|name| texture::file(name, here).is_some())?;
            Some((name.clone(), parameters::text(recipe.as_ref()?)))
        });
        StyleFiles { marks: marks.collect(), textures: textures.collect() }
    }

    /// Parses a style like [`Style::parse`], but takes recipes from `recipes` instead of files. Only images of marks
    /// and environment maps are read from files.
    ///
    /// # Errors
    /// The errors of [`Style::parse`]; a recipe that is neither in `recipes` nor built in is unknown.
    pub(crate) fn parse_with(name: &str, text: &str, recipes: &StyleFiles) -> Result<Self, StyleError> {
        let mut style = Self::read_values(name, text)?;
        style.complete(RecipeSource::Embedded(recipes)).map_err(|(_, error)| error)?;
        Ok(style)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::file::atomic;
    use crate::style::preset_text;

    #[test]
    fn recipes_outlive_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| atomic::write(&folder.path().join(name), text.as_bytes()).unwrap();
        let dash = "description = \"d\"\nkind = \"dash\"\nlength_px = 21\n";
        write("own.toml", dash);
        write("tool.toml", include_str!("../../textures/strokes/pencil.toml"));
        let text = preset_text("crosshatch").unwrap();
        let text = text.replacen("marks = \"", "marks = \"own.toml\" #", 1);
        let mut text: toml_edit::DocumentMut = text.parse().unwrap();
        let layers = text["layers"].as_array_of_tables_mut().unwrap();
        let strokes = layers.iter_mut().find(|layer| layer["kind"].as_str() == Some("strokes")).unwrap();
        strokes["texture"] = toml_edit::value("tool.toml");
        text["curvature"]["texture"] = toml_edit::value("tool.toml");
        write("style.toml", &text.to_string());
        let style = Style::read(&folder.path().join("style.toml")).unwrap();
        let held = style.recipe_files();
        assert_eq!((held.marks.len(), held.textures.len()), (1, 1));
        drop(folder);
        let again = Style::parse_with("x.png", &style.text(), &held).unwrap();
        assert_eq!(&again.layers, &style.layers);
        assert!(again.curvature.texture.is_some() && again.curvature == style.curvature);
        // A changed number in a stored recipe changes the style, and without the recipe parsing fails.
        let mut other = held.clone();
        other.marks.values_mut().for_each(|text| *text = text.replace("21", "22"));
        assert_ne!(Style::parse_with("x.png", &style.text(), &other).unwrap().hatching(), style.hatching());
        assert!(Style::parse_with("x.png", &style.text(), &StyleFiles::default()).is_err());
    }

    #[test]
    fn surroundings_are_read_from_where_they_were() {
        let folder = tempfile::tempdir().unwrap();
        let sky = include_bytes!("../tests/style_parameters/white.hdr");
        atomic::write(&folder.path().join("sky.hdr"), sky).unwrap();
        let text = preset_text("relief").unwrap().replacen("[relief]", "[relief]\nenvironment = \"sky.hdr\"", 1);
        atomic::write(&folder.path().join("style.toml"), text.as_bytes()).unwrap();
        let style = Style::read(&folder.path().join("style.toml")).unwrap();
        let again = || Style::parse_with("x.png", &style.text(), &style.recipe_files());
        let relief = again().unwrap().relief.unwrap();
        assert!(relief.sky.is_some());
        assert_eq!(Some(relief), style.relief);
        drop(folder);
        assert!(again().is_err());
    }

    #[test]
    fn presets_hold_nothing() {
        for name in crate::style::names() {
            let style = Style::load(name).unwrap();
            assert_eq!(style.recipe_files(), StyleFiles::default());
            assert_eq!(Style::parse_with("x.png", &style.text(), &StyleFiles::default()).unwrap(), style);
        }
    }
}
