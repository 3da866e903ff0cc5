//! `--quality`: draws with a point of a style's measured front.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;

use super::arguments;
use super::misuse::Misuse;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::message::{named, quoted};
use crate::measure::quality::{self, Front, Level};
use crate::measure::setting::{FRONTS, Setting};

/// `--quality` and `--front`.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct QualityArgs {
    /// Choose between speed and exactness: draw with a setting that `hachure bench --sweep` has measured for the style. It
    /// sets the resolution and the detail of trees (not in render), --lod-error, --antialias (not in fly) and parameters of
    /// the style, except those that you give. Some presets have built-in measurements (docs/trade-offs.md); --front names those of another style
    #[arg(long, value_name = "LEVEL", value_enum)]
    pub quality: Option<Level>,
    /// The measured settings for --quality (and for --budget): a file front-STYLE.toml of `hachure bench --sweep`. Give it
    /// again for another style [default: that of the preset]
    #[arg(long = "front", value_name = "FILE")]
    pub fronts: Vec<PathBuf>,
}

/// The use of a front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Use {
    /// A picture of the size that the user asks for, so without another render scale.
    Picture,
    /// Frames, with any render scale.
    Frames,
    /// Frames whose settings a governor chooses, from all points.
    Governor,
}

impl QualityArgs {
    /// Returns the setting for a style, which is a preset or a file; `None` without `--quality`.
    ///
    /// # Errors
    /// [`Misuse`] if nothing uses the front, or if the style has no measured front; a file that cannot be read, or that is the front of another style.
    pub(crate) fn setting(&self, style: &str, use_of: Use) -> anyhow::Result<Option<Setting>> {
        let Some(level) = self.quality else {
            if !self.fronts.is_empty() && use_of != Use::Governor {
                let cause = match use_of {
                    Use::Picture => "--front: applies only to --quality, which is not given",
                    _ => "--front: applies only to --quality or --budget, and neither is given",
                };
                bail!(Misuse(cause.to_owned()));
            }
            return Ok(None);
        };
        let (front, from) = self.front_of(style)?;
        let front = if use_of == Use::Picture { front.at_full_size() } else { front };
        let Some(point) = front.point(level) else {
            bail!("{from}: none of its points has the level {}", level.name())
        };
        let setting = point.setting().map_err(|error| anyhow::anyhow!("{from}: {}: {error}", level.name()))?;
        arguments::style_with(&format!("{from}: {}", level.name()), style, &setting.values)?;
        if use_of == Use::Picture && setting.tree_detail.is_some() {
            tracing::warn!("--quality: render draws trees as they are, and not with tree-detail");
        }
        Ok(Some(setting))
    }

    /// Returns the measured front of a style, which is a preset or a file, and what to call the front in messages.
    ///
    /// # Errors
    /// Those of [`QualityArgs::setting`].
    pub(crate) fn front_of(&self, style: &str) -> anyhow::Result<(Front, String)> {
        let name = arguments::style(style)?.name;
        let given = self.given()?;
        let Some((first, from)) = given.first() else {
            return Ok((built_in(style, &name)?, format!("the front of {name}")));
        };
        match given.iter().find(|(front, _)| front.style == name) {
            Some(found) => Ok(found.clone()),
            None => bail!(for_another_style(first, from, &name)),
        }
    }

    /// Reads the fronts of `--front`, each with the name of its file.
    ///
    /// # Errors
    /// A file that cannot be read, and a second front of one style.
    pub(crate) fn given(&self) -> anyhow::Result<Vec<(Front, String)>> {
        let mut given: Vec<(Front, String)> = Vec::new();
        for path in &self.fronts {
            let front = read(path)?;
            if let Some((_, before)) = given.iter().find(|(before, _)| before.style == front.style) {
                bail!("{}: was measured for the style {}, as {before} was", named(path), quoted(&front.style));
            }
            given.push((front, named(path)));
        }
        Ok(given)
    }
}

fn for_another_style(front: &Front, from: &str, name: &str) -> String {
    format!("{from}: it was measured for the style {}, and cannot be used for {}", quoted(&front.style), quoted(name))
}

fn read(path: &Path) -> anyhow::Result<Front> {
    let text = read_text(path, LARGEST_STYLE_BYTES).with_context(|| format!("cannot read {}", named(path)))?;
    Front::parse(&named(path), &text).map_err(anyhow::Error::msg)
}

