//! Five controls that every style has: density, weight, contrast, softness and warmth. Each drives several parameters.
//!
//! [`RULES`] is the list of these parameters, and states for each how it follows the control. A position is a whole
//! number from −100 to 100; at 0 every parameter has the value of the style as it is saved. Between 0 and an end a
//! parameter moves from its value to the end of its rule, which is clamped to the range of the parameter, so it never
//! stops before the control does. A style file has no key for controls: it gets the values of the parameters, and
//! [`position`] finds the position that they have come from.

use toml_edit::{Array, Value};

use super::parameters::{Definition, shortest};
use super::{Color, Style, Tone};

/// One of the five controls of a style: a rule that changes several parameters together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Control {
    /// How many lines and marks there are.
    Density,
    /// How bold lines and marks are.
    Weight,
    /// How far apart light and dark tones are.
    Contrast,
    /// How soft the borders of tones and marks are.
    Softness,
    /// How warm the paper and the inks are.
    Warmth,
}

/// The ends of a control's positions, which are −`END` and `END`.
pub(crate) const END: i8 = 100;

impl Control {
    pub(crate) const ALL: [Self; 5] = [Self::Density, Self::Weight, Self::Contrast, Self::Softness, Self::Warmth];

    /// Returns the name of the control.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Density => "Density",
            Self::Weight => "Weight",
            Self::Contrast => "Contrast",
            Self::Softness => "Softness",
            Self::Warmth => "Warmth",
        }
    }

    /// Returns one sentence of help.
    pub(crate) fn help(self) -> &'static str {
        match self {
            Self::Density => "How many lines and marks the drawing has.",
            Self::Weight => "How bold lines and marks are.",
            Self::Contrast => "How far light and dark tones are apart.",
            Self::Softness => "How soft the borders of tones and marks are.",
            Self::Warmth => "How warm the colours of paper and inks are; negative values are cool.",
        }
    }

    /// Returns why the control does nothing in a style; `None` if it does something.
    pub(crate) fn without_effect(self, style: &Style) -> Option<&'static str> {
        let has_tones = matches!(style.tone, Tone::Toon(_));
        let draws =
            style.layers.iter().any(|layer| !matches!(layer.kind(), "water" | "height_lines" | "drainage" | "rims"));
        match self {
            Self::Density | Self::Weight if !draws => Some(
                "This style has no layer of lines or marks, apart from shores, streams and contour lines of height.",
            ),
            Self::Contrast if !has_tones => Some("Only tones of the kind toon have contrast."),
            Self::Softness if !has_tones => Some("Only tones of the kind toon can be softened."),
            _ => None,
        }
    }
}

/// How a parameter follows a control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Follow {
    /// A number, or both of a pair, is multiplied by this at the upper end and divided by it at the lower end.
    Times(f32),
    /// This is added to a number at the upper end and subtracted from it at the lower end.
    Plus(f32),
    /// The differences in brightness between the colours of a list are multiplied by this at the upper end and divided
    /// by it at the lower end.
    Spread(f32),
    /// A colour becomes warmer at the upper end and cooler at the lower end, by this much.
    Warm(f32),
}

/// A parameter that follows a control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rule {
    pub control: Control,
    /// Key of the parameter without indices: it means this parameter of every layer of the kind, and of every entry of
    /// a list.
    pub key: &'static str,
    pub follow: Follow,
    /// Whether the position of the control is read from this parameter. Parameters that several controls drive are not
    /// read.
    pub is_read: bool,
}

/// A rule for a parameter that no other control drives.
const fn rule(control: Control, key: &'static str, follow: Follow) -> Rule {
    Rule { control, key, follow, is_read: true }
}

/// A rule for a parameter that another control also drives.
const fn shared(control: Control, key: &'static str, follow: Follow) -> Rule {
    Rule { control, key, follow, is_read: false }
}

use Control::{Contrast, Density, Softness, Warmth, Weight};
use Follow::{Plus, Spread, Times, Warm};

