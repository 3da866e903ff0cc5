// The sheet that is drawn on.
#define_import_path hachure::paper

#import hachure::color::noise

// Fibres and tooth, fixed to the sheet.
fn paper_grain(p: vec2<f32>) -> f32 {
    let fibre = noise(p * vec2<f32>(0.11, 0.37)) + noise(p.yx * vec2<f32>(0.09, 0.33));
    let tooth = noise(p * 0.83);
    return (fibre - 1.0) * 0.6 + (tooth - 0.5) * 0.8;
}
