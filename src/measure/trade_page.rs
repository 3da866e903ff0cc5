//! The page `docs/trade-offs.md`: the measured fronts of presets, and their plots.
//!
//! `HACHURE_REWRITE=1 cargo test --release --lib trade_page` rewrites the page and the plots.

use std::fmt::Write;

use super::quality::{Front, Level, Point};
use super::setting::FRONTS;
use super::trade;
use super::trade_plot::{Plotted, drawing};

const HEAD: &str = "# Measured trade-offs\n\n\
    What each preset costs at the settings of its measured front, and how exact it is there: the numbers behind \
    `--quality` and `--budget` ([guide](guide/benchmarks.md#speed-against-exactness), \
    [why](decisions/speed-against-exactness.md)). Errors are those against a converged reference of the same style: 16 \
    samples, an allowed error of the land of 0.1 px, exact options, at eight views. A line is lost if the reference has it and the \
    drawing has none within 1.5 px, and added if it is the other way round. The surface error is the largest one of about \
    2,000 pixels of each view, so it scatters.\n\n\
    The cost is relative to the style as it is. On a software driver it is the memory that a frame moves, which is the \
    same on every GPU; times there are not.\n";

fn page() -> String {
    let mut page = HEAD.to_owned();
    for (name, text) in FRONTS {
        let front = Front::parse(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let [width, height] = front.size;
        write!(page, "\n## {name}\n\n![Cost and error of {name}](pictures/{})\n\n", picture(name)).ok();
        let adapter = front.adapter.split(" (").next().unwrap_or_default();
        writeln!(page, "{width} × {height}, {adapter}. {}.\n", front.measured).ok();
        writeln!(
            page,
            "| level | setting | {} | ÷ as it is | lines lost % | lines added % | tone error % | surface error px |",
            front.cost
        )
        .ok();
        page += "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |\n";
        front.points.iter().for_each(|point| page += &row(point));
    }
    page
}

fn picture(name: &str) -> String {
    format!("trade-{name}.svg")
}

fn levels(point: &Point) -> String {
    let levels = Level::ALL.into_iter().filter(|level| point.levels.contains(level));
    levels.map(Level::name).collect::<Vec<_>>().join(", ")
}

fn row(point: &Point) -> String {
    let set: Vec<String> = point.set.iter().map(|(key, text)| format!("`{key}={text}`")).collect();
    let is_option = |key: &String| ["lod-error", "antialias"].contains(&key.as_str());
    let is_as_it_is = point.cost_ratio == 1.0 && point.set.keys().all(is_option);
    let error =
        |key: &str, digits: usize| point.errors.get(key).map_or("–".to_owned(), |error| format!("{error:.digits$}"));
    format!(
        "| {} | {} | {:.3} | {:.2} | {} | {} | {} | {} |\n",
        levels(point),
        if is_as_it_is { "the style as it is".to_owned() } else { set.join(" ") },
        point.cost,
        point.cost_ratio,
        error(trade::LINES_LOST, 1),
        error("lines_added_percent", 1),
        error(trade::TONE_ERROR, 2),
        error("surface_error_px", 2),
    )
}

/// Returns the plot of a front as an SVG file.
fn plot(front: &Front) -> String {
    let key = if front.points.iter().any(|point| point.errors.contains_key(trade::LINES_LOST)) {
        trade::LINES_LOST
    } else {
        trade::TONE_ERROR
    };
    let name = if key == trade::LINES_LOST { "lines lost, %" } else { "tone error, %" };
    let point = |point: &Point| {
        let words: Vec<String> = point.set.iter().map(|(key, text)| format!("{key}={text}")).collect();
        Some(Plotted {
            at: [point.cost, *point.errors.get(key)?],
            is_on_front: true,
            words: words.join(" "),
            label: levels(point),
        })
    };
    let points: Vec<Plotted> = front.points.iter().filter_map(point).collect();
    let style = "<style>text { font: 12px sans-serif; fill: #555 } .rule { stroke: #ddd }</style>\n<rect width=\"100%\" \
                 height=\"100%\" fill=\"#fff\"/>\n";
    drawing(&points, &front.cost, name).replacen('\n', &format!("\n{style}"), 1)
}

#[test]
#[allow(clippy::disallowed_methods, reason = "the page and the plots are files under version control")]
fn the_page_is_that_of_the_fronts() {
    let docs = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let mut files = vec![(docs.join("trade-offs.md"), page())];
    for (name, text) in FRONTS {
        let front = Front::parse(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
        files.push((docs.join("pictures").join(picture(name)), plot(&front)));
    }
    for (path, text) in files {
        if std::env::var("HACHURE_REWRITE").is_ok_and(|value| value == "1") {
            std::fs::write(&path, &text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
        let known = std::fs::read_to_string(&path).unwrap_or_default();
        let command = "HACHURE_REWRITE=1 cargo test --release --lib trade_page";
        assert!(known == text, "{} is out of date; run: {command}", path.display());
    }
    // Planted: another number is another row, and another plot.
    let front =
        FRONTS.first().and_then(|(name, text)| Front::parse(name, text).ok()).unwrap_or_else(|| panic!("no front"));
    let mut other = front.clone();
    other.points[0].cost *= 1.5;
    assert!(row(&other.points[0]) != row(&front.points[0]) && plot(&other) != plot(&front));
}

/// The levels of a front are far apart, and its costs come from one measurement: the setting that leaves the style as
/// it is costs as much as the style.
#[test]
fn the_fronts_agree_with_their_styles() {
    for (name, text) in FRONTS {
        let front = Front::parse(name, text).unwrap_or_else(|error| panic!("{name}: {error}"));
        let style = crate::style::Style::load(name).unwrap_or_else(|error| panic!("{name}: {error}"));
        let level = |level| front.point(level).unwrap_or_else(|| panic!("{name}: {level:?} is missing"));
        let [draft, balanced, exact] = Level::ALL.map(level);
        let apart = exact.cost / draft.cost;
        assert!(apart > 2.0, "{name}: draft and exact are {apart:.2} apart");
        assert!(draft.cost <= balanced.cost && balanced.cost <= exact.cost, "{name}");
        let is_as_it_is = |point: &&Point| {
            let setting = point.setting().unwrap_or_else(|error| panic!("{name}: {error}"));
            let is_default =
                setting.scale.is_none_or(|scale| scale == 1.0) && setting.lod_error_px.is_none_or(|px| px == 1.0);
            let text = crate::style::set::with_values(name, &style.text(), &style, &setting.values);
            let with = text.and_then(|text| crate::style::Style::parse_with(name, &text, &style.recipe_files()));
            is_default && with.is_ok_and(|with| with == style)
        };
        for own in front.points.iter().filter(is_as_it_is) {
            assert!((own.cost_ratio - 1.0).abs() < 0.01, "{name}: as it is, it costs {}", own.cost_ratio);
        }
    }
}