/// The parameters that follow each control.
pub(crate) const RULES: &[Rule] = &[
    // More strokes: a larger share of the area, shorter strokes too, and fainter suggestive contours and ridges.
    shared(Density, "strokes.crowd", Times(2.4)),
    rule(Density, "strokes.shortest_px", Times(0.45)),
    rule(Density, "strokes.shortest_interior_px", Times(0.45)),
    rule(Density, "strokes.suggestive_rise", Times(0.45)),
    rule(Density, "strokes.ridge_bend", Times(0.55)),
    rule(Density, "lines.crowd", Times(2.2)),
    rule(Density, "lines.density", Times(0.5)),
    rule(Density, "curvature.rise", Times(0.5)),
    rule(Density, "tone_lines.dark_ramp", Times(0.55)),
    rule(Density, "tone_lines.highlight_ramp", Times(0.55)),
    rule(Density, "tone_lines.shortest_px", Times(0.5)),
    // Marks and cuts are as many as the tone requires; closer rows make them finer.
    rule(Density, "rows.spacing_px", Times(0.75)),
    rule(Density, "cuts.families.spacing_px", Times(0.75)),
    rule(Density, "light.exposure", Times(0.8)),
    shared(Density, "tone.dark_share", Times(2.6)),
    rule(Density, "tone.white_share", Times(0.9)),
    // Bolder strokes need a larger share of the area, or there would be fewer.
    rule(Weight, "strokes.width_px", Times(1.8)),
    shared(Weight, "strokes.crowd", Times(1.6)),
    rule(Weight, "lines.ramp", Times(0.65)),
    rule(Weight, "lines.faintest", Plus(0.2)),
    rule(Weight, "lines.reach", Times(1.4)),
    rule(Weight, "curvature.width_px", Times(1.7)),
    rule(Weight, "tone_lines.width_px", Times(1.5)),
    rule(Weight, "hatching.sets.size", Times(1.35)),
    rule(Weight, "rows.darkest", Plus(0.12)),
    rule(Weight, "cuts.darkest", Plus(0.12)),
    rule(Weight, "height_lines.line_px", Times(1.6)),
    rule(Weight, "height_lines.index_px", Times(1.6)),
    rule(Weight, "drainage.line_px", Times(1.6)),
    rule(Weight, "drainage.widest_px", Times(1.6)),
    rule(Weight, "water.shore_px", Times(1.6)),
    rule(Weight, "water.line_px", Times(1.6)),
    rule(Weight, "sky.outline_px", Times(1.6)),
    rule(Weight, "paper.border_px", Times(1.6)),
    rule(Contrast, "light.contrast", Times(1.5)),
    rule(Contrast, "tone.darkest", Plus(-0.2)),
    shared(Contrast, "tone.dark_share", Times(2.0)),
    rule(Contrast, "tone.ramp.stops.colors", Spread(1.35)),
    rule(Contrast, "relief.alpha_px", Times(1.4)),
    rule(Softness, "tone.softness", Plus(0.5)),
    rule(Softness, "hatching.softness", Plus(0.25)),
    rule(Softness, "light.form_px", Times(1.8)),
    rule(Softness, "light.detail", Times(0.4)),
    rule(Softness, "light.wrap", Plus(0.3)),
    rule(Softness, "light.shadow", Plus(-0.25)),
    rule(Softness, "strokes.taper_px", Times(1.6)),
    rule(Softness, "tone_lines.softness", Plus(0.4)),
    rule(Softness, "tone_lines.blur", Times(1.5)),
    rule(Softness, "rows.taper", Plus(0.15)),
    rule(Softness, "watercolor.edge", Times(0.5)),
    rule(Softness, "relief.scale_px", Times(1.6)),
    // All colours are multiplied by that of the paper.
    rule(Warmth, "paper.color", Warm(1.0)),
    rule(Warmth, "tone_lines.ink", Warm(1.0)),
    rule(Warmth, "height_lines.ink", Warm(1.0)),
    rule(Warmth, "drainage.ink", Warm(1.0)),
    rule(Warmth, "hatching.ink", Warm(1.0)),
    rule(Warmth, "cuts.ink", Warm(1.0)),
    rule(Warmth, "rows.ink", Warm(1.0)),
    rule(Warmth, "water.ink", Warm(1.0)),
    rule(Warmth, "lines.ink", Warm(1.0)),
    rule(Warmth, "strokes.ink", Warm(1.0)),
    rule(Warmth, "sky.ink", Warm(1.0)),
    rule(Warmth, "paper.border", Warm(1.0)),
];

/// Returns the rules of a control that apply to a style.
pub(crate) fn rules(control: Control, style: &Style) -> impl Iterator<Item = &'static Rule> {
    let is_available = control.without_effect(style).is_none();
    // A tone that is only colour is not drawn with marks.
    let has_marks = style.layers.iter().any(|layer| matches!(layer.kind(), "hatching" | "rows" | "cuts"));
    RULES.iter().filter(move |rule| {
        rule.control == control
            && is_available
            && (has_marks || (rule.control, rule.key) != (Density, "light.exposure"))
    })
}

