// The second fundamental form of a surface and its derivative, in a tangent frame that depends on the normal alone.
//
// Signs are those of Rusinkiewicz (2004, "Estimating Curvatures and Their Derivatives on Triangle Meshes"): a surface
// that is convex, seen from outside, has positive curvature. So the form is the derivative of the normal: bend(a, b) =
// D_a n . b.
#define_import_path hachure::curvature

struct Shape {
    // Unit vector.
    normal: vec3<f32>,
    // Second fundamental form uu, uv, vv, in 1/m; u and v are the first two columns of `frame_of`.
    bend: vec3<f32>,
    // Its derivative uuu, uuv, uvv, vvv, in 1/m².
    change: vec4<f32>,
}

// Returns two unit tangents for a normal (Duff and others 2017, "Building an Orthonormal Basis, Revisited").
fn frame_of(n: vec3<f32>) -> mat2x3<f32> {
    let side = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    return mat2x3<f32>(vec3<f32>(1.0 + side * n.x * n.x * a, side * b, -side * n.x),
        vec3<f32>(b, side + n.y * n.y * a, -n.y));
}

// Evaluates a symmetric bilinear form.
fn form2(form: vec3<f32>, a: vec2<f32>, b: vec2<f32>) -> f32 {
    return form.x * a.x * b.x + form.y * (a.x * b.y + a.y * b.x) + form.z * a.y * b.y;
}

// Evaluates a symmetric trilinear form.
fn form3(form: vec4<f32>, a: vec2<f32>, b: vec2<f32>, c: vec2<f32>) -> f32 {
    return form2(vec3<f32>(dot(form.xy, c), dot(form.yz, c), dot(form.zw, c)), a, b);
}

// The two principal curvatures, the larger one first, and the direction of the larger one in the tangent frame, a unit
// vector.
struct Principal {
    most: f32,
    least: f32,
    along: vec2<f32>,
}

fn principal_of(bend: vec3<f32>) -> Principal {
    let mean = 0.5 * (bend.x + bend.z);
    let half = 0.5 * (bend.x - bend.z);
    let radius = length(vec2<f32>(half, bend.y));
    // The direction can be written in two ways; this chooses the one whose terms do not cancel. At an umbilic any
    // direction will do.
    var along = select(vec2<f32>(bend.y, radius - half), vec2<f32>(radius + half, bend.y), half >= 0.0);
    along = select(along / max(length(along), 1e-30), vec2<f32>(1.0, 0.0), radius <= 1e-30);
    return Principal(mean + radius, mean - radius, along);
}

// Radial curvature: the curvature along the direction to the eye projected on the surface (DeCarlo and others 2003,
// "Suggestive Contours for Conveying Shape").
struct Radial {
    // Radial curvature, in 1/m, and its derivative toward the eye, in 1/m².
    curvature: f32,
    change: f32,
    // Cosine between the normal and the direction to the eye.
    facing: f32,
}

fn radial_of(shape: Shape, to_eye: vec3<f32>) -> Radial {
    let facing = dot(shape.normal, to_eye);
    let w = to_eye * frame_of(shape.normal);
    let sine = max(length(w), 1e-6);
    let along = w / sine;
    let across = vec2<f32>(-along.y, along.x);
    let torsion = form2(shape.bend, along, across);
    // As the point moves toward the eye, the direction to the eye changes too: DeCarlo and others 2004, "Interactive
    // Rendering of Suggestive Contours with Temporal Coherence", appendix.
    let change = form3(shape.change, along, along, along) - 2.0 * torsion * torsion * facing / sine;
    return Radial(form2(shape.bend, along, along), change, facing);
}
