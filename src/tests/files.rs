//! Output files: they can be read back, they are written whole or not at all, and errors name the file and the cause.

#![allow(clippy::unwrap_used, reason = "a panic fails the test, in helpers too")]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use hachure::file::FileError;
use hachure::file::exr::{Channel, ExrWriter, SampleKind, Samples, SamplesRef, read_exr, write_exr};
use hachure::file::pattern::{FramePattern, MeshFormat, OutputKind, PictureFormat};
use hachure::file::png::{PngPixels, PngWriter, read_rgba8, write_rgba8};
use hachure::file::video::VideoWriter;

/// Returns pseudorandom numbers, the same in every run.
fn noise(seed: u32) -> impl Iterator<Item = u32> {
    let mut state = seed.wrapping_mul(2_654_435_769) | 1;
    std::iter::repeat_with(move || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    })
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn png_bands_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let rgba: Vec<u8> = noise(1).take(37 * 23 * 4).map(|number| number as u8).collect();
    let mut writer = PngWriter::create(&path, 37, 23).unwrap();
    for band in rgba.chunks(37 * 4 * 5) {
        writer.write_rows(band).unwrap();
    }
    assert!(!path.exists(), "the file exists before the picture is complete");
    writer.finish().unwrap();
    let picture = read_rgba8(&path).unwrap();
    assert_eq!((picture.width, picture.height), (37, 23));
    assert!(picture.rgba == rgba);
    let bytes = std::fs::read(&path).unwrap();
    assert!(bytes.windows(4).any(|chunk| chunk == b"sRGB"));
    assert!(bytes.windows(4).any(|chunk| chunk == b"IEND"));
    assert_eq!(names_in(folder.path()), ["a.png"]);
}

#[test]
fn png_rgb_is_read_as_opaque() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    let mut writer = PngWriter::create_with(&path, 2, 1, PngPixels::Rgb8).unwrap();
    writer.write_rows(&[1, 2, 3, 4, 5, 6]).unwrap();
    writer.finish().unwrap();
    assert_eq!(read_rgba8(&path).unwrap().rgba, [1, 2, 3, 255, 4, 5, 6, 255]);
}

#[test]
fn png_given_up_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    write_rgba8(&path, 1, 1, &[9; 4]).unwrap();
    let mut writer = PngWriter::create(&path, 4, 4).unwrap();
    writer.write_rows(&[0; 16]).unwrap();
    assert!(writer.write_rows(&[0; 15]).is_err());
    assert!(writer.write_rows(&[0; 64]).is_err(), "more rows than the picture has were accepted");
    let error = writer.finish().unwrap_err().to_string();
    assert!(error.contains("a.png: 3 rows are missing"), "{error}");
    assert_eq!(read_rgba8(&path).unwrap().rgba, [9; 4]);
    assert_eq!(names_in(folder.path()), ["a.png"]);
    assert!(PngWriter::create(&folder.path().join("no/a.png"), 1, 1).is_err());
    assert!(PngWriter::create(&path, 0, 1).is_err());
    let error = read_rgba8(&folder.path().join("b.png")).unwrap_err();
    assert!(matches!(error, FileError::Read { .. }) && error.to_string().contains("b.png"));
}

/// Returns channels of 50 × 37 pixels: more than two blocks of rows, the last one incomplete.
fn channels() -> Vec<Channel> {
    let count = 50 * 37;
    let mut depth: Vec<f32> = (0..count).map(|index| index as f32 * 0.37).collect();
    depth[7] = f32::INFINITY;
    depth[8] = f32::NAN;
    depth[9] = -0.0;
    depth[10] = f32::MIN_POSITIVE / 4.0;
    let floats = |seed| noise(seed).take(count).map(|number| number as f32 / 3e9).collect();
    let channel = |name: &str, samples| Channel { name: name.to_owned(), samples };
    vec![
        channel("R", Samples::F32(floats(1))),
        channel("G", Samples::F32(floats(2))),
        channel("B", Samples::F32(floats(3))),
        channel("A", Samples::F32(floats(4))),
        channel("surface.id", Samples::U32(noise(5).take(count).collect())),
        channel("depth.V", Samples::F32(depth)),
        channel("position.X", Samples::F32(floats(6))),
    ]
}

