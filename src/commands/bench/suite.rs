//! `--suite`: several benchmarks with one report, such as the tables of a paper, with the paper's figures beside ours.
//!
//! A suite is a TOML file: each of its parts is the command line of a benchmark. Files that a part names lie in the
//! folder of the suite. A built-in suite is first written to the output folder, so that a report has its inputs.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Parser;
use serde::Deserialize;

use super::{BenchArgs, Planned, open_gpu};
use crate::commands::misuse::Misuse;
use crate::commands::{print, print_json};
use crate::file::input::{LARGEST_SCENE_BYTES, read_text};
use crate::file::message::{did_you_mean, named, quoted};
use crate::file::{atomic, unnamed};
use crate::gpu::device::AdapterWish;
use crate::measure::suite::{PartReport, Published, SuiteReport};

/// A suite that is compiled into the program: its name, and its files with their texts, the suite itself first.
struct BuiltIn {
    name: &'static str,
    files: &'static [(&'static str, &'static str)],
}

/// Name of the file that lists the parts.
const SUITE_FILE: &str = "suite.toml";
/// Files that are written to the output folder.
const REPORT: &str = "suite.json";
const PAGE: &str = "suite.html";
/// Folder for the files of a built-in suite, in the output folder.
const INPUTS: &str = "inputs";

static BUILT_IN: [BuiltIn; 1] = [BuiltIn {
    name: "pietrok",
    files: &[
        (SUITE_FILE, include_str!("../../../benches/suites/pietrok/suite.toml")),
        ("hills.toml", include_str!("../../../benches/suites/pietrok/hills.toml")),
        ("mountain.toml", include_str!("../../../benches/suites/pietrok/mountain.toml")),
        ("wide.csv", include_str!("../../../benches/suites/pietrok/wide.csv")),
        ("low.csv", include_str!("../../../benches/suites/pietrok/low.csv")),
        ("mountain.csv", include_str!("../../../benches/suites/pietrok/mountain.csv")),
    ],
}];

/// A suite as its file says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SuiteFile {
    /// Title of the report.
    title: String,
    /// What the suite measures, in sentences.
    about: String,
    parts: Vec<Part>,
}

/// A benchmark of a suite.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Part {
    /// Name of its folder in the output folder.
    name: String,
    title: String,
    /// The arguments of `bench`, without the output.
    bench: Vec<String>,
    /// Published times of a frame.
    published: Option<Published>,
}

/// The command line of a part.
#[derive(Debug, Parser)]
#[command(name = "bench", no_binary_name = true)]
struct PartLine {
    #[command(flatten)]
    bench: BenchArgs,
}

/// Runs all parts of a suite, one after the other, and writes their reports and that of the suite.
///
/// # Errors
/// The suite or one of its parts is invalid, which is found before anything is drawn; the GPU fails; a file cannot be
/// written.
pub(super) fn run(name: &Path, args: &BenchArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    let output = &args.output;
    if output.exists() && !output.is_dir() {
        bail!("{}: is a file, and bench writes its report into a folder", named(output));
    }
    let [report_file, page] = [REPORT, PAGE].map(|name| output.join(name));
    unnamed::check(&report_file, args.overwrite, SuiteReport::is_own)?;
    unnamed::check(&page, args.overwrite, crate::measure::suite::is_page)?;
    let file = match BUILT_IN.iter().find(|suite| Path::new(suite.name) == name && !name.exists()) {
        Some(suite) => suite.write(&output.join(INPUTS), args.overwrite)?,
        None if !name.exists() => {
            let meant = did_you_mean(&name.to_string_lossy(), BUILT_IN.iter().map(|suite| suite.name));
            let known = names();
            bail!(Misuse(format!("--suite {}: there is no such file or suite{meant}; suites: {known}", quoted(&name.to_string_lossy()))));
        }
        None => name.to_owned(),
    };
    let suite = read(&file)?;
    let folder = file.parent().unwrap_or(Path::new("."));
    let lines = suite.parts.iter().map(|part| part.line(folder, &file, args)).collect::<anyhow::Result<Vec<_>>>()?;
    let planned = lines.iter().zip(&suite.parts).map(|(line, part)| {
        Planned::of(line).with_context(|| format!("{}: part {}", named(&file), part.name))
    });
    let planned = planned.collect::<anyhow::Result<Vec<_>>>()?;
    planned.iter().try_for_each(Planned::bake)?;
    let gpu = open_gpu(adapter)?;
    let mut report = SuiteReport {
        suite: suite.title,
        about: suite.about,
        adapter: gpu.description(),
        is_software: gpu.is_software(),
        parts: Vec::new(),
    };
    for (part, planned) in suite.parts.into_iter().zip(planned) {
        let measured = planned.measure(&gpu)?;
        report.parts.push(PartReport::of(part.name, part.title, &measured, part.published));
    }
    report.write(&report_file, &page)?;
    if args.json {
        return print_json(&report);
    }
    print(&format!("{}\n{}\nReport: {} (it explains the columns)", report.adapter, report.text(), named(&page)))
}

/// Returns the names of the built-in suites, for messages.
pub(super) fn names() -> String {
    BUILT_IN.iter().map(|suite| suite.name).collect::<Vec<_>>().join(", ")
}

