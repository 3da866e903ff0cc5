//! Reprojection: where a pixel of one frame is in another, and whether it is visible there.
//!
//! The world does not move: the motion of a surface comes from its position, that of the sky from its direction. A line
//! straddles the edge that it outlines, so half of its pixels are over the surface behind. A line therefore moves with
//! the *nearest* surface within [`OWNER_PX`]. Of the pixels there that show this surface, the one closest to the line's
//! pixel gives the motion, because on a plane seen at a grazing angle motion changes from row to row.
//!
//! Visibility in both frames is decided by the nearest distance around a point: the distance expected from one frame
//! must be found in the other. Distances may change much from pixel to pixel on land seen at a grazing angle, and
//! points are between pixels. So the expected distance must be between the nearest ones within a slightly smaller and a
//! slightly larger circle, with a tolerance.
//!
//! Lines of the surface *behind* the edge, which have their own motion, end at the same edge. A line that is not found
//! with the motion of the surface in front may be found with that of its own surface ([`Follower::place_behind`]).
//!
//! A line that is uncovered within [`OWNER_PX`] of an edge cannot be distinguished from that edge's own line. Edges
//! mostly have a line in both frames, which is then found.
//!
//! Each frame bends the earth around its own camera. Between frames this moves a point by the camera's step over the
//! earth's radius, some 1e-6 rad at 10 m.

use glam::{DVec2, DVec3};

use super::DrawnFrame;
use crate::scene::view::View;

/// A line belongs to the nearest surface within this distance.
pub(crate) const OWNER_PX: f64 = 2.0;
/// Pixels without ink are compared with the nearest surface within this distance. It is larger than for lines, because
/// a line of the other frame extends over the edge that it outlines and hides the pixels there.
const SURROUNDINGS_PX: f64 = 3.0;
/// Difference between the radii of the two circles in which a distance is searched and the nominal radius, in pixels,
/// since points are between pixels.
const SLACK_PX: f64 = 0.75;
/// Tolerance of an expected distance, relative to it.
const SAME_DISTANCE: f64 = 0.02;
/// Surfaces no farther than this, relative to the nearest one, have nearly its motion.
const SAME_SURFACE: f64 = 0.05;

/// The positions and distances of a frame's pixels.
pub(crate) struct SurfaceOfFrame<'a> {
    view: &'a View,
    /// Vector from the eye to the origin of positions.
    from_eye_m: DVec3,
    position: &'a [[f32; 4]],
    /// Distances from the eye; the sky is infinitely far.
    distance_m: Vec<f32>,
    size: [i64; 2],
}

/// Which surface's motion a pixel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Whose {
    /// The motion of the surface at the pixel.
    Surface,
    /// The motion of the nearest surface around the pixel.
    Line,
}

/// Maps pixels from one frame to another.
pub(crate) struct Follower<'a> {
    pub from: &'a SurfaceOfFrame<'a>,
    pub to: &'a SurfaceOfFrame<'a>,
}

impl<'a> SurfaceOfFrame<'a> {
    pub(crate) fn new(frame: &'a DrawnFrame) -> Self {
        let from_eye_m = frame.origin_m - frame.view.pose.position_m;
        let distance_m =
            |at: &[f32; 4]| if at[3] > 0.0 { (way(at) + from_eye_m).length() as f32 } else { f32::INFINITY };
        Self {
            view: &frame.view,
            from_eye_m,
            position: &frame.position,
            distance_m: frame.position.iter().map(distance_m).collect(),
            size: frame.view.part.size_px.map(i64::from),
        }
    }

    /// Returns the width of the picture in pixels.
    pub(crate) fn width(&self) -> usize {
        self.size[0] as usize
    }

    /// Whether a pixel shows a surface, not the sky.
    pub(crate) fn is_surface(&self, pixel: usize) -> bool {
        self.distance_m[pixel].is_finite()
    }

