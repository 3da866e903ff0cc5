//! `render --peaks` and `--names`: labels of summits and places.

use std::path::PathBuf;

use clap::Args;
use glam::DVec2;
use rustc_hash::FxHashMap;

use super::{Job, RenderArgs, title};
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::commands::progress::Bar;
use crate::features::when::When;
use crate::file::message::{counted, named};
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::peaks::{Summit, Wanted, summits_of_store};
use crate::picture::PictureRequest;
use crate::picture::imprint::More;
use crate::picture::legend::drawn_area;
use crate::picture::names::{self, Ground, Labels, Seen, Site};
use crate::picture::title::Block;
use crate::pyramid::TileStore;
use crate::scene::ranges;
use crate::scene::view::Pose;
use crate::style::Typeface;
use crate::vector::Group;
use crate::world::named_places::{self, NamedPlace, NamesError, WantedNames};

/// Least prominence of a summit that may have a label, in metres without exaggeration.
const LEAST_PROMINENCE_M: f64 = 5.0;
/// Largest number of summits among which those of a picture are chosen.
const MAX_SUMMITS: usize = 50_000;
/// A named place is at a summit if that is within this distance in metres, or within so many samples if they are
/// farther apart.
const SNAP_M: f64 = 250.0;
const SNAP_SAMPLES: f64 = 3.0;
/// Largest difference of a stated height from that of the land, in metres.
const MAX_OFF_M: f64 = 200.0;
/// Importance of a name relative to a height alone, and that of a name which is at no summit, in metres of prominence.
const NAMED: f64 = 3.0;
const ELSEWHERE_M: f64 = 60.0;

/// Which summits and places have labels.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct NamesArgs {
    /// Label up to this many summits in view with their heights, the most prominent first; they rise at least 5 m above
    /// the saddle to higher land
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole_within::<u32>(ranges::PEAKS))]
    pub peaks: Option<u32>,
    /// Name summits and places: points with names in a GeoJSON, GPX, CSV, GeoPackage or FlatGeobuf file, in any
    /// reference system. A point within 250 m of a summit names that summit; other points are labelled where they are
    #[arg(long, value_name = "FILE")]
    pub names: Option<PathBuf>,
    /// Layer of --names, if the file has several
    #[arg(long, value_name = "LAYER")]
    pub name_layer: Option<String>,
    /// Name only features that meet a condition, such as "kind == 'peak' and ele > 2000"; needs --names
    #[arg(long, value_name = "CONDITION", value_parser = condition)]
    pub name_when: Option<String>,
    /// Attribute of --names that holds the names [default: the first of name, title, label, text, gnis_name and
    /// feature_name that the file has]
    #[arg(long, value_name = "ATTRIBUTE")]
    pub name_field: Option<String>,
}

impl NamesArgs {
    pub(crate) fn is_empty(&self) -> bool {
        self.peaks.unwrap_or(0) == 0 && self.names.is_none()
    }

    /// Completes these options with those of a picture. What belongs to a file of names comes with it.
    pub(super) fn or(self, more: &More) -> Self {
        let peaks = self.peaks.or(more.peaks);
        if self.names.is_some() {
            return Self { peaks, ..self };
        }
        Self {
            peaks,
            names: more.names.as_ref().map(PathBuf::from),
            name_layer: self.name_layer.or_else(|| more.name_layer.clone()),
            name_when: self.name_when.or_else(|| more.name_when.clone()),
            name_field: self.name_field.or_else(|| more.name_field.clone()),
        }
    }
}

/// Returns why an output cannot have labels; `None` if it can.
pub(super) fn without_labels(args: &RenderArgs, kind: &OutputKind) -> Option<&'static str> {
    match kind {
        _ if !args.stereo.eyes().of_pair().is_empty() => Some("stereo pairs cannot have labels yet; use --eyes mono"),
        _ if args.show.is_some() => {
            Some("--show writes an intermediate target, which has no labels; leave one of the two out")
        }
        OutputKind::Picture(PictureFormat::GeoJson) => {
            Some("a .geojson holds only lines and marks; write a .svg, .pdf or .png for labels")
        }
        OutputKind::Picture(_) => None,
        _ => Some("films cannot have labels yet; write a single picture"),
    }
}

/// Checks a condition; its attributes are checked when the file is read.
fn condition(text: &str) -> Result<String, String> {
    When::parse(text).map(|_| text.to_owned()).map_err(|error| error.to_string())
}

