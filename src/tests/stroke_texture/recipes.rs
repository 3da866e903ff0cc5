//! Tests recipes and the styles that name them.

use hachure::style::texture::Recipe;
use hachure::style::{Style, StyleError, preset_text};

use crate::tests::stroke_texture::{RECIPE, recipe};

#[test]
fn mistakes_give_an_error_of_one_line() {
    let spoil = |from: &str, to: &str| {
        assert!(RECIPE.contains(from), "{from}");
        RECIPE.replacen(from, to, 1)
    };
    let spoiled = [
        (spoil("fill = 1.0", "fil = 1.0"), "mine.toml:12:1: unknown key \"touch.fil\"; did you mean \"fill\"?"),
        (spoil("seed = 7\n", ""), "the key \"tile.seed\" is missing"),
        (spoil("fill = 1.0", "fill = 1.5"), "touch.fill is 1.5, not between 0.05 and 1"),
        (spoil("softness = 0.1", "softness = 0.0"), "touch.softness is 0,"),
        (spoil("response = 1.0", "response = nan"), "touch.response is NaN"),
        (spoil("along_px = 128", "along_px = 100"), "tile.along_px is 100, not a power of two from 64 to 2048"),
        (spoil("along_px = 128", "along_px = -1"), ":4:"),
        (spoil("weight = 0.5", "weight = -0.5"), "marks.weight is -0.5"),
        (spoil("along_px = 12.3", "along_px = 1e9"), "marks.along_px is 1000000000"),
        (RECIPE.split("[[marks]]").next().unwrap().to_owned() + "marks = []", "mine.toml:"),
        ("[".to_owned(), ":1:"),
    ];
    for (text, cause) in spoiled {
        let error = Recipe::parse("mine.toml", &text).unwrap_err().to_string();
        assert!(error.starts_with("mine.toml:") && error.contains(cause), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    assert!(Recipe::parse("mine.toml", RECIPE).is_ok());
}

#[test]
fn a_style_names_a_texture_or_a_file_next_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let style = |texture: &str| {
        let text = preset_text("charcoal").unwrap().replace("\"charcoal\"\nwidth", &format!("\"{texture}\"\nwidth"));
        assert!(text.contains(texture));
        let path = folder.path().join("style.toml");
        hachure::file::atomic::write(&path, text.as_bytes()).unwrap();
        Style::load(path.to_str().unwrap()).map(|style| style.strokes().unwrap().texture.clone().unwrap())
    };
    assert_eq!(style("pencil").unwrap(), recipe("pencil"));
    hachure::file::atomic::write(&folder.path().join("mine.toml"), RECIPE.as_bytes()).unwrap();
    assert_eq!(style("mine.toml").unwrap(), Recipe::parse("test", RECIPE).unwrap());
    // The message has the texture's own name, after the position and the key in the style that name it.
    let error = style("crayon").unwrap_err();
    assert!(
        matches!(&error, StyleError::Named { source, .. } if matches!(**source, StyleError::UnknownTexture { .. }))
    );
    let expected = format!(
        "{}:45:11: strokes.texture: crayon: no such stroke texture; ",
        folder.path().join("style.toml").display()
    );
    assert!(error.to_string().starts_with(&expected), "{error}");
    assert!(style("nowhere.toml").unwrap_err().to_string().contains("nowhere.toml: cannot read the stroke texture: "));
    hachure::file::atomic::write(&folder.path().join("broken.toml"), b"tile = 3").unwrap();
    let error = style("broken.toml").unwrap_err().to_string();
    assert!(error.contains("broken.toml:1:") && error.lines().count() == 1, "{error}");
    assert!(Style::load("strokes").unwrap().strokes().unwrap().texture.is_none());
}
