"""Errors are exceptions with the line that the program prints; warnings are warnings."""

import unittest
import warnings

import numpy as np

import hachure
from common import SIZE, UTM, UTM_CRS, Case, hill, write_geotiff


class Errors(Case):
    def test_lines_are_those_of_the_program(self):
        dem = self.path("hill.tif")
        write_geotiff(dem, hill(), UTM, 32632)
        broken = self.path("broken.tif")
        with open(broken, "wb") as file:
            file.write(b"II*\0nothing")
        lines = []
        for name, words, options in [
            (dem, ["--style", "engravng"], {"style": "engravng"}),
            (self.path("missing.tif"), [], {}),
            (broken, [], {}),
            (dem, ["--sun", "1,2,3"], {"sun": (1, 2, 3)}),
            (dem, ["--set", "paper.color=7"], {"style": {"paper.color": 7}}),
            (dem, ["--set", "strokes.widthpx=7"], {"style": {"strokes": {"widthpx": 7}}}),
            (dem, ["--samples", "0"], {"samples": 0}),
            (dem, ["--look-at", "10,20"], {"look_at": (10, 20)}),
            (dem, ["--map=1,2"], {"map": (1, 2)}),
            (dem, ["--aov", "nothing"], {"layers": "nothing"}),
            (dem, ["--nosuch", "3"], {"nosuch": 3}),
        ]:
            # Channels are those of an EXR.
            output = self.path("a.exr" if "--aov" in words else "a.png")
            said, status = self.program("render", name, *words, "--size", "160x100", "-o", output)
            self.assertNotEqual(status, 0, words)
            with self.assertRaises(hachure.HachureError) as raised:
                hachure.draw(name, **{"size": SIZE, **options})
            self.assertEqual("hachure: " + str(raised.exception), said.splitlines()[-1], words)
            lines.append(said)
        # Planted: each says something else.
        self.assertEqual(len(set(lines)), len(lines))

    def test_arrays_that_are_no_heights(self):
        heights = hill(20, 30)
        for array, options, words in [
            (heights[0], {}, "shape"),
            (heights[:1], {}, "too few"),
            (np.full((5, 5), np.nan), {}, "no-data|no heights|no data"),
            (heights.astype(complex), {}, "complex"),
            (np.array([["a", "b"], ["c", "d"]]), {}, "must be numbers"),
            (heights, {"spacing_m": 0}, "above 0"),
            (heights, {"spacing_m": float("nan")}, "above 0"),
            (heights, {"transform": (1, 2, 3)}, "six numbers"),
            (heights, {"transform": (0, 0, 0, 0, 0, 0)}, "pixel size"),
            (heights, {"transform": (float("inf"), 0, 0, 0, 1, 0)}, "pixel size"),
            (heights, {"transform": UTM, "crs": "EPSG:1"}, "EPSG:1 is unknown"),
            (heights, {"transform": UTM, "crs": "EPSG:999999"}, "unknown"),
            (heights, {"transform": UTM, "crs": "nowhere"}, "unknown"),
            (heights, {"transform": UTM, "crs": object()}, "crs"),
            (heights, {"transform": UTM, "spacing_m": 3}, "one of them"),
            (heights, {"height_unit": "ft"}, "do not apply"),
            (heights, {"size": 5}, "size"),
            (heights, {"size": (0, 5)}, "side"),
            (heights, {"size": (1 << 30, 1 << 30)}, "side|pixels"),
            (heights, {"output": "a.png"}, "program only"),
            (heights, {"style": 3}, "style"),
            (heights, {"style": {"paper.color": object()}}, "value"),
            (heights, {"path": "tour"}, "film"),
            (self.path("a.tif"), {"transform": UTM}, "for arrays"),
        ]:
            with self.subTest(options=options, words=words), self.assertRaisesRegex(hachure.HachureError, words) as raised:
                hachure.draw(array, **{"size": SIZE, **options})
            self.assertNotIn("\n", str(raised.exception))

    def test_warnings_are_warnings(self):
        heights = hill()
        with self.assertWarnsRegex(hachure.HachureWarning, "sea-level"):
            hachure.draw(heights, "ink", SIZE, spacing_m=30, sea_level=8000)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            hachure.draw(heights, "ink", SIZE, spacing_m=30)

    def test_the_function_of_a_film_may_fail_and_may_not_draw(self):
        world = hachure.World(hill(), transform=UTM, crs=UTM_CRS)
        path = hachure.Path([(0, hachure.Camera(0, -1500, 600, above_ground=True)), (1, hachure.Camera(0, -1200, 600, above_ground=True))])

        def fail(frame):
            raise KeyError("mine")

        with self.assertRaises(KeyError):
            world.film(path, size=(64, 36), fps=2, on_frame=fail)
        with self.assertRaisesRegex(hachure.HachureError, "cannot draw"):
            world.film(path, size=(64, 36), fps=2, on_frame=lambda frame: world.draw(size=(64, 36)))
        self.assertEqual(world.draw(size=(64, 36)).size, (64, 36))


if __name__ == "__main__":
    unittest.main()
