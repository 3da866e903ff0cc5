//! The settings of a benchmark, and whether another one was made in the same way.

use std::fs::File;
use std::io::{ErrorKind, Read};

use serde::{Deserialize, Serialize};

/// The name in reports of the world that has none.
const BUILT_IN: &str = "the built-in world";

/// The program of a benchmark, and the options of its run. Size, eyes and anti-aliasing are elsewhere in the report.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settings {
    /// Version of hachure.
    pub version: String,
    /// CRC-32 of the program's file in hexadecimal digits, which differs between builds of one version; null if the file
    /// cannot be read.
    pub program_crc32: Option<String>,
    /// The world as given on the command line; null for the built-in world.
    pub world: Option<String>,
    /// The camera path as given on the command line.
    pub path: String,
    /// CRC-32 of the path's CSV text, in hexadecimal digits.
    pub path_crc32: String,
    /// Duration of the path, in seconds.
    pub duration_s: f64,
    /// Number of frames on the path; null in real time, where each style draws as many as it can.
    pub frames: Option<u64>,
    /// Whether the camera followed the clock (`--real-time`).
    pub real_time: bool,
    /// Requested largest error of the drawn surface, in pixels (`--lod-error`).
    pub lod_error_px: f64,
    /// Point of the styles' measured fronts (`--quality`); null without the option.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<String>,
    /// Memory for heights on the GPU for each style, in MiB (`--tile-memory`).
    pub tile_memory_mib: u64,
    /// Factor on heights (`--exaggeration`); null without the option.
    #[serde(default)]
    pub exaggeration: Option<f64>,
    /// Height of the sea, or none (`--sea-level`); null without the option.
    #[serde(default)]
    pub sea_level: Option<String>,
    /// Trees (`--trees`); null without the option.
    #[serde(default)]
    pub trees: Option<String>,
    /// Seed of the land (`--seed`); null without the option.
    #[serde(default)]
    pub seed: Option<u32>,
}

