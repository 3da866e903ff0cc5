//! `hachure info` for a scene: its world, light, wind, forest and models.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::{Context, bail};
use glam::DVec3;
use rustc_hash::FxHashMap;
use serde::Serialize;

use crate::commands::progress::Bar;
use crate::file::message::{named, printable};
use crate::mesh::Mesh;
use crate::mesh::placed::Stance;
use crate::scene::forest::Species;
use crate::scene::reach::Reach;
use crate::scene::{Density, Forest, MeshPlace, MeshPlacement, MeshPositions, Scene, Wind, World, mesh_list};

#[derive(Serialize)]
pub(super) struct SceneInfo {
    dem: Option<String>,
    procedural_seed: Option<u32>,
    sun_azimuth_deg: Option<f64>,
    sun_elevation_deg: Option<f64>,
    /// Date and time of the sun, if the scene gives them instead of angles.
    sun_date: Option<String>,
    sun_place: Option<String>,
    haze_distance_m: Option<f64>,
    /// Area of full contrast, as `--focus` takes it.
    focus: Option<String>,
    start: Option<String>,
    vertical_exaggeration: f64,
    sea_level_m: Option<f64>,
    /// Files with additional water.
    water: Vec<PathBuf>,
    /// Files of features.
    features: Vec<PathBuf>,
    /// Images on the land.
    images: Vec<PathBuf>,
    wind: Option<WindInfo>,
    meshes: Vec<MeshInfo>,
    forest: Option<ForestInfo>,
    tree_models: Vec<TreeInfo>,
}

#[derive(Serialize)]
struct WindInfo {
    speed_m_s: f64,
    from_deg: f64,
}

/// The rules of a scene's forest.
#[derive(Serialize)]
struct ForestInfo {
    seed: u32,
    trees_per_ha: f64,
    /// Height of the tree line; `None` if the scene has no tree line.
    tree_line_m: Option<f64>,
    steepest_deg: f64,
    level_ground: &'static str,
    /// Species whose trees the program grows.
    grown: Vec<GrownInfo>,
}

#[derive(Serialize)]
struct GrownInfo {
    form: &'static str,
    /// Mean height of a tree.
    height_m: f64,
    share: f64,
}

/// A species of a scene's forest whose trees are a model.
#[derive(Serialize)]
struct TreeInfo {
    file: PathBuf,
    up: &'static str,
    /// Mean height of a tree.
    height_m: f64,
    share: f64,
    /// Triangles of the file.
    triangles: u64,
}

/// A model of a scene, with the properties of its file.
#[derive(Serialize)]
struct MeshInfo {
    file: PathBuf,
    /// Position in the scene's notation; `None` if there are many instances.
    at: Option<String>,
    /// CSV file with the positions of the instances.
    instances: Option<PathBuf>,
    /// Number of instances; `None` if it depends on the terrain.
    places: Option<u64>,
    /// Instances per hectare, if a rule places them.
    per_ha: Option<f64>,
    yaw_deg: f64,
    scale: f64,
    up: &'static str,
    triangles: u64,
    vertices: u64,
    /// Size in metres, after scaling and with up corrected: east, north, up before the yaw.
    size_m: [f64; 3],
    dropped_triangles: u64,
    border_edges: u64,
    crowded_edges: u64,
    /// Number of named materials.
    materials: u64,
}

/// Reads and describes a scene file.
///
/// # Errors
/// Fails if the scene is invalid, or if it names files that do not exist or that it may not read.
pub(super) fn read(file: &Path, reach: Reach) -> anyhow::Result<SceneInfo> {
    let scene = Scene::read(file)?;
    scene.check_reach(file, reach)?;
    check_files(file, &scene)?;
    SceneInfo::of(scene).with_context(|| named(file))
}

