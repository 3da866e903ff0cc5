//! One eye's view, in f64, and its uniform for shaders.

use glam::{DMat4, DVec2, DVec3, DVec4};

pub(crate) use crate::gpu::wgsl::shared::view::View as ViewUniform;
use crate::scene::frustum::Frustum;

/// Distance of the near plane. With reversed infinite depth a small one costs no precision.
pub(crate) const NEAR_M: f64 = 1e-4;

/// The position and orientation of an eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in the world: east, north, up, in metres.
    pub position_m: DVec3,
    /// Viewing direction. `forward`, `right` and `up` are unit vectors, perpendicular to each other.
    pub forward: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Vertical field of view, in radians, of a symmetric lens.
    pub fov_rad: f64,
}

/// A rectangle of a picture: large pictures are rendered in several parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Upper left pixel in the picture; may be outside of it by a margin.
    pub origin_px: [i32; 2],
    /// Width and height.
    pub size_px: [u32; 2],
}

impl Part {
    /// Returns the part that covers the whole picture.
    pub fn whole(size_px: [u32; 2]) -> Self {
        Self { origin_px: [0, 0], size_px }
    }
}

/// The extent of a picture to each side of the optical axis, as tangents of angles. A headset's pictures extend farther
/// outward than toward the nose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Extent to the left; negative if the picture begins to the right of the axis.
    pub left: f64,
    /// Extent to the right.
    pub right: f64,
    /// Extent above the axis.
    pub up: f64,
    /// Extent below the axis.
    pub down: f64,
}

/// The time of a frame, in seconds from an arbitrary start; it drives the swaying of trees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Time of this frame.
    pub now_s: f64,
    /// Time of the previous frame, for motion vectors.
    pub before_s: f64,
}

impl Clock {
    /// Returns a clock in which no time has passed since the previous frame.
    pub fn still(now_s: f64) -> Self {
        Self { now_s, before_s: now_s }
    }

    /// Whether no time has passed since the previous frame.
    pub(crate) fn is_still(&self) -> bool {
        self.now_s == self.before_s
    }
}

/// A view of a part of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pose of the eye.
    pub pose: Pose,
    /// Pose of the eye in the previous frame, for motion vectors.
    pub previous: Pose,
    /// Lens of this frame; `None` is a symmetric lens with square pixels and the field of view of the pose.
    pub lens: Option<Lens>,
    /// Lens of the previous frame.
    pub previous_lens: Option<Lens>,
    /// Shift of the picture's content in pixels, for samples away from pixel centres (temporal anti-aliasing).
    pub jitter_px: DVec2,
    /// Time of the frame, the same for all eyes of a rig.
    pub clock: Clock,
    /// Size of the whole picture.
    pub picture_px: [u32; 2],
    /// The part of the picture that is rendered.
    pub part: Part,
}

/// Eyes that are drawn together, of one world, with one selection of tiles and patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// The position in the world that GPU coordinates are relative to.
    pub origin_m: DVec3,
    /// The eyes, at least one.
    pub eyes: Vec<View>,
}

impl Rig {
    /// Returns a rig of one eye, whose position is the origin.
    pub fn mono(view: View) -> Self {
        Self { origin_m: view.pose.position_m, eyes: vec![view] }
    }

    /// Returns the rig at another time.
    #[must_use]
    pub fn at(mut self, clock: Clock) -> Self {
        self.eyes.iter_mut().for_each(|eye| eye.clock = clock);
        self
    }

    /// Returns the time of the frame.
    pub(crate) fn clock(&self) -> Clock {
        self.eyes.first().map(|eye| eye.clock).unwrap_or_default()
    }

    /// Returns how far an eye is to the right of the origin, along the first eye's right axis, in metres.
    pub(crate) fn aside_m(&self, eye: usize) -> f64 {
        self.eyes.get(eye).map_or(0.0, |at| (at.pose.position_m - self.origin_m).dot(self.eyes[0].pose.right))
    }

