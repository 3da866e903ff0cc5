//! Tests labels of flights and of stereo pairs: a label changes at most once a second, hidden summits have none, and both
//! eyes have the same labels at the distances of their summits.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeMap;

use crate::tests::common;

use common::draw::NOON;
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::picture::PictureRequest;
use hachure::picture::names::moving::MovingNames;
use hachure::picture::names::sites::Sites;
use hachure::picture::names::{
    Ground, Labels, Placed, SeenSurface, Site, SiteKind, Visible, Wanted, above_land, drawn_rows, visible,
};
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::{Style, Typeface};

const SIZE_PX: [u32; 2] = [320, 200];

/// Peaks as east, north, height and width in metres. The fourth one is behind the first.
const PEAKS: [[f64; 4]; 6] = [
    [0.0, 0.0, 600.0, 500.0],
    [-900.0, 600.0, 500.0, 300.0],
    [1000.0, 900.0, 450.0, 300.0],
    [0.0, 1600.0, 400.0, 200.0],
    [-400.0, 1900.0, 520.0, 250.0],
    [600.0, 2000.0, 480.0, 250.0],
];

fn height_m(x_m: f64, y_m: f64) -> f64 {
    let cone =
        |[east, north, high_m, wide_m]: [f64; 4]| high_m * (1.0 - (x_m - east).hypot(y_m - north) / wide_m).max(0.0);
    PEAKS.map(cone).into_iter().fold(0.0, f64::max)
}

fn sites() -> Sites {
    let of = |(index, [east, north, high_m, _]): (usize, [f64; 4])| Site {
        world_m: DVec3::new(east, north, high_m),
        text: format!("Peak {index}"),
        weight: high_m,
        kind: SiteKind::Summit,
    };
    Sites { all: PEAKS.into_iter().enumerate().map(of).collect(), names: 0, saddles: 0, lakes: 0, doubted: 0 }
}

struct Scene {
    world: World,
    style: Style,
    renderer: Option<Renderer>,
}

impl Scene {
    fn new() -> Option<Self> {
        let world = World::new(grid_of(501, 501, 10.0, height_m), 0.2)?;
        let mut style = Style::load("pen").unwrap();
        style.paper.typeface = Typeface::Serif;
        Some(Self { world, style, renderer: None })
    }

    fn ground(&self) -> Ground<'_> {
        let area_px = [DVec2::ZERO, DVec2::from_array(SIZE_PX.map(f64::from))];
        Ground { area_px, paper: &self.style.paper, px: 1.0 }
    }

    fn visible(&mut self, pose: Pose, pair: Option<&Pair>, sites: &Sites, names: &MovingNames) -> Visible {
        let request = PictureRequest::still(pose, SIZE_PX, &self.style, NOON);
        let wanted = Wanted { sites: &sites.all, held: &names.held() };
        visible(&self.world.gpu, &mut self.renderer, &mut self.world.surfaces, &request, pair, wanted).unwrap()
    }
}

/// A frame of a flight.
#[derive(Clone)]
struct Frame {
    time_s: f64,
    placed: Vec<Placed>,
    /// How far the land is below the line of sight to each summit, in pixels, and whether the summit is in the picture.
    clear_px: Vec<(f64, bool)>,
}

const FRAMES_PER_S: f64 = 10.0;
/// The tolerance of what is visible for a label that is drawn, with a reserve.
const HIDDEN_PX: f64 = -8.0;

/// Returns how far the land is below the line of sight to a summit, in pixels.
fn clear_px(eye_m: DVec3, summit_m: DVec3, focal_px: f64) -> f64 {
    let clear = |i: u32| {
        let at_m = eye_m.lerp(summit_m, f64::from(i) / 600.0);
        (at_m.z - height_m(at_m.x, at_m.y)) / eye_m.distance(at_m) * focal_px
    };
    (1..590).map(clear).fold(f64::INFINITY, f64::min)
}