impl SceneInfo {
    /// Describes a scene.
    ///
    /// # Errors
    /// Fails if a model, or a list of positions, cannot be read.
    pub(super) fn of(scene: Scene) -> anyhow::Result<Self> {
        // Read each file only once: a long one takes a while, and its warnings about materials should not repeat.
        let mut known: FxHashMap<&Path, Rc<Mesh>> = FxHashMap::default();
        let mut meshes = Vec::with_capacity(scene.meshes.len());
        let mut tree_models = Vec::new();
        for placement in &scene.meshes {
            let mesh = match known.get(placement.file.as_path()) {
                Some(mesh) => Rc::clone(mesh),
                None => Rc::new(scene.read_mesh_with(&placement.file, &Bar::default())?),
            };
            meshes.push(MeshInfo::of(&mesh, placement)?);
            known.insert(&placement.file, mesh);
        }
        for (species, model) in scene.forest.iter().flat_map(Forest::species_of_models) {
            let mesh = match known.get(model.file.as_path()) {
                Some(mesh) => Rc::clone(mesh),
                None => Rc::new(scene.read_mesh_with(&model.file, &Bar::default())?),
            };
            tree_models.push(TreeInfo {
                file: model.file.clone(),
                up: if model.z_up { "z" } else { "y" },
                height_m: species.height_m,
                share: species.share,
                triangles: mesh.triangles.len() as u64,
            });
            known.insert(&model.file, mesh);
        }
        let (dem, procedural_seed) = match scene.world {
            World::File(path) => (Some(path.display().to_string()), None),
            World::Url(url) => (Some(url), None),
            World::Procedural { seed } => (None, Some(seed)),
            World::Files(paths) => {
                let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
                (Some(names.join(", ")), None)
            }
            World::Continent { seed, size_samples, spacing_m } => {
                (Some(format!("continent {seed}, {size_samples} × {size_samples} samples, {spacing_m} m apart")), None)
            }
            World::Model(model) => (Some(format!("flat ground for {}", model.file().display())), None),
            World::Memory => (Some("heights in memory".to_owned()), None),
        };
        Ok(Self {
            dem,
            procedural_seed,
            sun_azimuth_deg: scene.sun_time.is_none().then_some(scene.sun.azimuth_deg),
            sun_elevation_deg: scene.sun_time.is_none().then_some(scene.sun.elevation_deg),
            sun_date: scene.sun_time.map(|time| time.moment.to_string()),
            sun_place: scene.sun_time.and_then(|time| time.place).map(|place| place.to_string()),
            haze_distance_m: scene.haze.distance_m,
            focus: scene.focus.map(|focus| focus.to_string()),
            start: scene.start.map(|camera| camera.to_string()),
            vertical_exaggeration: scene.vertical_exaggeration,
            sea_level_m: scene.sea_level_m,
            water: scene.water.files().map(|(_, path)| path.clone()).collect(),
            features: scene.features.iter().map(|file| file.path.clone()).collect(),
            images: scene.images.iter().map(|file| file.path.clone()).collect(),
            wind: scene.wind.map(|Wind { speed_m_s, from_deg }| WindInfo { speed_m_s, from_deg }),
            meshes,
            forest: scene.forest.as_ref().map(ForestInfo::of),
            tree_models,
        })
    }
}

/// Checks that the files named by a scene exist.
fn check_files(file: &Path, scene: &Scene) -> anyhow::Result<()> {
    let heights = match &scene.world {
        World::File(path) => std::slice::from_ref(path),
        World::Files(paths) => paths.as_slice(),
        World::Url(_) | World::Procedural { .. } | World::Continent { .. } | World::Model(_) | World::Memory => &[],
    };
    let cover = scene.forest.iter().flat_map(|forest| forest.cover.files()).map(|(_, path)| path);
    let water = scene.water.files().map(|(_, path)| path);
    let features = scene.features.iter().map(|file| &file.path);
    let images = scene.images.iter().map(|file| &file.path);
    let meshes = scene.meshes.iter().map(|mesh| &mesh.file);
    let trees = scene.forest.iter().flat_map(|forest| &forest.models).map(|model| &model.file);
    let mut missing: Vec<&PathBuf> = heights
        .iter()
        .chain(meshes)
        .chain(scene.mesh_lists())
        .chain(trees)
        .chain(cover)
        .chain(water)
        .chain(features)
        .chain(images)
        .collect();
    // A file that may not be looked at is reported when it is opened.
    missing.retain(|path| !path.try_exists().unwrap_or_else(|error| error.kind() == ErrorKind::PermissionDenied));
    missing.dedup();
    // Name only as many files as fit on a line.
    let names = missing.iter().take(3).map(named).collect::<Vec<_>>().join(", ");
    match missing.len() {
        0 => Ok(()),
        1 => bail!("{}: {names} does not exist", named(file)),
        2 | 3 => bail!("{}: {names} do not exist", named(file)),
        count => bail!("{}: {names} and {} more do not exist", named(file), count - 3),
    }
}

