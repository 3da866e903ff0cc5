//! With extreme cameras and styles, all numbers are finite and in their ranges.

use glam::DVec3;
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::samples::{MAX_SAMPLES, Sample, SampleCounts};
use hachure::lines::strokes::stroke::{INK, STROKE_IDS};
use hachure::scene::view::Pose;
use hachure::style::{self, Style};

use crate::tests::coherence::checks::{finite, inked};
use crate::tests::coherence::{Flight, SIZE_PX, START, mountains, strokes};
use crate::tests::common::{World, full};

/// Reads the ink of the last frame and the sample to which each pixel belongs.
fn pictures(world: &World, flight: &Flight) -> (Vec<f32>, Vec<u32>) {
    let target = |kind| flight.renderer.target(kind).unwrap();
    let ink: Vec<u16> = read_as(&world.gpu, target(&INK), [0, 0], SIZE_PX).unwrap();
    let ids = read_as(&world.gpu, target(&STROKE_IDS), [0, 0], SIZE_PX).unwrap();
    (ink.into_iter().map(|bits| half::f16::from_bits(bits).to_f32()).collect(), ids)
}

#[test]
fn extremes_are_finite() {
    let Some(mut world) = mountains() else { return };
    let cameras = [
        START,
        "-300,-2500,+350,20,-6,1",
        "-300,-2500,+350,20,-6,150",
        // Among edges, below the ground, looking straight down from high above, and where nothing is in view.
        "0,0,+0.1,20,0,60",
        "0,0,-50,20,0,60",
        "0,0,+90000,20,-90,60",
        "0,0,+300,20,89,20",
    ];
    type Change = fn(&mut style::Strokes);
    let changes: [(&str, Change); 6] = [
        ("1 px", |own| own.width_px = 1.0),
        ("64 px", |own| (own.width_px, own.taper_px) = (64.0, 1000.0)),
        ("all of it", |own| (own.crease_deg, own.shortest_px, own.join_px) = (Some(0.0), 0.0, 16.0)),
        ("a quarter", |own| (own.resolution, own.fade_s, own.hold) = (0.25, 0.0, 1.0)),
        ("a shaky hand", |own| (own.wobble_px, own.curve_width) = (16.0, -1.0)),
        ("a texture", |own| {
            own.texture = Some(Style::load("charcoal").unwrap().strokes().unwrap().texture.clone().unwrap());
        }),
    ];
    let (steps, least) = if full() { (3, 500) } else { (2, 250) };
    // In the fast tier each change but the first is seen by the first camera, by one of its own, and by the last.
    for (number, (name, change)) in changes.into_iter().enumerate().skip(usize::from(!full())) {
        let three = [START, cameras[number], cameras[6]];
        let mut flight = Flight::new(&world, strokes(change));
        let (mut most, mut empty) = (0, 0);
        for camera in if full() { &cameras[..] } else { &three } {
            let start = world.pose(camera);
            for step in 0..steps {
                let pose = Pose { position_m: start.position_m + DVec3::new(0.3, 0.1, 0.0) * f64::from(step), ..start };
                let (_, counts, samples) = flight.draw(&mut world, pose);
                most = most.max(counts.samples);
                empty += u32::from(counts.strokes == 0);
                assert_eq!(finite(&counts, &samples), Ok(()), "{name}, {camera}");
                let (ink, ids) = pictures(&world, &flight);
                assert_eq!(inked(&ink, &ids, &samples), Ok(()), "{name}, {camera}");
            }
        }
        assert!(most > least && empty > 0, "{name}: {most} samples at most, {empty} pictures without strokes");
    }
}

#[test]
fn numbers_that_are_none_or_too_large_are_found() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|_| {}));
    let (_, counts, samples) = flight.fly(&mut world, 0);
    let (ink, ids) = pictures(&world, &flight);
    assert_eq!((finite(&counts, &samples), inked(&ink, &ids, &samples)), (Ok(()), Ok(())));

    let at = samples.len() / 2;
    type Spoil = fn(&mut Sample);
    let spoils: [(Spoil, &str); 7] = [
        (|own| own.position_m[2] = f32::NAN, "NaN"),
        (|own| own.px[0] = f32::INFINITY, "inf"),
        (|own| own.held_px[1] = f32::NAN, "NaN"),
        (|own| own.shown_px = f32::NEG_INFINITY, "-inf"),
        (|own| own.pressure = 1.5, "pressure: 1.5"),
        (|own| own.half_width_px = -1.0, "half_width_px: -1.0"),
        (|own| own.stroke = 0, "stroke: 0"),
    ];
    for (spoil, expected) in spoils {
        let mut spoiled = samples.clone();
        spoil(&mut spoiled[at]);
        let error = finite(&counts, &spoiled).unwrap_err();
        assert!(error.starts_with(&format!("sample {at} ")) && error.contains(expected), "{expected}: {error}");
    }
    for wrong in [
        SampleCounts { samples: MAX_SAMPLES + 1, ..counts },
        SampleCounts { fresh: counts.samples + 1, ..counts },
        SampleCounts { samples: counts.samples - 1, ..counts },
    ] {
        let error = finite(&wrong, &samples).unwrap_err();
        assert!(error.contains("SampleCounts"), "{error}");
    }

    // A pixel in the midst of the picture: x 100, y 50.
    let pixel = 50 * SIZE_PX[0] as usize + 100;
    for bad in [1.5, -0.25, f32::NAN] {
        let mut spoiled = ink.clone();
        spoiled[pixel] = bad;
        let error = inked(&spoiled, &ids, &samples).unwrap_err();
        assert!(error.starts_with("pixel 100, 50") && error.contains(&format!("{bad}")), "{error}");
    }
    // The number of a sample that does not exist, and of one at which no segment begins.
    let last = samples.iter().position(|own| own.flags & Sample::LAST != 0).unwrap();
    for bad in [samples.len() as u32 + 1, u32::MAX, last as u32 + 1] {
        let mut spoiled = ids.clone();
        spoiled[pixel] = bad;
        let error = inked(&ink, &spoiled, &samples).unwrap_err();
        assert!(error.starts_with("pixel 100, 50") && error.contains(&bad.to_string()), "{error}");
    }
}
