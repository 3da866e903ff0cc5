//! Tests suites of benchmarks.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::super::PARTS_ONLY;
use super::*;
use crate::tests::common::full;

/// Presets whose marks take seconds to make if they are not in the cache; the fast tier does without these presets.
const WITH_OTHER_MARKS: [&str; 5] = ["pencil", "stipple", "engraving", "woodcut", "charcoal"];

fn args(words: &[&str]) -> BenchArgs {
    PartLine::try_parse_from(words).unwrap().bench
}

#[test]
fn every_built_in_suite_is_understood() {
    for suite in &SUITES {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().to_str().unwrap().to_owned();
        let file = find(Path::new(suite.name), &folder.path().join(INPUTS), false).unwrap();
        // Written again, it is the same; a file of somebody else is kept.
        find(Path::new(suite.name), &folder.path().join(INPUTS), false).unwrap();
        let args = args(&["--suite", suite.name, "-o", &output, "--size", "64x36"]);
        let read = read(&file).unwrap();
        let mut lines = read.lines(&file, &args).unwrap();
        for (part, line) in &mut lines {
            line.styles.retain(|style| full() || !WITH_OTHER_MARKS.contains(&style.as_str()));
            Planned::of(line).unwrap_or_else(|error| panic!("{}: {}: {error:#}", suite.name, part.name));
            assert_eq!(line.size, Some([64, 36]));
        }
        atomic::write(&file, b"title = 1").unwrap();
        assert!(suite.write(&folder.path().join(INPUTS), false).is_err());
        // Planted: a part with an option that does not exist.
        let part = Part { bench: vec!["--stiles".to_owned()], ..lines[0].0.clone() };
        let error = part.line(folder.path(), &file, &args).unwrap_err().to_string();
        assert!(error.contains("--stiles") && error.contains(&part.name), "{error}");
    }
}

#[test]
fn every_option_is_that_of_the_suite_or_of_its_parts() {
    const OF_SUITE: [&str; 10] = [
        "adapter",
        "suite",
        "size",
        "frames",
        "tile_memory",
        "steadiness_pairs",
        "output",
        "overwrite",
        "json",
        "help",
    ];
    let mut command = PartLine::command();
    command.build();
    for option in command.get_arguments().map(|argument| argument.get_id().as_str()) {
        let owners = [&OF_SUITE[..], &PARTS_ONLY[..]].map(|options| options.contains(&option));
        assert!(owners[0] != owners[1], "{option}: {owners:?}");
    }
}

#[test]
fn a_wrong_suite_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("own.toml");
    let begin = "title = \"t\"\nabout = \"\"\n[[tables]]\ntitle = \"a table\"\n";
    let part = "[[tables.parts]]\nname = \"a\"\nbench = []\n";
    for (text, cause) in [
        ("title = 1".to_owned(), ":1:9: title must be text"),
        ("title = \"t\"\nabout = \"\"\ntables = []".to_owned(), "no parts"),
        (format!("{begin}{}", part.replace("\"a\"", "\"../a\"")), "cannot be the folder"),
        (format!("{begin}{part}{part}"), "two parts are called a"),
        (format!("{begin}{part}speed = 1\n"), "speed"),
        (format!("{begin}columns = [\"gpu_mb\"]\n{part}"), "gpu_ms"),
        (format!("{begin}passes = [\"lines/sobl\"]\n{part}"), "did you mean \"lines/sobel\""),
        (format!("{begin}passes = [\"\"]\n{part}"), "no pass has a name"),
    ] {
        atomic::write(&file, text.as_bytes()).unwrap();
        let error = read(&file).unwrap_err().to_string();
        assert!(error.contains("own.toml") && error.contains(cause) && !error.contains('\n'), "{text}: {error}");
    }
    let error = find(Path::new("pietrock"), folder.path(), false).unwrap_err().to_string();
    assert!(error.contains("pietrok") && error.contains("forest"), "{error}");
}

#[test]
fn words_are_paths_if_there_is_such_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["my,land.tif", "own.toml"] {
        atomic::write(&path(name), b"").unwrap();
    }
    std::fs::create_dir(path("tiles")).unwrap();
    let word = |word: &str| in_folder(folder.path(), word);
    assert_eq!(word("my,land.tif"), path("my,land.tif"));
    assert_eq!(word("tiles"), path("tiles"));
    let styles = format!("plain,{}", path("own.toml").display());
    assert_eq!(word("plain,own.toml"), *styles);
    assert_eq!(word("--styles=plain,own.toml"), *format!("--styles={styles}"));
    // Planted: words that do not name files stay as they are.
    for other in ["--sweep", "scale=0.5,1", "", "other.toml", "plain,tiles"] {
        assert_eq!(word(other), *other);
    }
}

#[test]
fn a_folder_with_the_name_of_a_suite_is_not_the_suite() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("relief");
    std::fs::create_dir(&own).unwrap();
    // As the name of a path it is a folder without a suite.
    assert_eq!(find(&own, folder.path(), false).unwrap(), own.join(SUITE_FILE));
    // The edited file of a built-in suite is not replaced.
    let inputs = folder.path().join(INPUTS);
    let file = find(Path::new("relief"), &inputs, false).unwrap();
    atomic::write(&file, b"title = 1").unwrap();
    let error = find(Path::new("relief"), &inputs, false).unwrap_err().to_string();
    assert!(error.contains("differs") && error.contains("suite.toml"), "{error}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "title = 1");
    find(Path::new("relief"), &inputs, true).unwrap();
}

#[test]
fn a_part_that_fails_is_in_the_report() {
    let part = Part { name: "low".to_owned(), bench: Vec::new() };
    let mut table = TableReport::default();
    add(&mut table, &part, false, Err(anyhow::anyhow!("cause").context("failed")));
    assert_eq!(table.parts[0].error.as_deref(), Some("failed: cause"));
    let report = SuiteReport { tables: vec![table], ..SuiteReport::default() };
    assert_eq!(report.failed().collect::<Vec<_>>(), ["low"]);
}
