// Pieces of lines and points of features, draped on the land and projected onto the picture.
#define_import_path hachure::draped

// A piece is a straight line on the picture, or a dot.
struct DrapedPiece {
    // Position on the targets in pixels, distance along the view axis, and length of the line up to here in metres; the
    // distance is 0 for a piece that is not drawn, and the length is DOT for a dot.
    begin: vec4<f32>,
    end: vec4<f32>,
}

const DOT: f32 = -1.0;

struct DrapedRules {
    // Number of pieces for which there is room.
    capacity: u32,
    line_px: f32,
    point_px: f32,
    dash_px: f32,
    gap_px: f32,
    // Number of segments and points, one for each thread that cuts lines.
    segments: u32,
    pad_b: f32,
    pad_c: f32,
}
