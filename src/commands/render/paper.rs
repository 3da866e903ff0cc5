//! `--paper` and `--dpi`: compute the size of a picture in pixels from its size on paper.

use super::RenderArgs;
use super::map::Page;
use super::vector::SvgOptions;
use crate::commands::misuse::Misuse;
use crate::file::message::named;
use crate::file::pattern::OutputKind;
use crate::pyramid::TileStore;
use crate::scene::map::MapArea;
use crate::scene::ranges;
use crate::source::WorldMapping;
use crate::tiles::grid_projection::GridProjection;
use crate::vector::sheet;
use crate::world::map::Edges;

/// Resolution of a raster picture on `--paper` without `--dpi`.
const SHEET_DPI: f64 = 300.0;
/// Margin around an SVG on `--paper` without `--margin`.
pub(super) const MARGIN_MM: f64 = 10.0;
pub(super) const MM_PER_INCH: f64 = 25.4;
/// Longest side of a picture, as for `--size`.
const LONGEST_PX: f64 = (1 << 20) as f64;

/// Returns the arguments with the size in pixels that follows from `--paper`, if it is given.
///
/// # Errors
/// Returns what is wrong with the arguments, in one line.
pub(super) fn measured(args: &RenderArgs, kind: &OutputKind) -> Result<RenderArgs, Misuse> {
    if kind.picture_format().is_none() {
        return not_of_a_film(args);
    }
    let is_svg = kind.is_drawing();
    let turn = if args.landscape { "--landscape" } else { "--portrait" };
    let is_turned = args.landscape || args.portrait;
    let holder = kind.lines_name();
    let mut args = args.clone();
    let Some(paper) = &args.paper else {
        return match is_turned {
            true => Err(Misuse(format!("{turn}: requires --paper, which is not given"))),
            false => Ok(args),
        };
    };
    // Lines have no pixels: without --dpi, a picture of --size is scaled to fit the paper.
    if is_svg && args.dpi.is_none() {
        return match is_turned {
            true => Err(Misuse(format!(
                "{turn}: {holder} on --paper without --dpi has the orientation of --size; add --dpi"
            ))),
            false => Ok(args),
        };
    }
    if args.size.is_some() {
        return Err(Misuse(
            "--size: cannot be combined with --paper, where the size in pixels follows from --dpi; leave --size out"
                .to_owned(),
        ));
    }
    let [longer, shorter] = sheet::sides_mm("--paper", paper).map_err(Misuse)?;
    let sides_mm = if args.portrait { [shorter, longer] } else { [longer, shorter] };
    let margin_mm = if is_svg { args.margin.unwrap_or(MARGIN_MM) } else { 0.0 };
    let dpi = *args.dpi.get_or_insert(SHEET_DPI);
    let size_px = sides_mm.map(|side| ((side - 2.0 * margin_mm) / MM_PER_INCH * dpi).round());
    if size_px.iter().any(|side| !(1.0..=LONGEST_PX).contains(side)) {
        let [width, height] = size_px.map(|side| side.max(0.0));
        return Err(Misuse(format!(
            "--paper: at {dpi} dots per inch it has {width}x{height} pixels; each side must be 1 to {LONGEST_PX}"
        )));
    }
    let size_px = size_px.map(|side| side as u32);
    ranges::check_pixels(size_px).map_err(|rule| Misuse(format!("--paper: at {dpi} dots per inch {rule}")))?;
    args.size = Some(size_px);
    Ok(args)
}

/// Returns the length of a pixel on paper in millimetres, if the paper has a size.
pub(super) fn mm_per_px(args: &RenderArgs, svg: Option<&SvgOptions>) -> Option<f64> {
    match svg {
        Some(svg) => svg.mm_per_px(),
        None => args.dpi.map(|dpi| MM_PER_INCH / dpi),
    }
}

/// How much larger the land must be on upright paper than on lying paper.
const LARGER: f64 = 1.02;

/// Returns the arguments of a map of all of the land on upright paper, if the land is larger there than on lying paper
/// and the arguments that were `given` leave the orientation open. `args` are the complete ones for lying paper.
///
/// # Errors
/// Fails if the extent of the heights is unknown.
pub(super) fn upright(
    given: &RenderArgs,
    args: &RenderArgs,
    store: &dyn TileStore,
    page: &Page,
) -> anyhow::Result<Option<RenderArgs>> {
    let is_open = !given.landscape && !given.portrait && given.size.is_none() && given.like.is_none();
    let is_whole = given.map == Some(MapArea::Whole) && given.map_place.at.is_none();
    if given.paper.is_none() || !is_open || !is_whole {
        return Ok(None);
    }
    let size = store.levels()[0];
    let mapping = WorldMapping::new(store.georeference(), size.width, size.height)?;
    let [low_m, high_m] = GridProjection::fit(&mapping, size.width, size.height).extent_m();
    let land_m = high_m - low_m;
    let Edges { foot_px, frame_px } = page.edges;
    let px_per_m = |[width, height]: [u32; 2]| {
        let room = [width, height.saturating_sub(foot_px)].map(|side| f64::from(side.saturating_sub(2 * frame_px)));
        (room[0] / land_m.x).min(room[1] / land_m.y)
    };
    let [width, height] = args.size();
    let is_larger = width > height && px_per_m([height, width]) > LARGER * px_per_m([width, height]);
    Ok(is_larger.then(|| match given.dpi {
        // Lines on paper have the orientation of their picture.
        None if args.dpi.is_none() => RenderArgs { size: Some([height, width]), ..given.clone() },
        _ => RenderArgs { portrait: true, ..given.clone() },
    }))
}

fn not_of_a_film(args: &RenderArgs) -> Result<RenderArgs, Misuse> {
    let given = [
        ("--dpi", args.dpi.is_some()),
        ("--landscape", args.landscape),
        ("--portrait", args.portrait),
        ("--paper", args.paper.is_some()),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => {
            Err(Misuse(format!("{option}: a film has no paper, and the output is {}", named(&args.output))))
        }
        None => Ok(args.clone()),
    }
}
