// Light warping: gathers more or less of the surrounding light around the direction to the eye, by how the surface
// bends.
//
// Vergne, Pacanowski, Barla, Granier and Schlick 2009, "Light Warping for Enhanced Surface Depiction", section 5. A
// direction of light is projected from the far pole (0, 0, -1) on the plane z = 1, scaled there by lambda_u and
// lambda_v along the principal directions u and v of the view-centred curvature, and projected back. x and y are those
// of the picture, z points to the eye.
//
// Differences from the paper:
// - With M = lambda_u u u^T + lambda_v v v^T the scaling needs no change into the frame of u and v. M is stored minus
//   the identity, so that a flat surface leaves light bit-identical.
// - With k = 2 (1 + z) / ((1 + z)^2 + |M xy|^2) the paper's W is (k M xy, z + (1 + z) (k - 1)), and it scales solid
//   angles by k^2 det M: the paper's Jacobian of the inverse, in fewer steps. The inverse is the same with 1 / lambda.
// - 1 + z is computed from x and y where z is near -1, where it would lose most of its digits.
#define_import_path hachure::light_warp

// A warp. Symmetric matrices are stored as xx, xy, yy.
struct Warp {
    // M minus the identity, and M squared minus the identity.
    stretch: vec3<f32>,
    squared: vec3<f32>,
    // Determinant of M.
    area: f32,
}

struct WarpedLight {
    // Unit vector.
    direction: vec3<f32>,
    // Factor by which the warp enlarges a solid angle.
    growth: f32,
}

// Returns lambda - 1 for a curvature multiplied by alpha: lambda = tan(arctan(alpha kappa) / 6 + pi / 4), which is
// between 0.58 and 1.73.
fn scale_less_one(alpha_kappa: f32) -> f32 {
    let t = tan(atan(alpha_kappa) / 6.0);
    return 2.0 * t / (1.0 - t);
}

fn warp_by(more: f32, less: f32, along: vec2<f32>) -> Warp {
    let across = vec2<f32>(-along.y, along.x);
    let uu = vec3<f32>(along.x * along.x, along.x * along.y, along.y * along.y);
    let vv = vec3<f32>(across.x * across.x, across.x * across.y, across.y * across.y);
    let stretch = more * uu + less * vv;
    let squared = more * (2.0 + more) * uu + less * (2.0 + less) * vv;
    return Warp(stretch, squared, (1.0 + more) * (1.0 + less));
}

// Returns the warp of a curvature. `most` and `least` are principal curvatures times alpha; `along` is the direction of
// `most`, a unit vector.
fn warp_of(most: f32, least: f32, along: vec2<f32>) -> Warp {
    return warp_by(scale_less_one(most), scale_less_one(least), along);
}

// Returns the inverse warp: 1 / lambda is lambda of the opposite curvature.
fn inverse_warp_of(most: f32, least: f32, along: vec2<f32>) -> Warp {
    return warp_of(-most, -least, along);
}

fn form_of(form: vec3<f32>, a: vec2<f32>) -> f32 {
    return form.x * a.x * a.x + 2.0 * form.y * a.x * a.y + form.z * a.y * a.y;
}

// Warps a unit direction.
fn warp_light(warp: Warp, light: vec3<f32>) -> WarpedLight {
    let flat = light.xy;
    let up = select(1.0 + light.z, dot(flat, flat) / (1.0 - light.z), light.z < 0.0);
    let more = form_of(warp.squared, flat);
    let all = 2.0 * up + more;
    // The far pole does not move.
    var k = 1.0 - more / max(all, 1e-30);
    if all <= 1e-30 {
        k = 1.0 / warp.area;
    }
    let moved = vec2<f32>(dot(warp.stretch.xy, flat), dot(warp.stretch.yz, flat));
    return WarpedLight(vec3<f32>(k * (flat + moved), light.z + up * (k - 1.0)), k * k * warp.area);
}
