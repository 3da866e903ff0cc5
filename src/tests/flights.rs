//! Simulated flights: the selection and the streaming of tiles along a camera path, without drawing. Time is simulated
//! and the store delivers a fixed number of tiles per second, so a flight is the same on every machine.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::tests::common;
use common::stores::Granted;
use common::{full, grid_of, rough_height_m};
use hachure::gpu::Gpu;
use hachure::pyramid::TileStore;
use hachure::pyramid::store::ContinentStore;
use hachure::scene::camera::Camera;
use hachure::scene::path::CameraPath;
use hachure::scene::view::{Clock, View};
use hachure::source::Silent;
use hachure::tiles::Terrain;
use hachure::tiles::atlas::SLOT_BYTES;
use hachure::tiles::terrain::{Loading, TerrainOptions};

/// Frames per second, unless `HACHURE_FPS` sets others for the long tier.
const FPS: f64 = 30.0;

/// A flight over a terrain.
struct Flight {
    gpu: Gpu,
    terrain: Terrain,
    store: Arc<Granted>,
    size_px: [u32; 2],
    tiles_per_s: f64,
    fps: f64,
    /// Whether water is drawn, whose maps are late like tiles.
    has_water: bool,
    /// Fraction of a tile that the store owes.
    owed: f64,
    now_s: f64,
}

/// The measurements of one frame.
#[derive(Clone, Copy, Debug, Default)]
struct FrameFacts {
    triangles: u64,
    is_late: bool,
    /// Whether the land itself is late, and not only the maps of its water.
    is_land_late: bool,
    /// The factor by which the surface is coarser because of memory.
    memory_factor: f64,
    without_room: u64,
    evicted_needed: u64,
    /// Time that this thread had a processor, in milliseconds: the time of a busy machine says nothing.
    prepare_cpu_ms: f64,
    /// Number of tiles that the view needs, that are being loaded, and that were read and evicted since the start.
    wanted: u64,
    pending: u64,
    read: u64,
    evicted: u64,
}

/// Returns the time that this thread has had a processor, in milliseconds; 0 where the system does not report it.
fn thread_cpu_ms() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).unwrap_or(0.0) * 1e-6
}

impl Flight {
    fn new(inner: Arc<dyn TileStore>, size_px: [u32; 2], memory_bytes: u64, tiles_per_s: f64) -> Option<Self> {
        let gpu = common::gpu()?;
        let store = Granted::new(inner);
        let options =
            TerrainOptions { loading: Loading::Stream, tile_memory_bytes: memory_bytes, ..TerrainOptions::default() };
        let terrain = Terrain::new(&gpu, Arc::clone(&store) as Arc<dyn TileStore>, options).unwrap();
        Some(Self { gpu, terrain, store, size_px, tiles_per_s, fps: FPS, has_water: false, owed: 0.0, now_s: 0.0 })
    }

    /// Prepares the next frame, and lets the store deliver what it can until the one after it.
    fn frame(&mut self, camera: &Camera) -> FrameFacts {
        self.now_s += 1.0 / self.fps;
        self.terrain.set_now_s(self.now_s);
        self.terrain.map_water(&self.gpu, self.has_water.then_some(None));
        let pose = common::pose_of(camera);
        let view = View::whole(pose, pose, self.size_px).at(Clock::still(self.now_s));
        let view = hachure::internals::terrain_view(&view);
        let before_ms = thread_cpu_ms();
        let prepared = self.terrain.prepare(&self.gpu, &view);
        let prepare_cpu_ms = thread_cpu_ms() - before_ms;
        self.gpu.queue.submit([]);
        self.gpu.wait();
        self.owed += self.tiles_per_s / self.fps;
        self.store.grant(self.owed as u64);
        self.owed = self.owed.fract();
        while self.terrain.looks_ahead() || !self.has_delivered() {
            std::thread::sleep(Duration::from_micros(100));
        }
        self.store.grant(0);
        let counts = self.terrain.tile_counts();
        FrameFacts {
            triangles: prepared.selection.triangles(),
            is_late: prepared.tiles.late,
            is_land_late: prepared.tiles.late_land,
            memory_factor: prepared.detail.memory_factor,
            without_room: prepared.tiles.without_room,
            evicted_needed: counts.evicted_needed,
            prepare_cpu_ms,
            wanted: prepared.tiles.wanted,
            pending: prepared.tiles.pending,
            read: counts.read,
            evicted: counts.evicted,
        }
    }