/// Checks whether the output can have labels, and the options of a file of names.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let labels = &args.labels;
    let of_names = [
        ("--name-layer", labels.name_layer.is_some()),
        ("--name-when", labels.name_when.is_some()),
        ("--name-field", labels.name_field.is_some()),
    ];
    if let (None, Some((option, _))) = (&labels.names, of_names.iter().find(|(_, is_given)| *is_given)) {
        return Err(Misuse(format!("{option}: belongs to a file of names; add --names FILE")));
    }
    match without_labels(args, kind) {
        Some(why) if !labels.is_empty() => {
            let option = if labels.names.is_some() { "--names" } else { "--peaks" };
            Err(Misuse(format!("{option}: {why}")))
        }
        _ => Ok(()),
    }
}

/// Reads the places of `--names`; `is_own` says that the command line names the file, and not only a picture, whose
/// file no message may quote.
pub(super) fn places(args: &RenderArgs, store: &dyn TileStore, is_own: bool) -> Result<Vec<NamedPlace>, NamesError> {
    let options = &args.labels;
    let Some(file) = &options.names else { return Ok(Vec::new()) };
    let size = store.levels()[0];
    let wanted = WantedNames {
        layer: options.name_layer.clone(),
        field: options.name_field.as_deref(),
        when: options.name_when.as_deref(),
    };
    let found = named_places::read(file, &wanted, store.georeference(), [size.width, size.height])?;
    for doubt in found.doubts.iter().filter(|_| is_own) {
        tracing::warn!("{}: {doubt}", named(file));
    }
    Ok(found.places)
}

impl Job<'_> {
    /// Returns the labels of a picture, first the halo, then the letters; none without options for them.
    pub(super) fn labels(&mut self, pose: Pose) -> anyhow::Result<Vec<Block>> {
        let Some(labels) = self.laid_out(pose)? else { return Ok(Vec::new()) };
        let paper = &self.style.paper;
        let ink = if self.map.is_some() { self.style.ink_on(paper.color) } else { self.style.ink_on_sky() };
        let halo = Block { strokes: labels.halo, ..Block::empty(paper.color) };
        let letters =
            Block { strokes: labels.strokes, areas: labels.areas, replaced: labels.replaced, ..Block::empty(ink) };
        Ok(vec![halo, letters])
    }

    /// Returns the labels as groups of a drawing.
    pub(super) fn label_groups(&mut self, pose: Pose) -> anyhow::Result<Vec<Group>> {
        let is_for_pens = self.args.pens.is_some();
        let named =
            self.labels(pose)?.into_iter().zip([("names-halo", "Halo of names"), ("names", "Names and heights")]);
        // A pen has no ink of the colour of paper.
        let drawn = named.filter(|(block, (id, _))| {
            let is_empty = block.strokes.is_empty() && block.areas.is_empty();
            !is_empty && (!is_for_pens || *id != "names-halo")
        });
        Ok(drawn.map(|(block, name)| block.group(name, is_for_pens)).collect())
    }

    fn laid_out(&mut self, pose: Pose) -> anyhow::Result<Option<Labels>> {
        if self.args.labels.is_empty() {
            return Ok(None);
        }
        let sites = self.sites()?;
        let mut style = self.style.clone();
        if self.args.pens.is_some() {
            style.paper.typeface = Typeface::Strokes;
        }
        let still = PictureRequest::still(pose, self.args.size(), &style, self.world.light());
        let request = PictureRequest { clock: self.clock, tone_curve: self.tone_curve, ..still };
        let visible = names::visible(&self.gpu, &mut self.world.surfaces, &request, &sites.all)?;
        let [columns, rows] = drawn_area(&style.paper, self.args.size()).map(|ends| ends.map(|side| side as f64));
        let area_px = [DVec2::new(columns[0], rows[0]), DVec2::new(columns[1], rows[1])];
        let seen = self.chosen(&sites, visible.sites, area_px);
        let ground = Ground { area_px, paper: &style.paper, px: self.args.px_per_style_px() };
        let labels = match self.map {
            Some(_) => names::on_map(&sites.all, &seen, &ground),
            None => names::above_land(&sites.all, &seen, visible.land_top_px, &ground),
        };
        if labels.labelled.is_empty() {
            let output = named(&self.args.output);
            tracing::warn!("{output}: shows no summit or named place that has room for a label");
        }
        title::warn_of_replaced("labels", &labels.replaced);
        Ok(Some(labels))
    }

    /// Returns the sites inside of the picture's border: all names, and as many heights as were asked for.
    fn chosen(&self, sites: &Sites, seen: Vec<Seen>, [low, high]: [DVec2; 2]) -> Vec<Seen> {
        let is_inside = |at: &Seen| at.px.cmpge(low).all() && at.px.cmplt(high).all();
        let (names, mut heights): (Vec<Seen>, Vec<Seen>) =
            seen.into_iter().filter(is_inside).partition(|at| at.site < sites.names);
        let is_map = self.map.is_some();
        let longest_px = names::MAX_ON_LAND * self.args.px_per_style_px();
        heights.retain(|at| is_map || at.below_px < longest_px);
        heights.sort_by(|a, b| sites.all[b.site].weight.total_cmp(&sites.all[a.site].weight));
        heights.truncate(self.args.labels.peaks.unwrap_or(0) as usize);
        names.into_iter().chain(heights).collect()
    }

    /// Returns all places that may have labels.
    fn sites(&self) -> anyhow::Result<Sites> {
        let terrain = &self.world.surfaces.terrain;
        let store = terrain.store();
        let exaggeration = self.world.scene.vertical_exaggeration;
        let wanted = Wanted {
            most: MAX_SUMMITS,
            least_prominence_m: LEAST_PROMINENCE_M * exaggeration,
            lowest_m: (f64::from(store.range_m()[0]) / exaggeration) as f32,
            has_isolation: false,
        };
        let summits = summits_of_store(store, wanted, &Bar::default())?.unwrap_or_default();
        let [wide_m, _] = terrain.extent_m();
        let snap_m = SNAP_M.max(SNAP_SAMPLES * wide_m / f64::from(store.levels()[0].width.max(2) - 1));
        let ground_m = |at: DVec2| self.world.ground_m(at.x, at.y);
        let sites = Sites::new(&summits, &self.places, Rules { snap_m, exaggeration }, &ground_m);
        if sites.doubted > 0 {
            tracing::warn!(
                "--names: the heights of {} differ from the land by more than {MAX_OFF_M} m; the land's are drawn",
                counted(sites.doubted, "summit")
            );
        }
        Ok(sites)
    }
}

