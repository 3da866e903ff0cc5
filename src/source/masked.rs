//! Masks: pictures that mark which samples of a GeoTIFF are heights. Where a mask is 0 there is no height, whatever the
//! sample holds.
//!
//! A mask is a separate picture in the same file (a transparency mask, TIFF 6.0, section 8), a sidecar file
//! (`dem.tif.msk`, which GDAL writes by default), or an alpha band among the bands.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tiff_reader::cache::BlockCache;
use tiff_reader::{OpenOptions, TiffFile};

use super::SourceError;
use super::georeference::Georeference;
use super::geotiff::{damaged, decode_error, guarded};
use super::geotiff_layout::{Layout, MAX_BLOCK_BYTES, check_mask, is_mask};
use super::place::{self, cannot_open, inconsistent};
use super::reader::{HeightReader, Window};
use super::tiff_blocks::{self as tiff_blocks, Blocks};

/// Size of the cache for decoded strips and tiles of a mask in its own file.
const CACHE_BYTES: usize = 8 << 20;

/// A picture or band that is 0 where there is no height.
#[derive(Clone)]
pub(super) struct Mask {
    /// The file that contains the mask.
    name: PathBuf,
    file: Arc<TiffFile>,
    cache: Arc<BlockCache>,
    pub blocks: Arc<Blocks>,
    band: usize,
}

impl Mask {
    /// Returns all masks of the heights in `blocks`: those inside the file and that of the sidecar file.
    ///
    /// # Errors
    /// Fails if a mask cannot be read, because the heights that it hides would otherwise be shown.
    pub(super) fn all(
        file: &Arc<TiffFile>,
        cache: &Arc<BlockCache>,
        blocks: &Arc<Blocks>,
        file_bytes: u64,
        path: &Path,
    ) -> Result<Vec<Self>, SourceError> {
        let mut masks: Vec<Self> = Self::internal(file, cache, blocks, file_bytes, path)?.into_iter().collect();
        if let Some(sidecar_path) = sidecar_mask(path) {
            masks.extend(Self::open(&sidecar_path, blocks.size)?);
        }
        Ok(masks)
    }

    /// Returns the mask inside the file for the picture in `blocks`: a mask picture of the same size, or an alpha band.
    ///
    /// # Errors
    /// The same as [`Mask::all`].
    pub(super) fn internal(
        file: &Arc<TiffFile>,
        cache: &Arc<BlockCache>,
        blocks: &Arc<Blocks>,
        file_bytes: u64,
        path: &Path,
    ) -> Result<Option<Self>, SourceError> {
        let [width, height] = blocks.size;
        let of_size = |ifd: &&tiff_reader::Ifd| is_mask(ifd) && [ifd.width(), ifd.height()] == [width, height];
        let mask = |blocks, band| Self { name: path.into(), file: file.clone(), cache: cache.clone(), blocks, band };
        if let Some((index, ifd)) = file.ifds().iter().enumerate().find(|(_, ifd)| of_size(ifd))
            && index != blocks.ifd
        {
            let Layout { blocks, block_bytes, .. } = check_mask(ifd, index, file_bytes, path)?;
            let mask = mask(Arc::new(blocks), 0);
            // A cache of its own keeps a strip that spans the whole picture from being decoded again for each window.
            let is_large = block_bytes > CACHE_BYTES as u64;
            let own = || Self { cache: tiff_blocks::cache(block_bytes as usize), ..mask.clone() };
            return Ok(Some(if is_large { own() } else { mask }));
        }
        let Some(band) = blocks.samples.alpha else { return Ok(None) };
        // Uncompressed heights may have strips of any size, but an alpha band is decoded by whole strips.
        if blocks.block_bytes() > MAX_BLOCK_BYTES {
            return Err(SourceError::TooLarge { path: path.into(), width, height });
        }
        Ok(Some(mask(blocks.clone(), band)))
    }

