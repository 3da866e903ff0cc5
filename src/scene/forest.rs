//! `[forest]` of a scene: which trees grow where.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::forest_cover::{ClassToml, CoverFiles, CoverToml};
use super::scene_file::{UpToml, color};

/// Rules for where trees grow; they are evaluated on the terrain.
#[derive(Clone, Debug, PartialEq)]
pub struct Forest {
    /// Seed of the random generator; each seed gives a different forest.
    pub seed: u32,
    /// Density of the forest where nothing limits it; at most [`Forest::MAX_TREES_PER_HA`].
    pub trees_per_ha: f64,
    /// Height above the sea above which no trees grow, in metres.
    pub tree_line_m: f64,
    /// How far the tree line varies up and down, and the height over which the forest thins out below it, in metres.
    pub raggedness_m: f64,
    /// Steepest slope on which trees grow, in degrees.
    pub steepest_deg: f64,
    /// Whether level land is water without trees, as lakes and the sea are level in elevation data.
    pub level_is_water: bool,
    /// The species, 1 to [`Forest::MAX_SPECIES`].
    pub species: Vec<Species>,
    /// The files that [`Form::Model`] indexes, each listed once.
    pub models: Vec<TreeFile>,
    /// Rasters that control where trees grow, in addition to the rules.
    pub cover: CoverFiles,
}

/// A species of tree, and where it prefers to grow.
#[derive(Clone, Debug, PartialEq)]
pub struct Species {
    /// Shape of the trees.
    pub form: Form,
    /// Share of all trees, relative to the shares of the other species, where conditions suit all species equally.
    pub share: f64,
    /// Mean height of a tree, in metres.
    pub height_m: f64,
    /// Heights above the sea between which it grows, in metres; it becomes rarer over 100 m beyond
    /// them.
    pub heights_m: [f64; 2],
    /// Preferred aspect of slopes, clockwise from north, in degrees.
    pub aspect_deg: f64,
    /// Strength of that preference, 0 to 1: at 1 the species does not grow on steep slopes of the opposite aspect.
    pub by_aspect: f64,
    /// Preference for terrain shape: 1 prefers hollows, −1 ridges.
    pub by_hollow: f64,
    /// Colour of leaves, and of model parts without a colour; sRGB, 0 to 1. `None` is the species' own colour.
    pub color_srgb: Option<[f32; 3]>,
    /// Colour of the bark of generated trees; sRGB, 0 to 1. `None` is the species' own colour.
    pub bark_srgb: Option<[f32; 3]>,
}

/// The shape of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Form {
    /// The shape of a spruce.
    Conifer,
    /// The shape of an oak or a beech.
    Broadleaf,
    /// The shape of a birch.
    Birch,
    /// A dead trunk.
    Snag,
    /// A model from a file; indexes [`Forest::models`].
    Model(usize),
}

impl Form {
    /// Returns the name of a generated form in scene files; `None` for a model.
    pub(crate) fn name(self) -> Option<&'static str> {
        match self {
            Self::Conifer => Some("conifer"),
            Self::Broadleaf => Some("broadleaf"),
            Self::Birch => Some("birch"),
            Self::Snag => Some("snag"),
            Self::Model(_) => None,
        }
    }
}

/// A model file of a tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeFile {
    /// Path of the OBJ file.
    pub file: PathBuf,
    /// Whether the file's z axis points up; otherwise its y axis does.
    pub z_up: bool,
}

impl Forest {
    /// Highest density: the number of candidate points per hectare.
    pub(crate) const MAX_TREES_PER_HA: f64 = 625.0;
    /// Largest number of species that a forest can have.
    pub(crate) const MAX_SPECIES: usize = 8;
    /// The seed of a forest whose scene gives none.
    pub(crate) const DEFAULT_SEED: u32 = 1;

    /// Returns the species that are models, each with its file.
    pub(crate) fn species_of_models(&self) -> impl Iterator<Item = (&Species, &TreeFile)> {
        self.species.iter().filter_map(|species| match species.form {
            Form::Model(number) => Some((species, self.models.get(number)?)),
            Form::Conifer | Form::Broadleaf | Form::Birch | Form::Snag => None,
        })
    }

    /// Whether the scene sets a tree line.
    pub(crate) fn has_tree_line(&self) -> bool {
        self.tree_line_m < HIGHEST_M
    }

    /// Returns the forest whose trees have the same places on land that is `factor` times as high. Trees themselves are
    /// not exaggerated.
    #[must_use]
    pub(crate) fn exaggerated(&self, factor: f64) -> Self {
        let mut forest = self.clone();
        forest.tree_line_m *= factor;
        forest.raggedness_m *= factor;
        forest.steepest_deg = exaggerated_slope_deg(forest.steepest_deg, factor);
        for species in &mut forest.species {
            species.heights_m = species.heights_m.map(|height_m| height_m * factor);
        }
        forest
    }

