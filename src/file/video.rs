//! Films: writes `.mp4` (H.264, 4:2:0) through an `ffmpeg` process, which reads the frames from its standard input.
//!
//! ffmpeg writes into a temporary folder that only the user can enter, so that nobody can put a link in the place of its
//! output. It ends with hachure, is ended if it makes no progress ([`super::process`]), and its film is looked at
//! ([`super::mp4`]) before it replaces an older one.

use std::ffi::OsStr;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use tempfile::TempDir;

use super::frame_rate::FrameRate;
use super::imprint::{self, KEY, Notes};
use super::input::open_regular;
use super::interrupt::Unfinished;
use super::process::{Guarded, PATIENCE, all_read, read_in_background};
use super::{FileError, atomic, mp4, one_line, sample_count};

/// Bytes of a frame that are sent to ffmpeg at once; each such piece is progress.
const PIECE_BYTES: usize = 1 << 16;
/// Interval at which ffmpeg is looked at while a frame is sent.
const LOOK: Duration = Duration::from_millis(50);

/// A film that is being written. Without [`VideoWriter::finish`] no file appears under its name.
pub struct VideoWriter {
    path: PathBuf,
    width: usize,
    height: usize,
    frame_count: u64,
    process: Guarded,
    frames: Option<Sender>,
    complaints: Option<JoinHandle<Vec<u8>>>,
    partial: Partial,
    patience: Duration,
}

/// The film while ffmpeg writes it, in a temporary folder.
struct Partial {
    folder: TempDir,
    film: PathBuf,
    _unfinished: Unfinished,
}

impl Partial {
    fn create(path: &Path) -> std::io::Result<Self> {
        let (folder, unfinished) = Unfinished::create(|| atomic::temporary_folder(path), TempDir::path)?;
        let film = folder.path().join("film.mp4");
        Ok(Self { folder, film, _unfinished: unfinished })
    }

    /// Returns the length and the time of change of the film, which show whether ffmpeg still writes.
    fn state(&self) -> Option<(u64, SystemTime)> {
        let metadata = fs::metadata(&self.film).ok()?;
        Some((metadata.len(), metadata.modified().ok()?))
    }

    fn commit(self, path: &Path) -> std::io::Result<()> {
        open_regular(&self.film)?.sync_all()?;
        fs::rename(&self.film, path)?;
        self.folder.close()
    }
}

/// A thread that writes frames to ffmpeg, since a write to a full pipe would wait without a deadline.
struct Sender {
    frames: SyncSender<Vec<u8>>,
    /// Each frame's buffer, when it has been written.
    written: Receiver<std::io::Result<Vec<u8>>>,
    pieces: Arc<AtomicU64>,
    buffer: Vec<u8>,
}

impl Sender {
    fn start(mut pipe: ChildStdin) -> std::io::Result<Self> {
        let (frames, taken) = sync_channel::<Vec<u8>>(1);
        let (give, written) = sync_channel(1);
        let pieces = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&pieces);
        std::thread::Builder::new().name("film".to_owned()).spawn(move || {
            for frame in taken {
                let result = frame.chunks(PIECE_BYTES).try_for_each(|piece| {
                    count.fetch_add(1, Ordering::Relaxed);
                    pipe.write_all(piece)
                });
                if give.send(result.map(|()| frame)).is_err() {
                    return;
                }
            }
        })?;
        Ok(Self { frames, written, pieces, buffer: Vec::new() })
    }
}

impl VideoWriter {
    /// Starts a film of `width` × `height` pixels with `fps` frames per second. An odd width or height is padded with a
    /// copy of the last column or row, since the format requires even ones.
    ///
    /// # Errors
    /// Fails if ffmpeg is missing, the picture is empty, the frame rate is not above 0, or the folder does not exist or
    /// is not writable.
    pub fn create(path: &Path, width: u32, height: u32, fps: impl Into<FrameRate>) -> Result<Self, FileError> {
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
        fps: impl Into<FrameRate>,
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
        fps: impl Into<FrameRate>,
        notes: &Notes<'_>,
    ) -> Result<Self, FileError> {
        sample_count(path, width, height)?;
        let fps = fps.into();
        if !fps.is_valid() {
            return Err(FileError::write(path, format!("{fps} frames per second is not a valid frame rate")));
        }
        let partial = Partial::create(path).map_err(|error| FileError::write(path, error))?;
        let size = format!("{}x{}", width.next_multiple_of(2), height.next_multiple_of(2));
        // ffmpeg drops custom tags unless `use_metadata_tags` is set.
        let tag = notes.imprint.map(|imprint| format!("{KEY}={imprint}"));
        let tag = tag.iter().flat_map(|tag| ["-metadata", tag.as_str()]);
        let flags = if notes.imprint.is_some() { "+faststart+use_metadata_tags" } else { "+faststart" };
        let mut command = Command::new(ffmpeg);
        command
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
            .arg(file_url(&partial.film))
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut process = Guarded::spawn(&mut command, Some(&partial.film)).map_err(|error| match error.kind() {
            ErrorKind::NotFound => FileError::NoFfmpeg { path: path.to_owned() },
            _ => FileError::write(path, format!("ffmpeg cannot be started: {error}")),
        })?;
        let frames = process.child().stdin.take().map(Sender::start).transpose();
        let frames = frames.map_err(|error| FileError::write(path, error))?;
        let complaints = read_in_background(process.child().stderr.take());
        Ok(Self {
            path: path.to_owned(),
            width: width as usize,
            height: height as usize,
            frame_count: 0,
            process,
            frames,
            complaints,
            partial,
            patience: PATIENCE,
        })
    }

