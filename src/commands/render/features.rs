//! `render --map -o NAME.geojson`: writes the strokes and marks of a map as lines on the earth.

use std::path::Path;

use anyhow::{Context, bail};
use glam::DVec2;
use kurbo::PathEl;

use super::Job;
use super::map::PlacedMap;
use super::vector::SvgOptions;
use crate::file::geojson::{Collection, Feature, WGS84, write_geojson};
use crate::file::message::named;
use crate::file::svg::{Layer, Stroke};
use crate::picture::PictureReport;
use crate::scene::view::Pose;
use crate::source::WorldMapping;
use crate::source::georeference::Crs;
use crate::source::lon_lat::ToWgs84;
use crate::style::{self, HeightsOf, Style};
use crate::tiles::Terrain;

/// Coordinates are rounded to this fraction of a pixel.
const ROUNDED_PX: f64 = 0.01;
/// Lines shorter than this become dots, in pixels.
const DOT_PX: f64 = 1e-3;
/// Degrees of a turn.
const TURN_DEG: f64 = 360.0;

/// The coordinates of a map's points.
struct Places<'a> {
    placed: &'a PlacedMap,
    mapping: &'a WorldMapping,
    /// Conversion to longitudes and latitudes, if they are requested.
    to_wgs84: Option<ToWgs84>,
    /// A turn in the unit of the first coordinate, if that is a longitude.
    turn: Option<f64>,
}

impl Places<'_> {
    fn world_m(&self, px: kurbo::Point) -> DVec2 {
        self.placed.map.world_from_px(DVec2::new(px.x, px.y))
    }

    fn of(&self, px: kurbo::Point) -> DVec2 {
        let crs = self.mapping.crs_from_world(self.world_m(px));
        let place = self.to_wgs84.as_ref().map_or(crs, |to| to.degrees(crs));
        within_poles(place, self.turn)
    }

    /// Returns the parts of a line of the picture.
    fn parts(&self, points: &[kurbo::Point]) -> Vec<Vec<[f64; 2]>> {
        cut_at_date_line(continuous(points.iter().map(|px| self.of(*px)).collect(), self.turn), self.turn)
    }

    /// Returns the length of a line in metres.
    fn length_m(&self, points: &[kurbo::Point]) -> f64 {
        points.windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>() * self.placed.map.pixel_m
    }
}

/// The meaning of a layer for the land.
enum LayerMeaning {
    /// Contour lines of height, with their interval in metres.
    Heights { interval_m: f64, of: HeightsOf },
    /// Hatching marks, rows or cuts, which follow the land.
    Marks,
    /// A layer without heights or slopes.
    Other,
}

impl LayerMeaning {
    fn of(style: &Style, layer: &Layer) -> Self {
        // The ids of sets and of pens begin with the id of the ink.
        let is_own = |id: &str| layer.id == id || layer.id.strip_prefix(id).is_some_and(|rest| rest.starts_with('-'));
        // `heights-layer-2` begins with `heights`, too: the highest of the layers is meant.
        let contours = style.inks().into_iter().rev().find_map(|own| match style.layers.get(own.layer?)? {
            style::Layer::HeightLines(lines) if is_own(&own.id(None)) => Some((f64::from(lines.interval_m), lines.of)),
            _ => None,
        });
        if let Some((interval_m, of)) = contours {
            return Self::Heights { interval_m, of };
        }
        let is_mark = style.inks().iter().any(|own| own.ink.makes_tone && is_own(own.ink.id));
        if is_mark { Self::Marks } else { Self::Other }
    }
}

/// Returns the height of a contour line: the multiple of the interval above `from_m` that is nearest to the median of the
/// land below its points, in metres. The lines follow the form of the land, which is smoother than its surface.
fn contour_height_m(
    terrain: &Terrain,
    points_m: impl Iterator<Item = DVec2>,
    [interval_m, from_m]: [f64; 2],
) -> Option<f64> {
    let mut heights: Vec<f64> = points_m.filter_map(|at_m| terrain.height_m(at_m)).collect();
    heights.sort_by(f64::total_cmp);
    let median_m = *heights.get(heights.len() / 2)?;
    Some(from_m + ((median_m - from_m) / interval_m).round() * interval_m)
}

/// Returns the slope of the land in degrees, over twice `step_m`.
fn slope_deg(terrain: &Terrain, at_m: DVec2, step_m: f64, exaggeration: f64) -> Option<f64> {
    let rise = |way: DVec2| {
        Some((terrain.height_m(at_m + way * step_m)? - terrain.height_m(at_m - way * step_m)?) / (2.0 * step_m))
    };
    Some((DVec2::new(rise(DVec2::X)?, rise(DVec2::Y)?).length() / exaggeration).atan().to_degrees())
}

