//! What an installation adds to a shell: completions, manual pages and the line of `--version`.

use std::fs;
use std::io::Write as _;
use std::process::{Command, Output, Stdio};

use hachure::commands::misuse::COMMANDS;

use crate::Place;

/// Lets a program read `text` from standard input; `None` if the program is not installed.
fn reads(program: &str, arguments: &[&str], text: &str) -> Option<Output> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let Ok(mut child) = command.spawn() else {
        println!("skipped: {program} is not installed");
        return None;
    };
    // A program that stops at an error need not read the rest.
    let _ = child.stdin.take().unwrap().write_all(text.as_bytes());
    Some(child.wait_with_output().unwrap())
}

/// Returns whether a shell accepts a script, without running it.
fn accepts(shell: &str, script: &str) -> Option<bool> {
    reads(shell, if shell == "fish" { &["--no-execute"] } else { &["-n"] }, script)
        .map(|output| output.status.success())
}

#[test]
fn shells_accept_their_completions() {
    let place = Place::empty();
    for shell in ["bash", "zsh", "fish"] {
        let script = place.text(&["completions", shell]);
        for name in COMMANDS.into_iter().chain(["migrate", "tolerance-px", "height-scale"]) {
            assert!(script.contains(name), "{shell} does not complete {name}");
        }
        assert!(!script.contains("planted-option"));
        if let Some(is_accepted) = accepts(shell, &script) {
            assert!(is_accepted, "{shell}");
            // Planted: a script without its second half of lines, and with a quote that is not closed.
            let lines: Vec<&str> = script.lines().collect();
            let half = format!("{}\nif '", lines[..lines.len() / 2].join("\n"));
            assert_eq!(accepts(shell, &half), Some(false), "{shell}");
        }
    }
    for shell in ["elvish", "powershell"] {
        assert!(place.text(&["completions", shell]).contains("tolerance-px"), "{shell}");
    }
    let error = place.misuse(&["completions", "sh"]);
    assert!(error.contains("it must be one of bash, elvish, fish, powershell, zsh"), "{error}");
    place.misuse(&["completions"]);
}

/// Bash completes words by the script.
#[test]
fn bash_completes_commands_options_and_values() {
    let place = Place::empty();
    let script = place.text(&["completions", "bash"]);
    let completed = |words: &[&str]| {
        let mut line = script.clone();
        line += &format!("\nCOMP_WORDS=({})\nCOMP_CWORD={}\n", words.join(" "), words.len() - 1);
        let [.., before, last] = words else { panic!("a command and a word") };
        line += &format!("_hachure hachure '{last}' '{before}'\nprintf '%s\\n' \"${{COMPREPLY[@]}}\"\n");
        let output = reads("bash", &["--norc"], &line).unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    for (words, expected) in [
        (&["hachure", "comp"][..], "completions"),
        (&["hachure", "render", "--tol"], "--tolerance-px"),
        (&["hachure", "completions", "z"], "zsh"),
        (&["hachure", "styles", "migr"], "migrate"),
    ] {
        let found = completed(words);
        assert!(found.lines().any(|line| line == expected), "{words:?}: {found}");
    }
    assert_eq!(completed(&["hachure", "render", "--planted"]).trim(), "");
}

#[test]
fn manual_pages_are_written_and_only_own_ones_replaced() {
    let place = Place::empty();
    let printed = place.text(&["man"]);
    assert!(printed.contains("\n.SH NAME\nhachure \\- "), "{printed}");
    assert!(place.names().is_empty());

    let text = place.text(&["man", "share/man1"]);
    assert!(text.starts_with("share/man1: ") && text.ends_with(" manual pages\n"), "{text}");
    let page = |name: &str| place.path("share/man1").join(name);
    assert_eq!(fs::read_to_string(page("hachure.1")).unwrap(), printed);
    for name in COMMANDS {
        let text = fs::read_to_string(page(&format!("hachure-{name}.1"))).unwrap();
        assert!(text.contains(&format!("\n.SH NAME\nhachure\\-{name} \\- ")), "{text}");
        // groff, which `man` uses, warns of requests that it does not know.
        if let Some(output) = reads("groff", &["-man", "-Tutf8", "-ww", "-K", "utf8"], &text) {
            assert_eq!(String::from_utf8_lossy(&output.stderr), "", "{name}");
            assert!(String::from_utf8_lossy(&output.stdout).contains("success"), "{name}");
        }
    }
    // Own pages are replaced.
    place.text(&["man", "share/man1"]);
    // The page of somebody else is kept, and no other page is written.
    place.file("share/man1/hachure-render.1", ".TH MINE 1\n");
    fs::remove_file(page("hachure.1")).unwrap();
    let error = place.error(&["man", "share/man1"]);
    assert!(error.contains("hachure-render.1: this file exists, and hachure did not write it"), "{error}");
    assert!(!page("hachure.1").exists());
    assert_eq!(fs::read_to_string(page("hachure-render.1")).unwrap(), ".TH MINE 1\n");
    place.text(&["man", "share/man1", "--overwrite"]);
    assert!(fs::read_to_string(page("hachure-render.1")).unwrap().contains("hachure"));

    place.misuse(&["man", "--overwrite"]);
    place.file("taken", "");
    assert!(place.error(&["man", "taken"]).contains("taken"));
}

#[test]
fn the_version_has_a_commit_and_the_features() {
    let place = Place::empty();
    for option in ["--version", "-V"] {
        let text = place.text(&[option]);
        let rest = text.strip_prefix(concat!("hachure ", env!("CARGO_PKG_VERSION"), " (")).unwrap();
        let (commit, features) = rest.strip_suffix(")\n").unwrap().split_once("; ").unwrap();
        assert!(!commit.is_empty() && rest.lines().count() == 1, "{text}");
        let has = |name: &str| features.split([' ', ',']).any(|word| word == name);
        assert_eq!(has("window"), cfg!(feature = "window"), "{text}");
        assert_eq!(has("headset"), cfg!(feature = "headset"), "{text}");
        assert_eq!(has("network"), cfg!(feature = "network"), "{text}");
    }
}
