//! The plot of a trade: settings by their cost and their main error, with the front as a line.

use super::report::Run;
use super::report_html::{escape, nice_step, short};
use super::trade::{self, Trade};

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 300.0;
/// Position at which the axes cross, in the SVG's units from the left and from the top.
const LEFT: f64 = 60.0;
const BOTTOM: f64 = HEIGHT - 46.0;

/// Returns the plot as SVG. The error is that of lines, or of tones in a style without lines; `None` if neither was
/// measured.
pub(super) fn svg(trade: &Trade<'_>) -> Option<String> {
    let has = |key: &str| trade.runs.iter().any(|run| trade::errors(run).contains_key(key));
    let (key, name) = [(trade::LINES_LOST, "lines lost, %"), (trade::TONE_ERROR, "tone error, %")]
        .into_iter()
        .find(|(key, _)| has(key))?;
    let place = |run: &Run| Some([trade.cost.of(run)?, *trade::errors(run).get(key)?]);
    let points: Vec<Plotted> = trade
        .runs
        .iter()
        .zip(trade.on_front())
        .filter_map(|(run, is_on_front)| {
            Some(Plotted { at: place(run)?, is_on_front, words: trade::setting_words(run), label: String::new() })
        })
        .collect();
    let svg = drawing(&points, trade.cost.head(), name);
    Some(format!(
        "<div class=\"wide\">{svg}</div>\n<p class=\"faint\">Filled: on the front. A point's name appears under the \
         mouse.</p>\n"
    ))
}

/// A setting on the plot.
pub(super) struct Plotted {
    /// Cost and error.
    pub at: [f64; 2],
    pub is_on_front: bool,
    /// The setting in words.
    pub words: String,
    /// Name that is written next to the point; may be empty.
    pub label: String,
}

/// Returns the plot of settings as SVG; `cost_name` and `name` are those of the axes.
pub(super) fn drawing(points: &[Plotted], cost_name: &str, name: &str) -> String {
    let largest = |axis: usize| points.iter().map(|point| point.at[axis]).fold(0.0, f64::max);
    let steps = [0, 1].map(|axis| nice_step(largest(axis) / 5.0));
    let tops = [0, 1].map(|axis| (largest(axis) / steps[axis] - 1e-9).ceil().max(1.0) * steps[axis]);
    let on_page =
        |[x, y]: [f64; 2]| [LEFT + x / tops[0] * (WIDTH - LEFT - 16.0), BOTTOM - y / tops[1] * (BOTTOM - 16.0)];

    let mut svg = format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\">\n");
    for tick in 0..=(tops[1] / steps[1]).round() as u32 {
        let value = f64::from(tick) * steps[1];
        let [_, y] = on_page([0.0, value]);
        svg += &format!("<line class=\"rule\" x1=\"{LEFT}\" x2=\"{}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>", WIDTH - 16.0);
        svg +=
            &format!("<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n", LEFT - 6.0, y + 4.0, short(value));
    }
    for tick in 0..=(tops[0] / steps[0]).round() as u32 {
        let value = f64::from(tick) * steps[0];
        let [x, _] = on_page([value, 0.0]);
        svg += &format!("<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", BOTTOM + 18.0, short(value));
    }
    let (right, below) = (WIDTH - 16.0, BOTTOM + 38.0);
    svg += &format!("<text x=\"{right}\" y=\"{below}\" text-anchor=\"end\">{cost_name}</text>\n");
    svg += &format!("<text x=\"{LEFT}\" y=\"10\">{name}</text>\n");
    let mut front: Vec<[f64; 2]> = points.iter().filter(|point| point.is_on_front).map(|point| point.at).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let line: Vec<String> = front.into_iter().map(on_page).map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    svg +=
        &format!("<polyline fill=\"none\" stroke=\"#888\" stroke-dasharray=\"3 3\" points=\"{}\"/>\n", line.join(" "));
    for Plotted { at, is_on_front, words, label } in points {
        let ([x, y], fill) = (on_page(*at), if *is_on_front { "#0b6" } else { "none" });
        let [cost, error] = at.map(short);
        svg += &format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\" stroke=\"#0b6\"><title>{}: {cost} {}, {error} \
             {name}</title></circle>\n",
            escape(words),
            cost_name
        );
        if !label.is_empty() {
            // Toward the middle of the plot, so that the text has room.
            let (side, anchor) = if x > 0.5 * WIDTH { (-8.0, "end") } else { (8.0, "start") };
            let (x, y) = (x + side, y - 6.0);
            svg += &format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>\n", escape(label));
        }
    }
    svg + "</svg>\n"
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::measure::report::Report;
    use crate::measure::work::FrameWork;

    fn run(setting: &str, gigabytes: f64, metrics: &[(&str, f64)]) -> Run {
        Run {
            style: "ink".to_owned(),
            setting: setting
                .split_once('=')
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .into_iter()
                .collect(),
            work: Some(FrameWork { bytes_read: (gigabytes * 1e9) as u64, ..FrameWork::default() }),
            exactness: Some(metrics.iter().map(|(name, value)| ((*name).to_owned(), Some(*value))).collect()),
            ..Run::default()
        }
    }

    fn plotted(runs: Vec<Run>) -> Option<String> {
        let report = Report { is_software: true, runs, ..Report::default() };
        svg(Trade::all(&report).first().unwrap())
    }

    #[test]
    fn settings_are_where_their_cost_and_error_are() {
        let lines = |recall| [("line_recall", recall), ("line_precision", 1.0), ("tone_error", 0.0)];
        let runs = vec![
            run("", 1.0, &lines(0.99)),
            run("lod-error=4", 0.5, &lines(0.9)),
            // Planted: dearer and worse, so not on the front.
            run("lod-error=2", 0.8, &lines(0.85)),
        ];
        let svg = plotted(runs).unwrap();
        assert_eq!((svg.matches("<circle").count(), svg.matches("fill=\"#0b6\"").count()), (3, 2), "{svg}");
        // 0.5 of 1 GB is the middle of the axis; 10 of 20 % (ticks of 5) of lines lost the middle of the other.
        let half = [LEFT + 0.5 * (WIDTH - LEFT - 16.0), BOTTOM - 10.0 / 15.0 * (BOTTOM - 16.0)];
        assert!(svg.contains(&format!("cx=\"{:.1}\" cy=\"{:.1}\"", half[0], half[1])), "{svg}");
        assert!(svg.contains("lod-error=4: 0.5 GB moved, 10 lines lost, %"), "{svg}");
    }

    #[test]
    fn a_style_without_lines_is_plotted_by_its_tones() {
        let tone = |error| [("tone_error", error)];
        let svg = plotted(vec![run("", 1.0, &tone(0.01)), run("relief.lights=8", 0.5, &tone(0.03))]).unwrap();
        assert!(svg.contains("tone error, %"), "{svg}");
        assert!(plotted(vec![run("", 1.0, &[]), run("relief.lights=8", 0.5, &[])]).is_none());
    }
}