impl Job<'_> {
    /// Writes the map's strokes and marks to `path`: in the reference system of the world's file, or in WGS 84.
    pub(super) fn features(&mut self, path: &Path, pose: Pose) -> anyhow::Result<PictureReport> {
        let (layers, drawn, report) = self.layers(path, pose, true)?;
        let (Some(placed), Some(svg)) = (&self.map, &self.svg) else {
            unreachable!("checked: a map with lines is drawn")
        };
        let terrain = &self.world.surfaces.terrain;
        let world = terrain.store().georeference();
        let to_wgs84 = self.args.wgs84.then(|| ToWgs84::new(world)).transpose().map_err(anyhow::Error::msg)?;
        let epsg = if self.args.wgs84 { WGS84 } else { world.epsg().context("the reference system has no code")? };
        let turn = match &world.crs {
            _ if self.args.wgs84 => Some(TURN_DEG),
            Crs::Geographic { radians_per_unit, .. } => Some(std::f64::consts::TAU / radians_per_unit),
            Crs::Projected { .. } | Crs::Local => None,
        };
        let places = Places { placed, mapping: terrain.mapping(), to_wgs84, turn };
        let middle = 0.5 * placed.map.size();
        let middle = kurbo::Point::new(middle.x, middle.y);
        // The middle may be on the antimeridian.
        let pair = continuous(vec![places.of(middle), places.of(middle + (0.0, 1.0))], places.turn);
        let unit_per_px = pair[0].distance(pair[1]);
        if !(unit_per_px.is_finite() && unit_per_px > 0.0) {
            bail!("cannot write {}: the centre of the map has no coordinates in EPSG:{epsg}", named(path));
        }
        let features = layers.iter().flat_map(|layer| self.layer_features(layer, svg, &places)).collect();
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let digits = (-(ROUNDED_PX * unit_per_px).log10()).ceil().clamp(0.0, 12.0) as usize;
        self.world.ground_was_read()?;
        write_geojson(path, &Collection { name, epsg, digits, features })?;
        self.drawn.append(&drawn);
        Ok(report)
    }

    /// Returns the lines of a layer.
    fn layer_features(&self, layer: &Layer, svg: &SvgOptions, places: &Places<'_>) -> Vec<Feature> {
        let terrain = &self.world.surfaces.terrain;
        let exaggeration = self.world.scene.vertical_exaggeration;
        let pixel_m = places.placed.map.pixel_m;
        let ink = layer.ink.clone().unwrap_or_else(|| svg.ink());
        let meaning = LayerMeaning::of(&self.style, layer);
        let feature = |stroke: &Stroke| {
            let points = flattened(&stroke.path, svg.flattening_px());
            let (height_m, slope_deg) = match meaning {
                LayerMeaning::Heights { interval_m, of } => {
                    let sea_m = self.world.surfaces.sea_level_m().filter(|_| of == HeightsOf::Sea);
                    let points_m = points.iter().map(|px| places.world_m(*px));
                    let drawn_m =
                        contour_height_m(terrain, points_m, [interval_m * exaggeration, sea_m.unwrap_or(0.0)]);
                    (drawn_m.map(|height_m| height_m / exaggeration), None)
                }
                LayerMeaning::Marks => {
                    let middle = points.get(points.len() / 2).copied();
                    let slope = |px| slope_deg(terrain, places.world_m(px), pixel_m, exaggeration);
                    (None, middle.and_then(slope))
                }
                LayerMeaning::Other => (None, None),
            };
            Feature {
                kind: layer.kind,
                layer: layer.id.clone(),
                width_m: stroke.width * pixel_m,
                ink: stroke.ink.clone().unwrap_or_else(|| ink.clone()),
                opacity: stroke.opacity,
                pen: layer.pen,
                length_m: places.length_m(&points),
                height_m,
                slope_deg,
                parts: places.parts(&points),
            }
        };
        layer.strokes.iter().map(feature).collect()
    }
}

/// Returns a place whose latitude is not beyond a pole. The outer samples of a grid of the globe are half a sample beyond.
fn within_poles(place: DVec2, turn: Option<f64>) -> DVec2 {
    turn.map_or(place, |turn| DVec2::new(place.x, place.y.clamp(-0.25 * turn, 0.25 * turn)))
}

/// Adds turns to the longitudes of a line, so that none differs from the one before by more than half a turn.
fn continuous(mut places: Vec<DVec2>, turn: Option<f64>) -> Vec<DVec2> {
    let Some(turn) = turn else { return places };
    for next in 1..places.len() {
        places[next].x += turn * ((places[next - 1].x - places[next].x) / turn).round();
    }
    places
}