fn fly(scene: &mut Scene, seconds: f64) -> Vec<Frame> {
    let (sites, mut names) = (sites(), MovingNames::default());
    let mut frames = Vec::new();
    for number in 0..(seconds * FRAMES_PER_S) as u32 {
        let time_s = f64::from(number) / FRAMES_PER_S;
        let part = time_s / seconds;
        let (x, yaw) = (-1400.0 + 2800.0 * part, 25.0 - 50.0 * part + 6.0 * (3.0 * time_s).sin());
        let pose = scene.world.pose(&format!("{x},-2300,+150,{yaw},{},60", 2.0 * (2.0 * time_s).sin()));
        let seen = scene.visible(pose, None, &sites, &names);
        let placed = names.frame(time_s, &sites, &seen, 10, &scene.ground());
        let view = View::whole(pose, pose, SIZE_PX);
        let clear_px = sites.all.iter().map(|site| {
            let px = view.place_px(site.world_m - pose.position_m);
            let inside = px.is_some_and(|px| px.x > 12.0 && px.x < 308.0 && px.y > 0.0 && px.y < 200.0);
            (clear_px(pose.position_m, site.world_m, view.focal_px()), inside)
        });
        frames.push(Frame { time_s, placed, clear_px: clear_px.collect() });
    }
    frames
}

/// Returns what is wrong with the labels of a flight.
fn faults(frames: &[Frame]) -> Vec<String> {
    let mut faults = Vec::new();
    // The time at which each label last appeared, and last began to disappear.
    let (mut appeared, mut left) = (BTreeMap::<usize, f64>::new(), BTreeMap::<usize, (f64, usize)>::new());
    let mut before: BTreeMap<usize, (Placed, bool)> = BTreeMap::new();
    for frame in frames {
        let at = format!("{:.1} s", frame.time_s);
        let mut now = BTreeMap::new();
        for label in &frame.placed {
            let site = label.at.site;
            let old = before.get(&site);
            let leaves = old.is_some_and(|(old, left)| label.opacity < old.opacity || (*left && label.opacity < 1.0));
            let (clear_px, _) = frame.clear_px[site];
            if !leaves && clear_px < HIDDEN_PX {
                faults.push(format!("{at}: {site} is hidden ({clear_px:.1} px)"));
            }
            if let Some((old, _)) = old {
                // Rows follow the land by a few pixels in a frame.
                if old.row != label.row || (old.bottom_px - label.bottom_px).abs() > 12.0 {
                    faults.push(format!("{at}: {site} jumps to another row"));
                }
                if (old.offset_px - label.offset_px).abs() > 12.0 {
                    faults.push(format!("{at}: {site} jumps along its row"));
                }
            } else {
                let last = left.get(&site).copied().unwrap_or((-9.0, 0));
                // A label may reappear in another row as soon as it has faded.
                let least_s = if last.1 == label.row { 1.0 } else { 0.25 };
                if frame.time_s - last.0 < least_s - 1e-6 {
                    faults.push(format!("{at}: {site} is back after {:.2} s", frame.time_s - last.0));
                }
                appeared.insert(site, frame.time_s);
            }
            now.insert(site, (label.clone(), leaves));
        }
        for (site, (old, had_left)) in &before {
            let leaves = now.get(site).is_none_or(|(_, leaves)| *leaves);
            if !leaves || *had_left {
                continue;
            }
            let (clear_px, is_inside) = frame.clear_px[*site];
            let age_s = frame.time_s - appeared[site];
            if age_s < 1.0 - 1e-6 && clear_px > 0.0 && is_inside {
                faults.push(format!("{at}: {site} leaves after {age_s:.2} s"));
            }
            left.insert(*site, (frame.time_s, old.row));
        }
        before = now;
    }
    faults
}

