//! Films: writes `.mp4` (H.264, 4:2:0) through an `ffmpeg` process, which reads the frames from its standard input.

use std::ffi::OsStr;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

use super::atomic::AtomicFile;
use super::imprint::{self, KEY, Notes};
use super::{FileError, one_line, sample_count};

/// A film that is being written. Without [`VideoWriter::finish`] no file appears under its name.
pub struct VideoWriter {
    path: PathBuf,
    width: usize,
    height: usize,
    padded: Vec<u8>,
    frame_count: u64,
    process: Child,
    frames: Option<ChildStdin>,
    complaints: Option<JoinHandle<String>>,
    file: Option<AtomicFile>,
}

impl VideoWriter {
    /// Starts a film of `width` × `height` pixels with `fps` frames per second. An odd width or height is padded with a
    /// copy of the last column or row, since the format requires even ones.
    ///
    /// # Errors
    /// Fails if ffmpeg is missing, the picture is empty, the frame rate is not above 0, or the folder does not exist or
    /// is not writable.
    pub fn create(path: &Path, width: u32, height: u32, fps: f64) -> Result<Self, FileError> {
        Self::create_with(OsStr::new("ffmpeg"), path, width, height, fps)
    }

    /// Does the same as [`VideoWriter::create`], with a given ffmpeg instead of the one on the search path.
    ///
    /// # Errors
    /// The same as [`VideoWriter::create`].
    pub(crate) fn create_with(
        ffmpeg: &OsStr,
        path: &Path,
        width: u32,
        height: u32,
        fps: f64,
    ) -> Result<Self, FileError> {
        Self::create_noted(ffmpeg, path, [width, height], fps, &Notes::default())
    }