/// Flattens a path into points; a path of hardly any length becomes one point.
fn flattened(path: &kurbo::BezPath, tolerance_px: f64) -> Vec<kurbo::Point> {
    let mut points: Vec<kurbo::Point> = Vec::new();
    kurbo::flatten(path, tolerance_px, |element| match element {
        PathEl::MoveTo(to) | PathEl::LineTo(to) => points.push(to),
        PathEl::ClosePath => points.extend(points.first().copied()),
        PathEl::QuadTo(..) | PathEl::CurveTo(..) => {}
    });
    points.dedup();
    let length_px: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    if length_px < DOT_PX {
        points.truncate(1);
    }
    points
}

/// Splits a line at the antimeridian, as RFC 7946 requires (section 3.1.9), so that longitudes are from −180° to 180°.
/// `turn` is 360° in the unit of longitudes; `None` for a system without longitudes.
fn cut_at_date_line(places: Vec<DVec2>, turn: Option<f64>) -> Vec<Vec<[f64; 2]>> {
    let Some(turn) = turn else { return vec![places.iter().map(DVec2::to_array).collect()] };
    let half = 0.5 * turn;
    let side = |place: DVec2| ((place.x + half) / turn).floor();
    let mut parts: Vec<Vec<[f64; 2]>> = vec![Vec::new()];
    let mut before: Option<DVec2> = None;
    let count = places.len();
    for (number, place) in places.into_iter().enumerate() {
        // The end of a line on the edge itself belongs to the part before it.
        if number + 1 == count
            && let Some(before) = before.filter(|before| side(*before) != side(place))
            && (place.x + half).rem_euclid(turn) == 0.0
            && before.x < place.x
        {
            parts.last_mut().into_iter().for_each(|part| part.push([half, place.y]));
            break;
        }
        if let Some(before) = before.filter(|before| side(*before) != side(place)) {
            let edge = side(before).max(side(place)) * turn - half;
            let part = (edge - before.x) / (place.x - before.x);
            let north = before.y + (place.y - before.y) * part;
            let sign = if place.x > before.x { 1.0 } else { -1.0 };
            parts.last_mut().into_iter().for_each(|part| part.push([sign * half, north]));
            parts.push(vec![[-sign * half, north]]);
        }
        parts.last_mut().into_iter().for_each(|part| part.push([place.x - side(place) * turn, place.y]));
        before = Some(place);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn longitudes_run_on_across_the_date_line() {
        let jumping = vec![DVec2::new(179.0, 10.0), DVec2::new(-179.0, 12.0), DVec2::new(179.5, 12.0)];
        let on = vec![DVec2::new(179.0, 10.0), DVec2::new(181.0, 12.0), DVec2::new(179.5, 12.0)];
        assert_eq!(continuous(jumping.clone(), Some(360.0)), on);
        assert_eq!(continuous(jumping.clone(), None), jumping);
    }

    #[test]
    fn latitudes_end_at_the_poles() {
        let beyond = DVec2::new(12.0, -90.05);
        assert_eq!(within_poles(beyond, Some(360.0)), DVec2::new(12.0, -90.0));
        assert_eq!(within_poles(-beyond, Some(360.0)), DVec2::new(-12.0, 90.0));
        assert_eq!(within_poles(beyond, None), beyond, "northings have no poles");
        assert!(within_poles(DVec2::NAN, Some(360.0)).is_nan());
    }

    #[test]
    fn lines_are_cut_at_the_date_line() {
        let line = vec![DVec2::new(179.0, 10.0), DVec2::new(181.0, 12.0), DVec2::new(179.5, 12.0)];
        let cut = cut_at_date_line(line.clone(), Some(360.0));
        let expected = vec![
            vec![[179.0, 10.0], [180.0, 11.0]],
            vec![[-180.0, 11.0], [-179.0, 12.0], [-180.0, 12.0]],
            vec![[180.0, 12.0], [179.5, 12.0]],
        ];
        assert_eq!(cut, expected);
        let to_the_edge = vec![DVec2::new(179.0, 10.0), DVec2::new(180.0, 12.0)];
        assert_eq!(cut_at_date_line(to_the_edge, Some(360.0)), [vec![[179.0, 10.0], [180.0, 12.0]]]);
        assert_eq!(cut_at_date_line(line, None), [vec![[179.0, 10.0], [181.0, 12.0], [179.5, 12.0]]]);
    }

    #[test]
    fn curves_become_lines_and_points_dots() {
        let path = kurbo::BezPath::from_svg("M0,0 C0,10 10,10 10,0").unwrap();
        let points = flattened(&path, 0.05);
        assert!(points.len() > 4 && points.first() == Some(&kurbo::Point::ZERO), "{points:?}");
        let highest = points.iter().map(|point| point.y).fold(0.0, f64::max);
        assert!((highest - 7.5).abs() < 0.1, "{highest}");
        let dot = kurbo::BezPath::from_svg("M3,4 L3.0001,4").unwrap();
        assert_eq!(flattened(&dot, 0.05), [kurbo::Point::new(3.0, 4.0)]);
    }
}
