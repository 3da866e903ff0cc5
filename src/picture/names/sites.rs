//! The sites of a world that may have labels: its summits and saddles, and the places of a file of names.

use std::sync::Arc;

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::{Site, SiteKind, label};
use crate::peaks::{Summit, SummitsError, Wanted, summits_of_store};
use crate::pyramid::{PyramidError, TileStore};
use crate::source::Progress;
use crate::world::named_places::NamedPlace;

/// Least prominence of a summit that may have a label, in metres without exaggeration.
const LEAST_PROMINENCE_M: f64 = 5.0;
/// Largest number of summits among which those of a picture are chosen.
const MAX_SUMMITS: usize = 50_000;
/// A named place is at a summit if that is within this distance in metres, or within so many samples if they are
/// farther apart.
const SNAP_M: f64 = 250.0;
const SNAP_SAMPLES: f64 = 3.0;
/// Largest difference of a stated height from that of the land, in metres.
pub(crate) const MAX_OFF_M: f64 = 200.0;
/// Importance of a name relative to a height alone, and that of a name which is at no summit, in metres of prominence.
const NAMED: f64 = 3.0;
const ELSEWHERE_M: f64 = 60.0;
/// Importance of a key saddle relative to the summit whose prominence it determines.
const SADDLE: f64 = 0.5;

/// Places that may have labels: first those with names, then summits without one, then saddles, then lakes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sites {
    pub all: Vec<Site>,
    /// Number of sites with names.
    pub names: usize,
    /// Number of saddles.
    pub saddles: usize,
    /// Number of lakes.
    pub lakes: usize,
    /// Number of summits whose stated height is not that of the land.
    pub doubted: u64,
}

/// The land on which sites are looked for.
pub(crate) struct Land<'a> {
    pub store: &'a Arc<dyn TileStore>,
    /// Extent from west to east, in metres.
    pub wide_m: f64,
    /// Factor on the heights of the drawn land.
    pub exaggeration: f64,
    /// Height of the drawn land at a place, in metres.
    pub ground_m: &'a dyn Fn(DVec2) -> f64,
}

/// How places and summits are related.
#[derive(Clone, Copy)]
struct Rules {
    snap_m: f64,
    /// Factor on the heights of the drawn land.
    exaggeration: f64,
}

impl Sites {
    /// Finds the summits of a land, and relates places to them. Reads all samples of the finest level.
    ///
    /// # Errors
    /// A tile cannot be read.
    pub(crate) fn find(
        land: &Land<'_>,
        places: &[NamedPlace],
        progress: &dyn Progress,
    ) -> Result<Self, SummitsError<PyramidError>> {
        let &Land { store, wide_m, exaggeration, ground_m } = land;
        let wanted = Wanted {
            most: MAX_SUMMITS,
            least_prominence_m: LEAST_PROMINENCE_M * exaggeration,
            lowest_m: (f64::from(store.range_m()[0]) / exaggeration) as f32,
            has_isolation: false,
        };
        let summits = summits_of_store(store, wanted, progress)?.unwrap_or_default();
        let snap_m = SNAP_M.max(SNAP_SAMPLES * wide_m / f64::from(store.levels()[0].width.max(2) - 1));
        Ok(Self::new(&summits, places, Rules { snap_m, exaggeration }, ground_m))
    }

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
                text: label(Some(&place.name), place.height_m),
                weight: ELSEWHERE_M,
                kind: SiteKind::Place,
            },
        });
        let mut all: Vec<Site> = named.collect();
        let names = all.len();
        let least_m = LEAST_PROMINENCE_M * rules.exaggeration;
        let is_certain = |summit: &Summit| f64::from(summit.certain_prominence_m) >= least_m;
        let unnamed = summits.iter().zip(&is_named).filter(|(summit, is_named)| !**is_named && is_certain(summit));
        all.extend(unnamed.map(|(summit, _)| of_summit(summit, None, rules).0));
        let without_saddles = all.len();
        all.extend(summits.iter().filter(|summit| is_certain(summit)).filter_map(|summit| of_saddle(summit, rules)));
        let saddles = all.len() - without_saddles;
        Self { all, names, saddles, lakes: 0, doubted }
    }

    /// Returns the index of the first saddle in `all`.
    pub(crate) fn first_saddle(&self) -> usize {
        self.first_lake() - self.saddles
    }

    /// Returns the index of the first lake in `all`.
    pub(crate) fn first_lake(&self) -> usize {
        self.all.len() - self.lakes
    }

    /// Replaces the lakes, which depend on the map.
    pub(crate) fn set_lakes(&mut self, lakes: Vec<Site>) {
        self.all.truncate(self.first_lake());
        self.lakes = lakes.len();
        self.all.extend(lakes);
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
        text: label(place.map(|place| place.name.as_str()), Some(height_m)),
        weight: prominence_m.max(1.0) * if place.is_some() { NAMED } else { 1.0 },
        kind: SiteKind::Summit,
    };
    (site, is_doubted)
}

/// Returns the site of the key saddle of a summit; `None` if it may be outside of the data.
fn of_saddle(summit: &Summit, rules: Rules) -> Option<Site> {
    let drawn_m = f64::from(summit.saddle_m?);
    let is_certain = summit.certain_prominence_m >= summit.prominence_m;
    let world_m = DVec2::from(summit.saddle_world_m?).extend(drawn_m);
    let weight = SADDLE * (f64::from(summit.prominence_m) / rules.exaggeration).max(1.0);
    is_certain.then(|| Site {
        world_m,
        text: label(None, Some(drawn_m / rules.exaggeration)),
        weight,
        kind: SiteKind::Saddle,
    })
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
            saddle_world_m: None,
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
        assert_eq!((sites.all[0].world_m.z, sites.all[0].kind, sites.names), (7.0, SiteKind::Place, 1));
        // Saddles come last, have the height of the land, and are left out if one outside of the data may be higher.
        let with_saddle = Summit { saddle_m: Some(2100.0), saddle_world_m: Some([40.0, 50.0]), ..summits[0].clone() };
        let uncertain = Summit { certain_prominence_m: 400.0, ..with_saddle.clone() };
        let sites = Sites::new(&[with_saddle, uncertain], &[], rules, &|_| 7.0);
        assert_eq!((sites.first_saddle(), sites.all.len()), (2, 3));
        let Site { world_m, text, kind, .. } = &sites.all[2];
        assert_eq!(
            (world_m.to_array(), text.as_str(), *kind),
            ([40.0, 50.0, 2100.0], "1\u{2009}050", SiteKind::Saddle)
        );
    }
}