    /// Sets the time without progress after which ffmpeg is ended.
    #[cfg(test)]
    pub(crate) fn set_patience(&mut self, patience: Duration) {
        self.patience = patience;
    }

    /// Appends a frame: width × height × 4 bytes of red, green, blue, alpha, from the top. Films have no alpha, so it
    /// is ignored.
    ///
    /// # Errors
    /// Fails if the number of bytes is wrong, if ffmpeg has stopped (with ffmpeg's message), or if it makes no progress.
    pub fn write_frame(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        let expected = self.width * self.height * 4;
        if rgba.len() != expected {
            let cause = format!("a frame has {} bytes instead of {expected}", rgba.len());
            return Err(FileError::write(&self.path, cause));
        }
        let stopped = || FileError::write(&self.path, "ffmpeg has stopped");
        let Some(mut sender) = self.frames.take() else { return Err(stopped()) };
        let mut frame = std::mem::take(&mut sender.buffer);
        pad_to_even(rgba, self.width, &mut frame);
        sender.frames.send(frame).map_err(|_| stopped())?;
        let state = |partial: &Partial, sender: &Sender| (sender.pieces.load(Ordering::Relaxed), partial.state());
        let (mut last, mut since) = (state(&self.partial, &sender), Instant::now());
        loop {
            match sender.written.recv_timeout(LOOK) {
                Ok(Ok(frame)) => {
                    sender.buffer = frame;
                    self.frames = Some(sender);
                    self.frame_count += 1;
                    return Ok(());
                }
                // ffmpeg has closed its end; its message says more than a broken pipe.
                Ok(Err(error)) => {
                    drop(sender);
                    return Err(self.stop().err().unwrap_or_else(|| FileError::write(&self.path, error)));
                }
                Err(RecvTimeoutError::Disconnected) => return Err(stopped()),
                Err(RecvTimeoutError::Timeout) => {}
            }
            let now = state(&self.partial, &sender);
            if now != last {
                (last, since) = (now, Instant::now());
            } else if since.elapsed() > self.patience {
                self.process.kill();
                return Err(self.no_progress());
            }
        }
    }

    fn no_progress(&self) -> FileError {
        let seconds = self.patience.as_secs_f64();
        FileError::write(&self.path, format!("ffmpeg made no progress for {seconds} s and was ended"))
    }

    /// Finishes the film and gives it its final name.
    ///
    /// # Errors
    /// Fails if no frame was written, if ffmpeg failed (with its message), made no progress, or wrote no complete film,
    /// or if the disk is full. An older film of that name is then unchanged.
    pub fn finish(mut self) -> Result<(), FileError> {
        if self.frame_count == 0 {
            return Err(FileError::write(&self.path, "the film has no frames"));
        }
        let said = self.stop()?;
        if let Some(fault) = mp4::fault(&self.partial.film, self.frame_count) {
            let said = if said.is_empty() { said } else { format!(": {said}") };
            return Err(FileError::write(&self.path, format!("ffmpeg reported success, but {fault}{said}")));
        }
        let Self { path, partial, .. } = self;
        partial.commit(&path).map_err(|error| FileError::write(&path, error))
    }

    /// Closes ffmpeg's input, waits for ffmpeg to exit and reports its failure. Returns its messages.
    fn stop(&mut self) -> Result<String, FileError> {
        self.frames = None;
        let partial = &self.partial;
        let status = self.process.wait_while(self.patience, || partial.state());
        let Some(status) = status.map_err(|error| FileError::write(&self.path, error))? else {
            return Err(self.no_progress());
        };
        let said = one_line(&String::from_utf8_lossy(&all_read(self.complaints.take())));
        match status.success() {
            true => Ok(said),
            false => Err(FileError::write(&self.path, format!("ffmpeg failed ({status}): {said}"))),
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

/// Copies a frame, and repeats the last column of an odd width and the last row of an odd height.
fn pad_to_even(rgba: &[u8], width: usize, padded: &mut Vec<u8>) {
    padded.clear();
    if width.is_multiple_of(2) && (rgba.len() / (width * 4)).is_multiple_of(2) {
        padded.extend_from_slice(rgba);
        return;
    }
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
