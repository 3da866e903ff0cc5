//! `--suite`: several benchmarks with one report, such as the tables of a paper, with the paper's figures next to ours.
//!
//! A suite is a TOML file of tables, and each part of a table is the command line of a benchmark, whose files are in the
//! folder of the suite. A built-in suite is first written to the output folder, so that a report has its
//! inputs.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::{CommandFactory, Parser};
use serde::Deserialize;

use super::built_in_suites::{BuiltIn, SUITE_FILE, SUITES};
use super::{BenchArgs, Planned, open_gpu};
use crate::commands::misuse::{Misuse, describe};
use crate::commands::{print, print_json};
use crate::file::input::{LARGEST_SCENE_BYTES, read_text};
use crate::file::message::{did_you_mean, named, quoted};
use crate::file::{atomic, standard, toml_text, unnamed};
use crate::gpu::device::{AdapterWish, Gpu};
use crate::gpu::shader::SHADERS;
use crate::measure::report::Report;
use crate::measure::suite::{self, PartReport, Published, SuiteReport, TableReport};

/// Files that are written to the output folder.
const REPORT: &str = "suite.json";
const PAGE: &str = "suite.html";
/// Folder for the files of a built-in suite, in the output folder.
const INPUTS: &str = "inputs";

/// The contents of a suite file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SuiteFile {
    /// Title of the report.
    title: String,
    /// The subject of the suite, in sentences.
    about: String,
    tables: Vec<Table>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    title: String,
    /// Names of passes, or beginnings of names, that have columns of their own.
    #[serde(default)]
    passes: Vec<String>,
    /// Keys of columns besides the usual ones.
    #[serde(default)]
    columns: Vec<String>,
    published: Option<Published>,
    parts: Vec<Part>,
}

/// A benchmark of a table.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Part {
    /// Name of its folder in the output folder.
    name: String,
    /// The arguments of `bench`, without the output.
    bench: Vec<String>,
}

/// The command line of a part.
#[derive(Debug, Parser)]
#[command(name = "bench", no_binary_name = true, args_override_self = true)]
struct PartLine {
    #[command(flatten)]
    bench: BenchArgs,
}

/// Runs all parts of a suite, one after the other, and writes their reports and that of the suite. A part that fails is
/// reported, and the others go on.
///
/// # Errors
/// The suite or one of its parts is invalid, which is found before anything is drawn; no GPU can be opened; a file cannot
/// be written; a part failed.
pub(super) fn run(name: &Path, args: &BenchArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    let output = &args.output;
    if output.exists() && !output.is_dir() {
        bail!("{}: is a file, and bench writes its report into a folder", named(output));
    }
    let [report_file, page] = [REPORT, PAGE].map(|name| output.join(name));
    unnamed::check(&report_file, args.overwrite, SuiteReport::is_own)?;
    unnamed::check(&page, args.overwrite, suite::is_page)?;
    let file = find(name, &output.join(INPUTS), args.overwrite)?;
    let suite = read(&file)?;
    let lines = suite.lines(&file, args)?;
    let mut planned = Vec::new();
    for (part, line) in &lines {
        planned.push(Planned::of(line).with_context(|| format!("{}: part {}", named(&file), part.name))?);
    }
    let mut planned = planned.into_iter();
    let gpu = open_gpu(adapter)?;
    let mut report = SuiteReport {
        suite: suite.title.clone(),
        about: suite.about.clone(),
        adapter: gpu.description(),
        is_software: gpu.is_software(),
        replaced: replaced(args),
        tables: Vec::new(),
    };
    let (count, mut number) = (lines.len(), 0);
    for table in &suite.tables {
        let parts = &table.parts;
        report.tables.push(table.report());
        for (part, planned) in parts.iter().zip(planned.by_ref()) {
            number += 1;
            standard::print_to_stderr(&format!("part {number} of {count}: {}", part.name));
            if let Some(table) = report.tables.last_mut() {
                add(table, part, parts.len() > 1, measured(planned, &gpu));
            }
            // The results so far are kept if a later part ends the program.
            report.write(&report_file, &page)?;
        }
    }
    if args.json {
        print_json(&report)?;
    } else {
        print(&format!("{}\n{}\nReport: {} (it explains the columns)", report.adapter, report.text(), named(&page)))?;
    }
    let failed: Vec<&str> = report.failed().collect();
    if !failed.is_empty() {
        bail!("{} of {count} benchmarks failed: {}; see {}", failed.len(), failed.join(", "), named(&page));
    }
    Ok(())
}

