//! Tests names on pictures: summits that the picture shows have labels at their places, hidden ones have none, and labels
//! do not overlap.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;

use crate::tests::common;

use common::draw::NOON;
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::labels::placement::Rect;
use hachure::picture::PictureRequest;
use hachure::picture::names::{
    Ground, Labels, Seen, Site, SiteKind, Visible, Wanted, above_land, drawn_rows, on_map, visible,
};
use hachure::scene::view::Pose;
use hachure::style::{Style, Typeface};

const SIZE_PX: [u32; 2] = [480, 300];
/// From the south, 150 m above the ground.
const CAMERA: &str = "0,-2500,+150,0,1,60";

/// Peaks as east, north, height and width in metres. The last one is behind the first.
const PEAKS: [[f64; 4]; 4] = [
    [0.0, 0.0, 600.0, 500.0],
    [-900.0, 600.0, 500.0, 300.0],
    [1000.0, 900.0, 450.0, 300.0],
    [0.0, 1600.0, 400.0, 200.0],
];

fn height_m(x_m: f64, y_m: f64) -> f64 {
    let cone =
        |[east, north, high_m, wide_m]: [f64; 4]| high_m * (1.0 - (x_m - east).hypot(y_m - north) / wide_m).max(0.0);
    PEAKS.map(cone).into_iter().fold(0.0, f64::max)
}

fn sites() -> Vec<Site> {
    let of = |(index, [east, north, high_m, _]): (usize, [f64; 4])| Site {
        world_m: DVec3::new(east, north, high_m),
        text: format!("Peak {index}"),
        weight: high_m,
        kind: SiteKind::Summit,
    };
    PEAKS.into_iter().enumerate().map(of).collect()
}

struct Drawn {
    world: World,
    style: Style,
    pose: Pose,
}

impl Drawn {
    fn new() -> Option<Self> {
        let world = World::new(grid_of(501, 501, 10.0, height_m), 0.2)?;
        let pose = world.pose(CAMERA);
        let mut style = Style::load("pen").unwrap();
        style.paper.typeface = Typeface::Serif;
        Some(Self { world, style, pose })
    }

    fn visible(&mut self, sites: &[Site]) -> Visible {
        let request = PictureRequest::still(self.pose, SIZE_PX, &self.style, NOON);
        let wanted = Wanted { sites, held: &BTreeSet::new() };
        visible(&self.world.gpu, &mut None, &mut self.world.surfaces, &request, None, wanted).unwrap()
    }

    fn seen(&mut self, sites: &[Site]) -> Vec<Seen> {
        self.visible(sites).sites
    }

    /// Lays out labels above the land, and draws them.
    fn above(&self, sites: &[Site], seen: &[Seen], land_top_px: f64, ground: &Ground<'_>) -> Labels {
        drawn_rows(sites, &above_land(sites, seen, land_top_px, ground), 0, ground)
    }

    fn ground(&self) -> Ground<'_> {
        let area_px = [DVec2::ZERO, DVec2::from_array(SIZE_PX.map(f64::from))];
        Ground { area_px, paper: &self.style.paper, px: 1.0 }
    }
}

/// Returns the boxes around the letters of labels, which are apart from each other by more than a letter.
fn boxes(labels: &Labels) -> Vec<Rect> {
    let mut found: Vec<Rect> = Vec::new();
    for area in &labels.areas {
        let around = kurbo::Shape::bounding_box(&area.curves);
        let own = Rect { from_px: [around.x0, around.y0], to_px: [around.x1, around.y1] };
        // Letters of a text follow each other from left to right.
        match found.last_mut() {
            Some(last)
                if own.from_px[0] >= last.from_px[0]
                    && own.from_px[0] - last.to_px[0] < 6.0
                    && own.overlaps(last, 6.0) =>
            {
                last.to_px = [0, 1].map(|axis| last.to_px[axis].max(own.to_px[axis]));
                last.from_px = [0, 1].map(|axis| last.from_px[axis].min(own.from_px[axis]));
            }
            _ => found.push(own),
        }
    }
    found
}