impl BuiltIn {
    /// Writes the files of the suite into a folder, and returns the path of the suite. Files that are there must have the
    /// same text.
    fn write(&self, folder: &Path, overwrite: bool) -> anyhow::Result<PathBuf> {
        for (name, text) in self.files {
            let is_same = |path: &Path| std::fs::read_to_string(path).is_ok_and(|found| found == *text);
            unnamed::check(&folder.join(name), overwrite, is_same)?;
        }
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", named(folder)))?;
        for (name, text) in self.files {
            let path = folder.join(name);
            atomic::write(&path, text.as_bytes()).with_context(|| format!("cannot write {}", named(&path)))?;
        }
        Ok(folder.join(SUITE_FILE))
    }
}

fn read(file: &Path) -> anyhow::Result<SuiteFile> {
    let text = read_text(file, LARGEST_SCENE_BYTES).with_context(|| format!("cannot read {}", named(file)))?;
    let suite: SuiteFile = toml::from_str(&text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        anyhow::anyhow!("{}:{line}: {}", named(file), error.message())
    })?;
    if suite.parts.is_empty() {
        bail!("{}: the suite has no parts", named(file));
    }
    for (index, part) in suite.parts.iter().enumerate() {
        let is_name = !part.name.is_empty() && part.name.chars().all(|it| it.is_ascii_alphanumeric() || "-_".contains(it));
        if !is_name || part.name == INPUTS {
            bail!("{}: {} cannot be the name of a part, which is that of a folder: use letters, digits, - and _", named(file), quoted(&part.name));
        }
        if suite.parts[..index].iter().any(|before| before.name == part.name) {
            bail!("{}: two parts are called {}", named(file), part.name);
        }
    }
    Ok(suite)
}

impl Part {
    /// Returns the arguments of the benchmark. A word that is the name of a file in the folder of the suite is its path.
    fn line(&self, folder: &Path, file: &Path, args: &BenchArgs) -> anyhow::Result<BenchArgs> {
        let words = self.bench.iter().map(|word| match folder.join(word) {
            path if !word.starts_with('-') && path.is_file() => path.into_os_string(),
            _ => word.into(),
        });
        let output = ["-o".into(), args.output.join(&self.name).into_os_string()];
        let words = words.chain(output).chain(args.overwrite.then(|| "--overwrite".into()));
        let line = PartLine::try_parse_from(words).map_err(|error| {
            let words: Vec<String> = self.bench.clone();
            let cause = crate::commands::misuse::describe(&error, &words, &<PartLine as clap::CommandFactory>::command());
            anyhow::anyhow!("{}: part {}: {cause}", named(file), self.name)
        })?;
        if line.bench.suite.is_some() {
            bail!("{}: part {}: a part of a suite is no suite", named(file), self.name);
        }
        Ok(line.bench)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn every_built_in_suite_is_read_and_its_lines_are_understood() {
        for suite in &BUILT_IN {
            let folder = tempfile::tempdir().unwrap();
            let file = suite.write(&folder.path().join(INPUTS), false).unwrap();
            // Written again, it is the same; a file of somebody else is kept.
            suite.write(&folder.path().join(INPUTS), false).unwrap();
            let mut words = vec!["--suite".into(), suite.name.into(), "-o".into(), folder.path().as_os_str().to_owned()];
            let args = PartLine::try_parse_from(words.drain(..)).unwrap().bench;
            let read = read(&file).unwrap();
            for part in &read.parts {
                let line = part.line(file.parent().unwrap(), &file, &args).unwrap();
                Planned::of(&line).unwrap();
                let published = part.published.iter().flat_map(|published| published.frame_ms.keys());
                for style in published {
                    assert!(line.styles.contains(style), "{}: {style} is not drawn", part.name);
                }
            }
            atomic::write(&file, b"title = 1").unwrap();
            assert!(suite.write(&folder.path().join(INPUTS), false).is_err());
            // Planted: a part with an option that does not exist.
            let part = Part { bench: vec!["--stiles".to_owned()], ..read.parts.into_iter().next().unwrap() };
            let error = part.line(folder.path(), &file, &args).unwrap_err().to_string();
            assert!(error.contains("--stiles") && error.contains(&part.name), "{error}");
        }
    }

    #[test]
    fn a_wrong_suite_is_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.toml");
        let part = "[[parts]]\nname = \"a\"\ntitle = \"A\"\nbench = []\n";
        for (text, cause) in [
            ("title = 1", ":1: "),
            ("title = \"t\"\nabout = \"\"\nparts = []", "no parts"),
            (&format!("title = \"t\"\nabout = \"\"\n{}", part.replace("\"a\"", "\"../a\"")), "cannot be the name"),
            (&format!("title = \"t\"\nabout = \"\"\n{part}{part}"), "two parts are called a"),
            (&format!("title = \"t\"\nabout = \"\"\n{part}speed = 1\n"), "speed"),
        ] {
            atomic::write(&file, text.as_bytes()).unwrap();
            let error = read(&file).unwrap_err().to_string();
            assert!(error.contains("own.toml") && error.contains(cause) && !error.contains('\n'), "{text}: {error}");
        }
    }
}