    /// Returns whether the store has delivered as many tiles as it may, or all that are requested.
    fn has_delivered(&self) -> bool {
        let [queued, under_way] = self.terrain.tiles_queued_and_under_way();
        // Without grants, the one thread that reads waits with a tile.
        if self.store.left() == 0 { under_way <= 1 } else { queued + under_way == 0 }
    }

    /// Draws frames from one camera until none is late; returns whether this happened within `most` frames.
    fn settle(&mut self, camera: &Camera, most: usize) -> bool {
        (0..most).any(|i| !self.frame(camera).is_late && i > 2)
    }
}

fn percentile(values: impl Iterator<Item = f64>, part: f64) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}

/// Returns the fraction of the frames that are late.
fn late(frames: &[FrameFacts]) -> f64 {
    frames.iter().filter(|frame| frame.is_late).count() as f64 / frames.len() as f64
}

/// Returns what is wrong with the frames of a flight, of which a fraction of `most_late` may be late.
fn faults(frames: &[FrameFacts], most_late: f64) -> Vec<String> {
    let mut faults = Vec::new();
    if late(frames) > most_late {
        faults.push(format!("{:.1} % of the frames are late", 100.0 * late(frames)));
    }
    let without_room: u64 = frames.iter().map(|frame| frame.without_room).sum();
    if without_room > 0 {
        faults.push(format!("{without_room} tiles had no room"));
    }
    let evicted = frames.last().map_or(0, |frame| frame.evicted_needed);
    if evicted > 0 {
        faults.push(format!("{evicted} tiles were evicted while they were needed"));
    }
    let octaves = |pair: &[FrameFacts]| (pair[1].memory_factor / pair[0].memory_factor).log2().abs();
    let jump = frames.windows(2).map(octaves).fold(0.0, f64::max);
    if jump > 0.26 {
        faults.push(format!("the error jumps by {jump:.2} octaves"));
    }
    faults
}

/// Returns the late frames that cost more than their neighbours that are not late. (Land itself may: a flight crosses
/// ridges, so only frames of more than twice the triangles count.)
fn costly_late_frames(frames: &[FrameFacts]) -> Vec<String> {
    let mut costly = Vec::new();
    for window in frames.windows(31).filter(|window| window[15].is_late) {
        let on_time = window.iter().filter(|frame| !frame.is_late).map(|frame| frame.triangles as f64);
        let most = 2.0 * on_time.clone().fold(0.0, f64::max);
        if on_time.count() > 0 && window[15].triangles as f64 > most {
            costly
                .push(format!("a late frame has {} triangles, its neighbours {most:.0} at most", window[15].triangles));
        }
    }
    costly
}

fn straight(start: &str, velocity_m_s: [f64; 2], frames: usize) -> Vec<Camera> {
    let start: Camera = start.parse().unwrap();
    let mut cameras = Vec::new();
    for i in 0..frames {
        let mut camera = start.on_ground(|_, _| 0.0);
        camera.position_m.x += velocity_m_s[0] * i as f64 / FPS;
        camera.position_m.y += velocity_m_s[1] * i as f64 / FPS;
        cameras.push(camera);
    }
    cameras
}

/// The heights are below 900 m.
const START: &str = "-9000,-8000,1100,45,-8,60";

/// Fewer tiles than the flight needs.
const ROOM_FOR: u64 = 26;

/// Flies over rough land of 44 tiles with so much memory.
fn over_rough_land(memory_bytes: u64) -> Option<Vec<FrameFacts>> {
    let store = common::in_memory(&grid_of(1401, 1290, 20.0, rough_height_m));
    let mut flight = Flight::new(store, [1280, 720], memory_bytes, 300.0)?;
    let cameras = straight(START, [212.0, 212.0], 150);
    assert!(flight.settle(&cameras[0], 100), "the first view is never complete");
    Some(cameras.iter().map(|camera| flight.frame(camera)).collect())
}

