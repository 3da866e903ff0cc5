// Trees that an eye sees. See src/forest/mod.rs.
#define_import_path hachure::trees

struct TreeInstance {
    // Where it stands: on the flat map, from the origin of the rig.
    flat_m: vec3<f32>,
    height_m: f32,
    // Sine and cosine of its turn.
    turn: vec2<f32>,
    // Of the surface.
    id: u32,
    padding: u32,
}
