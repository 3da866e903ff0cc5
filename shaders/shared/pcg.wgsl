// PCG in two dimensions (Jarzynski and Olano 2020): well mixed on every driver.
#define_import_path hachure::pcg

fn pcg(value: vec2<u32>) -> vec2<u32> {
    var v = value * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2<u32>(16u);
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> vec2<u32>(16u);
    return v;
}