fn bits(samples: &Samples) -> Vec<u32> {
    match samples {
        Samples::F32(samples) => samples.iter().map(|sample| sample.to_bits()).collect(),
        Samples::U32(samples) => samples.clone(),
    }
}

#[test]
fn exr_is_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let channels = channels();
    let attributes =
        [("camera".to_owned(), "0,0,+5,0,0,60".to_owned()), ("world".to_owned(), "Dürrenstein".to_owned())];
    write_exr(&path, 50, 37, &channels, &attributes).unwrap();
    let picture = read_exr(&path).unwrap();
    assert_eq!((picture.width, picture.height), (50, 37));
    assert_eq!(picture.attributes, attributes);
    let names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["A", "B", "G", "R", "depth.V", "position.X", "surface.id"]);
    for channel in &channels {
        let read = picture.channels.iter().find(|read| read.name == channel.name).unwrap();
        assert!(bits(&read.samples) == bits(&channel.samples), "{}", channel.name);
    }
    assert!(picture.f32("depth.V").unwrap()[7].is_infinite() && picture.f32("depth.V").unwrap()[8].is_nan());
    assert!(picture.u32("surface.id").is_some() && picture.f32("surface.id").is_none());
    assert_eq!(names_in(folder.path()), ["a.exr"]);
}

#[test]
fn exr_bands_of_any_height_make_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, bands) = (folder.path().join("whole.exr"), folder.path().join("bands.exr"));
    let channels = channels();
    write_exr(&whole, 50, 37, &channels, &[]).unwrap();
    let kinds: Vec<_> =
        channels.iter().map(|channel| (channel.name.as_str(), channel.samples.as_ref().kind())).collect();
    let mut writer = ExrWriter::create(&bands, 50, 37, &kinds, &[]).unwrap();
    let mut row = 0;
    for rows in [1, 0, 20, 3, 13] {
        let range = row * 50..(row + rows) * 50;
        let band: Vec<_> = channels
            .iter()
            .map(|channel| match channel.samples.as_ref() {
                SamplesRef::F32(samples) => SamplesRef::F32(&samples[range.clone()]),
                SamplesRef::U32(samples) => SamplesRef::U32(&samples[range.clone()]),
            })
            .collect();
        writer.write_rows(&band).unwrap();
        row += rows;
    }
    writer.finish().unwrap();
    assert!(std::fs::read(whole).unwrap() == std::fs::read(bands).unwrap());
}

#[test]
fn exr_errors_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let kinds = [("R", SampleKind::F32), ("id", SampleKind::U32)];
    let mut writer = ExrWriter::create(&path, 4, 40, &kinds, &[]).unwrap();
    let (floats, ids) = ([0.0; 80], [0; 80]);
    assert!(writer.write_rows(&[SamplesRef::U32(&ids), SamplesRef::F32(&floats)]).is_err());
    assert!(writer.write_rows(&[SamplesRef::F32(&floats)]).is_err());
    assert!(writer.write_rows(&[SamplesRef::F32(&floats[1..]), SamplesRef::U32(&ids[1..])]).is_err());
    writer.write_rows(&[SamplesRef::F32(&floats), SamplesRef::U32(&ids)]).unwrap();
    let error = writer.finish().unwrap_err().to_string();
    assert!(error.ends_with("a.exr: 20 rows are missing"), "{error}");
    drop(ExrWriter::create(&path, 4, 40, &kinds, &[]).unwrap());
    assert!(ExrWriter::create(&path, 4, 4, &[], &[]).is_err());
    assert!(ExrWriter::create(&path, 4, 4, &[("R", SampleKind::F32), ("R", SampleKind::U32)], &[]).is_err());
    assert!(ExrWriter::create(&path, 4, 4, &[("", SampleKind::F32)], &[]).is_err());
    assert!(ExrWriter::create(&path, 0, 4, &kinds, &[]).is_err());
    assert_eq!(names_in(folder.path()), [""; 0]);
    assert!(matches!(read_exr(&path), Err(FileError::Read { .. })));
}

