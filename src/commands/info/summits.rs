//! `info --peaks`: the most prominent summits of a DEM.

use std::fmt::Write as _;
use std::sync::Arc;

use anyhow::bail;
use clap::Args;

use super::{Info, InfoArgs};
use crate::commands::arguments;
use crate::commands::progress::Bar;
use crate::file::message::named;
use crate::peaks::{Summit, Wanted, summits_of_reader, summits_of_store};
use crate::pyramid::{Pyramid, TileStore};
use crate::scene::{Scene, World, ranges};
use crate::source::mosaic::Choice;
use crate::source::{self, HeightReader};
use crate::world;

/// Which summits are listed.
#[derive(Debug, Args)]
pub(crate) struct PeaksArgs {
    /// List this many of the most prominent summits of a DEM, with prominence and isolation
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole_within::<u32>(ranges::PEAKS))]
    pub peaks: Option<u32>,
    /// List only summits that rise at least this much above the saddle to higher land [default: 0]
    #[arg(long, value_name = "METRES", requires = "peaks", value_parser = arguments::within(ranges::PROMINENCE_M))]
    pub prominence: Option<f64>,
}

/// Finds the summits that are listed; `None` without `--peaks`.
///
/// # Errors
/// The file is no DEM, or its heights cannot be read.
pub(super) fn found(args: &InfoArgs, info: &Info) -> anyhow::Result<Option<Vec<Summit>>> {
    let Some(most) = args.summits.peaks else { return Ok(None) };
    let least_prominence_m = args.summits.prominence.unwrap_or(0.0);
    let wanted = |lowest_m: f32| Wanted { most: most as usize, least_prominence_m, lowest_m, has_isolation: true };
    let options = args.heights.options();
    let bar = Bar::default();
    let of_reader = |reader: &dyn HeightReader, lowest_m| summits_of_reader(reader, wanted(lowest_m), &bar);
    match info {
        Info::Dem { heights, .. } => Ok(of_reader(&*source::open_reader_with(&args.file, &options)?, heights.min_m)?),
        Info::Folder { heights, .. } => {
            let choice = Choice::of(std::slice::from_ref(&args.file), &options)?;
            Ok(of_reader(&*choice.open(&options)?, heights.min_m)?)
        }
        Info::Pyramid { heights, .. } => of_store(Arc::new(Pyramid::open(&args.file)?), wanted(heights.min_m), &bar),
        Info::Address { heights, .. } => {
            let url = args.file.to_string_lossy().into_owned();
            let scene = args.heights.apply_to(Scene::of_world(World::Url(url)));
            of_store(world::open_store(&scene, &bar)?, wanted(heights.min_m), &bar)
        }
        _ => bail!(
            "{}: --peaks needs heights: a DEM, a folder of DEMs, a pyramid or an address; for a scene, name its DEM",
            named(&args.file)
        ),
    }
}

fn of_store(store: Arc<dyn TileStore>, wanted: Wanted, bar: &Bar) -> anyhow::Result<Option<Vec<Summit>>> {
    Ok(summits_of_store(&store, wanted, bar)?)
}

/// Returns the list as text.
pub(super) fn text(summits: &[Summit], least_m: f64) -> String {
    if summits.is_empty() {
        return format!("summits   none with a prominence of at least {least_m} m\n");
    }
    let mut text = format!(
        "summits   the {} most prominent; height, prominence and saddle in m, isolation in km\n\
         {:>7} {:>15} {:>8} {:>15}  place\n",
        summits.len(),
        "height",
        "prominence",
        "saddle",
        "isolation"
    );
    for summit in summits {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "{:>7.0} {:>15} {:>8} {:>15}  {}",
            summit.height_m,
            prominence(summit),
            summit.saddle_m.map_or("-".to_owned(), |saddle_m| format!("{saddle_m:.0}")),
            isolation(summit),
            place(summit),
        );
    }
    if summits.iter().any(|summit| summit.certain_prominence_m < summit.prominence_m || summit.outside_m.is_some()) {
        text += "At least the value after ≥ is certain: beyond the border of the data, or in a gap, land may be higher or nearer.\n";
    }
    text
}

/// Returns the prominence, and the certain part of it in brackets if that is less.
fn prominence(Summit { prominence_m, certain_prominence_m, .. }: &Summit) -> String {
    if certain_prominence_m < prominence_m {
        return format!("{prominence_m:.0} (≥{certain_prominence_m:.0})");
    }
    format!("{prominence_m:.0}")
}

fn isolation(summit: &Summit) -> String {
    let km =
        |metres: f64| if metres < 10_000.0 { format!("{:.2}", metres / 1e3) } else { format!("{:.1}", metres / 1e3) };
    match (summit.isolation_m, summit.outside_m) {
        (Some(isolation_m), None) => km(isolation_m),
        (Some(isolation_m), Some(outside_m)) => format!("{} (≥{})", km(isolation_m), km(outside_m)),
        (None, Some(outside_m)) => format!("≥{}", km(outside_m)),
        (None, None) => "-".to_owned(),
    }
}

fn place(Summit { latitude_longitude_deg, world_m: [east_m, north_m], .. }: &Summit) -> String {
    let degrees = latitude_longitude_deg.map(|[latitude, longitude]| format!("{latitude:.5},{longitude:.5}; "));
    format!("{}{east_m:.0} m east, {north_m:.0} m north of the centre", degrees.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summit() -> Summit {
        Summit {
            height_m: 4371.4,
            prominence_m: 3000.6,
            certain_prominence_m: 2800.0,
            saddle_m: None,
            saddle_world_m: None,
            isolation_m: None,
            outside_m: Some(12_340.0),
            sample: [3, 4],
            world_m: [-20.4, 1000.0],
            latitude_longitude_deg: Some([46.852_51, -121.760_8]),
        }
    }

    #[test]
    fn what_is_uncertain_is_marked() {
        let highest = summit();
        assert_eq!(prominence(&highest), "3001 (≥2800)");
        assert_eq!(isolation(&highest), "≥12.3");
        assert_eq!(place(&highest), "46.85251,-121.76080; -20 m east, 1000 m north of the centre");
        assert!(text(std::slice::from_ref(&highest), 0.0).ends_with("nearer.\n"));
        let inner = Summit {
            certain_prominence_m: 3000.6,
            isolation_m: Some(1234.0),
            outside_m: None,
            latitude_longitude_deg: None,
            ..highest.clone()
        };
        assert_eq!([prominence(&inner), isolation(&inner)], ["3001", "1.23"]);
        assert!(!text(std::slice::from_ref(&inner), 0.0).contains('≥'));
        let near_border = Summit { outside_m: Some(800.0), ..inner };
        assert_eq!(isolation(&near_border), "1.23 (≥0.80)");
        assert_eq!(text(&[], 30.0), "summits   none with a prominence of at least 30 m\n");
    }
}
