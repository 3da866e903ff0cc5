// The curvature of the earth: transforms between the flat map and the bent world seen from the camera.
//
// The map is bent around the camera. A point at map distance d and height h is at the angle d / R from the camera's
// plumb line, and at the distance R + h from the earth's centre. R is the effective radius: light bends along with the
// earth, and standard refraction accounts for that by a larger radius. No formula subtracts large numbers, so that f32
// keeps 0.1 mm at 100 km. Trigonometric functions of graphics drivers are accurate to a few thousandths only, so the
// functions here are series, accurate to 1e-7 up to 1.2 rad.
#define_import_path hachure::earth
#import hachure::terrain::terrain

// Returns sin(x) / x, given x².
fn sinc(xx: f32) -> f32 {
    return 1.0 - xx / 6.0 * (1.0 - xx / 20.0 * (1.0 - xx / 42.0 * (1.0 - xx / 72.0 * (1.0 - xx / 110.0))));
}

// Returns (1 - cos(x)) / x², given x².
fn versine(xx: f32) -> f32 {
    return 0.5 * (1.0 - xx / 12.0 * (1.0 - xx / 30.0 * (1.0 - xx / 56.0 * (1.0 - xx / 90.0 * (1.0 - xx / 132.0)))));
}

fn camera_z_m() -> f32 {
    return terrain.camera_z_coarse_m + terrain.camera_z_fine_m;
}

// Moves a camera-relative point of the flat map into the bent world.
fn bend(flat_m: vec3<f32>) -> vec3<f32> {
    let k = terrain.inverse_radius;
    if k == 0.0 {
        return flat_m;
    }
    let dd = dot(flat_m.xy, flat_m.xy);
    let xx = dd * k * k;
    let taller = 1.0 + (flat_m.z + camera_z_m()) * k;
    return vec3<f32>(flat_m.xy * (sinc(xx) * taller), flat_m.z - taller * dd * k * versine(xx));
}

// A point of the bent world on the flat map.
struct Unbent {
    // Camera-relative, on the flat map, in metres.
    flat_m: vec3<f32>,
    // Unit vector away from the earth's centre.
    up: vec3<f32>,
    // Map metres per metre, toward the camera's plumb line and across.
    along: f32,
    across: f32,
    // Horizontal unit vector away from the plumb line; 0 on the line.
    outward: vec2<f32>,
}

fn unbend(at_m: vec3<f32>) -> Unbent {
    let k = terrain.inverse_radius;
    if k == 0.0 {
        return Unbent(at_m, vec3<f32>(0.0, 0.0, 1.0), 1.0, 1.0, vec2<f32>(0.0));
    }
    let camera = 1.0 + camera_z_m() * k;
    // Lengths are divided by the radius, and heights counted from the centre.
    let v = camera + at_m.z * k;
    let r = length(at_m.xy);
    let u = r * k / v;
    // The angle divided by its tangent, by halving the angle twice.
    let half = 1.0 / (1.0 + sqrt(1.0 + u * u));
    let t = u * half;
    let quarter = 1.0 / (1.0 + sqrt(1.0 + t * t));
    let q = t * quarter;
    let qq = q * q;
    let series = 1.0 - qq * (1.0 / 3.0 - qq * (1.0 / 5.0 - qq * (1.0 / 7.0 - qq * (1.0 / 9.0 - qq / 11.0))));
    let angle_by_tangent = 4.0 * half * quarter * series;
    let across = angle_by_tangent / v;
    let hypotenuse = sqrt(u * u * v * v + v * v);
    let z_m = (r * r * k + 2.0 * camera * at_m.z + at_m.z * at_m.z * k) / (hypotenuse + camera);
    let up = vec3<f32>(at_m.xy * k, v) / hypotenuse;
    let outward = at_m.xy / max(r, 1e-6);
    return Unbent(vec3<f32>(at_m.xy * across, z_m), up, 1.0 / hypotenuse, across, outward);
}

// Returns the derivative of map position and height along a direction of the bent world.
fn unbend_direction(at: Unbent, direction: vec3<f32>) -> vec3<f32> {
    let rise = dot(direction, at.up);
    let level = (direction - at.up * rise).xy;
    let outward = dot(level, at.outward);
    return vec3<f32>(level * at.across + at.outward * (outward * (at.along / at.up.z - at.across)), rise);
}

// Returns the unit normal in the bent world of a surface with the gradient `slope` on the flat map.
fn bend_normal(at: Unbent, slope: vec2<f32>) -> vec3<f32> {
    let outward = dot(slope, at.outward);
    let tangent = slope * at.across + at.outward * (outward * (at.up.z * at.along - at.across));
    let sine = length(at.up.xy);
    return normalize(at.up - vec3<f32>(tangent, -sine * outward * at.along));
}
