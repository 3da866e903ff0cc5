//! Styles that the fast tier of the tests draws in less time.

use hachure::style::Style;

use crate::tests::common::full;

/// Returns a style for a test of the surface or of its outlines. In the fast tier it has no other lines of the land:
/// maps of the water in tiles alone take longer than a small picture.
pub fn of_outlines(style: Style) -> Style {
    if full() { style } else { style.without(&["height_lines", "drainage", "ground", "water"]) }
}