/// Returns a key without the indices of layers and list entries, as [`Rule::key`] has it.
pub(crate) fn bare(key: &str) -> String {
    key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect()
}

/// The value of a parameter that follows a control.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Amount {
    Number(f32),
    Pair([f32; 2]),
    Color(Color),
    Colors(Vec<Color>),
}

impl Amount {
    /// Reads a value; `None` if its kind cannot follow a control.
    pub(crate) fn of(value: &Value) -> Option<Self> {
        let number = |value: &Value| value.as_float().map(|number| number as f32);
        match value {
            Value::Float(_) => number(value).map(Self::Number),
            Value::String(text) => text.value().parse().ok().map(Self::Color),
            Value::Array(list) => {
                let numbers: Option<Vec<f32>> = list.iter().map(number).collect();
                let colors = || list.iter().map(|color| color.as_str()?.parse().ok()).collect::<Option<_>>();
                match numbers.as_deref() {
                    Some([low, high]) => Some(Self::Pair([*low, *high])),
                    _ => colors().map(Self::Colors),
                }
            }
            _ => None,
        }
    }

    /// Returns the value as TOML.
    pub(crate) fn value(&self) -> Value {
        match self {
            Self::Number(number) => shortest(*number).into(),
            Self::Pair(pair) => pair.iter().map(|number| shortest(*number)).collect::<Array>().into(),
            Self::Color(color) => color.to_string().into(),
            Self::Colors(colors) => colors.iter().map(Color::to_string).collect::<Array>().into(),
        }
    }

    /// Returns how far two values are apart; 1 is about the way from 0 to an end of the control.
    fn distance(&self, other: &Self, follow: Follow) -> f32 {
        let of_colors = |a: &Color, b: &Color| {
            let [a, b] = [a, b].map(|color| color.srgb());
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / 0.15
        };
        match (self, other, follow) {
            (Self::Number(a), Self::Number(b), Times(factor)) => ratio(*a, *b) / factor.ln().abs(),
            (Self::Number(a), Self::Number(b), Plus(step)) => (a - b).abs() / step.abs(),
            (Self::Pair(a), Self::Pair(b), Times(factor)) => {
                a.iter().zip(b).map(|(a, b)| ratio(*a, *b)).fold(0.0, f32::max) / factor.ln().abs()
            }
            (Self::Color(a), Self::Color(b), _) => of_colors(a, b),
            (Self::Colors(a), Self::Colors(b), _) if a.len() == b.len() => {
                a.iter().zip(b).map(|(a, b)| of_colors(a, b)).fold(0.0, f32::max)
            }
            _ => FARTHEST,
        }
    }
}

/// Distance from which a value counts as set by the user, not by the control.
const FARTHEST: f32 = 0.4;
/// Distance below which a value counts as set by the control: values are rounded, and colours have 256 steps.
const NEAREST: f32 = 0.04;

fn ratio(a: f32, b: f32) -> f32 {
    if a > 0.0 && b > 0.0 { (a / b).ln().abs() } else { (a - b).abs() }
}

impl Follow {
    /// Returns the value at a position from −1 to 1, if `base` is that at 0.
    fn at(self, base: &Amount, definition: &Definition, position: f32) -> Amount {
        if position == 0.0 {
            return base.clone();
        }
        let [low, high] = definition.range.ends();
        let clamped = |value: f32| value.clamp(low.unwrap_or(f32::MIN), high.unwrap_or(f32::MAX));
        let part = position.abs();
        let times = |value: f32, factor: f32| {
            let end = clamped(if position > 0.0 { value * factor } else { value / factor });
            if value > 0.0 && end > 0.0 { rounded(value * (end / value).powf(part)) } else { value }
        };
        match (self, base) {
            (Times(factor), Amount::Number(value)) => Amount::Number(times(*value, factor)),
            // Both grow alike, so they stay in order.
            (Times(factor), Amount::Pair(pair)) => Amount::Pair(pair.map(|value| times(value, factor))),
            (Plus(step), Amount::Number(value)) => {
                let end = clamped(value + step * position.signum());
                Amount::Number(clamped(rounded(value + (end - value) * part)))
            }
            (Spread(factor), Amount::Colors(colors)) => Amount::Colors(spread(colors, factor.powf(position))),
            (Warm(amount), Amount::Color(color)) => Amount::Color(warmed(*color, amount * position)),
            _ => base.clone(),
        }
    }
}