/// Places that may have labels: first those with names, then summits without one.
struct Sites {
    all: Vec<Site>,
    /// Number of sites with names.
    names: usize,
    /// Number of summits whose stated height is not that of the land.
    doubted: u64,
}

/// How places and summits are related.
#[derive(Clone, Copy)]
struct Rules {
    snap_m: f64,
    /// Factor on the heights of the drawn land.
    exaggeration: f64,
}

impl Sites {
    fn new(summits: &[Summit], places: &[NamedPlace], rules: Rules, ground_m: &dyn Fn(DVec2) -> f64) -> Self {
        let cell = |at: DVec2| (at / rules.snap_m).floor().as_i64vec2().to_array();
        let at = |summit: &Summit| DVec2::from(summit.world_m);
        let mut cells: FxHashMap<[i64; 2], Vec<usize>> = FxHashMap::default();
        for (index, summit) in summits.iter().enumerate() {
            cells.entry(cell(at(summit))).or_default().push(index);
        }
        // Pairs of a place and a summit near it, the best first: a prominent summit may be farther away.
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (number, place) in places.iter().enumerate() {
            let [x, y] = cell(place.world_m);
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]));
            for index in around.filter_map(|cell| cells.get(&cell)).flatten().copied() {
                let away_m = at(&summits[index]).distance(place.world_m);
                if away_m <= rules.snap_m {
                    pairs.push((away_m / f64::from(summits[index].prominence_m).max(1.0).sqrt(), number, index));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut summit_of: Vec<Option<usize>> = vec![None; places.len()];
        let mut is_named = vec![false; summits.len()];
        for (_, number, index) in pairs {
            if summit_of[number].is_none() && !is_named[index] {
                (summit_of[number], is_named[index]) = (Some(index), true);
            }
        }
        let mut doubted = 0;
        let named = places.iter().zip(&summit_of).map(|(place, summit)| match summit {
            Some(index) => {
                let (site, is_doubted) = of_summit(&summits[*index], Some(place), rules);
                doubted += u64::from(is_doubted);
                site
            }
            None => Site {
                world_m: place.world_m.extend(ground_m(place.world_m)),
                text: names::label(Some(&place.name), place.height_m),
                weight: ELSEWHERE_M,
                is_summit: false,
            },
        });
        let mut all: Vec<Site> = named.collect();
        let names = all.len();
        let least_m = LEAST_PROMINENCE_M * rules.exaggeration;
        let is_certain = |summit: &Summit| f64::from(summit.certain_prominence_m) >= least_m;
        let unnamed = summits.iter().zip(&is_named).filter(|(summit, is_named)| !**is_named && is_certain(summit));
        all.extend(unnamed.map(|(summit, _)| of_summit(summit, None, rules).0));
        Self { all, names, doubted }
    }
}