#[test]
fn labels_of_a_flight_change_at_most_once_a_second() {
    let Some(mut scene) = Scene::new() else { return };
    let frames = fly(&mut scene, 6.0);
    assert_eq!(faults(&frames), Vec::<String>::new());
    // The first frame has labels, and the hidden peak has one in some frames and none in others.
    let opaque = |frame: &Frame| frame.placed.iter().filter(|label| label.opacity >= 1.0).count();
    assert!(opaque(&frames[0]) >= 2, "{:?}", frames[0].placed);
    let labels: usize = frames.iter().map(opaque).sum();
    assert!(labels > 3 * frames.len(), "{labels}");
    let of_hidden = |frame: &&Frame| frame.placed.iter().any(|label| label.at.site == 3);
    let shown = frames.iter().filter(of_hidden).count();
    assert!(shown > 5 && shown + 5 < frames.len(), "{shown} of {}", frames.len());
    assert!(frames.iter().flat_map(|frame| &frame.placed).any(|label| label.opacity > 0.0 && label.opacity < 1.0));
    // Planted: a label in another row, one that is elsewhere along its row, one that blinks, and one of a hidden peak.
    let number =
        (20..40).find(|number| frames[number - 1].placed.len() > 2 && frames[*number].placed.len() > 2).unwrap();
    let spoiled = |spoil: &dyn Fn(&mut Vec<Frame>)| {
        let mut frames = frames.clone();
        spoil(&mut frames);
        faults(&frames)
    };
    assert!(!spoiled(&|frames| frames[number].placed[0].bottom_px -= 17.0).is_empty());
    assert!(!spoiled(&|frames| frames[number].placed[0].offset_px -= 40.0).is_empty());
    assert!(!spoiled(&|frames| _ = frames[number].placed.remove(0)).is_empty());
    let hidden = frames.iter().position(|frame| frame.clear_px[3].0 < HIDDEN_PX && !of_hidden(&frame)).unwrap();
    let label = frames.iter().flat_map(|frame| &frame.placed).find(|label| label.at.site == 3).unwrap();
    assert!(!spoiled(&|frames| frames[hidden].placed.push(label.clone())).is_empty());
}

#[test]
fn a_cut_has_new_labels_at_once() {
    let Some(mut scene) = Scene::new() else { return };
    let (sites, mut names) = (sites(), MovingNames::default());
    let mut frame = |time_s: f64, camera: &str| {
        let pose = scene.world.pose(camera);
        let seen = scene.visible(pose, None, &sites, &names);
        let placed = names.frame(time_s, &sites, &seen, 10, &scene.ground());
        placed.iter().map(|label| (label.at.site, label.opacity)).collect::<Vec<_>>()
    };
    let first = frame(0.0, "0,-2500,+150,0,0,60");
    assert!(first.len() > 1 && first.iter().all(|(_, opacity)| *opacity == 1.0), "{first:?}");
    // Seen from the north, the summits are on the other side.
    let cut = frame(0.1, "0,2450,+900,180,-8,60");
    assert!(cut.len() > 1 && cut.iter().all(|(_, opacity)| *opacity == 1.0), "{cut:?}");
    // A camera that moves slowly makes no cut: what is new appears slowly.
    let slow = frame(0.2, "0,2450,+900,182,-8,60");
    assert!(slow.len() >= cut.len(), "{slow:?}");
}

/// The labels of both eyes.
struct Eyes {
    pair: Pair,
    placed: Vec<Placed>,
    drawn: [Labels; 2],
}

fn eyes(scene: &mut Scene, pose: Pose, pair: Pair) -> Eyes {
    let sites = sites();
    let seen = scene.visible(pose, Some(&pair), &sites, &MovingNames::default());
    let ground = scene.ground();
    let placed = above_land(&sites.all, &seen.sites, seen.land_top_px, &ground);
    let drawn = [0, 1].map(|eye| drawn_rows(&sites.all, &placed, eye, &ground));
    Eyes { pair, placed, drawn }
}

/// Returns which part of the leaders of an eye are at their summits in that eye's picture. `views` are those of the eyes.
fn agreement(eyes: &Eyes, rig: &Rig) -> f64 {
    let sites = sites();
    let right = |eye: usize| {
        let leaders = || eyes.drawn[eye].strokes.iter().filter(|stroke| stroke.points.len() == 2);
        let is_there = |label: &&Placed| {
            let way = sites.all[label.at.site].world_m - rig.eyes[eye].pose.position_m;
            let px = rig.eyes[eye].place_px(way).unwrap();
            leaders().any(|leader| {
                (leader.points[0].x - px.x).abs() < 0.1
                    && (leader.points[1].y - px.y + 3.0).abs() < 0.1
                    && (leader.points[0].y - label.bottom_px - 3.0).abs() < 1e-6
            })
        };
        eyes.placed.iter().filter(is_there).count()
    };
    (right(0) + right(1)) as f64 / (2 * eyes.placed.len()) as f64
}