    /// Returns the distance between the two eyes in metres; 0 for a single eye.
    pub(crate) fn apart_m(&self) -> f64 {
        match self.eyes.as_slice() {
            [left, right] => left.pose.position_m.distance(right.pose.position_m),
            _ => 0.0,
        }
    }

    /// Whether the rig has two eyes at different positions. Two eyes at one position see the same picture.
    pub(crate) fn is_pair(&self) -> bool {
        matches!(self.eyes.as_slice(), [left, right] if left.pose.position_m != right.pose.position_m)
    }
}

impl Pose {
    /// Returns the yaw clockwise from north, 0 to 360; it is well defined even when the eye looks straight up or down.
    pub(crate) fn yaw_deg(&self) -> f64 {
        // `right` is level and always 90° clockwise from the yaw.
        (-self.right.y).atan2(self.right.x).to_degrees().rem_euclid(360.0)
    }
}

impl View {
    /// Returns a view of a whole picture through a symmetric lens.
    pub fn whole(previous: Pose, pose: Pose, picture_px: [u32; 2]) -> Self {
        Self::of_part(previous, pose, picture_px, Part::whole(picture_px))
    }

    /// Returns whether the part of the picture is all of it.
    pub(crate) fn is_whole(&self) -> bool {
        self.part == Part::whole(self.picture_px)
    }

    /// Returns the view at another time.
    #[must_use]
    pub fn at(self, clock: Clock) -> Self {
        Self { clock, ..self }
    }

    /// Returns a view of a part of a picture through a symmetric lens.
    pub fn of_part(previous: Pose, pose: Pose, picture_px: [u32; 2], part: Part) -> Self {
        let (lens, jitter_px, clock) = (None, DVec2::ZERO, Clock::default());
        Self { pose, previous, lens, previous_lens: None, jitter_px, clock, picture_px, part }
    }

    /// Returns the pixels per radian at the axis, in the direction that has more of them.
    pub fn focal_px(&self) -> f64 {
        self.projection().focal_px.max_element()
    }

    /// Returns the pixels per radian at the axis, in the direction that has fewer of them.
    pub(crate) fn least_focal_px(&self) -> f64 {
        self.projection().focal_px.min_element()
    }

    /// Returns the vertical field of view in radians.
    pub(crate) fn fov_rad(&self) -> f64 {
        self.lens.map_or(self.pose.fov_rad, |lens| lens.up.atan() + lens.down.atan())
    }

    /// Returns the direction through a point of the picture ((0, 0) is its upper left corner), of length 1 along the
    /// axis.
    pub(crate) fn ray(&self, picture: DVec2) -> DVec3 {
        let Projection { focal_px, axis_px } = self.projection();
        let from_axis = (picture - axis_px) / focal_px;
        self.pose.forward + self.pose.right * from_axis.x - self.pose.up * from_axis.y
    }

    /// Returns the point of the picture at which a vector from the eye, or a direction, is seen: the inverse of
    /// [`View::ray`]. `None` if it points sideways or behind the eye.
    pub(crate) fn place_px(&self, way: DVec3) -> Option<DVec2> {
        let ahead = way.dot(self.pose.forward);
        let across = DVec2::new(way.dot(self.pose.right), -way.dot(self.pose.up));
        let Projection { focal_px, axis_px } = self.projection();
        (ahead > 1e-6 * way.length()).then(|| axis_px + across * (focal_px / ahead))
    }

    /// Returns the frustum of the part.
    pub(crate) fn frustum(&self) -> Frustum {
        let low = DVec2::new(f64::from(self.part.origin_px[0]), f64::from(self.part.origin_px[1]));
        let high = low + DVec2::new(f64::from(self.part.size_px[0]), f64::from(self.part.size_px[1]));
        Frustum::new([
            self.ray(low),
            self.ray(DVec2::new(high.x, low.y)),
            self.ray(high),
            self.ray(DVec2::new(low.x, high.y)),
        ])
    }

