//! `[forest]` of a scene: the rasters that control where trees grow. [`crate::forest::cover`] reads them.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::forest::{Form, Species, WrongKey, within};

/// Rasters that control where trees grow; the densities of several rasters are multiplied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CoverFiles {
    /// Greyscale mask: black means no trees, white as many as the rules allow.
    pub mask: Option<PathBuf>,
    /// Land cover: a raster of class numbers.
    pub land_cover: Option<PathBuf>,
    /// Meanings of the classes of `land_cover`, at most [`CoverFiles::MAX_CLASSES`]. Classes that are not listed have
    /// no trees.
    pub classes: Vec<CoverClass>,
    /// Heights of trees above the ground, in metres.
    pub canopy_height: Option<PathBuf>,
}

/// The meaning of a land-cover class.
#[derive(Clone, Debug, PartialEq)]
pub struct CoverClass {
    /// Number of the class in the raster.
    pub class: i32,
    /// Share of the trees allowed by the rules that grow in this class, 0 to 1.
    pub density: f64,
    /// Shares of the scene's species in this class, in place of each [`Species::share`].
    pub shares: Vec<f64>,
}

impl CoverFiles {
    /// Class numbers are stored in 8 bits, and 0 is none.
    pub(crate) const MAX_CLASSES: usize = 255;

    /// Returns the rasters, each with its key in the scene file.
    pub(crate) fn files(&self) -> impl Iterator<Item = (&'static str, &PathBuf)> {
        let all = [
            ("forest.mask", &self.mask),
            ("forest.land_cover", &self.land_cover),
            ("forest.canopy_height", &self.canopy_height),
        ];
        all.into_iter().filter_map(|(key, file)| Some((key, file.as_ref()?)))
    }
}

/// The keys of `[forest]` that concern rasters.
pub(super) struct CoverToml<'a> {
    pub mask: &'a Option<String>,
    pub land_cover: &'a Option<String>,
    pub canopy_height: &'a Option<String>,
    pub classes: &'a [ClassToml],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClassToml {
    class: i32,
    density: Option<f64>,
    mix: Option<MixToml>,
    species: Option<Vec<f64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MixToml {
    conifer: Option<f64>,
    broadleaf: Option<f64>,
    birch: Option<f64>,
    snag: Option<f64>,
}

impl CoverToml<'_> {
    /// Validates the keys and resolves file names against the folder of the scene file at `scene`.
    ///
    /// # Errors
    /// The first wrong key.
    pub(super) fn checked(&self, scene: &Path, species: &[Species]) -> Result<CoverFiles, WrongKey> {
        let file = |key: &str, name: &Option<String>| {
            let wrong = |cause: &str| Err((format!("forest.{key}"), cause.to_owned()));
            match name.as_deref() {
                None => Ok(None),
                Some("") => wrong("it is empty"),
                Some(name) if name.contains("://") => wrong("it must be a local file, not a URL"),
                Some(name) => Ok(Some(scene.parent().unwrap_or(Path::new("")).join(name))),
            }
        };
        let land_cover = file("land_cover", self.land_cover)?;
        let wrong = |key: &str, cause: String| Err((format!("forest.{key}"), cause));
        match (&land_cover, self.classes) {
            (None, [_, ..]) => return wrong("classes", "they describe land_cover, which is missing".to_owned()),
            (Some(_), []) => {
                return wrong(
                    "land_cover",
                    "it needs [[forest.classes]], because unlisted classes have no trees".to_owned(),
                );
            }
            (_, classes) if classes.len() > CoverFiles::MAX_CLASSES => {
                return wrong("classes", format!("at most {} are allowed", CoverFiles::MAX_CLASSES));
            }
            _ => {}
        }
        let mut classes: Vec<CoverClass> = Vec::new();
        for (number, class) in self.classes.iter().enumerate() {
            if classes.iter().any(|other| other.class == class.class) {
                return wrong(&format!("classes[{number}].class"), format!("{} is listed twice", class.class));
            }
            classes.push(class.checked(&format!("forest.classes[{number}]."), species)?);
        }
        let canopy_height = file("canopy_height", self.canopy_height)?;
        Ok(CoverFiles { mask: file("mask", self.mask)?, land_cover, classes, canopy_height })
    }
}