impl Settings {
    /// Returns why a benchmark with these settings cannot be compared with an older one: one sentence for each setting
    /// because of which their frames differ.
    pub(super) fn conflicts(&self, old: &Self) -> Vec<String> {
        let made = |before: String, now: String| {
            format!("nothing is compared: the old report was made with {before}, this one with {now}")
        };
        let option = |name: &str, before: &dyn ToString, now: &dyn ToString| {
            made(format!("{name} {}", before.to_string()), format!("{name} {}", now.to_string()))
        };
        let mut conflicts = Vec::new();
        if old.path_crc32 != self.path_crc32 {
            conflicts.push(if old.path == self.path {
                format!("nothing is compared: the cameras of --path {} are not those of the old report", self.path)
            } else {
                option("--path", &old.path, &self.path)
            });
        }
        match (old.frames, self.frames) {
            (Some(before), Some(now)) if before != now => {
                conflicts.push(made(format!("{before} frames"), format!("{now} frames")));
            }
            _ if old.real_time != self.real_time => {
                let word = |real_time| if real_time { "--real-time" } else { "a fixed number of frames" };
                conflicts.push(made(word(old.real_time).to_owned(), word(self.real_time).to_owned()));
            }
            _ => {}
        }
        if (old.lod_error_px - self.lod_error_px).abs() > 1e-9 * self.lod_error_px.abs() {
            conflicts.push(option("--lod-error", &old.lod_error_px, &self.lod_error_px));
        }
        if old.quality != self.quality {
            let word = |quality: &Option<String>| quality.clone().unwrap_or("none".to_owned());
            conflicts.push(option("--quality", &word(&old.quality), &word(&self.quality)));
        }
        if old.tile_memory_mib != self.tile_memory_mib {
            conflicts.push(option("--tile-memory", &old.tile_memory_mib, &self.tile_memory_mib));
        }
        if old.exaggeration != self.exaggeration {
            let factor = |factor: Option<f64>| factor.map_or_else(|| "none".to_owned(), |factor| factor.to_string());
            conflicts.push(option("--exaggeration", &factor(old.exaggeration), &factor(self.exaggeration)));
        }
        let [seed_before, seed_now] = [old, self].map(|settings| settings.seed.map(|seed| seed.to_string()));
        for (name, before, now) in [
            ("--sea-level", &old.sea_level, &self.sea_level),
            ("--trees", &old.trees, &self.trees),
            ("--seed", &seed_before, &seed_now),
        ] {
            if before != now {
                let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "not given".to_owned());
                conflicts.push(option(name, &value(before), &value(now)));
            }
        }
        conflicts
    }

    /// Returns differences from an older benchmark with which this one can be compared all the same: one sentence each.
    pub(super) fn remarks(&self, old: &Self) -> Vec<String> {
        let mut remarks = Vec::new();
        if old.world != self.world {
            let name = |world: &Option<String>| world.clone().unwrap_or_else(|| BUILT_IN.to_owned());
            let [before, now] = [&old.world, &self.world].map(name);
            remarks.push(format!("the world was {before}, and now is {now}; both have the same size"));
        }
        if (&old.version, &old.program_crc32) != (&self.version, &self.program_crc32) {
            let [before, now] = [old, self].map(Self::program);
            remarks.push(format!("the old report was made by {before}, this one by {now}"));
        }
        remarks
    }

    /// Returns a sentence that says how the benchmark was made.
    pub(super) fn sentence(&self) -> String {
        let world = self.world.as_deref().unwrap_or(BUILT_IN);
        let frames = self.frames.map_or_else(|| "in real time".to_owned(), |frames| format!("{frames} frames"));
        let Self { path, duration_s, lod_error_px, tile_memory_mib, .. } = self;
        let higher = self.exaggeration.map(|factor| format!(", heights × {factor}")).unwrap_or_default();
        let sea = self.sea_level.as_ref().map(|level| match level.as_str() {
            "none" => ", without a sea".to_owned(),
            level => format!(", with a sea at {level} m"),
        });
        let trees = self.trees.as_ref().map(|trees| match trees.as_str() {
            "off" => ", without trees".to_owned(),
            "on" => ", with trees".to_owned(),
            seed => format!(", with trees of seed {seed}"),
        });
        let seed = self.seed.map(|seed| format!(", seed {seed}"));
        let land = [seed, sea, trees].into_iter().flatten().collect::<String>();
        format!(
            "{}: {world} along {path} ({duration_s} s), {frames}, with an allowed error of {lod_error_px} px and \
             {tile_memory_mib} MiB for tiles{higher}{land}",
            self.program()
        )
    }

    /// Returns the program's name, version, and the checksum that distinguishes its build.
    fn program(&self) -> String {
        let build = self.program_crc32.as_ref().map_or_else(String::new, |crc32| format!(" (program {crc32})"));
        format!("hachure {}{build}", self.version)
    }
}