#[test]
fn names_say_what_an_output_is() {
    let of = |name: &str| OutputKind::of(Path::new(name));
    assert_eq!(of("a.png").unwrap(), OutputKind::Picture(PictureFormat::Png));
    assert_eq!(of("dir/a.EXR").unwrap(), OutputKind::Picture(PictureFormat::Exr));
    assert_eq!(of("a.mp4").unwrap(), OutputKind::Mp4);
    assert!(matches!(of("dir/%05d.exr").unwrap(), OutputKind::Frames(_, PictureFormat::Exr)));
    assert_eq!(of("a.SVG").unwrap(), OutputKind::Picture(PictureFormat::Svg));
    assert!(matches!(of("dir/%05d.svg").unwrap(), OutputKind::Frames(_, PictureFormat::Svg)));
    assert_eq!(of("a.JPG").unwrap(), OutputKind::Picture(PictureFormat::Jpg));
    assert_eq!(of("a.pdf").unwrap(), OutputKind::Picture(PictureFormat::Pdf));
    assert_eq!((of("a.gif").unwrap(), of("a.stl").unwrap()), (OutputKind::Gif, OutputKind::Mesh(MeshFormat::Stl)));
    assert!(
        of("a.webp").unwrap_err().to_string().contains(".png, .jpg, .jpeg, .exr, .svg, .pdf, .mp4, .gif, .glb or .stl")
    );
    assert!(
        of("dir/%03d.gif")
            .unwrap_err()
            .to_string()
            .ends_with("a GIF holds the whole film; leave out the pattern of frames")
    );
    assert_eq!(of("50%.gif").unwrap(), OutputKind::Gif, "this is no pattern");
    assert!(of("a").is_err());
}

#[test]
fn patterns_name_frames() {
    let parse = |pattern: &str| FramePattern::parse(Path::new(pattern));
    assert_eq!(parse("dir/%05d.exr").unwrap().path(42), PathBuf::from("dir/00042.exr"));
    assert_eq!(parse("dir/%05d.exr").unwrap().path(1_234_567), PathBuf::from("dir/1234567.exr"));
    assert_eq!(parse("a%d-100%%.png").unwrap().path(7), PathBuf::from("a7-100%.png"));
    for wrong in ["a.png", "a%%.png", "%d%d.png", "%5d.png", "%0d.png", "%x.png", "a%.png", "%099d.png", "%0+5d.png"] {
        let error = parse(wrong).unwrap_err().to_string();
        assert!(error.starts_with(wrong), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let pattern = FramePattern::parse(&folder.path().join("new/folder/%02d.png")).unwrap();
    write_rgba8(&pattern.prepare(3).unwrap(), 1, 1, &[0; 4]).unwrap();
    assert!(folder.path().join("new/folder/03.png").exists());
}

fn has(program: &str) -> bool {
    let found = Command::new(program).arg("-version").output().is_ok();
    if !found {
        println!("skipped: {program} is not installed");
    }
    found
}

#[test]
fn film_has_its_frames() {
    if !has("ffmpeg") || !has("ffprobe") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a: film.mp4");
    let mut film = VideoWriter::create(&path, 63, 47, 24.0).unwrap();
    assert!(film.write_frame(&[0; 3]).is_err());
    for frame in 0..12u8 {
        film.write_frame(&[[frame * 20, 128, 200, 255]; 63 * 47].concat()).unwrap();
    }
    assert!(!path.exists());
    film.finish().unwrap();
    assert_eq!(names_in(folder.path()), ["a: film.mp4"]);
    let probe = Command::new("ffprobe")
        .args(["-v", "error", "-count_frames", "-show_entries", "stream=width,height,nb_read_frames,r_frame_rate"])
        .args(["-show_entries", "stream=pix_fmt,color_space", "-of", "default=noprint_wrappers=1"])
        .arg(format!("file:{}", path.display()))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&probe.stdout).into_owned();
    let expected = ["width=64", "height=48", "nb_read_frames=12", "r_frame_rate=24/1", "yuv420p", "bt709"];
    assert!(expected.iter().all(|line| said.contains(line)), "{said}");
    // The moov atom is before the data, so that the film plays while it loads.
    let bytes = std::fs::read(&path).unwrap();
    let at = |tag: &[u8]| bytes.windows(4).position(|window| window == tag).unwrap();
    assert!(at(b"moov") < at(b"mdat"));
}

#[test]
fn film_without_ffmpeg_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mp4");
    let error = VideoWriter::create_with(OsStr::new("no-such-ffmpeg"), &path, 2, 2, 24.0).err().unwrap().to_string();
    assert!(error.contains("through ffmpeg, which is not installed; frames can be written as PNG"), "{error}");
    assert_eq!(names_in(folder.path()), [""; 0]);
}