impl MeshInfo {
    fn of(mesh: &Mesh, placement: &MeshPlacement) -> anyhow::Result<Self> {
        let stance = Stance { origin_m: DVec3::ZERO, yaw_deg: 0.0, scale: placement.scale, z_up: placement.z_up };
        let turn = stance.world_from_mesh();
        let places = || mesh.vertices_m.iter().map(|place| turn * DVec3::from_array(place.map(f64::from)));
        let low = places().fold(DVec3::INFINITY, DVec3::min);
        let high = places().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (mut at, mut instances, mut per_ha) = (None, None, None);
        let places = match &placement.positions {
            MeshPositions::At(MeshPlace { at_m: DVec3 { x, y, z }, height_above_ground }) => {
                let plus = if *height_above_ground { "+" } else { "" };
                at = Some(format!("{x},{y},{plus}{z}"));
                Some(1)
            }
            MeshPositions::Middle => Some(1),
            MeshPositions::Listed(list) => {
                instances = Some(list.clone());
                Some(mesh_list::read(list)?.len() as u64)
            }
            MeshPositions::Scattered(scatter) => match scatter.density {
                Density::Count(count) => Some(count.into()),
                Density::PerHa(wanted) => {
                    per_ha = Some(wanted);
                    None
                }
            },
        };
        Ok(Self {
            file: placement.file.clone(),
            at,
            instances,
            places,
            per_ha,
            yaw_deg: placement.yaw_deg,
            scale: placement.scale,
            up: if placement.z_up { "z" } else { "y" },
            triangles: mesh.triangles.len() as u64,
            vertices: mesh.vertices_m.len() as u64,
            size_m: (high - low).to_array(),
            dropped_triangles: mesh.flaws.dropped,
            border_edges: mesh.flaws.borders,
            crowded_edges: mesh.flaws.crowded,
            materials: mesh.materials.len() as u64 - 1,
        })
    }

    fn line(&self) -> String {
        let [east_m, north_m, up_m] = self.size_m;
        let materials = match self.materials {
            0 => String::new(),
            1 => ", 1 material".to_owned(),
            count => format!(", {count} materials"),
        };
        let flaws = [
            (self.dropped_triangles, "triangles dropped"),
            (self.border_edges, "open edges"),
            (self.crowded_edges, "edges of more than two triangles"),
        ];
        let flaws: String =
            flaws.iter().filter(|flaw| flaw.0 > 0).map(|(count, what)| format!(", {count} {what}")).collect();
        let arrangement = match (&self.at, &self.instances, self.places, self.per_ha) {
            (Some(at), ..) => format!("at {at}"),
            (None, Some(list), places, _) => format!("at {} places listed in {}", places.unwrap_or(0), named(list)),
            (None, None, Some(places), _) => format!("scattered at {places} places"),
            (None, None, None, per_ha) => format!("scattered, {} per hectare", per_ha.unwrap_or(0.0)),
        };
        format!(
            "mesh      {}: {} triangles, {east_m:.2} × {north_m:.2} × {up_m:.2} m{materials}, {arrangement}, yaw {}°{flaws}\n",
            named(&self.file),
            self.triangles,
            self.yaw_deg
        )
    }
}