    /// Returns the uniform for shaders, with positions relative to `origin_m`, the rig's origin.
    pub(crate) fn uniform(&self, origin_m: DVec3) -> ViewUniform {
        let Projection { focal_px, .. } = self.projection();
        let previous_projection = Projection::new(self.previous_lens, &self.previous, self.picture_px);
        let from_origin = |eye: &Pose, projection| {
            self.clip_from_camera(eye, projection) * DMat4::from_translation(origin_m - eye.position_m)
        };
        let now = from_origin(&self.pose, self.projection());
        let previous = from_origin(&self.previous, previous_projection);
        ViewUniform {
            clip_from_camera: now.as_mat4().to_cols_array_2d(),
            previous_clip_from_camera: previous.as_mat4().to_cols_array_2d(),
            ray_corner: self.ray(DVec2::ZERO).as_vec3().to_array(),
            focal_px: self.focal_px() as f32,
            ray_dx: (self.pose.right / focal_px.x).as_vec3().to_array(),
            near_m: NEAR_M as f32,
            ray_dy: (-self.pose.up / focal_px.y).as_vec3().to_array(),
            pad: 0.0,
            size_px: self.part.size_px,
            origin_px: self.part.origin_px,
            picture_px: self.picture_px.map(|side| side as f32),
            jitter_px: self.jitter_px.as_vec2().to_array(),
            eye_m: (self.pose.position_m - origin_m).as_vec3().to_array(),
            pad_eye: 0.0,
        }
    }

    /// Returns [`View::uniform`] without the jitter in its matrices, but with its `jitter_px`.
    pub(crate) fn still_uniform(&self, origin_m: DVec3) -> ViewUniform {
        let still = Self { jitter_px: DVec2::ZERO, ..*self };
        ViewUniform { jitter_px: self.jitter_px.as_vec2().to_array(), ..still.uniform(origin_m) }
    }

    /// Returns the projection of this frame with jitter. Motion vectors leave it out: the previous frame has none.
    fn projection(&self) -> Projection {
        let Projection { focal_px, axis_px } = Projection::new(self.lens, &self.pose, self.picture_px);
        Projection { focal_px, axis_px: axis_px + self.jitter_px }
    }

    /// Returns the reversed infinite projection of the part: depth is near / distance along the axis, 0 at infinity.
    fn clip_from_camera(&self, pose: &Pose, projection: Projection) -> DMat4 {
        let Projection { focal_px, axis_px } = projection;
        let size = DVec2::new(f64::from(self.part.size_px[0]), f64::from(self.part.size_px[1]));
        let origin = DVec2::new(f64::from(self.part.origin_px[0]), f64::from(self.part.origin_px[1]));
        let middle = (axis_px - origin) / size;
        let right = pose.right * (2.0 * focal_px.x / size.x) + pose.forward * (2.0 * middle.x - 1.0);
        let up = pose.up * (2.0 * focal_px.y / size.y) + pose.forward * (1.0 - 2.0 * middle.y);
        DMat4::from_cols(
            DVec4::new(right.x, up.x, 0.0, pose.forward.x),
            DVec4::new(right.y, up.y, 0.0, pose.forward.y),
            DVec4::new(right.z, up.z, 0.0, pose.forward.z),
            DVec4::new(0.0, 0.0, NEAR_M, 0.0),
        )
    }
}

/// A lens applied to the pixels of a picture.
#[derive(Clone, Copy, Debug)]
struct Projection {
    /// Pixels per unit of tangent, across and down.
    focal_px: DVec2,
    /// The point at which the axis meets the picture.
    axis_px: DVec2,
}

impl Projection {
    fn new(lens: Option<Lens>, pose: &Pose, picture_px: [u32; 2]) -> Self {
        let size_px = DVec2::new(f64::from(picture_px[0]), f64::from(picture_px[1]));
        match lens {
            None => {
                Self { focal_px: DVec2::splat(0.5 * size_px.y / (0.5 * pose.fov_rad).tan()), axis_px: size_px * 0.5 }
            }
            Some(Lens { left, right, up, down }) => {
                let focal_px = size_px / DVec2::new(left + right, up + down);
                Self { focal_px, axis_px: DVec2::new(left, up) * focal_px }
            }
        }
    }
}