#[cfg(unix)]
#[test]
fn film_reports_what_ffmpeg_said() {
    let folder = tempfile::tempdir().unwrap();
    let fake = folder.path().join("ffmpeg");
    // Another process writes the script. A file that this process opens for writing could be inherited for a moment by
    // a process that another test starts, and a script open for writing cannot be executed.
    let script = "printf '#!/bin/sh\necho no codec >&2\necho sorry >&2\nexit 3\n' >\"$0\" && chmod 755 \"$0\"";
    assert!(Command::new("sh").arg("-c").arg(script).arg(&fake).status().unwrap().success());
    let path = folder.path().join("a.mp4");
    let mut film = VideoWriter::create_with(fake.as_os_str(), &path, 256, 256, 24.0).unwrap();
    // The pipe may accept the first frames before the process has ended.
    let error = (0..100).find_map(|_| film.write_frame(&[0; 256 * 256 * 4]).err()).unwrap().to_string();
    assert!(error.contains("no codec sorry") && error.contains("exit status: 3"), "{error}");
    drop(film);
    assert_eq!(names_in(folder.path()), ["ffmpeg"]);
}

#[test]
fn film_given_up_leaves_nothing() {
    if !has("ffmpeg") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mp4");
    let mut film = VideoWriter::create(&path, 64, 64, 30.0).unwrap();
    film.write_frame(&[0; 64 * 64 * 4]).unwrap();
    drop(film);
    assert!(VideoWriter::create(&path, 64, 64, 30.0).unwrap().finish().is_err(), "a film without frames was accepted");
    assert!(VideoWriter::create(&path, 64, 64, f64::NAN).is_err());
    assert_eq!(names_in(folder.path()), [""; 0]);
}

/// Reads a file with the OpenEXR library itself, through Python.
#[test]
fn exr_is_read_by_another_program() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let attributes = [("camera".to_owned(), "0,0,+5,0,0,60".to_owned())];
    write_exr(&path, 50, 37, &channels(), &attributes).unwrap();
    // The script prints name, type and the weighted sum of the bits of every channel.
    let script = "
import sys, numpy, OpenEXR
part = OpenEXR.File(sys.argv[1], separate_channels=True).parts[0]
for name, channel in sorted(part.channels.items()):
    pixels = channel.pixels
    assert pixels.shape == (37, 50), pixels.shape
    bits = numpy.ascontiguousarray(pixels).view(numpy.uint32).ravel()
    print(name, pixels.dtype, int((bits.astype(numpy.uint64) * numpy.arange(1, bits.size + 1, dtype=numpy.uint64)).sum()))
print(part.header['hachure.camera'])
print(part.header['software'])
";
    let output = Command::new("python3").args(["-c", script]).arg(&path).output();
    let output = match output {
        Ok(output) if !String::from_utf8_lossy(&output.stderr).contains("ModuleNotFoundError") => output,
        _ => return println!("skipped: python3 with OpenEXR and numpy is not installed"),
    };
    let mut expected: Vec<String> = channels()
        .iter()
        .map(|channel| {
            let kind = if matches!(channel.samples, Samples::U32(_)) { "uint32" } else { "float32" };
            let sum = (1..).zip(bits(&channel.samples)).map(|(place, bits)| place * u64::from(bits)).sum::<u64>();
            format!("{} {kind} {sum}", channel.name)
        })
        .collect();
    expected.sort();
    expected.push("0,0,+5,0,0,60".to_owned());
    expected.push(concat!("hachure ", env!("CARGO_PKG_VERSION")).to_owned());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let complaints = String::from_utf8_lossy(&output.stderr);
    assert_eq!(said.lines().collect::<Vec<_>>(), expected, "{complaints}");
}