fn measured(planned: Planned<'_>, gpu: &Gpu) -> anyhow::Result<Report> {
    planned.bake()?;
    planned.measure(gpu)
}

/// Adds the result of a part to its table.
fn add(table: &mut TableReport, part: &Part, is_one_of_several: bool, report: anyhow::Result<Report>) {
    let (size_px, error) = match report {
        Ok(report) => {
            table.add(is_one_of_several.then_some(&part.name), &report);
            (Some(report.size_px), None)
        }
        Err(error) => {
            let error = format!("{error:#}");
            tracing::error!("{}: {error}", part.name);
            (None, Some(error))
        }
    };
    table.parts.push(PartReport { name: part.name.clone(), size_px, error });
}

/// Returns the file of a suite. A built-in suite is written to the folder `inputs`.
fn find(name: &Path, inputs: &Path, overwrite: bool) -> anyhow::Result<PathBuf> {
    // A folder may have the name of a built-in suite, such as the output of an earlier run.
    let is_built_in = SUITES.iter().any(|suite| Path::new(suite.name) == name);
    if name.is_dir() && (!is_built_in || name.join(SUITE_FILE).exists()) {
        return Ok(name.join(SUITE_FILE));
    }
    if name.is_file() && !is_built_in {
        return Ok(name.to_owned());
    }
    match SUITES.iter().find(|suite| Path::new(suite.name) == name) {
        Some(suite) => suite.write(inputs, overwrite),
        None => {
            let text = name.to_string_lossy();
            let names = SUITES.iter().map(|suite| suite.name);
            let meant = did_you_mean(&text, names.clone());
            let known = names.collect::<Vec<_>>().join(", ");
            bail!(Misuse(format!("--suite {}: there is no such suite or file{meant}; suites: {known}", quoted(&text))))
        }
    }
}

impl BuiltIn {
    /// Writes the files of the suite into a folder, and returns the path of the suite. Existing files must have the
    /// same text.
    fn write(&self, folder: &Path, overwrite: bool) -> anyhow::Result<PathBuf> {
        for (name, text) in self.files {
            let path = folder.join(name);
            let is_same = std::fs::read_to_string(&path).is_ok_and(|found| found == *text);
            if path.symlink_metadata().is_ok() && !is_same && !overwrite {
                bail!(
                    "{}: differs from the file of the built-in suite; to run your own, name its folder \
                     (--suite {}) and another output (-o)",
                    named(&path),
                    named(folder)
                );
            }
        }
        std::fs::create_dir_all(folder).with_context(|| format!("cannot create {}", named(folder)))?;
        for (name, text) in self.files {
            let path = folder.join(name);
            atomic::write(&path, text.as_bytes()).with_context(|| format!("cannot write {}", named(&path)))?;
        }
        Ok(folder.join(SUITE_FILE))
    }
}

/// Reads and checks a suite, without its parts' command lines.
fn read(file: &Path) -> anyhow::Result<SuiteFile> {
    let text = read_text(file, LARGEST_SCENE_BYTES).with_context(|| format!("cannot read {}", named(file)))?;
    let suite: SuiteFile = toml_text::read(&file.display().to_string(), &text)?;
    let parts: Vec<&Part> = suite.tables.iter().flat_map(|table| &table.parts).collect();
    if parts.is_empty() {
        bail!("{}: the suite has no parts", named(file));
    }
    for (index, part) in parts.iter().enumerate() {
        let is_name =
            !part.name.is_empty() && part.name.chars().all(|it| it.is_ascii_alphanumeric() || "-_".contains(it));
        if !is_name {
            let name = quoted(&part.name);
            bail!("{}: {name} cannot be the folder of a part: use letters, digits, - and _", named(file));
        }
        if part.name == INPUTS {
            bail!("{}: a part cannot be called {INPUTS}, which is the folder of the suite's own files", named(file));
        }
        // Some file systems do not distinguish capitals from small letters.
        if parts[..index].iter().any(|before| before.name.eq_ignore_ascii_case(&part.name)) {
            bail!("{}: two parts are called {}", named(file), part.name);
        }
    }
    for table in &suite.tables {
        let of_published = table.published.iter().map(|published| &published.quantity);
        for key in table.columns.iter().chain(of_published) {
            if !suite::keys().contains(&key.as_str()) {
                let meant = did_you_mean(key, suite::keys());
                let known = suite::keys().join(", ");
                bail!(
                    "{}: table {}: there is no column {}{meant}; columns: {known}",
                    named(file),
                    quoted(&table.title),
                    quoted(key)
                );
            }
        }
        for beginning in &table.passes {
            let is_known = |(name, _): &(&str, _)| name.starts_with(beginning.as_str()) || beginning.starts_with(name);
            if beginning.is_empty() || !SHADERS.iter().any(is_known) {
                let meant = did_you_mean(beginning, SHADERS.iter().map(|(name, _)| *name));
                bail!(
                    "{}: table {}: no pass has a name that begins with {}{meant}; report.json of a benchmark lists the \
                     passes of its styles",
                    named(file),
                    quoted(&table.title),
                    quoted(beginning)
                );
            }
        }
    }
    Ok(suite)
}

