//! Families of styles, by which lists of styles are grouped.

/// A family of styles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Family {
    /// Styles of the user.
    Own,
    /// Drawings of lines.
    Line,
    /// Tones drawn as marks.
    Hatching,
    /// Drawings of maps and panoramas.
    Map,
    /// Drawings in colours.
    Color,
    /// Baselines of comparisons.
    Baseline,
}

impl Family {
    pub(crate) const ALL: [Self; 6] = [Self::Own, Self::Line, Self::Hatching, Self::Map, Self::Color, Self::Baseline];

    /// Returns the heading of the family in a list.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Own => "Own styles",
            Self::Line => "Lines",
            Self::Hatching => "Hatching",
            Self::Map => "Maps",
            Self::Color => "Colour",
            Self::Baseline => "Baselines",
        }
    }

    /// Returns the presets of the family.
    fn presets(self) -> &'static [&'static str] {
        match self {
            Self::Own => &[],
            Self::Line => &["ink", "pen", "brush", "pencil-lines", "suggestive", "tone-lines"],
            Self::Hatching => &[
                "crosshatch",
                "crosshatch-curvature",
                "pencil",
                "stipple",
                "engraving",
                "woodcut",
                "charcoal",
                "dry-ink",
            ],
            Self::Map => &["hachures", "rock", "relief", "panorama"],
            Self::Color => {
                &["wash", "hokusai", "night", "orange", "orange-curvature", "cartoon", "green", "green-curvature"]
            }
            Self::Baseline => &["plain", "strokes", "lsa", "lsa-base", "lsa-full", "sobel", "roystan"],
        }
    }

    /// Returns the family of a preset, or of a style file.
    pub(crate) fn of(name: &str) -> Self {
        Self::ALL.into_iter().find(|family| family.presets().contains(&name)).unwrap_or(Self::Own)
    }

    /// Returns the place of a style within its family; styles of the user keep the order of the list.
    pub(crate) fn place(self, name: &str) -> usize {
        self.presets().iter().position(|known| *known == name).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::names;

    #[test]
    fn every_preset_has_one_family() {
        for name in names() {
            let count = Family::ALL.iter().filter(|family| family.presets().contains(&name)).count();
            assert_eq!(count, 1, "{name}");
        }
        let all: usize = Family::ALL.iter().map(|family| family.presets().len()).sum();
        assert_eq!(all, names().len());
        assert_eq!([Family::of("roystan"), Family::of("mine.toml")], [Family::Baseline, Family::Own]);
    }
}
