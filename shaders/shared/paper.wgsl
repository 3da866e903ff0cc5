// The sheet of paper that is drawn on.
#define_import_path hachure::paper

#import hachure::color::noise

// Returns the paper's grain, fibres and tooth, which is fixed to the sheet.
fn paper_grain(p: vec2<f32>) -> f32 {
    let fibre = noise(p * vec2<f32>(0.11, 0.37)) + noise(p.yx * vec2<f32>(0.09, 0.33));
    let tooth = noise(p * 0.83);
    return (fibre - 1.0) * 0.6 + (tooth - 0.5) * 0.8;
}

// Frames a picture: a bare margin along the edges, a bare foot below, and a line around the picture within them. `px`
// is the position on the sheet; `widths_px` are the widths of the margin and of the line.
fn bordered(drawn: vec3<f32>, bare: vec3<f32>, border: vec3<f32>, widths_px: vec2<f32>, foot_px: f32, px: vec2<f32>, sheet_px: vec2<f32>) -> vec3<f32> {
    let from_edge = min(px, sheet_px - vec2<f32>(0.0, foot_px) - px);
    let in_px = min(from_edge.x, from_edge.y) - widths_px.x;
    let on_line = clamp(min(in_px, widths_px.y - in_px) + 0.5, 0.0, min(widths_px.y, 1.0));
    let outside = select(0.0, clamp(0.5 - in_px, 0.0, 1.0), widths_px.x + foot_px > 0.0);
    return mix(mix(drawn, bare, outside), border, on_line);
}