    /// Opens the first picture of a mask file; returns `None` (with a warning) if it has another size.
    fn open(path: &Path, size: [u32; 2]) -> Result<Option<Self>, SourceError> {
        let file_bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
        let options = OpenOptions { block_cache_bytes: CACHE_BYTES, ..OpenOptions::default() };
        let file = Arc::new(TiffFile::open_with_options(path, options).map_err(damaged(path))?);
        let ifd = file.ifds().first().ok_or_else(|| inconsistent(path, "it contains no picture"))?;
        if [ifd.width(), ifd.height()] != size {
            tracing::warn!("{}: this mask has another size than its DEM and is ignored", path.display());
            return Ok(None);
        }
        let Layout { blocks, block_bytes, .. } = check_mask(ifd, 0, file_bytes, path)?;
        let cache = tiff_blocks::cache(CACHE_BYTES.max(block_bytes as usize));
        Ok(Some(Self { name: path.into(), file, cache, blocks: Arc::new(blocks), band: 0 }))
    }

    /// Replaces the heights of a window by NaN where the mask is 0.
    ///
    /// # Errors
    /// Fails if the mask cannot be decoded.
    pub(super) fn apply(&self, window: Window, heights_m: &mut [f32]) -> Result<(), SourceError> {
        let read = || self.blocks.read(&self.file, &self.cache, self.band, window);
        let bytes = guarded(&self.name, || read().map_err(|source| decode_error(source, &self.name)))?;
        let opacities = bytes.chunks_exact(self.blocks.samples.decoded.bytes());
        if opacities.len() != heights_m.len() {
            return Err(inconsistent(&self.name, "a strip or tile of its mask decodes to the wrong size"));
        }
        for (height_m, opacity) in heights_m.iter_mut().zip(opacities) {
            if opacity.iter().all(|&byte| byte == 0) {
                *height_m = f32::NAN;
            }
        }
        Ok(())
    }
}

/// Returns the path of the sidecar mask `NAME.msk`, if that file exists.
pub(crate) fn sidecar_mask(path: &Path) -> Option<PathBuf> {
    let mut name = path.as_os_str().to_owned();
    name.push(".msk");
    Some(PathBuf::from(name)).filter(|path| path.is_file())
}

/// A reader of heights with masks applied.
pub(super) struct Masked {
    heights: Box<dyn HeightReader>,
    masks: Vec<Mask>,
    /// The file of the heights.
    path: PathBuf,
}

impl Masked {
    /// Applies masks to a reader; returns the reader itself if there are none.
    pub(super) fn over(heights: Box<dyn HeightReader>, masks: Vec<Mask>, path: &Path) -> Box<dyn HeightReader> {
        match masks.is_empty() {
            true => heights,
            false => Box::new(Self { heights, masks, path: path.into() }),
        }
    }
}

impl HeightReader for Masked {
    fn size(&self) -> [u32; 2] {
        self.heights.size()
    }

    fn georeference(&self) -> &Georeference {
        self.heights.georeference()
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = self.heights.read(window)?;
        if window.samples() > 0 {
            self.masks.iter().try_for_each(|mask| mask.apply(window, &mut heights_m))?;
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        self.heights.block()
    }

    fn known_m(&self, window: Window) -> Option<f32> {
        // Masks only add no-data samples, so that without reading them only no-data is known.
        self.heights.known_m(window).filter(|height_m| height_m.is_nan())
    }

    fn is_serial(&self) -> bool {
        self.heights.is_serial()
    }

    fn declared_unit_m(&self) -> Option<f64> {
        self.heights.declared_unit_m()
    }

    fn is_coarse(&self) -> bool {
        self.heights.is_coarse()
    }

    fn warnings(&self) -> Vec<String> {
        self.heights.warnings()
    }

    fn identity(&self) -> String {
        let names = self.masks.iter().map(|mask| &*mask.name).filter(|name| *name != self.path);
        // The identity includes the masks: a cache from before they were applied does not match.
        self.heights.identity() + &place::identity(&names.collect::<Vec<_>>(), "masked\n")
    }
}