/// Rounds a number to four significant digits.
fn rounded(value: f32) -> f32 {
    let value = f64::from(value);
    if value == 0.0 || !value.is_finite() {
        return value as f32;
    }
    let step = 10_f64.powi(value.abs().log10().floor() as i32 - 3);
    ((value / step).round() * step) as f32
}

/// Returns the colours with other differences in brightness. The mean of the darkest and the brightest stays.
fn spread(colors: &[Color], factor: f32) -> Vec<Color> {
    let brightness = |color: &Color| color.srgb().iter().sum::<f32>() / 3.0;
    let all: Vec<f32> = colors.iter().map(brightness).collect();
    let middle = 0.5 * (all.iter().copied().fold(f32::MAX, f32::min) + all.iter().copied().fold(f32::MIN, f32::max));
    let shifted = |(color, brightness): (&Color, &f32)| {
        let by = (brightness - middle) * (factor - 1.0);
        Color::from_srgb(color.srgb().map(|channel| channel + by))
    };
    colors.iter().zip(&all).map(shifted).collect()
}

/// Factors of the light of the channels, as natural logarithms, in the warmest colour.
const WARM_LIGHT: [f32; 3] = [0.10, -0.02, -0.24];
/// Light that the warmest ink has in addition, so that black becomes brown; the coolest has it the other way round.
const WARM_INK: [f32; 3] = [0.016, 0.004, -0.016];

fn warmed(color: Color, position: f32) -> Color {
    let mut channels = color.linear();
    for ((channel, light), ink) in channels.iter_mut().zip(WARM_LIGHT).zip(WARM_INK) {
        *channel = *channel * (light * position).exp() + (1.0 - *channel) * (ink * position).max(0.0);
    }
    Color::from_srgb(channels.map(super::color::srgb_from_linear))
}

/// A parameter of a style that follows a control.
#[derive(Clone, Debug)]
pub(crate) struct Driven {
    /// Full key, for example `hatching.sets[0].size`.
    pub key: String,
    pub rule: &'static Rule,
    pub definition: Definition,
    /// The value at the position 0; `None` if what is saved has no such parameter.
    pub base: Option<Amount>,
    /// The current value.
    pub now: Amount,
}

/// Returns the position of a control: that from which the current values of its parameters have come, or nearly so. Of
/// several positions that fit alike, the one nearest to `expected` is returned.
pub(crate) fn position(driven: &[Driven], expected: i8) -> i8 {
    let read = driven.iter().filter(|one| one.rule.is_read);
    let read: Vec<(&Driven, &Amount)> = read.filter_map(|one| Some((one, one.base.as_ref()?))).collect();
    if read.iter().all(|(one, base)| one.now == **base) {
        return 0;
    }
    let misfit = |position: i8| -> f32 {
        let at = f32::from(position) / f32::from(END);
        let of_one = |(one, base): &(&Driven, &Amount)| {
            one.rule.follow.at(base, &one.definition, at).distance(&one.now, one.rule.follow).min(FARTHEST)
        };
        read.iter().map(of_one).sum()
    };
    let all: Vec<(i8, f32)> = (-END..=END).map(|position| (position, misfit(position))).collect();
    let best = all.iter().map(|(_, misfit)| *misfit).fold(f32::MAX, f32::min);
    let fitting = all.iter().filter(|(_, misfit)| *misfit <= best + 0.002 * read.len() as f32);
    let away = |position: i8| (i16::from(position) - i16::from(expected)).abs();
    fitting.map(|(position, _)| *position).min_by_key(|position| away(*position)).unwrap_or(0)
}

/// Returns the parameters that change if a control moves from one position to another, with their new values. A
/// parameter that the user has set moves by as much as one that only the control has set.
pub(crate) fn moved(driven: &[Driven], from: i8, to: i8) -> Vec<(String, Value)> {
    let [from, to] = [from, to].map(|position| f32::from(position) / f32::from(END));
    let mut changes = Vec::new();
    for one in driven {
        let follow = one.rule.follow;
        let at = |base: &Amount, position: f32| follow.at(base, &one.definition, position);
        let follows = |base: &&Amount| at(base, from).distance(&one.now, follow) < NEAREST;
        let new = match one.base.as_ref().filter(follows) {
            Some(base) => at(base, to),
            None => at(&one.now, (to - from).clamp(-2.0, 2.0)),
        };
        if new != one.now {
            changes.push((one.key.clone(), new.value()));
        }
    }
    changes
}
