//! Widgets for the values of parameters, by kind of value.

use std::ops::RangeInclusive;
use std::path::Path;

use egui::{Button, DragValue, Response, Slider, SliderClamping, TextEdit, Ui};
use toml_edit::{Array, Value};

use super::{Edit, named, previews};
use crate::studio::rows::Row;
use crate::studio::swatch::RecipeKind;
use crate::style::Color;
use crate::style::parameters::{Range, ValueKind, shortest};

/// Width of a slider in points.
const SLIDER_WIDTH: f32 = 104.0;
/// Width of texts and lists of names in points.
const TEXT_WIDTH: f32 = 150.0;
/// Largest height of the list of recipes in points.
const LIST_HEIGHT: f32 = 420.0;
/// Significant digits of a value that a slider sets.
const DIGITS: i32 = 4;

/// Adds the widgets of a parameter and returns them. `name` is the name of the parameter for AccessKit.
/// `of_style` is the folder of the style and its revision.
pub(super) fn widgets(
    ui: &mut Ui,
    name: &str,
    row: &Row,
    of_style: (&Path, u64),
    edits: &mut Vec<Edit>,
) -> Vec<Response> {
    let Some(value) = &row.value else { return vec![not_given(ui, name, row, edits)] };
    let mut set = |value: Value| edits.push(Edit::Set(row.key.clone(), value));
    match (&row.definition.kind, value) {
        (ValueKind::Number | ValueKind::Whole, value) => number(ui, name, row, as_number(value), &mut set),
        (ValueKind::Pair, Value::Array(pair)) => numbers(ui, name, row, pair, &mut set),
        (ValueKind::Flag, value) => {
            let mut is_on = value.as_bool().unwrap_or_default();
            let widget = ui.checkbox(&mut is_on, "");
            named(&widget, name);
            if widget.changed() {
                set(is_on.into());
            }
            vec![widget]
        }
        (ValueKind::Color, value) => vec![color(ui, name, value.as_str().unwrap_or_default(), |color| {
            set(color.into());
        })],
        (ValueKind::Choice(choices), value) => {
            let present = value.as_str().unwrap_or_default();
            let list = egui::ComboBox::from_id_salt("choice").width(TEXT_WIDTH).selected_text(present);
            let list = list.show_ui(ui, |ui| {
                for choice in choices {
                    let entry = ui.selectable_label(choice.name == present, &choice.name);
                    if entry.on_hover_text(choice.help).clicked() && choice.name != present {
                        set(choice.name.as_str().into());
                    }
                }
            });
            named(&list.response, name);
            vec![list.response]
        }
        (ValueKind::Text, value) => {
            let present = value.as_str().unwrap_or_default();
            let Some(kind) = RecipeKind::of_key(row.definition.key) else {
                return vec![text(ui, name, TEXT_WIDTH + 30.0, present, &mut set)];
            };
            ui.vertical(|ui| {
                let widgets = ui.horizontal(|ui| recipe(ui, name, kind, present, &mut set)).inner;
                previews::show(ui, kind, present, of_style);
                widgets
            })
            .inner
        }
        (ValueKind::List(kind), Value::Array(list)) if matches!(**kind, ValueKind::Text) => {
            texts(ui, name, list, &mut set)
        }
        (ValueKind::List(_), Value::Array(list)) => colors(ui, name, row, list, &mut set),
        (_, value) => {
            let label = ui.label(value.to_string());
            named(&label, name);
            vec![label]
        }
    }
}

/// Adds the button that gives an optional parameter a value.
fn not_given(ui: &mut Ui, name: &str, row: &Row, edits: &mut Vec<Edit>) -> Response {
    let button = ui.add(Button::new("not given").min_size(egui::vec2(SLIDER_WIDTH, 0.0)));
    named(&button, name);
    if button.clicked() {
        edits.push(Edit::Set(row.key.clone(), first_value(row)));
    }
    button
}