impl ForestInfo {
    fn of(forest: &Forest) -> Self {
        let grown = |species: &Species| {
            let form = species.form.name()?;
            Some(GrownInfo { form, height_m: species.height_m, share: species.share })
        };
        Self {
            seed: forest.seed,
            trees_per_ha: forest.trees_per_ha,
            tree_line_m: forest.has_tree_line().then_some(forest.tree_line_m),
            steepest_deg: forest.steepest_deg,
            level_ground: if forest.level_is_water { "water" } else { "land" },
            grown: forest.species.iter().filter_map(grown).collect(),
        }
    }

    fn lines(&self) -> String {
        let Self { seed, trees_per_ha, tree_line_m, steepest_deg, level_ground, grown } = self;
        let below = tree_line_m.map(|line_m| format!(" below {line_m} m")).unwrap_or_default();
        let species = grown.iter().map(|GrownInfo { form, height_m, share }| {
            format!("species   {form}, {} m tall, share {share}\n", rounded(*height_m))
        });
        format!(
            "forest    at most {trees_per_ha} trees per hectare{below}, on slopes up to {steepest_deg}°; level ground is \
             {level_ground}; seed {seed}\n{}",
            species.collect::<String>()
        )
    }
}

/// Returns a length in metres rounded to millimetres, without the errors of products such as 0.85 × 18.
fn rounded(length_m: f64) -> f64 {
    (length_m * 1000.0).round() / 1000.0
}

impl TreeInfo {
    fn line(&self) -> String {
        let Self { file, height_m, share, triangles, .. } = self;
        let height_m = rounded(*height_m);
        format!("species   {}: {triangles} triangles, {height_m} m tall, share {share}\n", named(file))
    }
}

impl SceneInfo {
    pub(super) fn text(&self, file: &str) -> String {
        let world = match (&self.dem, self.procedural_seed) {
            (Some(dem), _) => printable(dem, 400),
            (None, Some(seed)) => format!("the procedural world, seed {seed}"),
            (None, None) => "none".to_owned(),
        };
        let haze = match self.haze_distance_m {
            Some(distance_m) => format!("{distance_m} m"),
            None => "0.45 of the diagonal of the extent, at most 30 km".to_owned(),
        };
        let meshes: String = self.meshes.iter().map(MeshInfo::line).collect();
        let sun = match (&self.sun_date, self.sun_azimuth_deg.zip(self.sun_elevation_deg)) {
            (Some(date), _) => {
                format!("at {date}, over {}", self.sun_place.as_deref().unwrap_or("the location of the heights"))
            }
            (None, sun) => {
                let (azimuth_deg, elevation_deg) = sun.unwrap_or_default();
                format!("azimuth {azimuth_deg}°, elevation {elevation_deg}°")
            }
        };
        let wind = self.wind.as_ref();
        let wind = wind.map(|wind| format!("wind      {} m/s from {}°\n", wind.speed_m_s, wind.from_deg));
        let sea = self.sea_level_m.map(|level_m| format!("sea       up to {level_m} m\n"));
        let focus = self.focus.as_ref().map(|focus| format!("focus     {focus}\n"));
        let water: String = self.water.iter().map(|path| format!("water     {}\n", named(path))).collect();
        let features: String = self.features.iter().map(|path| format!("features  {}\n", named(path))).collect();
        let images: String = self.images.iter().map(|path| format!("image     {}\n", named(path))).collect();
        let forest = self.forest.as_ref().map(ForestInfo::lines);
        let trees: String = self.tree_models.iter().map(TreeInfo::line).collect();
        format!(
            "{file}: a scene\nworld     {world}\nsun       {sun}\nhaze      {haze}\n\
             start     {}\nvertical  × {}\n{}{}{water}{features}{images}{}{meshes}{}{trees}",
            self.start.as_deref().unwrap_or("a view of the most prominent summit"),
            self.vertical_exaggeration,
            focus.unwrap_or_default(),
            sea.unwrap_or_default(),
            wind.unwrap_or_default(),
            forest.unwrap_or_default(),
        )
    }
}
