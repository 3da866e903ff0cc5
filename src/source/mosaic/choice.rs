//! Chooses which of several files are the heights of a world.
//!
//! Folders of DEMs also hold other rasters on the same ground. Files that are pictures, or have samples of 8 bits, do
//! not hold heights; those that disagree with the DEM ([`super::agreement`]) are left out as well. Each is reported by
//! name.

use std::path::{Path, PathBuf};

use super::agreement::{self, Claim, Difference, Roughness};
use super::{Misfit, MosaicGrid, MosaicReader};
use crate::file::message::named;
use crate::source::folder::{self, Kind, kind_of};
use crate::source::values::Holds;
use crate::source::{HeightReader, OpenOptions, SourceError, VoidMode, open_as_it_is, open_reader_with, voids};

/// A named file that disagrees with another is left out only if it is rougher by this factor, as derived rasters are:
/// whoever names a file means it.
const ROUGHER: f64 = 3.0;

/// The height files of a world.
pub(crate) struct Choice {
    /// The files, in the given order; the files of a folder are sorted.
    pub files: Vec<PathBuf>,
    /// Files that hold no heights, with the reason as the end of a sentence.
    pub left_out: Vec<(PathBuf, String)>,
    /// Warnings about files that are used although they disagree with another.
    doubts: Vec<String>,
}

impl Choice {
    /// Chooses from files and folders.
    ///
    /// # Errors
    /// Fails if a folder or a file cannot be read, if no file holds heights, or if the files have no common grid. The
    /// message names the file that is the reason.
    pub(crate) fn of(inputs: &[PathBuf], options: &OpenOptions) -> Result<Self, SourceError> {
        let mut found = Vec::new();
        for input in inputs {
            match kind_of(input) {
                Kind::Folder => found.extend(folder::members(input)?.into_iter().map(|file| (file, false))),
                Kind::File | Kind::TileFolder => found.push((input.clone(), true)),
            }
        }
        let mut choice = Self { files: Vec::new(), left_out: Vec::new(), doubts: Vec::new() };
        if let [(file, true)] = &found[..] {
            choice.files.push(file.clone());
            return Ok(choice);
        }
        let bare = OpenOptions { voids: VoidMode::Holes, ..*options };
        let mut candidates = Vec::new();
        let mut refused = None;
        for (path, is_named) in found {
            let opened = open_as_it_is(&path, &bare).and_then(|reader| match reader.is_coarse() {
                true => Err(SourceError::NotHeights { path: path.clone(), what: COARSE, holds: Holds::Heights }),
                false => Ok(reader),
            });
            match opened {
                Ok(reader) => candidates.push(Candidate { path, is_named, reader }),
                Err(SourceError::NotHeights { path, what, holds }) => {
                    choice.left_out.push((path.clone(), format!("holds {what}, not {holds}")));
                    refused.get_or_insert(SourceError::NotHeights { path, what, holds });
                }
                Err(error) => return Err(error),
            }
        }
        if let (true, Some(refused)) = (candidates.is_empty(), refused) {
            return Err(refused);
        }
        choice.leave_out_derived(candidates)?;
        Ok(choice)
    }

    /// Opens the files, several as one grid.
    ///
    /// # Errors
    /// Fails if a file cannot be read, or if the files have no common grid.
    pub(crate) fn open(&self, options: &OpenOptions) -> Result<Box<dyn HeightReader>, SourceError> {
        if let [file] = &self.files[..] {
            return open_reader_with(file, options);
        }
        // No-data of one file may be land in another, so holes are filled in the combined grid.
        let bare = OpenOptions { voids: VoidMode::Holes, ..*options };
        let readers = self.files.iter().map(|file| open_reader_with(file, &bare)).collect::<Result<Vec<_>, _>>()?;
        let mosaic = Box::new(MosaicReader::new(readers)?);
        Ok(match options.voids {
            VoidMode::Fill => voids::filled(mosaic),
            VoidMode::Holes => mosaic,
        })
    }

