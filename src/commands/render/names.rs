//! `render --peaks`, `--saddles`, `--lakes` and `--names`: labels of summits, saddles, lakes and places.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use glam::DVec2;

use super::{Job, RenderArgs, title};
use crate::commands::arguments;
use crate::commands::misuse::Misuse;
use crate::commands::progress::Bar;
use crate::features::when::When;
use crate::file::message::{counted, named};
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::frame::Renderer;
use crate::picture::imprint::More;
use crate::picture::legend::drawn_area;
use crate::picture::names::lakes;
use crate::picture::names::moving::{self, MovingNames};
use crate::picture::names::sites::{Land, MAX_OFF_M, Sites};
use crate::picture::names::{self, Ground, Labels, Placed, Seen, SeenSurface, Visible, Wanted};
use crate::picture::title::Block;
use crate::picture::{PartRule, PictureRequest};
use crate::pyramid::TileStore;
use crate::scene::ranges;
use crate::scene::stereo::Pair;
use crate::scene::view::{Pose, Rig, View};
use crate::style::{Style, Typeface};
use crate::vector::Group;
use crate::world::named_places::{self, NamedPlace, NamesError, WantedNames};

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

    /// Returns the first option for labels.
    pub(crate) fn option(&self) -> &'static str {
        if self.names.is_some() { "--names" } else { "--peaks" }
    }

    /// Checks that the options of a file of names come with one.
    pub(crate) fn check(&self) -> Result<(), Misuse> {
        let of_names = [
            ("--name-layer", self.name_layer.is_some()),
            ("--name-when", self.name_when.is_some()),
            ("--name-field", self.name_field.is_some()),
        ];
        match (&self.names, of_names.iter().find(|(_, is_given)| *is_given)) {
            (None, Some((option, _))) => Err(Misuse(format!("{option}: belongs to a file of names; add --names FILE"))),
            _ => Ok(()),
        }
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
        _ if args.show.is_some() => {
            Some("--show writes an intermediate target, which has no labels; leave one of the two out")
        }
        OutputKind::Picture(PictureFormat::GeoJson) => {
            Some("a .geojson holds only lines and marks; write a .svg, .pdf or .png for labels")
        }
        OutputKind::Mesh(_) => Some("a mesh has no labels"),
        OutputKind::Picture(_) | OutputKind::Frames(..) | OutputKind::Mp4 | OutputKind::Gif => None,
    }
}

/// Checks a condition; its attributes are checked when the file is read.
fn condition(text: &str) -> Result<String, String> {
    When::parse(text).map(|_| text.to_owned()).map_err(|error| error.to_string())
}

/// Checks whether the output can have labels, and the options of a file of names.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let labels = &args.labels;
    labels.check()?;
    match without_labels(args, kind) {
        Some(why) if !labels.is_empty() => Err(Misuse(format!("{}: {why}", labels.option()))),
        Some(why) if args.has_labels() => Err(Misuse(format!("{}: {why}", args.option_of_maps()))),
        _ if args.map.is_none() && args.like.is_none() && (args.saddles.is_some() || args.lakes.is_some()) => {
            let (option, sites) = (args.option_of_maps(), &args.option_of_maps()[2..]);
            Err(Misuse(format!("{option}: only maps have labels of {sites}; add --map, or leave out the option")))
        }
        _ => Ok(()),
    }
}

