//! A rendered picture with its channels (AOVs) and their geometry.

use glam::{DVec2, DVec3};
use hachure::file::exr::Samples;
use hachure::frame::Renderer;
use hachure::picture::aov;
use hachure::picture::{self, PartRule, PictureReport, PictureRequest};
use hachure::scene::view::{Pose, View};
use hachure::style::{Style, preset_text};

use super::World;
use super::draw::north_west;

/// Returns the preset `ink` with the ε of the paper or of the footprint.
pub(crate) fn ink(epsilon: &str) -> Style {
    let text = preset_text("lsa").unwrap().replace("\"footprint\"", &format!("\"{epsilon}\""));
    let style = Style::parse("lsa", &text).unwrap();
    assert_eq!(format!("{:?}", style.lines().unwrap().epsilon).to_lowercase(), epsilon);
    style
}

/// A picture with all of its channels.
pub(crate) struct Shot {
    pub size_px: [u32; 2],
    pub view: View,
    pub picture: Vec<[f32; 4]>,
    pub depth_m: Vec<f64>,
    /// Relative to the camera, in metres.
    pub position_m: Vec<DVec3>,
    pub normal: Vec<DVec3>,
    pub id: Vec<u32>,
    pub motion_px: Vec<DVec2>,
    pub error: Vec<f64>,
    pub line: Vec<f64>,
    pub tone: Vec<f64>,
    pub report: PictureReport,
}

/// Renders `pose` with the footprint's ε.
pub(crate) fn shoot(world: &mut World, renderer: &mut Option<Renderer>, pose: Pose, size_px: [u32; 2]) -> Shot {
    shoot_style(world, renderer, pose, pose, size_px, &ink("footprint"), &PartRule::default())
}

/// Renders `pose` in a style, whole or in parts.
pub(crate) fn shoot_style(
    world: &mut World,
    renderer: &mut Option<Renderer>,
    pose: Pose,
    previous: Pose,
    size_px: [u32; 2],
    style: &Style,
    parts: &PartRule,
) -> Shot {
    let planes = aov::planes("depth,position,normal,surface,motion,lsa,tone", style).unwrap();
    let request =
        PictureRequest { previous, planes: &planes, ..PictureRequest::still(pose, size_px, style, north_west()) };
    let mut picture = Vec::new();
    let mut floats: Vec<Vec<f64>> = vec![Vec::new(); planes.len()];
    let mut id = Vec::new();
    let take = |band: picture::Band| {
        picture.extend(band.picture);
        for (floats, samples) in floats.iter_mut().zip(band.planes) {
            match samples {
                Samples::F32(values) => floats.extend(values.into_iter().map(f64::from)),
                Samples::U32(values) => id.extend(values),
            }
        }
        Ok::<_, std::convert::Infallible>(())
    };
    let report = picture::render_in_parts(&world.gpu, renderer, &mut world.surfaces, &request, parts, take).unwrap();
    let place = |name: &str| planes.iter().position(|plane| plane.name == name).unwrap();
    let mut plane = |name: &str| std::mem::take(&mut floats[place(name)]);
    let zip = |x: Vec<f64>, y: Vec<f64>, z: Vec<f64>| -> Vec<DVec3> {
        x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z)).collect()
    };
    Shot {
        size_px,
        view: View::whole(previous, pose, size_px),
        picture,
        depth_m: plane("depth.V"),
        position_m: zip(plane("position.X"), plane("position.Y"), plane("position.Z")),
        normal: zip(plane("normal.X"), plane("normal.Y"), plane("normal.Z")),
        id,
        motion_px: plane("motion.X").into_iter().zip(plane("motion.Y")).map(|(x, y)| DVec2::new(x, y)).collect(),
        error: plane("lsa.error"),
        line: plane("lsa.line"),
        tone: plane("tone.V"),
        report,
    }
}

impl Shot {
    pub(crate) fn is_sky(&self, pixel: usize) -> bool {
        self.depth_m[pixel].is_infinite()
    }

    /// Returns the column and row of a pixel.
    pub(crate) fn place(&self, pixel: usize) -> [i64; 2] {
        [pixel as i64 % i64::from(self.size_px[0]), pixel as i64 / i64::from(self.size_px[0])]
    }

    /// Returns the pixel `step` away, if it is in the picture.
    pub(crate) fn neighbour(&self, pixel: usize, step: [i64; 2]) -> Option<usize> {
        let [x, y] = self.place(pixel);
        let (x, y) = (x + step[0], y + step[1]);
        let inside = (0..i64::from(self.size_px[0])).contains(&x) && (0..i64::from(self.size_px[1])).contains(&y);
        inside.then(|| (y * i64::from(self.size_px[0]) + x) as usize)
    }

    /// Returns the direction through a pixel's centre, at unit distance along the view axis, computed from the pose
    /// alone.
    pub(crate) fn ray(&self, pixel: usize) -> DVec3 {
        let [x, y] = self.place(pixel).map(|at| at as f64 + 0.5);
        self.ray_at(x, y)
    }

    /// Returns the direction through a point of the picture.
    pub(crate) fn ray_at(&self, x_px: f64, y_px: f64) -> DVec3 {
        let pose = &self.view.pose;
        let [width, height] = self.size_px.map(f64::from);
        let tan = (0.5 * pose.fov_rad).tan();
        let (u, v) = ((2.0 * x_px - width) / height * tan, (1.0 - 2.0 * y_px / height) * tan);
        pose.forward + u * pose.right + v * pose.up
    }

    /// Returns the pixels per radian at the centre of the picture, computed from the pose alone.
    pub(crate) fn focal_px(&self) -> f64 {
        f64::from(self.size_px[1]) / (2.0 * (0.5 * self.view.pose.fov_rad).tan())
    }

    /// Returns the position of a pixel's surface in the world.
    pub(crate) fn world_m(&self, pixel: usize) -> DVec3 {
        self.view.pose.position_m + self.position_m[pixel]
    }

    /// Writes a channel as a grey picture for inspection, if HACHURE_TEST_PICTURES names a folder.
    pub(crate) fn keep(&self, name: &str, value: impl Fn(usize) -> f64) {
        let Some(folder) = std::env::var_os("HACHURE_TEST_PICTURES") else { return };
        let path = std::path::Path::new(&folder).join(format!("{name}.png"));
        let file = hachure::file::atomic::AtomicFile::create(&path).unwrap();
        let mut file = file;
        {
            let mut encoder = png::Encoder::new(file.writer(), self.size_px[0], self.size_px[1]);
            encoder.set_color(png::ColorType::Grayscale);
            encoder.set_depth(png::BitDepth::Eight);
            let mut writer = encoder.write_header().unwrap();
            let bytes: Vec<u8> =
                (0..self.depth_m.len()).map(|i| (value(i).clamp(0.0, 1.0) * 255.0).round() as u8).collect();
            writer.write_image_data(&bytes).unwrap();
        }
        file.commit().unwrap();
    }
}
