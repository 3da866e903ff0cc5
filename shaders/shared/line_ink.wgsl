// The coverage of a pixel by a line.
#define_import_path hachure::line_ink

// Returns the part of a pixel that a line covers whose centre is `away_px` away; lines thinner than a pixel become
// paler instead.
fn line_ink(away_px: f32, width_px: f32) -> f32 {
    return min(width_px, 1.0) * clamp(0.5 * max(width_px, 1.0) + 0.5 - abs(away_px), 0.0, 1.0);
}
