//! `render --show NAME`: writes an intermediate picture of the frame instead of the drawing.

use std::path::Path;

use super::map::Sidecars;
use super::{Job, RenderArgs};
use crate::commands::misuse::Misuse;
use crate::commands::print;
use crate::file::exr::write_exr_noted;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::png::{PngPixels, PngWriter};
use crate::frame::Renderer;
use crate::gpu::recorder::Submits;
use crate::picture::show::{self, ShowError};
use crate::picture::{PartRule, PictureReport};
use crate::scene::view::Pose;

/// Checks that the output can hold the picture and that the frame is drawn in one part.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    if args.show.is_none() {
        return Ok(());
    }
    if !matches!(kind, OutputKind::Picture(PictureFormat::Png | PictureFormat::Exr)) {
        let output = named(&args.output);
        return Err(Misuse(format!("--show: requires a .png or .exr output, and the output is {output}")));
    }
    let [width, height] = args.size();
    if !PartRule::default().is_whole(args.size()) {
        return Err(Misuse(format!(
            "--show: {width}x{height} px is too large for a picture drawn in one part; reduce --size"
        )));
    }
    Ok(())
}

impl Job<'_> {
    /// Draws a frame, and writes the picture that `--show` names to `path`. Warns of numbers in the frame that are not
    /// finite.
    pub(super) fn show(&mut self, path: &Path, pose: Pose) -> anyhow::Result<PictureReport> {
        let name = self.args.show.as_deref().unwrap_or_default();
        let renderer = Renderer::or_new(&mut self.renderer, &self.gpu)?;
        renderer.set_traces(true);
        renderer.set_wants_ids(true);
        renderer.set_submits(Submits::Checked);
        let report = self.render(pose, pose, |_| Ok(()))?;
        // A pass that reads a number that is not finite writes more of them: the first one shows where they begin.
        let found = self.renderer.as_mut().map(Renderer::take_non_finite).unwrap_or_default();
        if let Some(first) = found.first() {
            let more = match found.len() - 1 {
                0 => String::new(),
                more => format!(" (and {more} pictures and buffers after it)"),
            };
            tracing::warn!("{first}{more}; this is a bug in hachure: please report it with the command line");
        }
        let trace = self.renderer.as_ref().map(Renderer::trace).unwrap_or_default();
        let picture = match show::read(&self.gpu, trace, name, self.args.size()) {
            Ok(picture) => picture,
            Err(error @ ShowError::Unknown { .. }) => {
                if !self.args.json {
                    print(&show::listing(trace))?;
                }
                return Err(Misuse::of(error).into());
            }
            Err(error) => return Err(error.into()),
        };
        let [width, height] = picture.size_px;
        let imprint = self.imprint_text();
        let notes = self.notes(&imprint, pose);
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
            let attributes = [("camera".to_owned(), self.camera_text(pose)), ("picture".to_owned(), name.to_owned())];
            write_exr_noted(path, width, height, &picture.channels(), &attributes, &notes)?;
        } else {
            let mut writer = PngWriter::create_noted(path, width, height, PngPixels::Rgba8, &notes)?;
            writer.write_rows(&picture.rgba8())?;
            writer.finish_after(|| Sidecars::create(path, &[], false)?.commit())?;
        }
        Ok(report)
    }
}
