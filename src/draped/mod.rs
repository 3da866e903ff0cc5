//! Features on the land: points, lines and areas of the files that a scene lists or `--layer` names.
//!
//! ```text
//! features ─▶ read: lines on the land ─▶ tree: levels of detail ─▶ resident: blocks in view on the GPU ─▶ lines/draped
//!                   └─▶ areas on the land ─▶ areas: cells with edges ──────────────────────────────────────────▲
//! ```
//!
//! Lines are kept as they are in the file, flat on the map. For each view, blocks of 64 points or fewer are chosen whose
//! error is below a fraction of a pixel, and sent to the GPU, where they get their heights. Areas are on the GPU as a whole;
//! a pixel finds out which of them it is in.
//!
//! Why: `docs/decisions/features.md`.

mod areas;
mod graticule;
mod read;
mod resident;
mod tree;

use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec2;

use self::areas::AreaTree;
pub(crate) use self::read::DrapedError;
pub(crate) use self::resident::{LandInView, Resident, ResidentFill, ResidentLayer};
pub(crate) use self::tree::BLOCK_POINTS;
use self::tree::{LineTree, Sight};
use crate::features::Attributes;
use crate::features::when::When;
use crate::file::message::{printable, quoted};
use crate::scene::frustum::Bounds;
use crate::scene::view::Rig;
use crate::style::{FeatureKinds, Features};

/// Largest error of a simplified line, in pixels.
const ERROR_PX: f64 = 0.3;
/// Number of rules whose results are kept.
const KEPT_RULES: usize = 16;

/// The features of a world.
pub(crate) struct Draped {
    tree: LineTree,
    /// The areas; `None` if there are none.
    areas: Option<AreaTree>,
    /// The source, the kind and the attributes of each line and point of `tree`, and of each area.
    parts: Vec<Part>,
    /// Names of files and layers, in lower case.
    sources: Vec<Source>,
    /// Which parts the layers of styles draw.
    rules: Mutex<Vec<(Rule, Arc<[bool]>)>>,
}

/// A file of features, or a layer of one.
struct Source {
    file: String,
    layer: String,
    /// Names of its attributes.
    attributes: Vec<String>,
    /// Whether it is the graticule, and not from a file.
    is_graticule: bool,
}

impl Source {
    /// Returns whether a layer of a style names this source, by its file or its layer in lower case. A graticule is drawn
    /// only by a layer that names it.
    fn is_named(&self, name: &str) -> bool {
        match name {
            "" => !self.is_graticule,
            name => self.file == name || self.layer == name,
        }
    }
}

/// A line or a point of the tree, or an area.
struct Part {
    kind: PartKind,
    /// Index into [`Draped::sources`].
    source: u32,
    attributes: Arc<Attributes>,
}

/// The kind of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PartKind {
    Point,
    Line,
    /// The outline of an area, or of a hole in one.
    Ring,
    /// The area within the rings of a feature.
    Area,
}

/// Which parts a layer of a style draws.
#[derive(Clone, Debug, PartialEq)]
struct Rule {
    file: String,
    when: String,
    of: FeatureKinds,
    /// Whether lines have a width, and points a diameter.
    has_lines: bool,
    has_points: bool,
    /// Whether areas are filled.
    has_fill: bool,
}

impl Rule {
    fn of(layer: &Features) -> Self {
        Self {
            file: layer.file.to_lowercase(),
            when: layer.when.clone(),
            of: layer.of,
            has_lines: layer.line_px > 0.0,
            has_points: layer.point_px > 0.0,
            has_fill: layer.fill > 0.0,
        }
    }

    fn draws(&self, part: &Part, sources: &[Source], when: Option<&When>) -> bool {
        let is_of_kind = match self.of {
            FeatureKinds::All => true,
            FeatureKinds::Points => part.kind == PartKind::Point,
            FeatureKinds::Lines => part.kind == PartKind::Line,
            FeatureKinds::Areas => matches!(part.kind, PartKind::Ring | PartKind::Area),
        };
        let has_size = match part.kind {
            PartKind::Point => self.has_points,
            PartKind::Line | PartKind::Ring => self.has_lines,
            PartKind::Area => self.has_fill,
        };
        let source = sources.get(part.source as usize);
        is_of_kind
            && has_size
            && source.is_some_and(|source| source.is_named(&self.file))
            && when.is_none_or(|when| when.is_met(&part.attributes))
    }
}

/// A block that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DrawnBlock {
    /// Index into the blocks of the tree.
    pub index: u32,
    /// East and north of the block's origin in the world, in metres.
    pub origin_m: DVec2,
}

/// The blocks that a layer of a style draws in a view.
struct InView {
    blocks: Vec<DrawnBlock>,
    /// Number of blocks that are left out, because more than the largest number are in view.
    left_out: usize,
}

impl Draped {
    /// Returns whether no feature is on the land.
    pub(crate) fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Returns whether there are features of files, and whether there is a graticule.
    pub(crate) fn has_features_and_graticule(&self) -> [bool; 2] {
        let has = |is_graticule: bool| self.sources.iter().any(|source| source.is_graticule == is_graticule);
        [has(false), has(true)]
    }