    /// Returns the centre of a pixel, from the upper left corner of the picture.
    pub(crate) fn centre(&self, pixel: usize) -> DVec2 {
        let width = self.width();
        DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5)
    }

    /// Returns the pixels whose centres are within a distance of a point, with their squared distances.
    pub(crate) fn within(&self, place: DVec2, radius_px: f64) -> impl Iterator<Item = (usize, f64)> + use<'_> {
        let span = |at: f64, side: i64| {
            let first = ((at - radius_px - 0.5).ceil() as i64).max(0);
            let last = ((at + radius_px - 0.5).floor() as i64).min(side - 1);
            first..=last
        };
        let columns = span(place.x, self.size[0]);
        span(place.y, self.size[1]).flat_map(move |y| columns.clone().map(move |x| [x, y])).filter_map(move |[x, y]| {
            let squared = (DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - place).length_squared();
            (squared <= radius_px * radius_px).then_some(((y * self.size[0] + x) as usize, squared))
        })
    }

    /// Interpolates a picture bilinearly; beyond the border it continues with the outermost pixels.
    pub(crate) fn bilinear(&self, picture: &[f32], place: DVec2) -> f64 {
        let corner = place - 0.5;
        let (whole, part) = (corner.floor(), corner - corner.floor());
        let at = |dx: i64, dy: i64| {
            let x = (whole.x as i64 + dx).clamp(0, self.size[0] - 1);
            let y = (whole.y as i64 + dy).clamp(0, self.size[1] - 1);
            f64::from(picture[(y * self.size[0] + x) as usize])
        };
        let row = |dy: i64| at(0, dy) + (at(1, dy) - at(0, dy)) * part.x;
        row(0) + (row(1) - row(0)) * part.y
    }

    fn nearest_m(&self, place: DVec2, radius_px: f64) -> f64 {
        self.within(place, radius_px).map(|(pixel, _)| f64::from(self.distance_m[pixel])).fold(f64::INFINITY, f64::min)
    }
}