const LARGEST_SHARE: f64 = 1e6;

impl ClassToml {
    fn checked(&self, table: &str, species: &[Species]) -> Result<CoverClass, WrongKey> {
        let density = within(table, "density", self.density, 1.0, 0.0..=1.0)?;
        let wrong = |key: &str, cause: String| Err((format!("{table}{key}"), cause));
        let (key, shares) = match (&self.mix, &self.species) {
            (Some(_), Some(_)) => {
                return wrong("mix", "it cannot be combined with species; remove one of them".to_owned());
            }
            (None, None) => ("class", species.iter().map(|species| species.share).collect()),
            (Some(mix), None) => ("mix", mix.shares(&format!("{table}mix."), species)?),
            (None, Some(shares)) if shares.len() != species.len() => {
                let (given, wanted) = (shares.len(), species.len());
                return wrong("species", format!("it has {given} shares, but the scene has {wanted} species"));
            }
            (None, Some(shares)) => {
                let shares =
                    shares.iter().map(|share| within(table, "species", Some(*share), 0.0, 0.0..=LARGEST_SHARE));
                ("species", shares.collect::<Result<Vec<f64>, _>>()?)
            }
        };
        if density > 0.0 && shares.iter().sum::<f64>() <= 0.0 {
            return wrong(key, "all shares are 0; for a class without trees, set density = 0".to_owned());
        }
        Ok(CoverClass { class: self.class, density, shares })
    }
}

