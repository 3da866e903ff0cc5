"""Makes a font of this folder: a subset of SOURCE with another name, written to OUTPUT.

Usage: python subset.py SOURCE OUTPUT "Name of the subset"

README.md has the sources and the version of fonttools (`pip install fonttools`).
"""

import sys

from fontTools import subset

# Latin, Latin-1, Latin Extended-A and some letters beyond it, combining marks, Greek, Cyrillic, and the signs of a map.
RANGES = [
    (0x20, 0x7E), (0xA0, 0x17F), (0x192, 0x192), (0x218, 0x21B), (0x2C6, 0x2DD), (0x300, 0x304), (0x306, 0x30C),
    (0x326, 0x328), (0x384, 0x3CE), (0x400, 0x45F), (0x490, 0x493), (0x4AE, 0x4B1), (0x4D8, 0x4D9), (0x4E8, 0x4E9),
    (0x1E80, 0x1E85), (0x1E9E, 0x1E9E), (0x1EF2, 0x1EF3), (0x2009, 0x200A), (0x2010, 0x2015), (0x2018, 0x201E),
    (0x2020, 0x2022), (0x2026, 0x2026), (0x202F, 0x202F), (0x2030, 0x2030), (0x2032, 0x2033), (0x2039, 0x203A),
    (0x2044, 0x2044), (0x20AC, 0x20AC), (0x2116, 0x2116), (0x2122, 0x2122), (0x2190, 0x2193), (0x2212, 0x2212),
    (0x221E, 0x221E), (0x2248, 0x2248), (0x2260, 0x2260), (0x2264, 0x2265), (0x25B2, 0x25B3), (0xFB01, 0xFB02),
]
FEATURES = ["kern", "liga", "ccmp", "locl", "mark", "mkmk", "lnum", "pnum", "case"]


def main():
    source, output, name = sys.argv[1:]
    options = subset.Options()
    options.layout_features = FEATURES
    options.hinting = False
    options.desubroutinize = False
    options.legacy_kern = True
    options.name_IDs = [0, 1, 2, 4, 6, 13, 14]
    options.name_languages = [0x409]
    options.recalc_timestamp = False
    options.notdef_outline = True
    options.drop_tables += ["FFTM", "DSIG", "BASE", "PfEd", "TeX "]
    font = subset.load_font(source, options)
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=[code for first, last in RANGES for code in range(first, last + 1)])
    subsetter.subset(font)
    for number, text in [(1, name), (2, "Regular"), (4, name), (6, name.replace(" ", ""))]:
        for record in [record for record in font["name"].names if record.nameID == number]:
            record.string = text
    if "CFF " in font:
        cff = font["CFF "].cff
        cff.fontNames = [name.replace(" ", "")]
        cff[0].FullName = cff[0].FamilyName = name
        if hasattr(cff[0], "Notice"):
            cff[0].Notice = str(font["name"].getDebugName(0))
    subset.save_font(font, output, options)


main()