impl Follower<'_> {
    /// Returns where `pixel` is in the other frame, from that picture's upper left corner; `None` if it is not visible
    /// there.
    pub(crate) fn place(&self, pixel: usize, whose: Whose) -> Option<DVec2> {
        let centre = self.from.centre(pixel);
        let radius_px = if whose == Whose::Line { OWNER_PX } else { SURROUNDINGS_PX };
        let distance_m = |pixel: usize| f64::from(self.from.distance_m[pixel]);
        let around = || self.from.within(centre, radius_px);
        let owner = around().min_by(|a, b| distance_m(a.0).total_cmp(&distance_m(b.0)))?.0;
        let mover = match whose {
            Whose::Surface => pixel,
            Whose::Line => {
                let of_owner = around().filter(|(at, _)| distance_m(*at) <= distance_m(owner) * (1.0 + SAME_SURFACE));
                of_owner.min_by(|a, b| a.1.total_cmp(&b.1))?.0
            }
        };
        let place = self.moved(pixel, mover)?;
        let expected_m = self.expected_m(owner);
        let covered = self.to.nearest_m(place, radius_px - SLACK_PX) < expected_m * (1.0 - SAME_DISTANCE);
        let gone = self.to.nearest_m(place, radius_px + SLACK_PX) > expected_m * (1.0 + SAME_DISTANCE);
        (!covered && !gone).then_some(place)
    }

    /// Returns [`Self::place`] with the motion of the surface at the pixel itself, which must be visible near its place
    /// but need not be the nearest one there.
    pub(crate) fn place_behind(&self, pixel: usize) -> Option<DVec2> {
        let place = self.moved(pixel, pixel)?;
        let expected_m = self.expected_m(pixel);
        let is_it = |found_m: f64| (found_m - expected_m).abs() <= SAME_DISTANCE * expected_m || found_m == expected_m;
        let mut around = self.to.within(place, OWNER_PX);
        around.any(|(at, _)| is_it(self.to.distance_m[at].into())).then_some(place)
    }

    /// Returns where ink of a stroke at `depth_m` along the view axis is in the other frame. A wide stroke extends
    /// farther over the edge that it outlines than a line does. `None` if nearer surfaces hide it there.
    pub(crate) fn place_of_stroke(&self, pixel: usize, depth_m: f64, half_width_px: f64) -> Option<DVec2> {
        let origin = self.from.view.part.origin_px;
        let ray = self.from.view.ray(self.from.centre(pixel) + DVec2::new(origin[0].into(), origin[1].into()));
        let step_m = self.from.view.pose.position_m - self.to.view.pose.position_m;
        let way = ray * depth_m + step_m;
        let shift = self.to.view.part.origin_px;
        let place = self.to.view.place_px(way)? - DVec2::new(shift[0].into(), shift[1].into());
        let [width, height] = self.to.size.map(|side| side as f64);
        if !(0.0..width).contains(&place.x) || !(0.0..height).contains(&place.y) {
            return None;
        }
        let expected_m = way.length();
        // Hidden only if everything around it is nearer.
        let is_open = |at: usize| f64::from(self.to.distance_m[at]) >= expected_m * (1.0 - SAME_DISTANCE);
        self.to.within(place, half_width_px + OWNER_PX).any(|(at, _)| is_open(at)).then_some(place)
    }

    /// Returns a pixel's place by the motion of `mover`; `None` outside of the picture.
    fn moved(&self, pixel: usize, mover: usize) -> Option<DVec2> {
        let place = self.from.centre(pixel) + self.motion(mover)?;
        let [width, height] = self.to.size.map(|side| side as f64);
        ((0.0..width).contains(&place.x) && (0.0..height).contains(&place.y)).then_some(place)
    }

    fn expected_m(&self, pixel: usize) -> f64 {
        self.way_there(pixel).map_or(f64::INFINITY, DVec3::length)
    }

    /// Returns the vector from the other frame's eye to the point that a pixel shows; `None` for the sky.
    fn way_there(&self, pixel: usize) -> Option<DVec3> {
        let step_m = self.from.view.pose.position_m - self.to.view.pose.position_m;
        let at = &self.from.position[pixel];
        (at[3] > 0.0).then(|| way(at) + self.from.from_eye_m + step_m)
    }

    /// Returns the motion in the picture of the point that a pixel shows; `None` if it ends up sideways or behind the
    /// eye.
    fn motion(&self, pixel: usize) -> Option<DVec2> {
        let (here, there) = match self.way_there(pixel) {
            Some(there) => (way(&self.from.position[pixel]) + self.from.from_eye_m, there),
            None => {
                let origin = self.from.view.part.origin_px;
                let ray = self.from.view.ray(self.from.centre(pixel) + DVec2::new(origin[0].into(), origin[1].into()));
                (ray, ray)
            }
        };
        // Both by projection, so that rounding errors of positions against pixel centres cancel.
        let shift = |view: &View| DVec2::new(view.part.origin_px[0].into(), view.part.origin_px[1].into());
        let from = self.from.view.place_px(here)? - shift(self.from.view);
        let to = self.to.view.place_px(there)? - shift(self.to.view);
        Some(to - from)
    }
}