impl MixToml {
    /// Returns a share for each species. The share of a form is divided among its species in proportion to their own
    /// shares.
    fn shares(&self, table: &str, species: &[Species]) -> Result<Vec<f64>, WrongKey> {
        let mut shares = vec![0.0; species.len()];
        for (key, form, share) in [
            ("conifer", Form::Conifer, self.conifer),
            ("broadleaf", Form::Broadleaf, self.broadleaf),
            ("birch", Form::Birch, self.birch),
            ("snag", Form::Snag, self.snag),
        ] {
            let share = within(table, key, share, 0.0, 0.0..=LARGEST_SHARE)?;
            let own = || species.iter().filter(|species| species.form == form);
            let all: f64 = own().map(|species| species.share).sum();
            if share > 0.0 && all <= 0.0 {
                return Err((format!("{table}{key}"), "the scene has no species of this form".to_owned()));
            }
            for (own, species) in shares.iter_mut().zip(species).filter(|(_, species)| species.form == form) {
                *own = if share > 0.0 { share * species.share / all } else { 0.0 };
            }
        }
        Ok(shares)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Scene;
    use super::*;
    use crate::scene::Forest;

    fn forest(keys: &str) -> Result<Forest, String> {
        let text = format!("[world]\nprocedural = {{ seed = 1 }}\n[forest]\n{keys}");
        let scene = Scene::parse(Path::new("land/s.toml"), &text).map_err(|error| error.to_string())?;
        scene.forest.ok_or_else(|| "no forest".to_owned())
    }

    const SPECIES: &str = "[[forest.species]]\nform = \"conifer\"\nshare = 6\n[[forest.species]]\nform = \"conifer\"\n\
                           share = 2\n[[forest.species]]\nform = \"birch\"\nshare = 1\n";

    #[test]
    fn rasters_and_classes_are_read() {
        let keys = format!(
            "mask = \"m.png\"\nland_cover = \"c.tif\"\ncanopy_height = \"/h.tif\"\n\
             [[forest.classes]]\nclass = 41\ndensity = 0.5\nmix = {{ conifer = 4, birch = 1 }}\n\
             [[forest.classes]]\nclass = 42\nspecies = [0, 1, 2]\n[[forest.classes]]\nclass = 43\n{SPECIES}"
        );
        let cover = forest(&keys).unwrap().cover;
        let class = |class, density, shares: [f64; 3]| CoverClass { class, density, shares: shares.to_vec() };
        let expected = CoverFiles {
            mask: Some("land/m.png".into()),
            land_cover: Some("land/c.tif".into()),
            classes: vec![
                class(41, 0.5, [3.0, 1.0, 1.0]),
                class(42, 1.0, [0.0, 1.0, 2.0]),
                class(43, 1.0, [6.0, 2.0, 1.0]),
            ],
            canopy_height: Some("/h.tif".into()),
        };
        assert_eq!(cover, expected);
        // Planted: the conifers' share given to each of them in full.
        assert_ne!(cover.classes[0].shares, [4.0, 4.0, 1.0]);
        assert_eq!(forest("").unwrap().cover, CoverFiles::default());
    }

    #[test]
    fn errors_have_a_position() {
        let land = |class: &str| format!("land_cover = \"c.tif\"\n[[forest.classes]]\n{class}\n{SPECIES}");
        for (keys, expected) in [
            ("mask = \"\"".to_owned(), "4:8: forest.mask: it is empty"),
            ("mask = \"https://x/m.png\"".to_owned(), "4:8: forest.mask: it must be a local file"),
            ("mask = 3".to_owned(), "4:8: forest.mask must be text"),
            ("maks = \"m.png\"".to_owned(), "4:1: unknown key \"forest.maks\"; did you mean \"mask\"?"),
            ("land_cover = \"c.tif\"".to_owned(), "4:14: forest.land_cover: it needs [[forest.classes]]"),
            ("[[forest.classes]]\nclass = 4".to_owned(), "forest.classes: they describe land_cover, which is missing"),
            (land("class = 4\ndensity = 1.5"), "7:11: forest.classes.density: it must be between 0 and 1"),
            (land("density = 1"), "the key \"forest.classes.class\" is missing"),
            (
                land("class = 4\nmix = { conifer = 1 }\nspecies = [1, 1, 1]"),
                "7:7: forest.classes.mix: it cannot be combined with species",
            ),
            (
                land("class = 4\nspecies = [1, 1]"),
                "7:11: forest.classes.species: it has 2 shares, but the scene has 3 species",
            ),
            (land("class = 4\nspecies = [1, -1, 1]"), "7:11: forest.classes.species: it must be between 0 and 1000000"),
            (land("class = 4\nspecies = [0, 0, 0]"), "7:11: forest.classes.species: all shares are 0"),
            (
                land("class = 4\nmix = { snag = 1 }"),
                "7:16: forest.classes.mix.snag: the scene has no species of this form",
            ),
            (land("class = 4\nmix = { oak = 1 }"), "unknown key \"forest.classes.mix.oak\""),
            (land("class = 4\n[[forest.classes]]\nclass = 4"), "8:9: forest.classes.class: 4 is listed twice"),
            (land("class = 4.5"), "forest.classes.class must be a whole number"),
        ] {
            let error = forest(&keys).unwrap_err();
            assert!(error.starts_with("land/s.toml:") && error.contains(expected) && !error.contains('\n'), "{error}");
        }
        assert!(forest(&land("class = 4\nspecies = [0, 0, 0]\ndensity = 0")).is_ok());
    }

    #[test]
    fn a_scene_reaches_only_rasters_in_its_folder() {
        use crate::scene::reach::Reach;
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("s.toml");
        for key in ["mask", "canopy_height", "land_cover"] {
            let check = |name: &str, reach| {
                let classes = if key == "land_cover" { "[[forest.classes]]\nclass = 1\n" } else { "" };
                let text = format!("[world]\nprocedural = {{ seed = 1 }}\n[forest]\n{key} = \"{name}\"\n{classes}");
                Scene::parse(&file, &text).unwrap().check_reach(&file, reach).map_err(|error| error.to_string())
            };
            let error = check("../m.tif", Reach::SceneFolder).unwrap_err();
            assert!(error.contains(&format!("forest.{key}: ")) && error.contains("--trust-scene"), "{error}");
            assert!(check("/etc/hostname", Reach::SceneFolder).is_err());
            assert!(check("deep/m.tif", Reach::SceneFolder).is_ok() && check("../m.tif", Reach::Anywhere).is_ok());
        }
    }
}