/// Reads the places of `--names`; `is_own` says that the command line names the file, and not only a picture, whose
/// file no message may quote.
pub(crate) fn places(options: &NamesArgs, store: &dyn TileStore, is_own: bool) -> Result<Vec<NamedPlace>, NamesError> {
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

/// Id of the layer of a drawing with the letters of labels.
pub(super) const NAMES: &str = "names";
/// Labels with this opacity are drawn in a vector file, which has no fading ones.
const DRAWN_OPACITY: f64 = 0.5;

/// The labels of an eye's picture.
#[derive(Clone, Debug, Default)]
pub(super) struct EyeLabels {
    /// What is drawn under the letters in the colour of the paper.
    halos: Vec<Block>,
    /// Letters, leaders and symbols.
    letters: Vec<Block>,
}

impl EyeLabels {
    /// Returns the blocks in the order in which they are drawn.
    pub(super) fn blocks(&self) -> impl Iterator<Item = &Block> + Clone {
        self.halos.iter().chain(&self.letters)
    }
}

/// The places that may have labels, and the labels of the frames so far.
pub(super) struct Names {
    sites: Sites,
    moving: MovingNames,
    /// Draws pictures on which places are looked for.
    renderer: Option<Renderer>,
    /// Whether any picture had a label.
    has_labels: bool,
    /// Characters that no font has.
    replaced: Vec<char>,
}

impl Names {
    /// Finds the places of a job that has options for labels.
    ///
    /// # Errors
    /// A tile cannot be read.
    fn of(job: &Job<'_>) -> anyhow::Result<Self> {
        let terrain = &job.world.surfaces.terrain;
        let land = Land {
            store: terrain.store(),
            wide_m: terrain.extent_m()[0],
            exaggeration: job.world.scene.vertical_exaggeration,
            ground_m: &|at: DVec2| job.world.ground_m(at.x, at.y),
        };
        let sites = Sites::find(&land, &job.places, &Bar::default())?;
        if sites.doubted > 0 {
            tracing::warn!(
                "--names: the heights of {} differ from the land by more than {MAX_OFF_M} m; the land's are drawn",
                counted(sites.doubted, "summit")
            );
        }
        let moving = MovingNames::default();
        Ok(Self { sites, moving, renderer: None, has_labels: false, replaced: Vec::new() })
    }

    /// Returns the indices of sites that the picture before labels.
    fn held(&self) -> BTreeSet<usize> {
        self.moving.held()
    }
}

/// The eyes of a picture that is drawn as a whole.
fn rig_of(request: &PictureRequest<'_>, pair: Option<&Pair>) -> Rig {
    let view = View::whole(request.previous, request.pose, request.size_px).at(request.clock);
    pair.map_or_else(|| Rig::mono(view), |pair| pair.rig(&view))
}

/// How the labels of a picture are laid out and drawn.
pub(super) struct LabelRules<'a> {
    args: &'a RenderArgs,
    style: &'a Style,
    /// Time of the frame of a film in seconds; `None` for a single picture.
    time_s: Option<f64>,
}

impl LabelRules<'_> {
    /// Lays out the labels of a picture, and returns those of each eye.
    fn labels(&self, names: &mut Names, visible: &Visible) -> Vec<EyeLabels> {
        let Self { args, style, .. } = self;
        let [columns, rows] = drawn_area(&style.paper, args.size()).map(|ends| ends.map(|side| side as f64));
        let area_px = [DVec2::new(columns[0], rows[0]), DVec2::new(columns[1], rows[1])];
        let mut paper = style.paper.clone();
        if args.pens.is_some() {
            paper.typeface = Typeface::Strokes;
        }
        let ground = Ground { area_px, paper: &paper, px: args.px_per_style_px() };
        let most = args.labels.peaks.unwrap_or(0) as usize;
        let Names { sites, moving, .. } = names;
        let is_map = args.map.is_some();
        let placed = match self.time_s {
            Some(time_s) => moving.frame(time_s, sites, visible, most, &ground),
            None if is_map => Vec::new(),
            None => {
                let seen = chosen(sites, &visible.sites, [most, 0, 0], &ground, false);
                names::above_land(&sites.all, &seen, visible.land_top_px, &ground)
            }
        };
        let eyes = if args.stereo.eyes().of_pair().is_empty() { 1 } else { 2 };
        let drawn: Vec<Vec<(f64, Labels)>> = if is_map {
            let [saddles, lakes] = [args.saddles, args.lakes].map(|most| most.unwrap_or(0) as usize);
            let seen = chosen(sites, &visible.sites, [most, saddles, lakes], &ground, true);
            vec![vec![(1.0, names::on_map(&sites.all, &seen, &ground))]]
        } else {
            (0..eyes).map(|eye| of_eye(sites, &placed, eye, &ground)).collect()
        };
        for (_, labels) in drawn.iter().flatten() {
            names.has_labels |= !labels.labelled.is_empty();
            names.replaced.extend(&labels.replaced);
        }
        drawn.into_iter().map(|labels| self.blocks(labels)).collect()
    }

    /// Returns the blocks of labels with their opacities.
    fn blocks(&self, labels: Vec<(f64, Labels)>) -> EyeLabels {
        let paper = &self.style.paper;
        let ink = if self.args.map.is_some() { self.style.ink_on(paper.color) } else { self.style.ink_on_sky() };
        let mut drawn = EyeLabels::default();
        for (opacity, labels) in labels {
            let opacity = opacity as f32;
            drawn.halos.push(Block { strokes: labels.halo, opacity, ..Block::empty(paper.color) });
            let (strokes, areas, texts) = (labels.strokes, labels.areas, labels.texts);
            drawn.letters.push(Block { strokes, areas, texts, opacity, ..Block::empty(ink) });
        }
        drawn
    }
}