#[test]
fn both_eyes_have_the_same_labels_at_the_distances_of_their_summits() {
    let Some(mut scene) = Scene::new() else { return };
    let pose = scene.world.pose("0,-2500,+150,0,1,60");
    let camera = View::whole(pose, pose, SIZE_PX);
    for convergence_m in [None, Some(2500.0)] {
        let pair = Pair { ipd_m: 80.0, convergence_m };
        let found = eyes(&mut scene, pose, pair);
        assert!(found.placed.len() >= 3, "{:?}", found.placed);
        assert_eq!(agreement(&found, &pair.rig(&camera)), 1.0);
        // The letters are the same ones, each moved by the parallax of its summit.
        let [left, right] = [0, 1].map(|eye: usize| &found.drawn[eye]);
        assert_eq!((left.areas.len(), &left.labelled), (right.areas.len(), &right.labelled));
        let parallax_px: Vec<f64> = left
            .areas
            .iter()
            .zip(&right.areas)
            .map(|(left, right)| {
                let [left, right] = [left, right].map(|area| kurbo::Shape::bounding_box(&area.curves));
                assert!((left.y0 - right.y0).abs() < 1e-9);
                right.x0 - left.x0
            })
            .collect();
        let expected: Vec<f64> = found.placed.iter().map(|label| label.at.apart_px).collect();
        assert!(parallax_px.iter().all(|px| expected.iter().any(|other| (px - other).abs() < 1e-6)));
        let spread =
            |all: &[f64]| all.iter().fold(f64::MIN, |a, b| a.max(*b)) - all.iter().fold(f64::MAX, |a, b| a.min(*b));
        assert!(spread(&expected) > 2.0, "{expected:?}");
        // Planted: the pictures of the eyes are exchanged.
        let exchanged = Eyes { drawn: [right.clone(), left.clone()], placed: found.placed.clone(), pair };
        assert!(agreement(&exchanged, &pair.rig(&camera)) < 0.5);
        // Eyes that are exchanged exchange their labels.
        let other = eyes(&mut scene, pose, Pair { ipd_m: -pair.ipd_m, ..pair });
        let leaders = |labels: &Labels| -> Vec<f64> {
            let leaders = labels.strokes.iter().filter(|stroke| stroke.points.len() == 2);
            leaders.map(|stroke| stroke.points[0].x).collect()
        };
        for (a, b) in [(0, 1), (1, 0)] {
            let [own, exchanged] = [leaders(&found.drawn[a]), leaders(&other.drawn[b])];
            assert!(own.iter().zip(&exchanged).all(|(own, other)| (own - other).abs() < 1e-6), "{own:?} {exchanged:?}");
        }
        assert!(found.pair.ipd_m == -other.pair.ipd_m);
    }
    // A summit that only one eye sees has no label: the fourth peak is behind the first.
    let pair = Pair { ipd_m: 900.0, convergence_m: None };
    let side = scene.world.pose("-330,-2500,+150,0,1,60");
    let seen = scene.visible(side, Some(&pair), &sites(), &MovingNames::default());
    let rig = pair.rig(&View::whole(side, side, SIZE_PX));
    let alone = |eye: usize| {
        let pose = rig.eyes[eye].pose;
        scene.visible(pose, None, &sites(), &MovingNames::default()).sites.iter().any(|at| at.site == 3)
    };
    let mut alone = alone;
    let [left, right] = [alone(0), alone(1)];
    assert!(left != right && !seen.sites.iter().any(|at| at.site == 3), "{left} {right}");
}

#[test]
fn the_frame_itself_decides_as_a_picture_for_it_does() {
    let Some(mut scene) = Scene::new() else { return };
    let pose = scene.world.pose("300,-2500,+150,-4,1,60");
    let (sites, names) = (sites(), MovingNames::default());
    let expected = scene.visible(pose, None, &sites, &names);
    let rig = Rig::mono(View::whole(pose, pose, SIZE_PX));
    let World { gpu, surfaces, .. } = &mut scene.world;
    let mut renderer = Renderer::new(gpu).unwrap();
    renderer.render_eyes(gpu, surfaces, &rig, &scene.style, &NOON).unwrap();
    let held = names.held();
    let wanted = Wanted { sites: &sites.all, held: &held };
    let surface = SeenSurface::read(gpu, &renderer, surfaces, &rig).unwrap().unwrap();
    assert_eq!(surface.visible(wanted, &rig), expected);
    assert!(expected.sites.len() >= 3);
    // Planted: another rig, whose picture has another size.
    let other = Rig::mono(View::whole(pose, pose, [160, 100]));
    assert!(SeenSurface::read(gpu, &renderer, surfaces, &other).unwrap().is_none());
}
