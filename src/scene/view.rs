//! One eye's view, in f64, and as the shaders read it.

use glam::{DMat4, DVec2, DVec3, DVec4};

pub use crate::gpu::wgsl::shared::view::View as ViewUniform;
use crate::scene::frustum::Frustum;

/// The near plane. Reversed infinite depth loses nothing by a small one.
pub const NEAR_M: f64 = 1e-4;

/// Where an eye is and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// In the world: east, north, up.
    pub position_m: DVec3,
    /// Unit; so are the next two, and each is perpendicular to the others.
    pub forward: DVec3,
    /// Unit.
    pub right: DVec3,
    /// Unit.
    pub up: DVec3,
    /// Vertical field of view of a lens that is symmetric.
    pub fov_rad: f64,
}

/// A part of a picture: large pictures are rendered in several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its first pixel in the picture; may lie outside by a margin.
    pub origin_px: [i32; 2],
    /// Its size.
    pub size_px: [u32; 2],
}

impl Part {
    /// All of a picture.
    pub fn whole(size_px: [u32; 2]) -> Self {
        Self { origin_px: [0, 0], size_px }
    }
}

/// How far a picture reaches to each side of the axis: tangents of the angles. A headset's pictures reach farther
/// outward than toward the nose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// To the left; below 0 where the picture begins on the right of the axis.
    pub left: f64,
    /// To the right.
    pub right: f64,
    /// Upward.
    pub up: f64,
    /// Downward.
    pub down: f64,
}

/// When a frame is drawn, in seconds since any moment: trees sway by it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Of this frame.
    pub now_s: f64,
    /// Of the frame before, for motion.
    pub before_s: f64,
}

impl Clock {
    /// No time has passed since the frame before.
    pub fn still(now_s: f64) -> Self {
        Self { now_s, before_s: now_s }
    }

    /// Whether no time has passed.
    pub fn is_still(&self) -> bool {
        self.now_s == self.before_s
    }
}

/// A view of a part of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye.
    pub pose: Pose,
    /// The eye one frame ago, for motion.
    pub previous: Pose,
    /// Its lens now; none is symmetric, with square pixels and the field of view of the pose.
    pub lens: Option<Lens>,
    /// Its lens one frame ago.
    pub previous_lens: Option<Lens>,
    /// By how much the content of the picture is moved, in pixels: for samples beside the centres of pixels.
    pub jitter_px: DVec2,
    /// One for all eyes of a rig.
    pub clock: Clock,
    /// Of the whole picture.
    pub picture_px: [u32; 2],
    /// What is rendered of it.
    pub part: Part,
}

/// Eyes that are drawn together: of one world, with one choice of tiles and patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// What positions count from, in the world.
    pub origin_m: DVec3,
    /// At least one.
    pub eyes: Vec<View>,
}

impl Rig {
    /// Of one eye, at its origin.
    pub fn mono(view: View) -> Self {
        Self { origin_m: view.pose.position_m, eyes: vec![view] }
    }

    /// The same at another time.
    #[must_use]
    pub fn at(mut self, clock: Clock) -> Self {
        self.eyes.iter_mut().for_each(|eye| eye.clock = clock);
        self
    }

    /// When all eyes see.
    pub fn clock(&self) -> Clock {
        self.eyes.first().map(|eye| eye.clock).unwrap_or_default()
    }

    /// How far to the right of the origin an eye stands, as the first one looks.
    pub fn aside_m(&self, eye: usize) -> f64 {
        self.eyes.get(eye).map_or(0.0, |at| (at.pose.position_m - self.origin_m).dot(self.eyes[0].pose.right))
    }

    /// How far two eyes stand apart; 0 of one eye.
    pub fn apart_m(&self) -> f64 {
        match self.eyes.as_slice() {
            [left, right] => left.pose.position_m.distance(right.pose.position_m),
            _ => 0.0,
        }
    }

    /// Whether it is of two eyes that stand apart. Two at one place see the same, and have nothing to agree on.
    pub fn is_pair(&self) -> bool {
        matches!(self.eyes.as_slice(), [left, right] if left.pose.position_m != right.pose.position_m)
    }
}