/// Returns the value that an optional parameter gets first.
fn first_value(row: &Row) -> Value {
    match &row.definition.kind {
        ValueKind::Color => Color::default().to_string().into(),
        ValueKind::Choice(choices) => choices.first().map_or_else(String::new, |choice| choice.name.clone()).into(),
        ValueKind::Flag => true.into(),
        ValueKind::Text => RecipeKind::of_key(row.definition.key)
            .and_then(|kind| kind.names().first().copied())
            .unwrap_or_default()
            .into(),
        kind => {
            let middle = row.definition.slider().map_or(1.0, |ends| match ends.is_logarithmic {
                true => (ends.low.max(1.0) * ends.high).sqrt(),
                false => 0.5 * (ends.low + ends.high),
            });
            match kind {
                ValueKind::Whole => i64::from(middle.round() as u32).into(),
                _ => shortest(middle.round().max(f32::MIN_POSITIVE)).into(),
            }
        }
    }
}

fn as_number(value: &Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64)).unwrap_or_default()
}

/// Adds a slider, if the range has ends, and a field for the number.
fn number(ui: &mut Ui, name: &str, row: &Row, mut value: f64, set: &mut impl FnMut(Value)) -> Vec<Response> {
    let definition = &row.definition;
    let is_whole = matches!(definition.kind, ValueKind::Whole);
    let before = value;
    let mut widgets = Vec::new();
    if let Some(ends) = definition.slider() {
        ui.spacing_mut().slider_width = SLIDER_WIDTH;
        let [low, high] = [ends.low, ends.high].map(f64::from);
        let mut slider = Slider::new(&mut value, low..=high).logarithmic(ends.is_logarithmic).show_value(false);
        // Values beyond the ends may be typed, and stay until the slider is moved.
        slider = slider.clamping(SliderClamping::Edits).smallest_positive(if low > 0.0 { low } else { 0.01 });
        let widget = ui.add(if is_whole { slider.integer() } else { slider });
        named(&widget, name);
        if is_menu_click(ui) {
            value = before;
        } else if widget.changed() {
            value = if is_whole { value.round() } else { rounded(value, high - low) };
        }
        widgets.push(widget);
    }
    let [low, high] = definition.range.ends().map(|end| end.map(f64::from));
    let range = low.unwrap_or(f64::from(f32::MIN))..=high.unwrap_or(f64::from(f32::MAX));
    let speed = definition.slider().map_or(0.01 * before.abs().max(1.0), |ends| match ends.is_logarithmic {
        true => 0.01 * before.abs().max(0.1),
        false => f64::from(ends.high - ends.low) / 300.0,
    });
    let mut field = DragValue::new(&mut value).range(range).clamp_existing_to_range(false).speed(speed);
    // A text that is not complete must not be drawn.
    field = field.update_while_editing(false);
    field = if is_whole { field.max_decimals(0) } else { field.max_decimals(5) };
    if let Some(word) = definition.zero_word {
        field = field.custom_formatter(|value, digits| number_or_word(value, digits, word));
        field = field.custom_parser(|text| number_of(text, word));
    }
    let is_word = definition.zero_word.is_some() && before == 0.0;
    if let Some(unit) = row.unit().filter(|unit| unit.len() < 5 && !is_word) {
        field = field.suffix(if unit == "°" { unit.to_owned() } else { format!(" {unit}") });
    }
    let field = ui.add(field);
    let words = if widgets.is_empty() { name.to_owned() } else { format!("{name}, number") };
    named(&field, &words);
    widgets.push(field);
    if value.to_bits() != before.to_bits() {
        set(of_range(value, before, &definition.range, is_whole));
    }
    widgets
}

/// Returns a number as text, and 0 as a word.
fn number_or_word(value: f64, digits: RangeInclusive<usize>, zero_word: &str) -> String {
    if value == 0.0 { zero_word.to_owned() } else { egui::emath::format_with_decimals_in_range(value, digits) }
}