    /// Returns the mean height of the tallest species, in metres.
    pub(crate) fn height_m(&self) -> f64 {
        self.species.iter().map(|species| species.height_m).fold(0.0, f64::max)
    }
}

impl Default for Forest {
    /// Returns the mixed forest of a scene whose table `[forest]` is empty.
    fn default() -> Self {
        Self {
            seed: Self::DEFAULT_SEED,
            trees_per_ha: 300.0,
            // Higher than any land, so there is no tree line.
            tree_line_m: HIGHEST_M,
            raggedness_m: 80.0,
            steepest_deg: 38.0,
            level_is_water: true,
            species: Species::mixed(DEFAULT_HEIGHT_M),
            models: Vec::new(),
            cover: CoverFiles::default(),
        }
    }
}

/// Returns the slope, in degrees, that land of a slope has when it is drawn `factor` times as high.
pub(crate) fn exaggerated_slope_deg(slope_deg: f64, factor: f64) -> f64 {
    match slope_deg {
        // The tangent of a right angle is undefined, and a factor of 1 changes no bit.
        slope_deg if slope_deg >= 90.0 || factor == 1.0 => slope_deg,
        slope_deg => (slope_deg.to_radians().tan() * factor).atan().to_degrees(),
    }
}

impl Species {
    /// Returns a species that grows anywhere.
    pub fn new(form: Form, share: f64, height_m: f64) -> Self {
        let heights_m = [-HIGHEST_M, HIGHEST_M];
        Self {
            form,
            share,
            height_m,
            heights_m,
            aspect_deg: 0.0,
            by_aspect: 0.0,
            by_hollow: 0.0,
            color_srgb: None,
            bark_srgb: None,
        }
    }

    /// Returns a mixed forest whose conifers are `height_m` tall: broadleaves in hollows, birches and dead trunks
    /// between.
    pub fn mixed(height_m: f64) -> Vec<Self> {
        let conifers = Self::new(Form::Conifer, 6.0, height_m);
        let broadleaves = Self { by_hollow: 0.6, ..Self::new(Form::Broadleaf, 3.0, 0.85 * height_m) };
        let birches = Self::new(Form::Birch, 1.2, 0.75 * height_m);
        vec![conifers, broadleaves, birches, Self::new(Form::Snag, 0.2, 0.6 * height_m)]
    }
}