/// Writes a program that stands for ffmpeg. Another process writes it, as in [`film_reports_what_ffmpeg_said`].
#[cfg(unix)]
fn fake_ffmpeg(folder: &Path, script: &str) -> PathBuf {
    let fake = folder.join("ffmpeg");
    let write = "printf '%s' \"$1\" >\"$0\" && chmod 755 \"$0\"";
    assert!(Command::new("sh").args(["-c", write]).arg(&fake).arg(script).status().unwrap().success());
    fake
}

#[cfg(unix)]
#[test]
fn a_film_is_looked_at_before_it_replaces_another() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mp4");
    std::fs::write(&path, b"an older film").unwrap();
    let film = |script: &str| {
        let fake = fake_ffmpeg(folder.path(), &format!("#!/bin/sh\nfor last; do :; done\n{script}\n"));
        let mut film = VideoWriter::create_with(fake.as_os_str(), &path, 2, 2, 24.0).unwrap();
        film.set_patience(std::time::Duration::from_millis(300));
        film.write_frame(&[0; 16])?;
        film.finish()
    };
    let smallest = crate::file::mp4::SMALLEST.iter().map(|byte| format!("\\{byte:03o}")).collect::<String>();
    let whole = format!("cat >/dev/null; printf '{smallest}' >\"${{last#file:}}\"");
    for (script, cause) in [
        ("cat >/dev/null".to_owned(), "ffmpeg reported success, but wrote a film that cannot be read"),
        ("cat >/dev/null; : >\"${last#file:}\"".to_owned(), "wrote no film"),
        (whole.replace("\\155\\144\\141\\164", ""), "wrote no film, or only a part of one"),
        (format!("{whole}; exit 3"), "exit status: 3"),
        ("cat >/dev/null; sleep 1000".to_owned(), "ffmpeg made no progress for 0.3 s"),
    ] {
        let error = film(&script).unwrap_err().to_string();
        assert!(error.contains(cause), "{script}: {error}");
        assert_eq!(names_in(folder.path()), ["a.mp4", "ffmpeg"]);
        assert_eq!(std::fs::read(&path).unwrap(), b"an older film");
    }
    film(&whole).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), crate::file::mp4::SMALLEST);
    // A program that reads nothing: the pipe is full before the first frame is sent.
    let fake = fake_ffmpeg(folder.path(), "#!/bin/sh\nsleep 1000\n");
    let mut film = VideoWriter::create_with(fake.as_os_str(), &path, 512, 512, 24.0).unwrap();
    film.set_patience(std::time::Duration::from_millis(300));
    let error = film.write_frame(&[0; 512 * 512 * 4]).unwrap_err().to_string();
    assert!(error.contains("ffmpeg made no progress"), "{error}");
    drop(film);
    assert_eq!(names_in(folder.path()), ["a.mp4", "ffmpeg"]);
}

#[test]
fn exr_has_the_same_bytes_in_every_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let attributes: Vec<_> = (0..8).map(|i| (format!("name{i}"), format!("value {i}"))).collect();
    let written = |attributes: &[(String, String)]| {
        write_exr(&path, 3, 2, &[Channel { name: "R".into(), samples: Samples::F32(vec![1.0; 6]) }], attributes)
            .unwrap();
        std::fs::read(&path).unwrap()
    };
    let first = written(&attributes);
    // A random order of eight attributes would hardly be the same four times. Planted: another value.
    assert!((0..4).all(|_| written(&attributes) == first));
    assert!(written(&attributes[1..]) != first);
    let reversed: Vec<_> = attributes.iter().rev().cloned().collect();
    assert!(written(&reversed) == first);
    assert_eq!(read_exr(&path).unwrap().attributes, attributes);
}