#[test]
fn summits_in_view_are_found_and_hidden_ones_are_not() {
    let Some(mut drawn) = Drawn::new() else { return };
    let sites = sites();
    let seen = drawn.seen(&sites);
    let mut found: Vec<usize> = seen.iter().map(|at| at.site).collect();
    found.sort_unstable();
    assert_eq!(found, [0, 1, 2], "{seen:?}");
    // The camera looks north: a summit to the east of another is to the right of it.
    let at = |site: usize| seen.iter().find(|at| at.site == site).unwrap().px;
    assert!(at(1).x < at(0).x && at(0).x < at(2).x, "{seen:?}");
    assert!((at(0).x - 240.0).abs() < 1.0 && at(0).y < at(1).y, "{seen:?}");
    // Planted: the same summits under the ground, in the air, and exchanged heights.
    let moved = |by_m: f64| -> Vec<Site> {
        sites.iter().map(|site| Site { world_m: site.world_m + by_m * DVec3::Z, ..site.clone() }).collect()
    };
    assert!(drawn.seen(&moved(150.0)).is_empty());
    let above: Vec<usize> = drawn.seen(&moved(-150.0)).iter().map(|at| at.site).collect();
    assert!(above.len() < 3, "{above:?}");
    // Without the peak in front, the hidden one is seen.
    let Some(world) =
        World::new(grid_of(501, 501, 10.0, |x_m, y_m| if y_m > 1200.0 { height_m(x_m, y_m) } else { 0.0 }), 0.2)
    else {
        return;
    };
    drawn.world = world;
    drawn.pose = drawn.world.pose(CAMERA);
    let seen: Vec<usize> = drawn.seen(&sites).iter().map(|at| at.site).collect();
    assert_eq!(seen, [3]);
}

#[test]
fn labels_are_above_their_summits_and_apart() {
    let Some(mut drawn) = Drawn::new() else { return };
    let sites = sites();
    let Visible { sites: seen, land_top_px, .. } = drawn.visible(&sites);
    let labels = drawn.above(&sites, &seen, land_top_px, &drawn.ground());
    assert_eq!(labels.labelled.len(), 3, "{labels:?}");
    let boxes = boxes(&labels);
    assert_eq!(boxes.len(), 3, "{boxes:?}");
    let apart = |boxes: &[Rect]| {
        boxes.iter().enumerate().all(|(i, own)| boxes[..i].iter().all(|other| !own.overlaps(other, 1.0)))
    };
    assert!(apart(&boxes));
    // Planted: a label at the place of another.
    assert!(!apart(&[boxes[0], boxes[1], boxes[0]]));
    // Leaders are vertical, from a label down to its summit.
    let leaders: Vec<_> = labels.strokes.iter().filter(|stroke| stroke.points.len() == 2).collect();
    for at in &seen {
        let own = leaders.iter().find(|leader| (leader.points[0].x - at.px.x).abs() < 0.01);
        let Some(leader) = own else { panic!("{at:?} has no leader: {leaders:?}") };
        assert!((leader.points[1].x - at.px.x).abs() < 1e-9 && (at.px.y - leader.points[1].y - 3.0).abs() < 1e-9);
        assert!(boxes.iter().any(|label| {
            label.from_px[0] <= at.px.x && label.to_px[0] >= at.px.x && label.to_px[1] <= leader.points[0].y
        }));
    }
    // Names are above all land, also above what has no name.
    let lowest = boxes.iter().map(|label| label.to_px[1]).fold(0.0, f64::max);
    assert!(lowest < land_top_px && labels.halo.is_empty(), "{lowest} {land_top_px}");
    let only = drawn.above(&sites, &seen[1..2], land_top_px, &drawn.ground());
    assert!(self::boxes(&only).iter().all(|label| label.to_px[1] < land_top_px));
    // Without room in the sky they are on land, with a halo, and without any room nothing is drawn.
    let high = drawn.above(&sites, &seen, 4.0, &drawn.ground());
    assert!(!high.halo.is_empty() && !high.labelled.is_empty(), "{high:?}");
    let narrow = Ground { area_px: [DVec2::ZERO, DVec2::new(480.0, 12.0)], ..drawn.ground() };
    assert!(drawn.above(&sites, &seen, land_top_px, &narrow).labelled.is_empty());
}

#[test]
fn labels_of_a_map_keep_clear_of_other_symbols() {
    let Some(drawn) = Drawn::new() else { return };
    let sites = sites();
    let seen: Vec<Seen> = [[200.0, 150.0], [212.0, 150.0], [5.0, 5.0], [330.0, 200.0]]
        .into_iter()
        .enumerate()
        .map(|(site, px)| Seen { site, px: px.into(), apart_px: 0.0, below_px: 0.0 })
        .collect();
    let labels = on_map(&sites, &seen, &drawn.ground());
    assert!(labels.labelled.len() >= 3 && !labels.halo.is_empty(), "{labels:?}");
    let symbols: Vec<Rect> = seen
        .iter()
        .filter(|at| labels.labelled.contains(&at.site))
        .map(|at| Rect { from_px: (at.px - 3.0).to_array(), to_px: (at.px + 3.0).to_array() })
        .collect();
    let clear = |boxes: &[Rect]| boxes.iter().all(|own| symbols.iter().all(|symbol| !own.overlaps(symbol, 0.0)));
    let found = boxes(&labels);
    assert!(clear(&found), "{found:?} {symbols:?}");
    // Planted: a label on a symbol.
    assert!(!clear(&[symbols[0]]));
}