/// Returns the number that a text states; the word for 0 counts as 0.
fn number_of(text: &str, zero_word: &str) -> Option<f64> {
    if text.trim().eq_ignore_ascii_case(zero_word) {
        return Some(0.0);
    }
    text.replace(char::is_whitespace, "").replace('−', "-").parse().ok()
}

/// Returns whether the mouse opens a menu. A slider of egui follows every button of the mouse, but a right click must not
/// change the value.
pub(super) fn is_menu_click(ui: &Ui) -> bool {
    let button = egui::PointerButton::Secondary;
    ui.input(|input| input.pointer.button_down(button) || input.pointer.button_released(button))
}

/// Rounds a value that a slider set to a few digits, relative to the value or to a small part of the slider.
fn rounded(value: f64, width: f64) -> f64 {
    let size = value.abs().max(1e-3 * width);
    if size == 0.0 || !size.is_finite() {
        return value;
    }
    let step = 10_f64.powi(size.log10().floor() as i32 + 1 - DIGITS);
    (value / step).round() * step
}

/// Returns a number as a value of a style, moved to the nearest one that the range allows. `before` is the value until
/// now.
fn of_range(value: f64, before: f64, range: &Range, is_whole: bool) -> Value {
    if !is_whole {
        return shortest(value as f32).into();
    }
    let number = value.round().max(0.0) as u32;
    let number = match *range {
        Range::ZeroOr(low, _) if number < low && number > 0 => {
            if value > before {
                low
            } else {
                0
            }
        }
        Range::PowerOfTwo(low, high) => {
            let power = if value > before { number.next_power_of_two() } else { (number / 2 + 1).next_power_of_two() };
            power.clamp(low, high)
        }
        _ => number,
    };
    i64::from(number).into()
}

/// Adds two fields for a pair of numbers.
fn numbers(ui: &mut Ui, name: &str, row: &Row, pair: &Array, set: &mut impl FnMut(Value)) -> Vec<Response> {
    let mut values: Vec<f64> = pair.iter().map(as_number).collect();
    let before = values.clone();
    let [low, high] = row.definition.range.ends().map(|end| end.map(f64::from));
    let range = low.unwrap_or(f64::from(f32::MIN))..=high.unwrap_or(f64::from(f32::MAX));
    let mut widgets = Vec::new();
    for (value, words) in values.iter_mut().zip(["lower", "upper"]) {
        let speed = high.map_or(0.005 * value.abs().max(0.01), |high| high / 300.0);
        let field = DragValue::new(value).range(range.clone()).clamp_existing_to_range(false).speed(speed);
        let field = ui.add(field.max_decimals(5).update_while_editing(false).min_size(egui::vec2(52.0, 0.0)));
        named(&field, &format!("{name}, {words}"));
        widgets.push(field);
    }
    if values != before {
        let shortened = values.iter().map(|value| shortest(*value as f32));
        set(Value::Array(shortened.collect()));
    }
    widgets
}

/// Adds a button that shows a colour and opens a picker.
fn color(ui: &mut Ui, name: &str, text: &str, set: impl FnOnce(String)) -> Response {
    let present: Color = text.parse().unwrap_or_default();
    let mut srgb = present.srgb().map(|channel| (255.0 * channel).round() as u8);
    let button = ui.color_edit_button_srgb(&mut srgb);
    named(&button, name);
    let chosen = Color::from_srgb(srgb.map(|channel| f32::from(channel) / 255.0));
    if chosen != present {
        set(chosen.to_string());
    }
    button.on_hover_text(chosen.to_string())
}