fn way(at: &[f32; 4]) -> DVec3 {
    DVec3::new(at[0].into(), at[1].into(), at[2].into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::view::Pose;

    const SIZE_PX: [u32; 2] = [7, 5];

    fn view(position_m: DVec3) -> View {
        let pose = Pose { position_m, forward: DVec3::Y, right: DVec3::X, up: DVec3::Z, fov_rad: 0.7 };
        View::whole(pose, pose, SIZE_PX)
    }

    /// A wall `ahead_m` to the north of the eye.
    fn frame(position_m: DVec3, ahead_m: f32) -> DrawnFrame {
        let view = view(position_m);
        let centres = (0..SIZE_PX[0] * SIZE_PX[1])
            .map(|pixel| DVec2::new(f64::from(pixel % SIZE_PX[0]) + 0.5, f64::from(pixel / SIZE_PX[0]) + 0.5));
        let position = centres.map(|centre| {
            let [x, y, z] = (view.ray(centre).as_vec3() * ahead_m).to_array();
            [x, y, z, ahead_m]
        });
        let position = position.collect();
        DrawnFrame {
            view,
            origin_m: position_m,
            position,
            ink: None,
            strokes: None,
            centres: None,
            marks: None,
            luma: vec![0.0; 35],
            colors: vec![[0; 3]; 35],
        }
    }

    #[test]
    fn a_circle_has_the_pixels_whose_centres_lie_in_it() {
        let frame = frame(DVec3::ZERO, 10.0);
        let seen = SurfaceOfFrame::new(&frame);
        let places = (-8..40).flat_map(|x| (-8..30).map(move |y| DVec2::new(f64::from(x) / 4.0, f64::from(y) / 4.0)));
        for (place, radius_px) in places.flat_map(|place| [0.3, 1.25, 1.5, 2.0, 2.75].map(|radius| (place, radius))) {
            let found: Vec<usize> = seen.within(place, radius_px).map(|(pixel, _)| pixel).collect();
            let squared = |pixel: &usize| (seen.centre(*pixel) - place).length_squared();
            let expected: Vec<usize> = (0..35).filter(|pixel| squared(pixel) <= radius_px * radius_px).collect();
            assert_eq!(found, expected, "{place} {radius_px}");
        }
    }

    #[test]
    fn a_wall_grows_as_the_eye_comes_nearer() {
        let (far, near) = (frame(DVec3::ZERO, 10.0), frame(DVec3::new(0.0, 2.0, 0.0), 8.0));
        let (far, near) = (SurfaceOfFrame::new(&far), SurfaceOfFrame::new(&near));
        let (on, back) = (Follower { from: &far, to: &near }, Follower { from: &near, to: &far });
        let middle = DVec2::new(3.5, 2.5);
        // The second pixel of the second row moves to 10 / 8 of its distance from the centre, and back.
        let expected = middle + (DVec2::new(1.5, 1.5) - middle) * 1.25;
        for whose in [Whose::Line, Whose::Surface] {
            let place = on.place(8, whose).expect("it is in both pictures");
            assert!((place - expected).length() < 1e-5, "{place}");
            let place = back.place(8, whose).expect("it is in both pictures");
            assert!((place - middle - (DVec2::new(1.5, 1.5) - middle) * 0.8).length() < 1e-5, "{place}");
        }
        assert_eq!(on.place(0, Whose::Line), None, "the corner leaves the picture");
        // Planted: the wall is farther there than it can be.
        let wrong = frame(DVec3::new(0.0, 2.0, 0.0), 10.0);
        let wrong = SurfaceOfFrame::new(&wrong);
        assert_eq!(Follower { from: &far, to: &wrong }.place(8, Whose::Line), None);
        assert_eq!(Follower { from: &far, to: &wrong }.place_behind(8), None);
    }

    #[test]
    fn a_picture_is_linear_between_its_pixels() {
        let frame = frame(DVec3::ZERO, 10.0);
        let seen = SurfaceOfFrame::new(&frame);
        let linear = |place: DVec2| 0.25 + 0.1 * place.x - 0.07 * place.y;
        let picture: Vec<f32> = (0..35).map(|pixel| linear(seen.centre(pixel)) as f32).collect();
        for place in [[0.5, 0.5], [3.0, 2.0], [6.2, 4.4], [1.75, 3.1]].map(DVec2::from) {
            assert!((seen.bilinear(&picture, place) - linear(place)).abs() < 1e-6, "{place}");
        }
        let corner = seen.bilinear(&picture, DVec2::ZERO);
        assert!((corner - linear(DVec2::splat(0.5))).abs() < 1e-6, "the outermost pixel goes on");
    }
}
