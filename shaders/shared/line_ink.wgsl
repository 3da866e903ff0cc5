// The coverage of a pixel by a line.
#define_import_path hachure::line_ink

// Returns the fraction of a pixel that a line covers, if the line's centre is `away_px` from the pixel's. Lines thinner
// than a pixel become paler instead of thinner.
fn line_ink(away_px: f32, width_px: f32) -> f32 {
    return min(width_px, 1.0) * clamp(0.5 * max(width_px, 1.0) + 0.5 - abs(away_px), 0.0, 1.0);
}
