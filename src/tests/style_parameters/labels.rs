//! Tests the labels of parameters, and the words for the value 0, over all definitions.

use std::collections::BTreeSet;

use hachure::style::parameters::{Definition, Setting, parameters_of};
use hachure::style::{Style, marks, texture};

/// The most words of a label.
const MOST_WORDS: usize = 4;
/// Clauses of help that say that 0 stands for something else than a number.
const ZERO_CLAUSES: [&str; 8] = [
    "0 is none",
    "0 is not at all",
    "0 is no limit",
    "0 draws none",
    "0 draws solid",
    "0 turns",
    "0 keeps all",
    "0 chooses",
];

/// Returns what is wrong with the labels of a section, and with the words for 0.
fn mistakes(section: &str, definitions: &[Definition]) -> Vec<String> {
    let mut seen = BTreeSet::new();
    let mut mistakes = Vec::new();
    for definition in definitions {
        let label = definition.label();
        let mut note = |what: &str| mistakes.push(format!("{section} {}: \"{label}\" {what}", definition.key));
        let words = label.split_whitespace().count();
        if !(1..=MOST_WORDS).contains(&words) {
            note("has too many words");
        }
        if label.contains('_') || !label.starts_with(char::is_uppercase) {
            note("is no sentence case");
        }
        if !seen.insert(label.to_lowercase()) {
            note("is the label of two parameters");
        }
        let says_zero = ZERO_CLAUSES.iter().any(|clause| definition.help.contains(clause));
        let allows_zero = definition.range.ends()[0].is_none_or(|low| low <= 0.0);
        match definition.zero_word {
            None if says_zero => note("has no word for 0"),
            Some(_) if !definition.help.contains("0 ") || !allows_zero => note("has a word for 0 without help"),
            _ => {}
        }
    }
    mistakes
}

/// Returns the sections of styles and recipes: their keys, and the definitions of their values.
fn sections() -> Vec<(String, Vec<Definition>)> {
    let mut sections = Vec::new();
    for (name, kind) in
        [("style", Style::kind()), ("marks", marks::Recipe::kind()), ("texture", texture::Recipe::kind())]
    {
        sections.push((name.to_owned(), Vec::new()));
        for parameter in parameters_of(&kind, None) {
            match parameter.definition.section() {
                Some(_) => sections.push((format!("{name}: {}", parameter.key), Vec::new())),
                None => sections.last_mut().unwrap().1.push(parameter.definition),
            }
        }
    }
    sections
}

#[test]
fn every_label_is_unique_and_short() {
    let sections = sections();
    let found: Vec<String> =
        sections.iter().flat_map(|(section, definitions)| mistakes(section, definitions)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    let count: usize = sections.iter().map(|(_, definitions)| definitions.len()).sum();
    let zero_words = sections.iter().flat_map(|(_, all)| all).filter(|definition| definition.zero_word.is_some());
    assert!(count > 200 && zero_words.count() > 20, "{count} parameters");
    let of_style: Vec<Definition> = parameters_of(&Style::kind(), None)
        .into_iter()
        .map(|parameter| parameter.definition)
        .filter(|definition| definition.section().is_some())
        .collect();
    let found = mistakes("sections", &of_style);
    assert!(found.is_empty(), "{}", found.join("\n"));

    // Planted: each mistake is found.
    let (_, strokes) = sections.iter().find(|(section, _)| section == "style: strokes").unwrap();
    let with = |key: &str, change: &dyn Fn(Definition) -> Definition| {
        let planted = strokes.iter().map(|known| if known.key == key { change(known.clone()) } else { known.clone() });
        mistakes("strokes", &planted.collect::<Vec<_>>())
    };
    for (change, words) in [
        (&(|known: Definition| known.with_label(&["Width"])) as &dyn Fn(Definition) -> Definition, "two parameters"),
        (&|known| known.with_label(&["One two three four five"]), "too many words"),
        (&|known| known.with_label(&["curve_width"]), "sentence case"),
        (&|known| known.with_zero_word(&["none"]), "without help"),
    ] {
        let found = with("resolution", change);
        assert!(found.len() == 1 && found[0].contains(words), "{words}: {found:?}");
    }
    let found = with("slender", &|known| Definition { zero_word: None, ..known });
    assert!(found.len() == 1 && found[0].contains("no word for 0"), "{found:?}");
}