#[test]
fn a_view_that_needs_more_than_memory_holds_is_coarser_and_does_not_thrash() {
    let Some(frames) = over_rough_land(ROOM_FOR * SLOT_BYTES) else { return };
    let most = frames.iter().map(|frame| frame.memory_factor).fold(0.0, f64::max);
    assert!(most > 1.05, "the flight does not need more than there is: {most}");
    assert_eq!([faults(&frames, 0.2), costly_late_frames(&frames)].concat(), Vec::<String>::new());

    // The planted errors: each is found.
    let planted = |change: fn(&mut FrameFacts)| {
        let mut frames = frames.clone();
        frames[100..].iter_mut().for_each(change);
        faults(&frames, 0.2)
    };
    assert!(!planted(|frame| frame.is_late = true).is_empty());
    assert!(!planted(|frame| frame.without_room = 1).is_empty());
    assert!(!planted(|frame| frame.evicted_needed = 1).is_empty());
    assert!(!planted(|frame| frame.memory_factor *= 1.3).is_empty());
    let mut costly = frames.clone();
    (costly[100].is_late, costly[100].triangles) = (true, 3 * costly[100].triangles);
    assert!(!costly_late_frames(&costly).is_empty());
}

#[test]
fn what_fits_into_memory_is_as_fine_as_requested() {
    let Some(frames) = over_rough_land(64 << 20) else { return };
    assert!(frames.iter().all(|frame| frame.memory_factor == 1.0));
    assert_eq!([faults(&frames, 0.05), costly_late_frames(&frames)].concat(), Vec::<String>::new());
}

#[test]
fn a_turn_and_back_reads_nothing_twice_that_memory_can_hold() {
    let store = common::in_memory(&grid_of(1401, 1290, 20.0, rough_height_m));
    let Some(mut flight) = Flight::new(store, [1280, 720], 64 << 20, 300.0) else { return };
    let there: Camera = START.parse::<Camera>().unwrap().on_ground(|_, _| 0.0);
    let mut back = there;
    back.yaw_deg += 180.0;
    assert!(flight.settle(&there, 200) && flight.settle(&back, 200));
    let read = flight.terrain.tile_counts().read;
    assert!(flight.settle(&there, 200) && flight.settle(&back, 200));
    assert_eq!(flight.terrain.tile_counts().read, read);
}

/// Tests that a view with water is complete after a turn although its tiles and those of its maps fill the memory. With the
/// slots of tiles that only the mesh uses, there would be too few.
#[test]
fn a_turn_with_water_comes_to_rest_in_little_memory() {
    let store = common::in_memory(&grid_of(1401, 1290, 20.0, rough_height_m));
    for slots in (ROOM_FOR - 6..ROOM_FOR + 14).step_by(4) {
        let Some(mut flight) =
            Flight::new(Arc::clone(&store) as Arc<dyn TileStore>, [1280, 720], slots * SLOT_BYTES, 300.0)
        else {
            return;
        };
        flight.has_water = true;
        let mut camera = START.parse::<Camera>().unwrap().on_ground(|_, _| 0.0);
        assert!(flight.settle(&camera, 200), "{slots} slots: the first view is never complete");
        for turn_deg in [180.0, -180.0] {
            for _ in 0..45 {
                camera.yaw_deg += turn_deg / 45.0;
                flight.frame(&camera);
            }
            assert!(flight.settle(&camera, 200), "{slots} slots: the view is never complete after a turn");
        }
    }
}

/// A flight of the long tier.
#[derive(Clone)]
struct Long {
    name: &'static str,
    size_px: [u32; 2],
    memory_mib: u64,
    has_water: bool,
    /// The fraction of its frames that may be late: what was measured, and a little more
    /// (`docs/decisions/tile-streaming.md`).
    most_late: f64,
}

/// Returns the flights of the long tier: each with and without water.
fn long_flights() -> Vec<Long> {
    let of = |name, width_px, memory_mib, most_late: [f64; 2]| {
        [false, true].map(|has_water| Long {
            name,
            size_px: [width_px, width_px / 16 * 9],
            memory_mib,
            has_water,
            most_late: most_late[usize::from(has_water)],
        })
    };
    [
        of("valley", 1920, 512, [0.01, 0.02]),
        of("valley", 1920, 128, [0.01, 0.02]),
        of("valley", 1920, 64, [0.01, 0.02]),
        of("valley", 3840, 512, [0.01, 0.02]),
        // The store delivers too few tiles for a turn.
        of("turn", 1920, 512, [0.6, 0.75]),
        of("turn", 1920, 128, [0.3, 0.3]),
    ]
    .concat()
}

