// The cells on which the masses of a picture are edited. They are those of the whole picture, so its parts agree, and
// their number is the same at every size, so a print has the masses of its preview.
#define_import_path hachure::mass_grid

// Number of cells along the longer side of a picture.
const LONGEST: u32 = 120u;
// Replaces the tone of a cell without land.
const NO_LAND: f32 = -1.0;

struct MassCell {
    // The edited tone, and the one before; NO_LAND where there is none.
    tone: f32,
    before: f32,
    // Distance along the view axis.
    depth_m: f32,
    // The level beyond which the tone was before it was edited; 0 if it has not been.
    level: f32,
}

struct MassRules {
    // Number of cells, across and down.
    cells: vec2<u32>,
    // Number of tones between which masses are told apart.
    levels: u32,
    // Number of cells below which a mass is taken to those around it.
    least: u32,
    // 1: masses are the cells that are darker than a level; 0: those that are at least as light.
    dark: u32,
    // How far below a level its step begins to rise, as a part of the distance of levels.
    rise: f32,
    pad_b: u32,
    pad_c: u32,
}

// A cell at a level. The levels of a label or an area follow each other, in rows below rows.
struct LevelCell {
    level: u32,
    // Column and row.
    place: vec2<u32>,
    // Index of the cell, and of the cell at its level.
    cell: u32,
    index: u32,
    is_outside: bool,
}

// Returns the cell and level of an invocation.
fn level_cell(rules: MassRules, id: vec2<u32>) -> LevelCell {
    let cells = rules.cells;
    let row = id.y % cells.y;
    let is_outside = id.x >= cells.x || id.y >= cells.y * (rules.levels - 1u);
    return LevelCell(1u + id.y / cells.y, vec2<u32>(id.x, row), row * cells.x + id.x, id.y * cells.x + id.x, is_outside);
}

// Bit of a mass's area that says that land of the other kind borders on the mass.
const BORDERED: u32 = 0x80000000u;

// Returns the tone from which on a cell is as light as a level.
fn tone_of_level(rules: MassRules, level: u32) -> f32 {
    return (f32(level) - rules.rise) / f32(rules.levels);
}

// Returns whether a cell of a tone belongs to the masses of a level, which is 1 or more.
fn is_in(rules: MassRules, tone: f32, level: u32) -> bool {
    let is_light = tone >= tone_of_level(rules, level);
    return tone != NO_LAND && is_light != (rules.dark == 1u);
}