const HIGHEST_M: f64 = 1e6;
/// Mean height of conifers in a scene that gives none, in metres.
const DEFAULT_HEIGHT_M: f64 = 18.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ForestToml {
    seed: Option<u32>,
    trees_per_ha: Option<f64>,
    tree_line_m: Option<f64>,
    raggedness_m: Option<f64>,
    steepest_deg: Option<f64>,
    height_m: Option<f64>,
    #[serde(default)]
    level_ground: LevelGroundToml,
    mask: Option<String>,
    land_cover: Option<String>,
    canopy_height: Option<String>,
    #[serde(default)]
    classes: Vec<ClassToml>,
    #[serde(default)]
    species: Vec<SpeciesToml>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpeciesToml {
    form: Option<FormToml>,
    file: Option<String>,
    up: Option<UpToml>,
    share: Option<f64>,
    height_m: Option<f64>,
    low_m: Option<f64>,
    high_m: Option<f64>,
    aspect_deg: Option<f64>,
    by_aspect: Option<f64>,
    by_hollow: Option<f64>,
    color: Option<String>,
    bark_color: Option<String>,
}

#[derive(Clone, Copy, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
enum LevelGroundToml {
    #[default]
    Water,
    Land,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum FormToml {
    Conifer,
    Broadleaf,
    Birch,
    Snag,
}

/// A key and what is wrong with its value.
pub(super) type WrongKey = (String, String);

/// Returns a number of a table, or its default, if it is in range; `table` ends with a dot.
pub(super) fn within(
    table: &str,
    key: &str,
    value: Option<f64>,
    default: f64,
    range: RangeInclusive<f64>,
) -> Result<f64, WrongKey> {
    let value = value.unwrap_or(default);
    let cause = || format!("it must be between {} and {}", range.start(), range.end());
    if range.contains(&value) { Ok(value) } else { Err((format!("{table}{key}"), cause())) }
}

impl ForestToml {
    /// Validates the section and resolves file names against the folder of the scene file at `scene`.
    ///
    /// # Errors
    /// The first wrong key.
    pub(super) fn checked(&self, scene: &Path) -> Result<Forest, WrongKey> {
        let number = |key, value, default, range| within("forest.", key, value, default, range);
        let height_m = number("height_m", self.height_m, DEFAULT_HEIGHT_M, 0.01..=1000.0)?;
        if self.species.len() > Forest::MAX_SPECIES {
            return Err(("forest.species".to_owned(), format!("at most {} are allowed", Forest::MAX_SPECIES)));
        }
        let own = self.species.iter().enumerate();
        let mut models = Vec::new();
        let own = own.map(|(number, species)| {
            let table = format!("forest.species[{number}]");
            let form = species.form(&table, scene, &mut models)?;
            species.checked(&format!("{table}."), form, height_m)
        });
        let own: Vec<Species> = own.collect::<Result<_, _>>()?;
        let species = if own.is_empty() { Species::mixed(height_m) } else { own };
        let Self { mask, land_cover, canopy_height, classes, .. } = self;
        let cover = CoverToml { mask, land_cover, canopy_height, classes }.checked(scene, &species)?;
        let usual = Forest::default();
        Ok(Forest {
            seed: self.seed.unwrap_or(usual.seed),
            trees_per_ha: number(
                "trees_per_ha",
                self.trees_per_ha,
                usual.trees_per_ha,
                0.0..=Forest::MAX_TREES_PER_HA,
            )?,
            tree_line_m: number("tree_line_m", self.tree_line_m, usual.tree_line_m, -HIGHEST_M..=HIGHEST_M)?,
            raggedness_m: number("raggedness_m", self.raggedness_m, usual.raggedness_m, 0.0..=10_000.0)?,
            steepest_deg: number("steepest_deg", self.steepest_deg, usual.steepest_deg, 1.0..=89.0)?,
            level_is_water: self.level_ground == LevelGroundToml::Water,
            species,
            models,
            cover,
        })
    }
}

impl SpeciesToml {
    /// Returns the form. A model that is not in `models` yet is added to it.
    fn form(&self, table: &str, scene: &Path, models: &mut Vec<TreeFile>) -> Result<Form, WrongKey> {
        let wrong = |key: &str, cause: &str| Err((format!("{table}{key}"), cause.to_owned()));
        let name = match (self.form, self.file.as_deref()) {
            (Some(_), Some(_)) => return wrong(".file", "it cannot be combined with form; remove one of them"),
            (None, None) => return wrong("", "it needs form = \"conifer\" or file = \"tree.obj\""),
            (Some(_), None) if self.up.is_some() => return wrong(".up", "it is only used with file, which is missing"),
            (Some(form), None) => {
                return Ok(match form {
                    FormToml::Conifer => Form::Conifer,
                    FormToml::Broadleaf => Form::Broadleaf,
                    FormToml::Birch => Form::Birch,
                    FormToml::Snag => Form::Snag,
                });
            }
            (None, Some("")) => return wrong(".file", "it is empty"),
            (None, Some(name)) if name.contains("://") => {
                return wrong(".file", "it must be a local file, not a URL");
            }
            (None, Some(name)) => name,
        };
        let file = scene.parent().unwrap_or(Path::new("")).join(name);
        let model = TreeFile { file, z_up: matches!(self.up, Some(UpToml::Z)) };
        let known = models.iter().position(|known| *known == model);
        Ok(Form::Model(known.unwrap_or_else(|| {
            models.push(model);
            models.len() - 1
        })))
    }

    fn checked(&self, table: &str, form: Form, height_m: f64) -> Result<Species, WrongKey> {
        let number = |key, value, default, range| within(table, key, value, default, range);
        let low_m = number("low_m", self.low_m, -HIGHEST_M, -HIGHEST_M..=HIGHEST_M)?;
        let high_m = number("high_m", self.high_m, HIGHEST_M, -HIGHEST_M..=HIGHEST_M)?;
        if low_m > high_m {
            return Err((format!("{table}low_m"), "it is greater than high_m".to_owned()));
        }
        let own_color = |key: &str, text: &Option<String>| {
            let wrong = || (format!("{table}{key}"), "it must be written as \"#rrggbb\"".to_owned());
            text.as_deref().map(|text| color(text).ok_or_else(wrong)).transpose()
        };
        if self.bark_color.is_some() && form.name().is_none() {
            return Err((
                format!("{table}bark_color"),
                "it is only used with form; a model has its own materials".to_owned(),
            ));
        }
        // An aspect without a strength is meant to count fully.
        let by_aspect = if self.aspect_deg.is_some() { 1.0 } else { 0.0 };
        Ok(Species {
            form,
            share: number("share", self.share, 1.0, 0.0..=1e6)?,
            height_m: number("height_m", self.height_m, height_m, 0.01..=1000.0)?,
            heights_m: [low_m, high_m],
            aspect_deg: number("aspect_deg", self.aspect_deg, 0.0, -360.0..=360.0)?,
            by_aspect: number("by_aspect", self.by_aspect, by_aspect, 0.0..=1.0)?,
            by_hollow: number("by_hollow", self.by_hollow, 0.0, -1.0..=1.0)?,
            color_srgb: own_color("color", &self.color)?,
            bark_srgb: own_color("bark_color", &self.bark_color)?,
        })
    }
}