impl Pose {
    /// Clockwise from north, 0 to 360; that of the picture's right side when the eye looks straight up or down.
    pub fn yaw_deg(&self) -> f64 {
        // The right side is level, and a quarter turn ahead of the yaw.
        (-self.right.y).atan2(self.right.x).to_degrees().rem_euclid(360.0)
    }
}

impl View {
    /// All of a picture through a symmetric lens.
    pub fn whole(previous: Pose, pose: Pose, picture_px: [u32; 2]) -> Self {
        Self::of_part(previous, pose, picture_px, Part::whole(picture_px))
    }

    /// The same at another time.
    #[must_use]
    pub fn at(self, clock: Clock) -> Self {
        Self { clock, ..self }
    }

    /// A part of a picture through a symmetric lens.
    pub fn of_part(previous: Pose, pose: Pose, picture_px: [u32; 2], part: Part) -> Self {
        let (lens, jitter_px, clock) = (None, DVec2::ZERO, Clock::default());
        Self { pose, previous, lens, previous_lens: None, jitter_px, clock, picture_px, part }
    }

    /// Pixels per radian around the axis, in the direction that has more of them.
    pub fn focal_px(&self) -> f64 {
        self.projection().focal_px.max_element()
    }

    /// Vertical field of view.
    pub fn fov_rad(&self) -> f64 {
        self.lens.map_or(self.pose.fov_rad, |lens| lens.up.atan() + lens.down.atan())
    }

    /// The direction through a point of the picture (0, 0 is its upper left corner), at unit distance along the axis.
    pub fn ray(&self, picture: DVec2) -> DVec3 {
        let Projection { focal_px, axis_px } = self.projection();
        let from_axis = (picture - axis_px) / focal_px;
        self.pose.forward + self.pose.right * from_axis.x - self.pose.up * from_axis.y
    }

    /// Where a way from the eye, or a direction, appears in the picture: the inverse of [`View::ray`]. None beside or
    /// behind the eye.
    pub fn place_px(&self, way: DVec3) -> Option<DVec2> {
        let ahead = way.dot(self.pose.forward);
        let across = DVec2::new(way.dot(self.pose.right), -way.dot(self.pose.up));
        let Projection { focal_px, axis_px } = self.projection();
        (ahead > 1e-6 * way.length()).then(|| axis_px + across * (focal_px / ahead))
    }

    /// What the part sees.
    pub fn frustum(&self) -> Frustum {
        let low = DVec2::new(f64::from(self.part.origin_px[0]), f64::from(self.part.origin_px[1]));
        let high = low + DVec2::new(f64::from(self.part.size_px[0]), f64::from(self.part.size_px[1]));
        Frustum::new([
            self.ray(low),
            self.ray(DVec2::new(high.x, low.y)),
            self.ray(high),
            self.ray(DVec2::new(low.x, high.y)),
        ])
    }

    /// For the shaders: positions count from `origin_m`, that of the rig.
    pub fn uniform(&self, origin_m: DVec3) -> ViewUniform {
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

    /// As [`View::uniform`], of the picture without its jitter, of which the shaders are told all the same.
    pub fn still_uniform(&self, origin_m: DVec3) -> ViewUniform {
        let still = Self { jitter_px: DVec2::ZERO, ..*self };
        ViewUniform { jitter_px: self.jitter_px.as_vec2().to_array(), ..still.uniform(origin_m) }
    }

    /// Of this frame, jitter and all. The motion of a pixel is without it: the previous frame's has none.
    fn projection(&self) -> Projection {
        let Projection { focal_px, axis_px } = Projection::new(self.lens, &self.pose, self.picture_px);
        Projection { focal_px, axis_px: axis_px + self.jitter_px }
    }

    /// Reversed infinite projection of the part: depth is near / distance along the axis, 0 at infinity.
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

/// A lens over the pixels of a picture.
#[derive(Clone, Copy, Debug)]
struct Projection {
    /// Pixels per unit of tangent, across and down.
    focal_px: DVec2,
    /// Where the axis meets the picture.
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
