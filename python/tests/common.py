"""Worlds, and the program, for the tests of the package. Nothing here needs more than numpy."""

import os
import struct
import subprocess
import tempfile
import unittest

import numpy as np

#: The program to which pictures are compared.
PROGRAM = os.environ.get("HACHURE_PROGRAM")
SIZE = (160, 100)


def hill(rows=90, columns=120, seed=3):
    """Heights in metres, float32, that are the same in no two directions."""
    y, x = np.mgrid[0:1 : rows * 1j, 0:1 : columns * 1j]
    heights = 700 * np.exp(-9 * ((x - 0.4) ** 2 + 1.5 * (y - 0.55) ** 2)) + 90 * np.sin(9 * x + 2 * y) * np.cos(5 * y * x)
    rough = np.random.default_rng(seed).normal(0, 1.5, (rows, columns))
    return (heights + rough + 300).astype(np.float32)


#: Transform of `hill` in UTM, in the order of rasterio: 30 m, no two numbers equal.
UTM = (30.0, 0.0, 412345.5, 0.0, -30.0, 5176543.25)
UTM_CRS = "EPSG:32632"
#: In degrees.
DEGREES = (0.0004, 0.0, 7.75, 0.0, -0.0004, 46.5)
DEGREES_CRS = "EPSG:4326"


def write_geotiff(path, heights, transform, epsg, nodata=None):
    """Writes heights as a GeoTIFF: float32, one strip, no compression."""
    rows, columns = heights.shape
    a, b, c, d, e, f = transform
    assert b == 0 and d == 0 and e < 0
    is_geographic = epsg == 4326
    keys = [1, 1, 0, 3, 1024, 0, 1, 2 if is_geographic else 1, 1025, 0, 1, 1, 2048 if is_geographic else 3072, 0, 1, epsg]
    data = heights.astype("<f4").tobytes()
    tags = [
        (256, "L", [columns]), (257, "L", [rows]), (258, "H", [32]), (259, "H", [1]), (262, "H", [1]), (273, "L", [8]),
        (277, "H", [1]), (278, "L", [rows]), (279, "L", [len(data)]), (339, "H", [3]), (33550, "d", [a, -e, 0.0]),
        (33922, "d", [0.0, 0.0, 0.0, c, f, 0.0]), (34735, "H", keys),
    ]
    if nodata is not None:
        tags.append((42113, "s", str(nodata).encode() + b"\0"))
    types = {"H": 3, "L": 4, "d": 12, "s": 2}
    start = 8 + len(data)
    after = start + 2 + 12 * len(tags) + 4
    entries, more = b"", b""
    for tag, kind, values in tags:
        packed = values if kind == "s" else struct.pack(f"<{len(values)}{kind}", *values)
        if len(packed) <= 4:
            place = packed.ljust(4, b"\0")
        else:
            more += b"\0" * (-(after + len(more)) % 8)
            place = struct.pack("<L", after + len(more))
            more += packed
        entries += struct.pack("<HHL", tag, types[kind], len(values)) + place
    with open(path, "wb") as file:
        file.write(struct.pack("<2sHL", b"II", 42, start) + data)
        file.write(struct.pack("<H", len(tags)) + entries + struct.pack("<L", 0) + more)


class Case(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def program(self, *words):
        """Runs the program, and returns what it wrote to standard error and its status."""
        if not PROGRAM:
            self.skipTest("HACHURE_PROGRAM names no program")
        done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, timeout=500)
        return done.stderr.strip(), done.returncode

    def rendered(self, *words, size=SIZE):
        """Returns the picture that the program draws with these words."""
        import hachure

        output = os.path.join(tempfile.mkdtemp(dir=self.folder), "program.png")
        said, status = self.program("render", *words, "--size", f"{size[0]}x{size[1]}", "-o", output)
        self.assertEqual(status, 0, said)
        return hachure.read_png(output)

    def assert_same(self, found, expected):
        self.assertEqual(found.shape, expected.shape)
        different = int((found != expected).any(axis=-1).sum())
        self.assertEqual(different, 0, f"{different} of {found.shape[0] * found.shape[1]} pixels differ")

    def assert_differs(self, found, expected):
        self.assertTrue(found.shape != expected.shape or (found != expected).any(), "a planted error was not seen")