    /// Prints a warning for each file that is left out, or that disagrees with another.
    pub(crate) fn warn(&self) {
        for (file, why) in &self.left_out {
            tracing::warn!("{}: left out, because it {why}", named(file));
        }
        self.doubts.iter().for_each(|doubt| tracing::warn!("{doubt}"));
    }

    fn leave_out_derived(&mut self, candidates: Vec<Candidate>) -> Result<(), SourceError> {
        let places: Vec<_> =
            candidates.iter().map(|candidate| (candidate.reader.georeference(), candidate.reader.size())).collect();
        MosaicGrid::new(&places).map_err(|Misfit { member, cause }| {
            let path = candidates.get(member).map_or_else(PathBuf::new, |candidate| candidate.path.clone());
            SourceError::Mosaic { path, cause }
        })?;
        let conflicts = Conflicts::between(&candidates)?;
        let mut is_kept = vec![false; candidates.len()];
        for &member in &conflicts.by_trust {
            let winner = conflicts.of(member).find(|(other, _)| is_kept[*other]);
            is_kept[member] = winner.is_none();
            let Some((winner, difference)) = winner else { continue };
            let (path, other) = (&candidates[member].path, &candidates[winner].path);
            let why = words(difference, other);
            let is_rough = conflicts.shares[member] > ROUGHER * conflicts.shares[winner];
            if candidates[member].is_named && !is_rough && Claim::of(&stem(path)) != Claim::Derived {
                is_kept[member] = true;
                self.doubts.push(format!("{}: {why}; both are used, because both were named", named(path)));
            } else {
                let why = format!("{why}; {} is taken for the DEM", file_name(other));
                self.left_out.push((path.clone(), format!("does not hold its heights: {why}")));
            }
        }
        let kept = candidates.into_iter().zip(is_kept).filter(|(_, is_kept)| *is_kept);
        self.files = kept.map(|(candidate, _)| candidate.path).collect();
        self.left_out.sort();
        Ok(())
    }
}

/// The content of a file of 8-bit samples in messages: the same words as for PNG.
const COARSE: &str = "a grey picture of 8 bits or less";

struct Candidate {
    path: PathBuf,
    /// Whether the file itself was given, and not its folder.
    is_named: bool,
    reader: Box<dyn HeightReader>,
}

/// Which files disagree, and which of them are most probably the DEM.
struct Conflicts {
    pairs: Vec<(usize, usize, Difference)>,
    /// Roughness of each file, where it overlaps others.
    shares: Vec<f64>,
    /// All files, the most trusted first.
    by_trust: Vec<usize>,
}

impl Conflicts {
    fn between(candidates: &[Candidate]) -> Result<Self, SourceError> {
        let placed: Vec<_> = candidates
            .iter()
            .map(|candidate| {
                let way = agreement::way_between(&*candidate.reader, &*candidates[0].reader);
                let bounds = way.ok().and_then(|way| agreement::bounds(&way, candidate.reader.size()));
                agreement::PlacedReader {
                    reader: &*candidate.reader,
                    box_samples: bounds.unwrap_or([f64::NAN; 4]),
                    claim: Claim::of(&stem(&candidate.path)),
                }
            })
            .collect();
        let mut pairs = Vec::new();
        let mut roughness = vec![Roughness::default(); placed.len()];
        for b in 1..placed.len() {
            for a in 0..b {
                let Some((difference, found)) = agreement::compare([&placed[a], &placed[b]])? else { continue };
                roughness[a].join(found[0]);
                roughness[b].join(found[1]);
                pairs.extend(difference.map(|difference| (a, b, difference)));
            }
        }
        let shares: Vec<f64> = roughness.into_iter().map(Roughness::share).collect();
        // Where the values are proportional, the smaller are metres rather than feet or centimetres.
        let is_larger = |member: usize| {
            pairs.iter().any(|&(a, b, difference)| match difference {
                Difference::Factor(factor) => (a == member && factor > 1.0) || (b == member && factor < 1.0),
                Difference::Other { .. } => false,
            })
        };
        let mut by_trust: Vec<usize> = (0..placed.len()).collect();
        by_trust.sort_by(|&a, &b| {
            let claims = placed[a].claim.cmp(&placed[b].claim);
            claims.then(is_larger(a).cmp(&is_larger(b))).then(shares[a].total_cmp(&shares[b]))
        });
        Ok(Self { pairs, shares, by_trust })
    }

