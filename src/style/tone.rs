//! The `[tone]`, `[light]` and `[watercolor]` sections of a style: how light becomes tone and colour.

use serde::{Deserialize, Serialize, Serializer};
use toml_edit::{Item, Table};

use super::Color;
use super::parameters::{Definition, Range, Setting, Tree, ValueKind, choices, parameters};
use crate::file::toml_text::Wrong;

/// How light becomes tone and colour.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase", tag = "kind")]
pub enum Tone {
    /// Blinn-Phong shading over an elevation tint.
    Plain(Plain),
    /// Tones in steps, or smooth ones.
    Toon(Toon),
}

choices! {
    /// Names of the variants of [`Tone`].
    enum ToneKind {
        /// Blinn-Phong shading over an elevation tint; the only other key is `local_color`.
        Plain,
        /// Tones in steps or smooth, in greys or colours.
        Toon,
    }
}

parameters! {
    /// Blinn-Phong shading over an elevation tint.
    pub struct Plain {
        /// How much trees and models show their own colours; 0 colours them like the land.
        local_color called "Local colour": f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

parameters! {
    /// Tones in steps, or smooth ones.
    pub struct Toon {
        /// Number of tone steps; 0 gives a smooth tone.
        steps called "Tone steps": u32 => Range::ZeroOr(2, 64), zero "smooth";
        /// Tone of the darkest step.
        darkest called "Darkest tone": f32 => Range::Within(0.0, 1.0);
        /// Tone of the lightest step.
        lightest called "Lightest tone": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// How much of the tone is drawn as colour; hatching can draw the rest.
        wash called "Drawn as colour": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Colours of the tones; without this section tones are grey.
        ramp: Option<Ramp>;
        /// Fraction of a step in which it blends into the next.
        softness called "Softness of steps": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Light and dark areas that cover less of the picture are merged into the land around them; 0 keeps all. Needs `steps`.
        smallest_share called "Smallest mass": f32 = 0.0 => Range::Within(0.0, 0.1), zero "all";
        /// How much trees and models show their own colours; 0 colours them like the land.
        local_color called "Local colour": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Whether tones are spread until the shares of the land in view below are light and dark.
        fit called "Fit to picture": bool = false;
        /// Share of the land in view that is left as paper; of stepped tones, the share of the lightest step. Needs `fit`.
        white_share called "Share of paper": f32 = 0.25 => Range::Within(0.0, 0.6);
        /// Share of the land in view that is dark; of stepped tones, the share of the darkest step. Needs `fit`.
        dark_share called "Share of darks": f32 = 0.05 => Range::Within(0.0, 0.4);
        /// Share of its darkness that land loses where it is a quarter as far as the middle of the view. Needs `fit`.
        recede called "Lighter foreground": f32 = 0.33 => Range::Within(0.0, 1.0);
        /// Ink that tints near land, strongest where it is a quarter as far as the middle of the view. Needs `fit`.
        foreground_color called "Foreground colour": Color = Color::default();
        /// How strongly near land is tinted; 0 does not tint it.
        foreground_tint called "Foreground tint": f32 = 0.0 => Range::Within(0.0, 1.0), zero "none";
    }
}

parameters! {
    /// Colours by tone and by one attribute of the surface (X-toon: Barla, Thollot and Markosian 2006).
    pub struct Ramp {
        /// Attribute that selects the colour, in addition to the tone.
        by called "Colour by": Attribute = Attribute::Height;
        /// Colours at increasing values of the attribute; between two stops colours are interpolated.
        stops: Vec<Stop> => Range::Entries(1, 16);
    }
}

choices! {
    /// Attribute that selects the colour of a ramp, in addition to the tone.
    pub enum Attribute {
        /// The height: 0 at the lowest point of the terrain, 1 at the highest.
        Height,
        /// The slope in degrees.
        Slope,
        /// The distance from the eye in metres.
        Distance,
    }
}

parameters! {
    /// Colours at one value of the attribute.
    pub struct Stop, listed rises {
        /// Value of the attribute.
        at called "At value": f32 => Range::Within(-1e9, 1e9);
        /// Evenly spaced colours from the darkest tone to the lightest.
        colors called "Colours": Vec<Color> => Range::Entries(1, 16);
    }
}

parameters! {
    /// Tones that look like watercolour (Bousseau, Kaplan, Thollot and Sillion 2006).
    pub struct Watercolor {
        /// How much darker the pigment is at the edge of a wash.
        edge called "Edge darkening": f32 = 1.2 => Range::Within(0.0, 4.0);
        /// Width of the dark edge of a wash.
        edge_px called "Edge width": f32 = 3.0 => Range::Within(1.0, 16.0);
        /// How much pigment settles in the hollows of the paper's texture.
        granulation: f32 = 0.5 => Range::Within(0.0, 2.0);
        /// How unevenly water distributes the pigment.
        flow called "Uneven flow": f32 = 0.6 => Range::Within(0.0, 2.0);
        /// How far washes stray from the area that they fill.
        warp_px called "Straying of washes": f32 = 5.0 => Range::Within(0.0, 32.0);
    }
}

parameters! {
    /// How the land is lit.
    pub struct Shading {
        /// How far light wraps around the surface; 0 is Lambert's cosine law, 1 keeps shape visible in the shade.
        wrap called "Wrap of light": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Ambient light: the brightness where the sun does not shine.
        ambient called "Ambient light": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strength of cast shadows; at 1 they remove all sunlight.
        shadow called "Cast shadows": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Strength of ambient occlusion by the surrounding land.
        occlusion called "Ambient occlusion": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// How much of the darkness comes from the slope alone, independent of light; a slope of 45° is black.
        slope called "Darkness by slope": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// The land is smoothed to this size before it is lit; 0 lights it unsmoothed.
        form_px called "Smoothing of land": f32 = 0.0 => Range::Within(0.0, 256.0), zero "none";
        /// Size of the slopes that are drawn together into planes which meet at ridges; 0 draws none. Needs `form_px`.
        planes_px called "Size of planes": f32 = 0.0 => Range::Within(0.0, 512.0), zero "none";
        /// How much of the unsmoothed slopes is mixed into the light on smoothed land.
        detail called "Unsmoothed detail": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Largest rotation of the light where a ridge runs parallel to it.
        turn_deg called "Turn along ridges": f32 = 0.0 => Range::Within(0.0, 60.0);
        /// How much lighter crests and darker hollows become, by the curvature of the land.
        crests called "Crest contrast": f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Size of the crests and hollows that `crests` acts on.
        crests_px called "Crest size": f32 = 12.0 => Range::Within(1.0, 256.0);
        /// Gentler slopes stay white as paper; from four times this slope on the tone is complete.
        level_deg called "White below slope": f32 = 0.0 => Range::Within(0.0, 20.0);
        /// Factor of the light; above 1 more of the land is white.
        exposure: f32 = 1.0 => Range::Within(0.25, 4.0);
        /// Exponent of the tone; above 1 tones are darker.
        contrast: f32 = 1.0 => Range::Within(0.2, 5.0);
    }
}

/// Checks that the values of the stops of a ramp increase.
fn rises(stops: &[Stop], key: &str) -> Result<(), Wrong> {
    for pair in stops.windows(2) {
        let [from, to] = [pair[0].at, pair[1].at];
        if !(to > from && to - from < f32::INFINITY) {
            return Err(Wrong::new(key, format!(" must increase, but {from} is followed by {to}")));
        }
    }
    Ok(())
}

impl Tone {
    /// Returns whether the tones follow `[light]`, with its shadows, form, crests and occlusion, and `[relief]`.
    pub(crate) fn uses_light(&self) -> bool {
        match self {
            Self::Plain(_) => false,
            Self::Toon(_) => true,
        }
    }

    /// Returns how much trees and models show their own colours, 0 to 1.
    pub(crate) fn local_color(&self) -> f32 {
        match self {
            Self::Plain(plain) => plain.local_color,
            Self::Toon(toon) => toon.local_color,
        }
    }

    /// Returns whether tones are drawn as colours, and are not only input of the hatching.
    pub(crate) fn is_seen(&self) -> bool {
        match self {
            Self::Plain(_) => true,
            Self::Toon(toon) => toon.wash > 0.0,
        }
    }

    /// Returns the name of the kind, as written in a style file.
    pub(crate) fn name(&self) -> String {
        self.kind_and_keys().0.name()
    }

    /// Returns the kind, and the keys of that kind as a TOML table.
    fn kind_and_keys(&self) -> (ToneKind, Option<Item>) {
        match self {
            Self::Plain(plain) => (ToneKind::Plain, plain.item()),
            Self::Toon(toon) => (ToneKind::Toon, toon.item()),
        }
    }
}

impl Setting for Tone {
    fn kind() -> ValueKind {
        let help = "Method that turns light into tone and colour.";
        let mut all =
            vec![Definition::of::<ToneKind>("kind", help, &[], Range::Any, None).with_label(&["Kind of tone"])];
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
