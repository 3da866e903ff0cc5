//! `--sweep`: values that a benchmark tries in all combinations, and the settings that follow from them.

use std::collections::BTreeMap;
use std::str::FromStr;

use anyhow::bail;

use super::BenchArgs;
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::commands::quality_args::Use;
use crate::frame::Antialias;
use crate::measure::setting::{OWN_KEYS, Setting};
use crate::style::set::SetValue;
use crate::style::{Layer, Style};

/// Largest number of settings of all styles, without the styles as they are: each has a renderer and tiles of its own.
const MOST_SETTINGS: usize = 64;
/// Allowed error of the surface without an option, in pixels.
pub(super) const DEFAULT_LOD_ERROR_PX: f64 = 1.0;
/// Allowed error of the reference's surface, in pixels.
const REFERENCE_LOD_ERROR_PX: f64 = 0.1;
/// Factor of the reference's tree detail: trees stay meshes down to a quarter of the usual size.
const REFERENCE_TREE_DETAIL: f64 = 4.0;

/// A parameter of a style, or an option, and the values that are tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sweep {
    key: String,
    values: Vec<String>,
}

impl FromStr for Sweep {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, values) = text.split_once('=').unwrap_or((text, ""));
        let values = split_outside_brackets(values);
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(
                "it must be KEY=VALUE,VALUE,…, such as lod-error=0.5,1,2 or strokes.update_every=1,10".to_owned()
            );
        }
        let is_same = |a: &str, b: &str| a == b || a.parse::<f64>().is_ok_and(|number| b.parse() == Ok(number));
        let is_twice = |(index, value): &(usize, &String)| values[..*index].iter().any(|before| is_same(before, value));
        if let Some(twice) = values.iter().enumerate().find(is_twice) {
            return Err(format!("{} is listed twice", twice.1));
        }
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

/// Splits values at commas that are neither in brackets nor in quotes: a value may be a list or a pair.
fn split_outside_brackets(text: &str) -> Vec<String> {
    let (mut values, mut depth, mut is_quoted) = (vec![String::new()], 0_i32, false);
    for sign in text.chars() {
        match sign {
            '"' => is_quoted = !is_quoted,
            '[' if !is_quoted => depth += 1,
            ']' if !is_quoted => depth -= 1,
            _ => {}
        }
        match values.last_mut() {
            Some(value) if sign != ',' || depth > 0 || is_quoted => value.push(sign),
            _ => values.push(String::new()),
        }
    }
    values.into_iter().map(|value| value.trim().to_owned()).collect()
}

/// A style as it is drawn in a run.
#[derive(Clone, Debug)]
pub(super) struct Variant {
    /// The style; its name has the values of the setting.
    pub style: Style,
    /// The values of the sweep, by their keys.
    pub setting: BTreeMap<String, String>,
    pub size_px: [u32; 2],
    pub lod_error_px: f64,
    pub antialias: Antialias,
    /// Factor of the detail of trees.
    pub tree_detail: f64,
    /// Largest error of a height that rounding causes, in metres.
    pub tile_error_m: f64,
}

impl Variant {
    /// Returns a style as it is drawn at the size of the command line, without any other option.
    fn without_setting(args: &BenchArgs, style: Style) -> Self {
        Self {
            style,
            setting: BTreeMap::new(),
            size_px: args.size_px(),
            lod_error_px: DEFAULT_LOD_ERROR_PX,
            antialias: Antialias::None,
            tree_detail: 1.0,
            tile_error_m: 0.0,
        }
    }

    /// Returns a style with the options of the command line.
    fn as_it_is(args: &BenchArgs, name: &str) -> anyhow::Result<Self> {
        let setting = args.quality.setting(name, use_of(args))?.unwrap_or_default();
        let variant = Self::without_setting(args, arguments::style_with("--quality", name, &setting.values)?);
        let mut variant = variant.with_setting(&setting);
        variant.lod_error_px = args.lod_error.unwrap_or(variant.lod_error_px);
        variant.antialias = args.antialias.unwrap_or(variant.antialias);
        Ok(variant)
    }

