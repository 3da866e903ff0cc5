//! How light becomes tone and colour.

use serde::{Deserialize, Serialize, Serializer};
use toml_edit::{Item, Table};

use super::Color;
use super::parameters::{Definition, Range, Setting, Tree, ValueKind, choices, parameters};
use crate::file::toml_text::Wrong;

/// How light becomes colour.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase", tag = "kind")]
pub enum Tone {
    /// Blinn-Phong over an elevation tint.
    Plain(Plain),
    /// Steps.
    Toon(Toon),
}

choices! {
    /// The names of the variants of [`Tone`].
    enum ToneKind {
        /// Blinn-Phong shading over a tint of elevation; of the other keys it has `local_color` alone.
        Plain,
        /// Tones in steps, or smooth ones, in greys or colours.
        Toon,
    }
}

parameters! {
    /// Blinn-Phong over an elevation tint.
    pub struct Plain {
        /// How much trees and models have of their own colours; 0 is none, and they are coloured as land is.
        local_color: f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

parameters! {
    /// Steps of light.
    pub struct Toon {
        /// Number of steps; 0 is smooth.
        steps: u32 => Range::ZeroOr(2, 64);
        /// Tone of the darkest step.
        darkest: f32 => Range::Within(0.0, 1.0);
        /// Tone of the lightest step.
        lightest: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// How much of the tone is colour; marks can do the rest.
        wash: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Colours of the tones; without the section they are greys.
        ramp: Option<Ramp>;
        /// Part of a step in which it fades to the next.
        softness: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much trees and models have of their own colours; 0 is none, and they are coloured as land is.
        local_color: f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

parameters! {
    /// Colours by tone and by something else of the place (X-toon: Barla, Thollot and Markosian 2006).
    pub struct Ramp {
        /// What colours go by, beside the tone.
        by: Attribute = Attribute::Height;
        /// Colours at values of the attribute, which rise from stop to stop; in between they are mixed.
        stops: Vec<Stop> => Range::Entries(1, 16);
    }
}

choices! {
    /// What a ramp goes by, beside the tone.
    pub enum Attribute {
        /// The height: 0 at the lowest place of the land, 1 at the highest.
        Height,
        /// The slope in degrees.
        Slope,
        /// The distance from the eye in metres.
        Distance,
    }
}

parameters! {
    /// Colours at a value of the attribute.
    pub struct Stop, listed rises {
        /// Value of the attribute.
        at: f32 => Range::Within(-1e9, 1e9);
        /// From the darkest tone to the lightest, at even distances.
        colors: Vec<Color> => Range::Entries(1, 16);
    }
}

parameters! {
    /// Tones that run and settle as water and pigment do (Bousseau, Kaplan, Thollot and Sillion 2006).
    pub struct Watercolor {
        /// How much darker pigment is where a wash ends.
        edge: f32 = 1.2 => Range::Within(0.0, 4.0);
        /// Width of that edge.
        edge_px: f32 = 3.0 => Range::Within(1.0, 16.0);
        /// How much pigment settles in the valleys of the paper.
        granulation: f32 = 0.5 => Range::Within(0.0, 2.0);
        /// How unevenly water carries pigment.
        flow: f32 = 0.6 => Range::Within(0.0, 2.0);
        /// How far washes stray from what they fill.
        warp_px: f32 = 5.0 => Range::Within(0.0, 32.0);
    }
}

parameters! {
    /// How light falls.
    pub struct Shading {
        /// How far light reaches around; 0 is Lambert's cosine, and 1 keeps form in the shade.
        wrap: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// What is left where the sun does not shine.
        ambient: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much of the sun cast shadows take.
        shadow: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much of the ambient light the land around takes.
        occlusion: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much of the darkness comes from the slope itself, of which 45° are black.
        slope: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Light falls on the land's form at this scale, and not on each of its samples; 0 is the land as it is.
        form_px: f32 = 0.0 => Range::Within(0.0, 256.0);
        /// How much of the land's own slopes light falls on beside its form.
        detail: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How far light turns where a ridge of that form runs along it.
        turn_deg: f32 = 0.0 => Range::Within(0.0, 60.0);
        /// How much lighter crests are and how much darker hollows, by how the land bends.
        crests: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Size of what is a crest or a hollow.
        crests_px: f32 = 12.0 => Range::Within(1.0, 256.0);
        /// Land that slopes less is paper; from four times that on it has all of its tone.
        level_deg: f32 = 0.0 => Range::Within(0.0, 20.0);
        /// What light is multiplied by; above 1 more of the land is white.
        exposure: f32 = 1.0 => Range::Within(0.25, 4.0);
        /// Exponent of the tone; above 1 it is darker.
        contrast: f32 = 1.0 => Range::Within(0.2, 5.0);
    }
}

/// That the stops of a ramp rise.
fn rises(stops: &[Stop], key: &str) -> Result<(), Wrong> {
    for pair in stops.windows(2) {
        let [from, to] = [pair[0].at, pair[1].at];
        if !(to > from && to - from < f32::INFINITY) {
            return Err(Wrong::new(key, format!(" must rise, and do not from {from} to {to}")));
        }
    }
    Ok(())
}

impl Tone {
    /// How much trees and models have of their own colours.
    pub fn local_color(&self) -> f32 {
        match self {
            Self::Plain(plain) => plain.local_color,
            Self::Toon(toon) => toon.local_color,
        }
    }

    /// Whether tones are colours of the picture, and not for marks alone.
    pub fn is_seen(&self) -> bool {
        match self {
            Self::Plain(_) => true,
            Self::Toon(toon) => toon.wash > 0.0,
        }
    }

    /// The name of its kind, as a style file has it.
    pub fn name(&self) -> String {
        self.kind_and_keys().0.name()
    }

    /// Its kind, and the keys of that kind.
    fn kind_and_keys(&self) -> (ToneKind, Option<Item>) {
        match self {
            Self::Plain(plain) => (ToneKind::Plain, plain.item()),
            Self::Toon(toon) => (ToneKind::Toon, toon.item()),
        }
    }
}

impl Setting for Tone {
    fn kind() -> ValueKind {
        let help = "How the tone of a place becomes its colour.";
        let mut all = vec![Definition::of::<ToneKind>("kind", help, &[], Range::Any, None)];
        for keys in [Toon::kind()] {
            if let ValueKind::Section(keys) = keys {
                all.extend(keys);
            }
        }
        ValueKind::Section(all)
    }

    fn check(&self, key: &str, range: &Range) -> Result<(), Wrong> {
        match self {
            Self::Plain(plain) => plain.check(key, range),
            Self::Toon(toon) => toon.check(key, range),
        }
    }

    fn item(&self) -> Option<Item> {
        let (kind, rest) = self.kind_and_keys();
        let mut table = Table::new();
        table.insert("kind", kind.item()?);
        table.extend(rest.and_then(|rest| rest.into_table().ok()).into_iter().flatten());
        Some(Item::Table(table))
    }
}

impl Serialize for Tone {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Tree(self.item().as_ref()).serialize(serializer)
    }
}