/// Returns the labels of an eye with their opacities: those that are opaque together.
fn of_eye(sites: &Sites, placed: &[Placed], eye: usize, ground: &Ground<'_>) -> Vec<(f64, Labels)> {
    let (opaque, fading): (Vec<&Placed>, Vec<&Placed>) = placed.iter().partition(|label| label.opacity >= 1.0);
    let drawn = |labels: &[&Placed]| names::drawn_rows(&sites.all, labels.iter().copied(), eye, ground);
    let opaque = [(1.0, drawn(&opaque))].into_iter();
    opaque.chain(fading.into_iter().map(|label| (label.opacity, drawn(&[label])))).collect()
}

/// Returns the sites inside of the picture's border: all names, and so many of the weightiest summits without names, of the
/// weightiest saddles, and of the largest lakes.
fn chosen(sites: &Sites, seen: &[Seen], most: [usize; 3], ground: &Ground<'_>, is_map: bool) -> Vec<Seen> {
    let inside = seen.iter().filter(|at| moving::is_inside(at, ground)).copied();
    let (names, heights): (Vec<Seen>, Vec<Seen>) = inside.partition(|at| at.site < sites.names);
    let longest_px = names::MAX_ON_LAND * ground.px;
    let legible = heights.into_iter().filter(|at| is_map || at.below_px < longest_px);
    let (summits, others): (Vec<Seen>, Vec<Seen>) = legible.partition(|at| at.site < sites.first_saddle());
    let (saddles, lakes): (Vec<Seen>, Vec<Seen>) = others.into_iter().partition(|at| at.site < sites.first_lake());
    let weightiest = |(mut heights, most): (Vec<Seen>, usize)| {
        heights.sort_by(|a, b| sites.all[b.site].weight.total_cmp(&sites.all[a.site].weight));
        heights.truncate(most);
        heights
    };
    names.into_iter().chain([summits, saddles, lakes].into_iter().zip(most).flat_map(weightiest)).collect()
}

impl RenderArgs {
    /// Returns whether any option asks for labels.
    pub(super) fn has_labels(&self) -> bool {
        !self.labels.is_empty() || self.saddles.unwrap_or(0) > 0 || self.lakes.unwrap_or(0) > 0
    }

    /// Returns the first option for labels that only maps have.
    fn option_of_maps(&self) -> &'static str {
        if self.saddles.is_some() { "--saddles" } else { "--lakes" }
    }
}