/// Returns the CRC-32 of the program that is running, in hexadecimal digits; `None` if its file cannot be read.
pub(crate) fn program_crc32() -> Option<String> {
    let mut program = File::open(std::env::current_exe().ok()?).ok()?;
    let (mut crc32, mut block) = (crc32fast::Hasher::new(), vec![0; 1 << 16]);
    loop {
        match program.read(&mut block) {
            Ok(0) => return Some(format!("{:08x}", crc32.finalize())),
            Ok(length) => crc32.update(&block[..length]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(_) => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings {
            version: "1.0.0".to_owned(),
            program_crc32: Some("01234567".to_owned()),
            path: "tour".to_owned(),
            path_crc32: "89abcdef".to_owned(),
            duration_s: 30.0,
            frames: Some(24),
            lod_error_px: 1.0,
            tile_memory_mib: 512,
            ..Settings::default()
        }
    }

    #[test]
    fn each_setting_that_changes_the_frames_is_a_conflict() {
        let conflicts = |change: &dyn Fn(&mut Settings)| {
            let mut old = settings();
            change(&mut old);
            assert_eq!(settings().remarks(&old), Vec::<String>::new());
            settings().conflicts(&old).join("; ")
        };
        assert_eq!(conflicts(&|_| ()), "");
        // The same cameras in another file are the same path.
        assert_eq!(conflicts(&|old| old.path = "copy of tour.csv".to_owned()), "");
        let path = conflicts(&|old| (old.path, old.path_crc32) = ("valley".to_owned(), "0".to_owned()));
        let expected = "nothing is compared: the old report was made with --path valley, this one with --path tour";
        assert_eq!(path, expected);
        assert!(conflicts(&|old| old.path_crc32 = "0".to_owned()).contains("the cameras of --path tour"));
        assert!(conflicts(&|old| old.frames = Some(3)).contains("with 3 frames, this one with 24 frames"));
        let real_time = conflicts(&|old| (old.frames, old.real_time) = (None, true));
        assert!(real_time.contains("with --real-time, this one with a fixed number"), "{real_time}");
        assert!(
            conflicts(&|old| old.quality = Some("draft".to_owned()))
                .contains("--quality draft, this one with --quality none")
        );
        assert!(conflicts(&|old| old.lod_error_px = 4.0).contains("with --lod-error 4, this one with --lod-error 1"));
        let higher = conflicts(&|old| old.exaggeration = Some(2.5));
        assert!(higher.contains("with --exaggeration 2.5, this one with --exaggeration none"), "{higher}");
        let flooded = conflicts(&|old| old.sea_level = Some("12".to_owned()));
        assert!(flooded.contains("with --sea-level 12, this one with --sea-level not given"), "{flooded}");
        assert!(conflicts(&|old| old.seed = Some(2)).contains("with --seed 2, this one with --seed not given"));
        assert!(conflicts(&|old| old.trees = Some("off".to_owned())).contains("with --trees off, this one"));
        assert!(
            conflicts(&|old| old.tile_memory_mib = 64).contains("--tile-memory 64, this one with --tile-memory 512")
        );
    }

    #[test]
    fn another_program_or_world_is_a_remark() {
        let remark = |change: &dyn Fn(&mut Settings)| {
            let mut old = settings();
            change(&mut old);
            assert_eq!(settings().conflicts(&old), Vec::<String>::new());
            settings().remarks(&old).join("; ")
        };
        assert_eq!(remark(&|_| ()), "");
        let version = remark(&|old| old.version = "0.9.0".to_owned());
        assert!(
            version.contains("made by hachure 0.9.0") && version.contains("this one by hachure 1.0.0"),
            "{version}"
        );
        assert!(remark(&|old| old.program_crc32 = None).contains("this one by hachure 1.0.0 (program 01234567)"));
        assert!(remark(&|old| old.world = Some("a.tif".to_owned())).contains("the world was a.tif"));
    }

    #[test]
    fn a_sentence_says_how_it_was_made() {
        let sentence = "hachure 1.0.0 (program 01234567): the built-in world along tour (30 s), 24 frames, with an allowed \
                        error of 1 px and 512 MiB for tiles";
        assert_eq!(settings().sentence(), sentence);
        let high = Settings { exaggeration: Some(2.0), ..settings() };
        assert!(high.sentence().ends_with("for tiles, heights × 2"), "{}", high.sentence());
        let [sea_level, trees] = ["12", "7"].map(|value| Some(value.to_owned()));
        let wet = Settings { sea_level, trees, seed: Some(2), ..settings() }.sentence();
        assert!(wet.ends_with("for tiles, seed 2, with a sea at 12 m, with trees of seed 7"), "{wet}");
        let [sea_level, trees] = ["none", "off"].map(|value| Some(value.to_owned()));
        let bare = Settings { sea_level, trees, ..settings() }.sentence();
        assert!(bare.ends_with("for tiles, without a sea, without trees"), "{bare}");
        let real_time = Settings { frames: None, real_time: true, world: Some("a.tif".to_owned()), ..settings() };
        assert!(real_time.sentence().contains("a.tif along tour (30 s), in real time, "), "{}", real_time.sentence());
    }

    #[test]
    fn the_program_has_a_checksum() {
        assert!(program_crc32().is_some_and(|crc32| crc32.len() == 8));
    }
}