    /// Does the same as [`VideoWriter::create_with`], and also writes `notes` as a tag.
    ///
    /// # Errors
    /// The same as [`VideoWriter::create`].
    pub fn create_noted(
        ffmpeg: &OsStr,
        path: &Path,
        [width, height]: [u32; 2],
        fps: f64,
        notes: &Notes<'_>,
    ) -> Result<Self, FileError> {
        sample_count(path, width, height)?;
        if !(fps.is_finite() && fps > 0.0) {
            return Err(FileError::write(path, format!("{fps} frames per second is not a valid frame rate")));
        }
        let file = AtomicFile::create(path).map_err(|error| FileError::write(path, error))?;
        let size = format!("{}x{}", width.next_multiple_of(2), height.next_multiple_of(2));
        // ffmpeg drops custom tags unless `use_metadata_tags` is set.
        let tag = notes.imprint.map(|imprint| format!("{KEY}={imprint}"));
        let tag = tag.iter().flat_map(|tag| ["-metadata", tag.as_str()]);
        let flags = if notes.imprint.is_some() { "+faststart+use_metadata_tags" } else { "+faststart" };
        let mut process = Command::new(ffmpeg)
            .args(["-hide_banner", "-nostdin", "-loglevel", "error", "-y"])
            .args(["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", &size, "-framerate", &fps.to_string()])
            .args(["-i", "pipe:0", "-an"])
            // Without these options players would decode the colours by another standard than they were encoded by.
            .args(["-vf", "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p"])
            .args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"])
            .args(["-color_range", "tv", "-c:v", "libx264", "-crf", "16", "-movflags", flags])
            .args(tag)
            .args(["-f", "mp4"])
            // The prefix `file:` keeps a name with a colon or a leading dash a file name.
            .arg(file_url(file.partial_path()))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| match error.kind() {
                ErrorKind::NotFound => FileError::NoFfmpeg { path: path.to_owned() },
                _ => FileError::write(path, format!("ffmpeg cannot be started: {error}")),
            })?;
        let frames = process.stdin.take();
        // stderr is read in the background, because a full pipe would block ffmpeg.
        let complaints = process.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut bytes = Vec::new();
                // The output that was read before an error is still useful.
                let _ = stderr.read_to_end(&mut bytes);
                one_line(&String::from_utf8_lossy(&bytes))
            })
        });
        Ok(Self {
            path: path.to_owned(),
            width: width as usize,
            height: height as usize,
            padded: Vec::new(),
            frame_count: 0,
            process,
            frames,
            complaints,
            file: Some(file),
        })
    }

    /// Appends a frame: width × height × 4 bytes of red, green, blue, alpha, from the top. Films have no alpha, so it
    /// is ignored.
    ///
    /// # Errors
    /// Fails if the number of bytes is wrong, or if ffmpeg has stopped; the error then contains ffmpeg's message.
    pub fn write_frame(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        let expected = self.width * self.height * 4;
        if rgba.len() != expected {
            let cause = format!("a frame has {} bytes instead of {expected}", rgba.len());
            return Err(FileError::write(&self.path, cause));
        }
        let frame = if self.width.is_multiple_of(2) && self.height.is_multiple_of(2) {
            rgba
        } else {
            pad_to_even(rgba, self.width, &mut self.padded);
            &self.padded
        };
        let sent = self.frames.as_mut().map(|frames| frames.write_all(frame));
        match sent {
            Some(Ok(())) => {
                self.frame_count += 1;
                Ok(())
            }
            // ffmpeg has closed its end; its message says more than a broken pipe.
            Some(Err(error)) => Err(self.stop().err().unwrap_or_else(|| FileError::write(&self.path, error))),
            None => Err(FileError::write(&self.path, "ffmpeg has stopped")),
        }
    }

    /// Finishes the film and gives it its final name.
    ///
    /// # Errors
    /// Fails if no frame was written, if ffmpeg failed (with its message), or if the disk is full.
    pub fn finish(mut self) -> Result<(), FileError> {
        if self.frame_count == 0 {
            return Err(FileError::write(&self.path, "the film has no frames"));
        }
        self.stop()?;
        match self.file.take() {
            Some(file) => file.commit().map_err(|error| FileError::write(&self.path, error)),
            None => Err(FileError::write(&self.path, "ffmpeg has stopped")),
        }
    }

    /// Closes ffmpeg's input, waits for ffmpeg to exit and reports its failure.
    fn stop(&mut self) -> Result<(), FileError> {
        self.frames = None;
        let status = self.process.wait().map_err(|error| FileError::write(&self.path, error))?;
        let said = self.complaints.take().and_then(|thread| thread.join().ok()).unwrap_or_default();
        if status.success() {
            return Ok(());
        }
        self.file = None;
        Err(FileError::write(&self.path, format!("ffmpeg failed ({status}): {said}")))
    }
}

impl Drop for VideoWriter {
    /// Stops ffmpeg when a film is abandoned; does nothing after [`VideoWriter::finish`].
    fn drop(&mut self) {
        if self.file.is_some() {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

fn file_url(path: &Path) -> std::ffi::OsString {
    let mut url = std::ffi::OsString::from("file:");
    url.push(path);
    url
}

/// Reads the imprint from a film's tags with ffmpeg.
pub(super) fn imprint(path: &Path) -> Result<Option<String>, FileError> {
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-hide_banner", "-nostdin", "-loglevel", "error", "-i"]).arg(file_url(path));
    let output = imprint::output_of(ffmpeg.args(["-f", "ffmetadata", "pipe:1"]), path)?;
    Ok(imprint::of_ffmetadata(&output))
}

/// Repeats the last column of an odd width and the last row of an odd height.
fn pad_to_even(rgba: &[u8], width: usize, padded: &mut Vec<u8>) {
    padded.clear();
    for row in rgba.chunks_exact(width * 4) {
        padded.extend_from_slice(row);
        if width % 2 == 1 {
            padded.extend_from_slice(&row[row.len() - 4..]);
        }
    }
    let row_bytes = width.next_multiple_of(2) * 4;
    if (padded.len() / row_bytes) % 2 == 1 {
        padded.extend_from_within(padded.len() - row_bytes..);
    }
}