/// Returns the camera of a long flight: along the valley at 300 m/s, or on one spot, turning by 180 degrees in two seconds
/// and back.
fn long_camera(name: &str, valley: &CameraPath, time_s: f64) -> Camera {
    if name == "valley" {
        return valley.sample(time_s);
    }
    let mut camera = valley.sample(0.0);
    camera.yaw_deg += 90.0 * ((time_s - 2.0).clamp(0.0, 2.0) - (time_s - 6.0).clamp(0.0, 2.0));
    camera
}

/// The flights of the long tier: 12 s over the continent, or as many seconds as `HACHURE_FLIGHT_S` says. `HACHURE_FLIGHT`
/// names the flights to run alone (a part of the name), `HACHURE_FLIGHT_TRACE` prints their frames, and `HACHURE_FPS` and
/// `HACHURE_TILES_PER_S` set their frames per second and the store's tiles per second.
#[test]
fn the_continent_streams_at_every_size_and_memory() {
    if !full() {
        return;
    }
    let cache = common::between_runs("built-in-land");
    let store: Arc<dyn TileStore> = Arc::new(ContinentStore::open(1, 327_680, 10.0, Some(&cache), &Silent).unwrap());
    let path = CameraPath::read(Path::new("terrain/paths/valley.csv")).unwrap();
    let variable = |name| std::env::var(name).ok();
    let number = |name, usual| variable(name).and_then(|text| text.parse().ok()).unwrap_or(usual);
    let seconds: f64 = number("HACHURE_FLIGHT_S", 12.0);
    let (fps, tiles_per_s): (f64, f64) = (number("HACHURE_FPS", FPS), number("HACHURE_TILES_PER_S", 1500.0));
    let only = variable("HACHURE_FLIGHT");
    let mut all_faults = Vec::new();
    for long in long_flights() {
        let water = if long.has_water { " with water" } else { "" };
        let title = format!("{} {:?} {} MiB{water}", long.name, long.size_px, long.memory_mib);
        if only.as_ref().is_some_and(|only| !title.contains(only)) {
            continue;
        }
        let Some(mut flight) = Flight::new(Arc::clone(&store), long.size_px, long.memory_mib << 20, tiles_per_s) else {
            return;
        };
        flight.has_water = long.has_water;
        flight.fps = fps;
        let at = |time_s| long_camera(long.name, &path, time_s);
        assert!(flight.settle(&at(0.0), 400), "the first view is never complete");
        let frames: Vec<FrameFacts> =
            (0..(seconds * fps) as usize).map(|i| flight.frame(&at(i as f64 / fps))).collect();
        if variable("HACHURE_FLIGHT_TRACE").is_some() {
            for (i, frame) in frames.iter().enumerate() {
                let FrameFacts { wanted, pending, read, evicted, triangles, is_late, is_land_late, .. } = frame;
                println!(
                    "{i}: late {is_late}, land late {is_land_late}, factor {:.2}, {wanted} wanted, {pending} pending, \
                     {read} read, {evicted} evicted, {triangles} triangles",
                    frame.memory_factor
                );
            }
        }
        let counts = flight.terrain.tile_counts();
        let after = &frames[fps as usize..];
        let of = |get: fn(&FrameFacts) -> f64, part| percentile(after.iter().map(get), part);
        println!(
            "{title}: late {:.1} %, of it land {:.1} %, factor {:.2} at p50 and {:.2} at most, prepare {:.2} ms at p50 and \
             {:.2} ms at p99 of CPU, triangles {} at p50 and {} at most, {} tiles read, {} evicted, GPU hits {} of {}",
            100.0 * late(after),
            100.0 * after.iter().filter(|frame| frame.is_land_late).count() as f64 / after.len() as f64,
            of(|frame| frame.memory_factor, 0.5),
            of(|frame| frame.memory_factor, 1.0),
            of(|frame| frame.prepare_cpu_ms, 0.5),
            of(|frame| frame.prepare_cpu_ms, 0.99),
            of(|frame| frame.triangles as f64, 0.5),
            of(|frame| frame.triangles as f64, 1.0),
            counts.read,
            counts.evicted,
            counts.gpu_hits,
            counts.gpu_hits + counts.gpu_misses,
        );
        let mut found = faults(after, long.most_late);
        if long.name == "valley" {
            found.extend(costly_late_frames(after));
        } else if seconds >= 12.0 && late(&frames[(10.0 * fps) as usize..]) > 0.0 {
            found.push("it is late four seconds after the turn".into());
        }
        all_faults.extend(found.into_iter().map(|fault| format!("{title}: {fault}")));
    }
    assert_eq!(all_faults, Vec::<String>::new());
}