/// Returns the site of a summit, with the name and the stated height of a place at it, and whether that height is not
/// drawn because it differs much from that of the land.
fn of_summit(summit: &Summit, place: Option<&NamedPlace>, rules: Rules) -> (Site, bool) {
    let drawn_m = f64::from(summit.height_m);
    let land_m = drawn_m / rules.exaggeration;
    let stated_m = place.and_then(|place| place.height_m);
    let is_doubted = stated_m.is_some_and(|stated_m| (stated_m - land_m).abs() > MAX_OFF_M);
    let height_m = stated_m.filter(|_| !is_doubted).unwrap_or(land_m);
    // Beyond the border of the data, a summit there may be the slope of a higher one.
    let prominence_m = f64::from(summit.certain_prominence_m) / rules.exaggeration;
    let site = Site {
        world_m: DVec2::from(summit.world_m).extend(drawn_m),
        text: names::label(place.map(|place| place.name.as_str()), Some(height_m)),
        weight: prominence_m.max(1.0) * if place.is_some() { NAMED } else { 1.0 },
        is_summit: true,
    };
    (site, is_doubted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summit(world_m: [f64; 2], height_m: f32, prominence_m: f32) -> Summit {
        Summit {
            height_m,
            prominence_m,
            certain_prominence_m: prominence_m,
            saddle_m: None,
            isolation_m: None,
            outside_m: None,
            sample: [0, 0],
            world_m,
            latitude_longitude_deg: None,
        }
    }

    fn place(world_m: [f64; 2], name: &str, height_m: Option<f64>) -> NamedPlace {
        NamedPlace { world_m: world_m.into(), name: name.to_owned(), height_m }
    }

    #[test]
    fn names_are_those_of_the_most_prominent_summit_nearby() {
        let summits = [summit([0.0, 0.0], 3000.0, 900.0), summit([120.0, 0.0], 2980.0, 30.0)];
        let main = place([100.0, 20.0], "Main", None);
        let small = place([110.0, 0.0], "Small", Some(1490.0));
        let rules = Rules { snap_m: 250.0, exaggeration: 2.0 };
        // Whatever the order of the file.
        for places in [[&main, &small], [&small, &main]] {
            let sites = Sites::new(&summits, &places.map(Clone::clone), rules, &|_| 7.0);
            let mut texts: Vec<&str> = sites.all.iter().map(|site| site.text.as_str()).collect();
            texts.sort_unstable();
            assert_eq!((texts, sites.names), (vec!["Main 1\u{2009}500", "Small 1\u{2009}490"], 2));
        }
        let sites = Sites::new(&summits, &[main, small], rules, &|_| 7.0);
        assert_eq!(sites.all[0].world_m, DVec2::ZERO.extend(3000.0));
        assert!((sites.all[0].weight - 3.0 * 450.0).abs() < 1e-9);
        // Too far away for a name, which has a place of its own then.
        let far = [place([900.0, 0.0], "Hut", Some(1.0))];
        let sites = Sites::new(&summits, &far, rules, &|_| 7.0);
        // A height that is not that of the land.
        let wrong = Sites::new(&summits, &[place([0.0, 0.0], "Main", Some(14_411.0))], rules, &|_| 7.0);
        assert_eq!((wrong.all[0].text.as_str(), wrong.doubted), ("Main 1\u{2009}500", 1));
        // A summit on the border of the data may be none.
        let on_border = Summit { certain_prominence_m: 0.0, ..summit([5000.0, 0.0], 2000.0, 500.0) };
        assert_eq!(Sites::new(&[on_border], &[], rules, &|_| 7.0).all, []);
        let texts: Vec<&str> = sites.all.iter().map(|site| site.text.as_str()).collect();
        assert_eq!(texts, ["Hut 1", "1\u{2009}500", "1\u{2009}490"]);
        assert_eq!((sites.all[0].world_m.z, sites.all[0].is_summit, sites.names), (7.0, false, 1));
    }
}