    /// Returns the files that disagree with `member`; a factor is that of the member's values.
    fn of(&self, member: usize) -> impl Iterator<Item = (usize, Difference)> {
        self.pairs.iter().filter_map(move |&(a, b, difference)| match difference {
            _ if a == member => Some((b, difference)),
            Difference::Factor(factor) if b == member => Some((a, Difference::Factor(1.0 / factor))),
            _ if b == member => Some((a, difference)),
            _ => None,
        })
    }
}

fn words(difference: Difference, other: &Path) -> String {
    let other = file_name(other);
    match difference {
        Difference::Factor(factor) => {
            format!("its values are {factor:.4} times those of {other} on the same ground, as in another unit")
        }
        Difference::Other { median_m } => {
            format!("on the same ground it differs from {other} by {median_m:.0} m (median)")
        }
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn file_name(path: &Path) -> String {
    named(path.file_name().unwrap_or(path.as_os_str()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::file::atomic;
    use crate::file::geotiff::GeoTiffWriter;

    const SIDE: u32 = 60;

    fn height_m(x: f64, y: f64) -> f64 {
        900.0 + 150.0 * (x / 17.0).sin() * (y / 13.0).cos() + 20.0 * (x / 3.1).sin() + 2.0 * y
    }

    fn slopes(x: f64, y: f64) -> [f64; 2] {
        [(height_m(x + 1.0, y) - height_m(x - 1.0, y)) / 60.0, (height_m(x, y + 1.0) - height_m(x, y - 1.0)) / 60.0]
    }

    fn slope_deg(x: f64, y: f64) -> f64 {
        slopes(x, y)[0].hypot(slopes(x, y)[1]).atan().to_degrees()
    }

    fn aspect_deg(x: f64, y: f64) -> f64 {
        slopes(x, y)[1].atan2(slopes(x, y)[0]).to_degrees().rem_euclid(360.0)
    }

    fn roughness_m(x: f64, y: f64) -> f64 {
        let around = [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)];
        around.iter().map(|(i, k)| (height_m(x + i, y + k) - height_m(x, y)).abs()).fold(0.0, f64::max)
    }

    /// Writes an ASCII grid whose first column is `west` samples of 30 m from the origin.
    fn write(folder: &Path, name: &str, west: u32, of: impl Fn(f64, f64) -> f64) -> PathBuf {
        let value = |i: u32| of(f64::from(west + i % SIDE), f64::from(i / SIDE));
        let values: Vec<String> = (0..SIDE * SIDE).map(|i| format!("{:.3}", value(i))).collect();
        let header = format!("ncols {SIDE}\nnrows {SIDE}\nxllcorner {}\nyllcorner 0\ncellsize 30\n", 30 * west);
        let path = folder.join(name);
        atomic::write(&path, (header + &values.join(" ")).as_bytes()).unwrap();
        path
    }

    /// Writes a BIL of 8-bit samples.
    fn write_8_bit(folder: &Path, name: &str) {
        let samples: Vec<u8> = (0..SIDE * SIDE).map(|i| (i % 251) as u8).collect();
        atomic::write(&folder.join(name), &samples).unwrap();
        let header =
            format!("ncols {SIDE}\nnrows {SIDE}\nnbits 8\nulxmap 15\nulymap 1785\nxdim 30\nydim 30\nbyteorder I\n");
        atomic::write(&folder.join(name).with_extension("hdr"), header.as_bytes()).unwrap();
    }

    fn names(choice: &Choice) -> (Vec<String>, Vec<String>) {
        let left_out = choice.left_out.iter().map(|(path, _)| file_name(path)).collect();
        (choice.files.iter().map(|path| file_name(path)).collect(), left_out)
    }

    fn of(inputs: &[PathBuf]) -> Choice {
        Choice::of(inputs, &OpenOptions::default()).unwrap()
    }

    #[test]
    fn derived_rasters_of_a_folder_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        // Names that do not help, in an order in which the DEM is last.
        write(at, "a.asc", 0, slope_deg);
        write(at, "b.asc", 0, aspect_deg);
        write(at, "c.asc", 0, roughness_m);
        write(at, "d.asc", 0, |x, y| 180.0 + 70.0 * (slopes(x, y)[0] - slopes(x, y)[1]).tanh());
        write(at, "e.asc", 0, |x, y| if x * y > 900.0 { 40.0 } else { 10.0 });
        write_8_bit(at, "f.bil");
        let tags = Default::default();
        let mut rgb = GeoTiffWriter::create(&at.join("g.tif"), 2, 2, tags, None, None).unwrap();
        rgb.write_rows(&[0; 16]).unwrap();
        rgb.finish().unwrap();
        write(at, "x.asc", 0, height_m);
        // Neighbours and other surveys belong to the world.
        write(at, "y.asc", 59, height_m);
        write(at, "z.asc", 30, |x, y| height_m(x, y) + 47.0 + 3.0 * (x * 77.0).sin());
        let choice = of(&[at.to_owned()]);
        let (files, left_out) = names(&choice);
        assert_eq!(files, ["x.asc", "y.asc", "z.asc"], "{:?}", choice.left_out);
        assert_eq!(left_out, ["a.asc", "b.asc", "c.asc", "d.asc", "e.asc", "f.bil", "g.tif"]);
        let why = |name: &str| &choice.left_out.iter().find(|(path, _)| path.ends_with(name)).unwrap().1;
        assert!(why("a.asc").contains("x.asc is taken for the DEM"), "{}", why("a.asc"));
        assert!(why("f.bil").contains("8 bits") && why("g.tif").contains("RGB"));
    }

    #[test]
    fn names_decide_where_values_do_not() {
        let folder = tempfile::tempdir().unwrap();
        // A smooth field that is not one of heights: temperature, or the height of the geoid.
        write(folder.path(), "geoid.asc", 0, |x, y| 3000.0 + 0.1 * x + 0.2 * y);
        write(folder.path(), "dem.asc", 0, height_m);
        assert_eq!(names(&of(&[folder.path().to_owned()])).0, ["dem.asc"]);
        write(folder.path(), "feet.asc", 0, |x, y| height_m(x, y) / 0.3048);
        let choice = of(&[folder.path().to_owned()]);
        assert_eq!(names(&choice).0, ["dem.asc"]);
        assert!(choice.left_out[0].1.contains("3.2808 times"), "{:?}", choice.left_out);
    }

    #[test]
    fn named_files_are_used_unless_they_are_derived() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        let dem = write(at, "a.asc", 0, height_m);
        let slope = write(at, "b.asc", 0, slope_deg);
        let pit = write(at, "c.asc", 0, |x, y| height_m(x, y) - 400.0);
        let choice = of(&[slope, dem.clone(), pit.clone()]);
        assert_eq!(names(&choice).0, ["a.asc", "c.asc"]);
        assert_eq!(choice.doubts.len(), 1, "{:?}", choice.doubts);
        // Of a folder, such a file is left out.
        assert_eq!(names(&of(&[at.to_owned()])).0.len(), 1);
    }

    #[test]
    fn the_file_that_does_not_fit_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        write_8_bit(at, "only.bil");
        let error = Choice::of(&[at.to_owned()], &OpenOptions::default()).err().unwrap().to_string();
        assert!(error.contains("only.bil: holds a grey picture of 8 bits or less, not heights"), "{error}");
        write(at, "t0.asc", 0, height_m);
        write(at, "t1.asc", 59, height_m);
        for name in ["t0", "t2"] {
            let text = "PROJCS[\"WGS 84 / UTM zone 32N\",AUTHORITY[\"EPSG\",\"32632\"]]";
            atomic::write(&at.join(name).with_extension("prj"), text.as_bytes()).unwrap();
        }
        write(at, "t2.asc", 118, height_m);
        let error = Choice::of(&[at.to_owned()], &OpenOptions::default()).err().unwrap().to_string();
        assert!(error.contains("t1.asc: has no coordinate reference system"), "{error}");
        assert!(!error.contains("t0") && !error.contains('\t'), "{error}");
    }
}