impl SuiteFile {
    /// Returns the parts with their arguments, in the order of the tables.
    fn lines(&self, file: &Path, args: &BenchArgs) -> anyhow::Result<Vec<(&Part, BenchArgs)>> {
        let folder = file.parent().unwrap_or(Path::new("."));
        let parts = self.tables.iter().flat_map(|table| &table.parts);
        parts.map(|part| Ok((part, part.line(folder, file, args)?))).collect()
    }
}

impl Table {
    /// Returns the table's report, without parts.
    fn report(&self) -> TableReport {
        TableReport {
            title: self.title.clone(),
            passes: self.passes.clone(),
            columns: self.columns.clone(),
            published: self.published.clone(),
            ..TableReport::default()
        }
    }
}

impl Part {
    /// Returns the arguments of the benchmark. `--size`, `--frames`, `--tile-memory` and `--steadiness-pairs` of the command line
    /// replace those of the part.
    fn line(&self, folder: &Path, file: &Path, args: &BenchArgs) -> anyhow::Result<BenchArgs> {
        let is_output = |word: &&String| word.starts_with("-o") || word.split('=').next() == Some("--output");
        if let Some(word) = self.bench.iter().find(is_output) {
            bail!("{}: part {}: {word}: the suite chooses the folder of a part", named(file), self.name);
        }
        let mut words: Vec<OsString> = self.bench.iter().map(|word| in_folder(folder, word)).collect();
        words.extend(["-o".into(), args.output.join(&self.name).into_os_string()]);
        words.extend(replaced(args).into_iter().map(OsString::from));
        words.extend(args.overwrite.then(|| "--overwrite".into()));
        let line = PartLine::try_parse_from(words).map_err(|error| {
            let cause = describe(&error, &self.bench, &PartLine::command());
            anyhow::anyhow!("{}: part {}: {cause}", named(file), self.name)
        })?;
        if line.bench.suite.is_some() {
            bail!("{}: part {}: a part of a suite cannot be a suite", named(file), self.name);
        }
        Ok(line.bench)
    }
}

/// Returns the options that replace those of all parts.
fn replaced(args: &BenchArgs) -> Vec<String> {
    let size = args.size.map(|[width, height]| format!("--size={width}x{height}"));
    let frames = args.frames.map(|frames| format!("--frames={frames}"));
    let memory = args.tile_memory.map(|mebibytes| format!("--tile-memory={mebibytes}"));
    let pairs = args.steadiness_pairs.map(|pairs| format!("--steadiness-pairs={pairs}"));
    [size, frames, memory, pairs].into_iter().flatten().collect()
}

/// Returns a word of a command line in which names of files and folders in the folder of the suite are replaced by
/// their paths: the whole word, the value of an option after `=`, or an entry of a list.
fn in_folder(folder: &Path, word: &str) -> OsString {
    let path = folder.join(word);
    if !word.is_empty() && path.exists() {
        return path.into_os_string();
    }
    if let Some((option, value)) = word.split_once('=').filter(|(option, _)| option.starts_with("--")) {
        let mut whole = OsString::from(format!("{option}="));
        whole.push(in_folder(folder, value));
        return whole;
    }
    let entries = word.split(',').map(|entry| match folder.join(entry) {
        path if !entry.is_empty() && path.is_file() => path.into_os_string(),
        _ => entry.into(),
    });
    entries.collect::<Vec<_>>().join(",".as_ref())
}

#[cfg(test)]
mod tests;