    /// Returns whether a layer of a style has areas to fill.
    pub(crate) fn fills_any(&self, layer: &Features) -> bool {
        self.filled_by(&Rule::of(layer)).is_some()
    }

    /// Returns what is wrong with the layers of a style, each as a clause: names of files and attributes that do not exist,
    /// and features that no layer draws.
    pub(crate) fn doubts(&self, layers: &[&Features]) -> Vec<String> {
        let mut doubts = Vec::new();
        let named = |layer: &Features| {
            let name = layer.file.to_lowercase();
            self.sources.iter().filter(move |source| source.is_named(&name)).collect::<Vec<_>>()
        };
        for layer in layers {
            let sources = named(layer);
            if sources.is_empty() && !layer.file.is_empty() {
                let mut known: Vec<&str> = self.sources.iter().map(|source| source.layer.as_str()).collect();
                known.dedup();
                doubts.push(format!(
                    "features.file: no file or layer is called {}; there are {}",
                    quoted(&layer.file),
                    printable(&known.join(", "), 200)
                ));
            }
            let attributes: Vec<&str> =
                sources.iter().flat_map(|source| source.attributes.iter().map(String::as_str)).collect();
            let when = (!layer.when.is_empty()).then(|| When::parse(&layer.when).ok()).flatten();
            if let Some(error) = when.filter(|_| !sources.is_empty()).and_then(|when| when.check(&attributes).err()) {
                doubts.push(format!("features.when: {error}"));
            }
        }
        let is_drawn = |source: &Source| layers.iter().any(|layer| source.is_named(&layer.file.to_lowercase()));
        for source in self.sources.iter().filter(|source| !is_drawn(source)) {
            let name = quoted(&source.layer);
            doubts.push(format!("features: no layer of the style draws {name}; add one with file = {name}"));
        }
        doubts
    }

    /// Returns the areas and, for each of them, a bit in words of 32: whether a layer of a style fills it. `None` if it
    /// fills none.
    fn filled_by(&self, rule: &Rule) -> Option<(&AreaTree, Vec<u32>)> {
        let areas = self.areas.as_ref().filter(|_| rule.has_fill)?;
        let drawn = self.drawn_by(rule);
        let mut words = vec![0_u32; drawn.len().div_ceil(32)];
        for (index, _) in self
            .parts
            .iter()
            .zip(&*drawn)
            .enumerate()
            .filter(|(_, (part, is_drawn))| part.kind == PartKind::Area && **is_drawn)
        {
            words[index / 32] |= 1 << (index % 32);
        }
        words.iter().any(|word| *word != 0).then_some((areas, words))
    }

    /// Returns which parts a layer of a style draws.
    fn drawn_by(&self, rule: &Rule) -> Arc<[bool]> {
        let mut rules = self.rules.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, drawn)) = rules.iter().find(|(known, _)| known == rule) {
            return Arc::clone(drawn);
        }
        // A style with a mistake in a condition cannot be loaded.
        let when = (!rule.when.is_empty()).then(|| When::parse(&rule.when).ok()).flatten();
        let drawn: Arc<[bool]> = self.parts.iter().map(|part| rule.draws(part, &self.sources, when.as_ref())).collect();
        if rules.len() >= KEPT_RULES {
            rules.remove(0);
        }
        rules.push((rule.clone(), Arc::clone(&drawn)));
        drawn
    }

    /// Returns the blocks that a layer of a style draws in a view of land: at most `most`. What the earth hides has none.
    fn blocks_in_view(&self, layer: &Features, rig: &Rig, land: &LandInView<'_>, most: usize) -> InView {
        let range_m = land.range_m;
        let drawn = self.drawn_by(&Rule::of(layer));
        let bounds = |low: DVec2, high: DVec2, from: glam::DVec3| Bounds {
            low_m: low.extend(range_m[0]) - from,
            high_m: high.extend(range_m[1]) - from,
        };
        let eyes: Vec<_> = rig.eyes.iter().map(|eye| (eye.pose.position_m, eye.frustum(), eye.focal_px())).collect();
        let is_seen = |low: DVec2, high: DVec2| {
            eyes.iter().any(|(from, frustum, _)| {
                let bent = (land.earth_curvature)(from.z).bend_bounds(&bounds(low, high, *from));
                bent.is_some_and(|bounds| frustum.may_see(&bounds))
            })
        };
        let pixel_m = |low: DVec2, high: DVec2| {
            let of_eye = |(from, _, focal_px): &(glam::DVec3, _, f64)| bounds(low, high, *from).distance_m() / focal_px;
            eyes.iter().map(of_eye).fold(f64::INFINITY, f64::min)
        };
        let is_drawn = |part: u32| drawn.get(part as usize).copied().unwrap_or(false);
        let sight = Sight { is_seen: &is_seen, pixel_m: &pixel_m, is_drawn: &is_drawn, error_px: ERROR_PX };
        let mut chosen = Vec::new();
        let left_out = self.tree.choose(&sight, most, &mut chosen).left_out;
        let blocks = self.tree.blocks();
        let block = |index: &u32| {
            blocks.get(*index as usize).map(|block| DrawnBlock { index: *index, origin_m: block.origin_m })
        };
        InView { blocks: chosen.iter().filter_map(block).collect(), left_out }
    }
}