    /// Returns a style with a setting of its front, under its own name.
    ///
    /// # Errors
    /// A value that the style cannot have.
    pub(super) fn of_setting(args: &BenchArgs, name: &str, setting: &Setting) -> anyhow::Result<Self> {
        let style = arguments::style_with("--front", name, &setting.values)?;
        let mut variant = Self::without_setting(args, style);
        variant.antialias = args.antialias.unwrap_or_default();
        Ok(variant.with_setting(setting))
    }

    /// Returns the variant with the changes of a setting, apart from parameters of the style. With another render
    /// scale, lengths of the style are scaled too, so that the picture is the same drawing.
    fn with_setting(mut self, setting: &Setting) -> Self {
        let scale = setting.scale.unwrap_or(1.0);
        self.style = self.style.scaled(scale);
        self.size_px = self.size_px.map(|side| ((f64::from(side) * scale).round() as u32).max(1));
        self.lod_error_px = setting.lod_error_px.unwrap_or(self.lod_error_px);
        self.antialias = setting.antialias.unwrap_or(self.antialias);
        self.tree_detail = setting.tree_detail.unwrap_or(self.tree_detail);
        self.tile_error_m = setting.tile_error_m.unwrap_or(self.tile_error_m);
        self
    }

    /// Returns the style `name` of the command line, followed by itself with each setting of the sweeps.
    ///
    /// # Errors
    /// The style cannot be read; [`Misuse`] for a key or a value.
    pub(super) fn all(args: &BenchArgs, name: &str) -> anyhow::Result<Vec<Self>> {
        let mut variants = vec![Self::as_it_is(args, name)?];
        if args.sweep.is_empty() {
            return Ok(variants);
        }
        for pairs in settings(&args.sweep) {
            variants.push(Self::with(args, name, &pairs)?);
        }
        Ok(variants)
    }

    fn with(args: &BenchArgs, name: &str, pairs: &[(&str, &str)]) -> anyhow::Result<Self> {
        let setting = Setting::of(pairs.iter().copied());
        let setting = setting.map_err(|error| Misuse(format!("--sweep {error}")))?;
        let style = arguments::style_with("--sweep", name, &setting.values)
            .map_err(|error| explained(name, &setting, error))?;
        let mut variant = Self { style, ..Self::as_it_is(args, name)? }.with_setting(&setting);
        let words: Vec<String> = pairs.iter().map(|(key, text)| format!("{key}={text}")).collect();
        variant.style.name = format!("{} {}", variant.style.name, words.join(" "));
        variant.setting = pairs.iter().map(|(key, text)| ((*key).to_owned(), (*text).to_owned())).collect();
        Ok(variant)
    }

    /// Returns the reference of a style: with its exact options, a small allowed error, and many samples.
    ///
    /// # Errors
    /// The style cannot be read.
    pub(super) fn reference(args: &BenchArgs, name: &str) -> anyhow::Result<Self> {
        let style = arguments::style_with("--sweep", name, &exact_values(&arguments::style(name)?))?;
        let lod_error_px = args.lod_error.map_or(REFERENCE_LOD_ERROR_PX, |px| px.min(REFERENCE_LOD_ERROR_PX));
        let variant = Self::as_it_is(args, name)?;
        Ok(Self {
            style,
            size_px: args.size_px(),
            lod_error_px,
            antialias: Antialias::Temporal,
            tree_detail: REFERENCE_TREE_DETAIL,
            tile_error_m: 0.0,
            ..variant
        })
    }
}

/// Adds what helps to the error of a sweep: which section a style lacks, or which keys there are.
fn explained(style: &str, setting: &Setting, error: anyhow::Error) -> anyhow::Error {
    let words = error.to_string();
    let keys: Vec<&str> = setting.values.iter().map(|value| value.key.as_str()).collect();
    if words.contains(" is missing") || words.contains(" are missing") {
        let sections: Vec<&str> = keys.iter().filter_map(|key| Some(key.split_once('.')?.0)).collect();
        return Misuse(format!(
            "--sweep {}: the style {style} lacks what it changes ({}); a sweep needs a parameter that all the styles have",
            keys.join(", "),
            sections.join(", ")
        ))
        .into();
    }
    if words.contains("there is no parameter") {
        let own = OWN_KEYS.join(", ");
        return Misuse(format!("{words}; besides parameters of styles, --sweep knows {own}")).into();
    }
    error
}

fn use_of(args: &BenchArgs) -> Use {
    if args.budget.is_some() { Use::Governor } else { Use::Frames }
}

