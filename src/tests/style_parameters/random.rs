//! Generates random texts of styles and recipes from the definitions of their parameters.

use hachure::style::parameters::{Definition, Range, Setting, ValueKind};
use hachure::style::{marks, texture};
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, value};

/// The pseudorandom generator SplitMix64.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// Returns a number from 0 to below `end`.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn pick<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }

    /// Returns a number from `low` to `high`, both included, and often one of these ends.
    fn within(&mut self, low: f32, high: f32) -> f32 {
        match self.below(8) {
            0 => low,
            1 => high,
            _ => (low + (high - low) * (self.next() as f32 / u64::MAX as f32)).clamp(low, high),
        }
    }

    fn text(&mut self) -> String {
        let characters = ['a', 'ß', '山', ' ', '"', '\'', '\\', '\n', '\t', '#', '=', '[', ']', '.', '\u{1b}', '🖋'];
        (0..self.below(9)).map(|_| self.pick(&characters)).collect()
    }
}

/// Returns a key without the indices of entries.
pub fn bare(key: &str) -> String {
    key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect()
}

/// Returns a valid text, with some of the keys or with all of them.
pub fn table<T: Setting>(random: &mut Random, all: bool) -> DocumentMut {
    let ValueKind::Section(definitions) = T::kind() else { panic!("it is a section") };
    DocumentMut::from(section(&definitions, random, all))
}

fn section(definitions: &[Definition], random: &mut Random, all: bool) -> Table {
    let mut table = Table::new();
    for definition in definitions {
        if all || definition.is_required || random.below(3) > 0 {
            table.insert(definition.key, item(definition, random, all));
        }
    }
    let kind = table.get("kind").and_then(Item::as_str).map(str::to_owned);
    match kind.as_deref() {
        Some("plain") => match all {
            true => _ = table.insert("kind", value("toon")),
            false => table.retain(|key, _| key == "kind"),
        },
        Some("stack") => {
            let names = (0..=random.below(32)).map(|number| format!("{number}.png")).collect::<Array>();
            table.insert("images", value(names));
        }
        Some(_) => _ = table.remove("images"),
        None => {}
    }
    // Marks can be at most 0.9 times as wide as their spacing.
    if let (Some(width_px), Some(spacing_px)) = (number(&table, "width_px", 2.0), number(&table, "spacing_px", 8.0))
        && kind.is_some()
        && width_px > 0.9 * spacing_px
    {
        table.insert("width_px", value(1.0));
        table.insert("spacing_px", value(f64::from(random.within(2.0, 64.0))));
    }
    table
}

fn number(table: &Table, key: &str, default: f64) -> Option<f64> {
    table.get(key).map_or(Some(default), Item::as_float)
}

fn item(definition: &Definition, random: &mut Random, all: bool) -> Item {
    match &definition.kind {
        ValueKind::Section(definitions) => Item::Table(section(definitions, random, all)),
        ValueKind::Layers(kinds) => {
            // Each kind once, in any order.
            let mut tables: Vec<Table> = Vec::new();
            for kind in kinds.iter().filter(|_| all || random.below(3) > 0).collect::<Vec<_>>() {
                let mut table = Table::new();
                table.insert("kind", value(kind.key));
                table.extend(section(kind.section().unwrap_or_default(), random, all));
                tables.insert(random.below(tables.len() + 1), table);
            }
            Item::ArrayOfTables(tables.into_iter().collect::<ArrayOfTables>())
        }
        ValueKind::List(kind) => {
            let Range::Entries(low, high) = definition.range else { return value(Array::new()) };
            let count = low + random.below(high - low + 1);
            if definition.key == "on_maps" {
                let known = ["light.shadow=0.5", "light.form_px=7", "paper.color=#ffeedd", "haze.faintest_tone=0.25"];
                return value(known.into_iter().filter(|_| random.below(2) > 0).collect::<Array>());
            }
            let ValueKind::Section(definitions) = &**kind else {
                return value((0..count).map(|_| color(random)).collect::<Array>());
            };
            let mut tables: Vec<Table> = (0..count).map(|_| section(definitions, random, all)).collect();
            // Stops must increase, and a style sorts its layers.
            for key in ["at", "from"].into_iter().filter(|key| definitions.iter().any(|known| known.key == *key)) {
                let high = if key == "at" { 1e9 } else { 0.99 };
                for (place, table) in tables.iter_mut().enumerate() {
                    let part = (place as f32 + random.within(0.0, 0.9)) / count as f32;
                    table.insert(key, value(f64::from(part * high)));
                }
            }
            Item::ArrayOfTables(tables.into_iter().collect::<ArrayOfTables>())
        }
        ValueKind::Text => value(match definition.key {
            "texture" => random.pick(&texture::names()).to_owned(),
            "marks" => random.pick(&marks::names()).to_owned(),
            "when" => random.pick(&["", "kind == 'path'", "ele > 2000 and name is not none"]).to_owned(),
            "environment" => "src/tests/style_parameters/white.hdr".to_owned(),
            _ => random.text(),
        }),
        ValueKind::Color => value(color(random)),
        ValueKind::Flag => value(random.below(2) == 0),
        ValueKind::Choice(choices) => value(choices[random.below(choices.len())].name.as_str()),
        ValueKind::Number | ValueKind::Whole | ValueKind::Pair => numbers(definition, random),
    }
}

fn color(random: &mut Random) -> String {
    format!("#{:06x}", random.next() & 0xff_ffff)
}

fn numbers(definition: &Definition, random: &mut Random) -> Item {
    let pair = |from: f32, to: f32| value([from, to].map(f64::from).into_iter().collect::<Array>());
    match (&definition.kind, definition.range) {
        (ValueKind::Whole, Range::Within(low, high)) => value(f64::from(random.within(low, high)) as i64),
        (_, Range::Within(low, high)) => value(f64::from(random.within(low, high))),
        (_, Range::AtLeast(low)) => value(f64::from(low + random.within(0.0, 100.0))),
        (_, Range::Above(low)) => value(f64::from(low + random.within(f32::MIN_POSITIVE, 100.0))),
        (_, Range::PowerOfTwo(low, high)) => {
            let sizes: Vec<i64> =
                (0..31).map(|power| 1 << power).filter(|size| (low.into()..=high.into()).contains(size)).collect();
            value(random.pick(&sizes))
        }
        (_, Range::ZeroOr(low, high)) => match random.below(4) {
            0 => value(0),
            _ => value(i64::from(low) + random.below((high - low) as usize + 1) as i64),
        },
        (_, Range::Rising(low)) => {
            let from = low + random.within(0.0, 10.0);
            pair(from, from + random.within(0.01, 10.0))
        }
        (_, Range::Span(low, high)) => {
            let to = random.within(low, high);
            pair(random.within(low, to), to)
        }
        (ValueKind::Whole, _) => value((random.next() & 0xffff_ffff) as i64),
        (kind, range) => panic!("{kind:?} in {range:?}"),
    }
}