/// Returns the built-in front of the style `name`, which the command line calls `style`.
fn built_in(style: &str, name: &str) -> anyhow::Result<Front> {
    let text = FRONTS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
    let Some(text) = text else {
        let measured = FRONTS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        bail!(Misuse(format!(
            "{name} has no measured settings for --quality and --budget (presets that have some: {measured}). Measure them: hachure \
             bench --path tour --styles {name} --sweep scale=0.5,0.75,1 --sweep lod-error=0.5,1,4 -o DIR (or with your \
             own WORLD and --path PATH.csv); then add --front DIR/{}",
            quality::file_name(name),
            name = named(style),
        )));
    };
    Front::parse(&format!("the front of {name}"), text).map_err(anyhow::Error::msg)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

    #[test]
    fn every_shipped_front_has_its_levels() {
        for (name, text) in FRONTS {
            let front = Front::parse(name, text).unwrap();
            assert_eq!(front.style, *name);
            for level in Level::ALL {
                let args = QualityArgs { quality: Some(level), fronts: Vec::new() };
                let setting = args.setting(name, Use::Frames).unwrap().unwrap();
                arguments::style_with("--quality", name, &setting.values).unwrap();
            }
            let cost = |level| front.point(level).unwrap().cost;
            assert!(cost(Level::Draft) <= cost(Level::Balanced) && cost(Level::Balanced) <= cost(Level::Exact));
            let recall =
                |level: Level| 100.0 - front.point(level).unwrap().errors.get("lines_lost_percent").unwrap_or(&0.0);
            assert!(recall(Level::Balanced) >= 0.98 * recall(Level::Exact), "{name}");
        }
    }

    #[test]
    fn a_front_must_be_that_of_the_style() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("front-lsa.toml");
        let text = "style = \"lsa\"\nadapter = \"\"\nsize = [1, 1]\ncost = \"GPU ms\"\n[[points]]\nlevels = [\"draft\"]\n\
                    cost = 1.0\ncost_ratio = 0.5\nerrors = { tone_error_percent = 1.0 }\nset = { lod-error = \"4\", scale = \"0.5\", \
                    \"lines.halved\" = \"true\" }\n";
        atomic::write(&path, text.as_bytes()).unwrap();
        let args = |level| QualityArgs { quality: Some(level), fronts: vec![path.clone()] };
        let setting = args(Level::Draft).setting("lsa", Use::Frames).unwrap().unwrap();
        assert_eq!((setting.lod_error_px, setting.scale, setting.antialias), (Some(4.0), Some(0.5), None));
        assert_eq!(setting.values[0].to_string(), "lines.halved=true");
        for (level, style, cause) in [
            (Level::Draft, "pen", "measured for the style"),
            (Level::Exact, "lsa", "none of its points has the level exact"),
        ] {
            let error = args(level).setting(style, Use::Frames).unwrap_err().to_string();
            assert!(error.contains(cause) && error.contains("front-lsa.toml"), "{error}");
        }
        atomic::write(&path, text.replace("\"4\"", "\"-4\"").as_bytes()).unwrap();
        let error = args(Level::Draft).setting("lsa", Use::Frames).unwrap_err().to_string();
        assert!(error.contains("point 1: lod-error=-4"), "{error}");
        // A value that the style cannot have is a mistake in the file.
        atomic::write(&path, text.replace("halved", "halvd").as_bytes()).unwrap();
        let error = args(Level::Draft).setting("lsa", Use::Frames).unwrap_err().to_string();
        assert!(error.contains("front-lsa.toml") && error.contains("lines.halvd"), "{error}");
        // Without --quality there is no setting, and without a front an error that says how to measure one.
        assert_eq!(QualityArgs::default().setting("lsa", Use::Frames).unwrap(), None);
        let unused = QualityArgs { quality: None, fronts: vec![path.clone()] };
        assert!(
            unused.setting("lsa", Use::Frames).unwrap_err().is::<Misuse>()
                && unused.setting("lsa", Use::Governor).unwrap().is_none()
        );
        let none = QualityArgs { quality: Some(Level::Draft), fronts: Vec::new() };
        let none = none.setting("plain", Use::Frames).unwrap_err();
        assert!(none.is::<Misuse>() && none.to_string().contains("--sweep"), "{none}");

        // Each of several fronts serves its own style; two of one style leave open which one counts.
        let other = folder.path().join("front-lsa-base.toml");
        atomic::write(&path, text.as_bytes()).unwrap();
        atomic::write(&other, text.replace("\"lsa\"", "\"lsa-base\"").replace("\"0.5\"", "\"0.25\"").as_bytes())
            .unwrap();
        let scale = |fronts: &[&PathBuf], style: &str| {
            let fronts = fronts.iter().map(|path| (*path).clone()).collect();
            let args = QualityArgs { quality: Some(Level::Draft), fronts };
            args.setting(style, Use::Frames).map(|setting| setting.unwrap().scale)
        };
        assert_eq!(scale(&[&path, &other], "lsa").unwrap(), Some(0.5));
        assert_eq!(scale(&[&path, &other], "lsa-base").unwrap(), Some(0.25));
        assert!(
            scale(&[&path, &path], "lsa").unwrap_err().to_string().contains("was measured for the style \"lsa\", as")
        );
    }
}