impl Job<'_> {
    /// Finds the places that may have labels, if there are options for them.
    ///
    /// # Errors
    /// A tile cannot be read.
    pub(super) fn find_names(&mut self) -> anyhow::Result<()> {
        if self.args.has_labels() {
            self.names = Some(Names::of(self)?);
        }
        Ok(())
    }

    /// Warns if no picture had a label, and about characters that no font has.
    pub(super) fn warn_of_names(&self) {
        let Some(names) = &self.names else { return };
        if !names.has_labels {
            let output = named(&self.args.output);
            tracing::warn!("{output}: shows no summit or named place that has room for a label");
        }
        title::warn_of_replaced("labels", &names.replaced);
    }

    /// Returns whether the surface of each frame decides which labels it has, so that labels are laid out after a frame
    /// is drawn. Other pictures are looked at beforehand.
    pub(super) fn labels_follow_frame(&self) -> bool {
        let is_one_frame = PartRule::default().is_whole(self.args.size()) && self.args.samples() == 1;
        self.names.is_some() && self.args.path.is_some() && is_one_frame && self.svg.is_none()
    }

    /// Returns the labels of each eye for a picture that is drawn next; none without options for them.
    ///
    /// # Errors
    /// The picture on which places are looked for cannot be drawn.
    pub(super) fn labels(&mut self, pose: Pose) -> anyhow::Result<Vec<EyeLabels>> {
        let Some(names) = &mut self.names else { return Ok(Vec::new()) };
        let still = PictureRequest::still(pose, self.args.size(), &self.style, self.world.light());
        let request = PictureRequest { clock: self.clock, tone_curve: self.tone_curve, ..still };
        if let Some(placed) = self.map.as_ref().filter(|_| self.args.lakes.unwrap_or(0) > 0) {
            let exaggeration = self.world.scene.vertical_exaggeration;
            let inputs = lakes::Inputs { map: &placed.map, exaggeration, px: self.args.px_per_style_px() };
            names.sites.set_lakes(lakes::lakes(&self.gpu, &mut self.world.surfaces, &request, &inputs)?);
        }
        let held = names.held();
        let wanted = Wanted { sites: &names.sites.all, held: &held };
        let (gpu, surfaces) = (&self.gpu, &mut self.world.surfaces);
        let visible = names::visible(gpu, &mut names.renderer, surfaces, &request, self.pair.as_ref(), wanted)?;
        let time_s = self.args.path.is_some().then_some(self.clock.now_s);
        Ok(LabelRules { args: self.args, style: &self.style, time_s }.labels(names, &visible))
    }

    /// Returns the labels of each eye for the frame that was drawn last.
    ///
    /// # Errors
    /// The frame cannot be read back.
    pub(super) fn labels_of_frame(&mut self, pose: Pose, previous: Pose) -> anyhow::Result<Vec<EyeLabels>> {
        let still = PictureRequest::still(pose, self.args.size(), &self.style, self.world.light());
        let request = PictureRequest { previous, clock: self.clock, ..still };
        let rig = rig_of(&request, self.pair.as_ref());
        let drawn = self.renderer.as_ref();
        let surface = drawn.map(|drawn| SeenSurface::read(&self.gpu, drawn, &self.world.surfaces, &rig)).transpose()?;
        let (Some(names), Some(surface)) = (&mut self.names, surface.flatten()) else { return self.labels(pose) };
        let held = names.held();
        let visible = surface.visible(Wanted { sites: &names.sites.all, held: &held }, &rig);
        let rules = LabelRules { args: self.args, style: &self.style, time_s: Some(self.clock.now_s) };
        Ok(rules.labels(names, &visible))
    }

    /// Returns the labels as groups of a drawing, for each eye.
    ///
    /// # Errors
    /// The errors of [`Job::labels`].
    pub(super) fn label_groups(&mut self, pose: Pose) -> anyhow::Result<Vec<Vec<Group>>> {
        let is_for_pens = self.args.pens.is_some();
        let joined = |blocks: Vec<Block>| {
            let drawn = blocks.into_iter().filter(|block| f64::from(block.opacity) >= DRAWN_OPACITY);
            drawn.reduce(|mut all, block| {
                all.strokes.extend(block.strokes);
                all.areas.extend(block.areas);
                all.texts.extend(block.texts);
                all
            })
        };
        let groups = |EyeLabels { halos, letters }: EyeLabels| {
            // A pen has no ink of the colour of paper.
            let halos = if is_for_pens { None } else { joined(halos) };
            let named = [(halos, ("names-halo", "Halo of names")), (joined(letters), (NAMES, "Names and heights"))];
            let blocks = named.into_iter().filter_map(|(block, name)| block.zip(Some(name)));
            let drawn = blocks.filter(|(block, _)| !block.strokes.is_empty() || !block.areas.is_empty());
            drawn.map(|(block, name)| block.group(name, is_for_pens)).collect()
        };
        Ok(self.labels(pose)?.into_iter().map(groups).collect())
    }
}