/// Checks that the sweeps of a command make a number of settings that can be measured.
///
/// # Errors
/// [`Misuse`]: two sweeps of one key, or too many settings.
pub(super) fn check(args: &BenchArgs) -> anyhow::Result<()> {
    for (index, sweep) in args.sweep.iter().enumerate() {
        if args.sweep[..index].iter().any(|before| before.key == sweep.key) {
            bail!(Misuse(format!("--sweep {} is given twice: list all its values in one", sweep.key)));
        }
    }
    let values = args.sweep.iter().map(|sweep| sweep.values.len());
    let count = values.fold(args.styles.len(), usize::saturating_mul);
    if !args.sweep.is_empty() && count > MOST_SETTINGS {
        let factors: Vec<String> = std::iter::once(format!("{} of --styles", args.styles.len()))
            .chain(args.sweep.iter().map(|sweep| format!("{} of {}", sweep.values.len(), sweep.key)))
            .collect();
        bail!(Misuse(format!(
            "--sweep: {} are {count} settings, and one benchmark has at most {MOST_SETTINGS}; give fewer values, or one \
             style at a time",
            factors.join(" × ")
        )));
    }
    Ok(())
}

/// Returns every combination of the sweeps' values, with their keys.
fn settings(sweeps: &[Sweep]) -> Vec<Vec<(&str, &str)>> {
    sweeps.iter().fold(vec![Vec::new()], |settings, sweep| {
        let with = |setting: &Vec<_>| {
            let setting = setting.clone();
            sweep.values.iter().map(move |value| {
                let mut setting = setting.clone();
                setting.push((sweep.key.as_str(), value.as_str()));
                setting
            })
        };
        settings.iter().flat_map(with).collect()
    })
}

/// Returns the values with which a style is exact, where it has a choice.
fn exact_values(style: &Style) -> Vec<SetValue> {
    let of_layers = style.layers.iter().enumerate().filter_map(|(index, layer)| {
        let (key, value) = match layer {
            Layer::ToneLines(_) => ("exact", "true"),
            Layer::Lines(_) => ("halved", "false"),
            Layer::Strokes(_) => ("resolution", "1"),
            _ => return None,
        };
        Some(SetValue { key: format!("{}.{key}", style.layers.key(index)), text: value.to_owned() })
    });
    let lights = style.relief.is_some().then(|| SetValue { key: "relief.lights".to_owned(), text: "256".to_owned() });
    of_layers.chain(lights).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    fn sweeps(texts: &[&str]) -> Vec<Sweep> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn a_sweep_has_a_key_and_values() {
        let sweep: Sweep = "lod-error= 0.5, 1".parse().unwrap();
        assert_eq!(sweep, Sweep { key: "lod-error".to_owned(), values: vec!["0.5".to_owned(), "1".to_owned()] });
        let pairs: Sweep = "lines.ramp=[0.1, 0.3],[0.2,0.4]".parse().unwrap();
        assert_eq!(pairs.values, ["[0.1, 0.3]", "[0.2,0.4]"]);
        assert!("scale=1,0.5,1".parse::<Sweep>().unwrap_err().contains("1 is listed twice"));
        assert!("scale=0.5,0.50".parse::<Sweep>().unwrap_err().contains("0.50 is listed twice"));
        for wrong in ["", "lod-error", "lod-error=", "=1", "lod-error=1,,2"] {
            assert!(wrong.parse::<Sweep>().unwrap_err().contains("KEY=VALUE"), "{wrong}");
        }
    }

    #[test]
    fn every_value_meets_every_other() {
        let sweeps = sweeps(&["lod-error=1,2", "strokes.update_every=1,5,10"]);
        let settings = settings(&sweeps);
        assert_eq!(settings.len(), 6);
        assert_eq!(settings[3], [("lod-error", "2"), ("strokes.update_every", "1")]);
    }

    #[test]
    fn a_reference_approximates_nothing() {
        for (name, key) in [("tone-lines", "tone_lines.exact"), ("lsa", "lines.halved")] {
            let style = Style::load(name).unwrap();
            let values = exact_values(&style);
            assert!(values.iter().any(|value| value.key == key), "{name}: {values:?}");
            assert_ne!(arguments::style_with("--sweep", name, &values).unwrap(), style);
        }
    }
}
