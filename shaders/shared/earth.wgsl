// The curvature of the earth: from the flat map to the bent world, as seen from the camera, and back.
//
// The map is bent around the camera: a place at map distance d and height h stands at the angle d / R from the
// camera's own plumb line, at the distance R + h from the earth's centre. R is the effective radius: light bends
// along, which standard refraction allows for by a larger earth. All formulas are written without the difference of
// large numbers: f32 holds 0.1 mm at 100 km. Trigonometry of graphics drivers is good to a few thousandths only, so
// the functions are series, good to 1e-7 up to 1.2 rad.
#define_import_path hachure::earth
#import hachure::terrain::terrain

// sin(x) / x by x².
fn sinc(xx: f32) -> f32 {
    return 1.0 - xx / 6.0 * (1.0 - xx / 20.0 * (1.0 - xx / 42.0 * (1.0 - xx / 72.0 * (1.0 - xx / 110.0))));
}

// (1 - cos(x)) / x² by x².
fn versine(xx: f32) -> f32 {
    return 0.5 * (1.0 - xx / 12.0 * (1.0 - xx / 30.0 * (1.0 - xx / 56.0 * (1.0 - xx / 90.0 * (1.0 - xx / 132.0)))));
}

fn camera_z_m() -> f32 {
    return terrain.camera_z_coarse_m + terrain.camera_z_fine_m;
}

// A place of the flat map, camera-relative, in the bent world.
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

// What is known of a place in the bent world.
struct Unbent {
    // Camera-relative, on the flat map.
    flat_m: vec3<f32>,
    // Unit: away from the earth's centre.
    up: vec3<f32>,
    // Map metres per metre: toward the camera's plumb line, and across.
    along: f32,
    across: f32,
    // Unit in the horizontal plane, away from the plumb line; 0 on it.
    outward: vec2<f32>,
}

fn unbend(at_m: vec3<f32>) -> Unbent {
    let k = terrain.inverse_radius;
    if k == 0.0 {
        return Unbent(at_m, vec3<f32>(0.0, 0.0, 1.0), 1.0, 1.0, vec2<f32>(0.0));
    }
    let camera = 1.0 + camera_z_m() * k;
    // Everything by the radius, counted from the centre.
    let v = camera + at_m.z * k;
    let r = length(at_m.xy);
    let u = r * k / v;
    // The angle over its tangent, by halving it twice.
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

// A direction of the bent world on the flat map: how map place and height change along it.
fn unbend_direction(at: Unbent, direction: vec3<f32>) -> vec3<f32> {
    let rise = dot(direction, at.up);
    let level = (direction - at.up * rise).xy;
    let outward = dot(level, at.outward);
    return vec3<f32>(level * at.across + at.outward * (outward * (at.along / at.up.z - at.across)), rise);
}

// The unit normal in the bent world of a surface with slopes `slope` on the flat map.
fn bend_normal(at: Unbent, slope: vec2<f32>) -> vec3<f32> {
    let outward = dot(slope, at.outward);
    let tangent = slope * at.across + at.outward * (outward * (at.up.z * at.along - at.across));
    let sine = length(at.up.xy);
    return normalize(at.up - vec3<f32>(tangent, -sine * outward * at.along));
}