/// Adds buttons for a list of colours, and buttons that make it longer and shorter.
fn colors(ui: &mut Ui, name: &str, row: &Row, list: &Array, set: &mut impl FnMut(Value)) -> Vec<Response> {
    let texts: Vec<String> = list.iter().filter_map(|value| value.as_str().map(str::to_owned)).collect();
    let mut changed = texts.clone();
    let mut widgets = Vec::new();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        ui.spacing_mut().interact_size.x = 26.0;
        for (number, text) in texts.iter().enumerate() {
            ui.push_id(number, |ui| {
                let words = format!("{name}, colour {}", number + 1);
                widgets.push(color(ui, &words, text, |color| changed[number] = color));
            });
        }
        let (low, high) = match row.definition.range {
            Range::Entries(low, high) => (low, high),
            _ => (0, usize::MAX),
        };
        let add = ui.add_enabled(texts.len() < high, Button::new("+").small());
        named(&add, &format!("{name}, add a colour"));
        if add.on_hover_text("Add a colour").clicked() {
            changed.push(texts.last().cloned().unwrap_or_else(|| Color::default().to_string()));
        }
        let remove = ui.add_enabled(texts.len() > low, Button::new("−").small());
        named(&remove, &format!("{name}, remove the last colour"));
        if remove.on_hover_text("Remove the last colour").clicked() {
            changed.pop();
        }
    });
    if changed != texts {
        set(Value::Array(changed.into_iter().collect()));
    }
    widgets
}

/// Adds a field for each entry of a list of texts, and an empty one that adds an entry. An emptied field removes its
/// entry.
fn texts(ui: &mut Ui, name: &str, list: &Array, set: &mut impl FnMut(Value)) -> Vec<Response> {
    let present: Vec<&str> = list.iter().filter_map(Value::as_str).collect();
    let mut changed = None;
    let widgets = ui.vertical(|ui| {
        let field = |(number, entry): (usize, &str)| {
            let mut typed =
                |value: Value| changed = Some((number, value.as_str().unwrap_or_default().trim().to_owned()));
            let words = format!("{name}, entry {}", number + 1);
            ui.push_id(number, |ui| text(ui, &words, TEXT_WIDTH + 30.0, entry, &mut typed)).inner
        };
        present.iter().copied().chain([""]).enumerate().map(field).collect()
    });
    if let Some((number, typed)) = changed {
        let mut entries: Vec<String> = present.iter().map(|entry| (*entry).to_owned()).collect();
        match entries.get_mut(number) {
            Some(entry) => *entry = typed,
            None => entries.push(typed),
        }
        set(Value::Array(entries.into_iter().filter(|entry| !entry.is_empty()).collect()));
    }
    widgets.inner
}

/// Adds a field for the name of a recipe, and a list of the built-in ones with their pictures.
fn recipe(ui: &mut Ui, name: &str, kind: RecipeKind, present: &str, set: &mut impl FnMut(Value)) -> Vec<Response> {
    let field = text(ui, name, TEXT_WIDTH - 20.0, present, set);
    let list = ui.menu_button("…", |ui| {
        egui::ScrollArea::vertical().max_height(LIST_HEIGHT).show(ui, |ui| {
            for known in kind.names() {
                ui.horizontal(|ui| {
                    previews::show(ui, kind, known, (Path::new(""), 0));
                    if ui.selectable_label(known == present, known).clicked() {
                        set(known.into());
                        ui.close();
                    }
                });
            }
        });
    });
    named(&list.response, &format!("{name}, built-in recipes"));
    vec![field]
}

/// Adds a field for a text.
fn text(ui: &mut Ui, name: &str, width: f32, present: &str, set: &mut impl FnMut(Value)) -> Response {
    let id = ui.make_persistent_id("text");
    // What is being typed is kept until it is complete.
    let mut typed = ui.data_mut(|data| data.get_temp::<String>(id)).unwrap_or_else(|| present.to_owned());
    let field = ui.add(TextEdit::singleline(&mut typed).id(id.with("field")).desired_width(width));
    named(&field, name);
    if field.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, typed));
    } else if field.lost_focus() {
        ui.data_mut(|data| data.remove::<String>(id));
        let is_kept = !ui.input(|input| input.key_pressed(egui::Key::Escape));
        if is_kept && typed != present {
            set(typed.into());
        }
    }
    field
}
