"""Pictures of files and of arrays are those of the program, bit for bit."""

import os
import unittest

import numpy as np

import hachure
from common import DEGREES, DEGREES_CRS, SIZE, UTM, UTM_CRS, Case, hill, write_geotiff


class Pictures(Case):
    def setUp(self):
        super().setUp()
        self.heights = hill()
        self.dem = self.path("hill.tif")
        write_geotiff(self.dem, self.heights, UTM, 32632)

    def test_a_file_is_drawn_as_by_the_program(self):
        for style, words, options in [
            ("ink", [], {}),
            ("engraving", [], {}),
            ("pencil", ["--map"], {"map": True}),
            ("crosshatch", ["--camera", "100,-900,+400,-5,-20,45"], {"view": hachure.Camera(100, -900, 400, -5, -20, 45, True)}),
            ("hachures", ["--map=200,-100,1500", "--dpi", "144"], {"map": (200, -100, 1500), "dpi": 144}),
            ("ink", ["--exaggeration", "2", "--sun", "90,20"], {"exaggeration": 2, "sun": (90, 20)}),
        ]:
            with self.subTest(style=style, words=words):
                expected = self.rendered(self.dem, "--style", style, *words)
                found = hachure.draw(self.dem, style, SIZE, **options)
                self.assertEqual((found.array.dtype, found.array.shape), (np.uint8, (SIZE[1], SIZE[0], 4)))
                self.assert_same(found.array, expected)
                # Planted: another size of strokes, or another light.
                self.assert_differs(hachure.draw(self.dem, style, SIZE, **{**options, "sun": (200, 60), "dpi": 200}).array, expected)

    def test_an_array_is_drawn_as_its_file(self):
        for transform, crs, epsg in [(UTM, UTM_CRS, 32632), (DEGREES, DEGREES_CRS, 4326)]:
            dem = self.path(f"{epsg}.tif")
            write_geotiff(dem, self.heights, transform, epsg)
            of_file = self.rendered(dem, "--style", "engraving")
            draw = lambda heights, transform=transform, crs=crs: hachure.draw(
                heights, "engraving", SIZE, transform=transform, crs=crs).array
            self.assert_same(draw(self.heights), of_file)
            self.assert_same(draw(self.heights.astype(np.float64)), of_file)
            self.assert_same(draw(np.asfortranarray(self.heights)), of_file)
            self.assert_same(draw(self.heights[::-1, ::-1][::-1, ::-1]), of_file)
            # Planted: a transposed array, one that is upside down, and samples that are farther apart.
            self.assert_differs(draw(np.ascontiguousarray(self.heights.T)), of_file)
            self.assert_differs(draw(self.heights[::-1]), of_file)
            a, b, c, d, e, f = transform
            self.assert_differs(draw(self.heights, (1.01 * a, b, c, d, 1.01 * e, f)), of_file)
        # Planted: in degrees, a metre is at another place of the array farther north.
        self.assert_differs(draw(self.heights, (a, b, c, d, e, f + 20)), of_file)

    def test_maps_of_arrays_have_the_place_of_those_of_files(self):
        words, options = ["--map", "--map-frame", "--style", "relief"], {"map": True, "map_frame": True}
        of_file = self.rendered(self.dem, *words, size=(400, 320))
        of_array = hachure.draw(self.heights, "relief", (400, 320), transform=UTM, crs=UTM_CRS, **options)
        self.assert_same(of_array.array, of_file)
        # Planted: a transform that is shifted by 1 km shows other coordinates.
        shifted = (UTM[0], 0, UTM[2] + 1000, 0, UTM[4], UTM[5])
        moved = hachure.draw(self.heights, "relief", (400, 320), transform=shifted, crs=UTM_CRS, **options)
        self.assert_differs(moved.array, of_file)
        self.assertIn("32632", of_array.crs)
        a, b, c, d, e, f = of_array.transform
        self.assertEqual((b, d, a), (0, 0, -e))
        # The middle of the picture is the middle of the land.
        self.assertAlmostEqual(c + 200 * a, UTM[2] + 60 * 30, delta=a)
        self.assertAlmostEqual(f + 160 * e, UTM[5] - 45 * 30, delta=a)
        self.assertAlmostEqual(moved.transform[2] - c, 1000, places=6)
        self.assertIsNone(hachure.draw(self.heights, size=SIZE, spacing_m=30).transform)

    def test_no_data_is_that_of_a_file(self):
        heights = self.heights.copy()
        heights[20:24, 30:35] = -9999  # filled
        heights[60:, :70] = -9999  # a hole at the edge
        write_geotiff(self.dem, heights, UTM, 32632, nodata=-9999)
        of_file = self.rendered(self.dem, "--style", "ink", "--map")
        draw = lambda dem, **options: hachure.draw(dem, "ink", SIZE, transform=UTM, crs=UTM_CRS, map=True, **options).array
        self.assert_same(draw(heights, nodata=-9999), of_file)
        self.assert_same(draw(np.where(heights == -9999, np.float32(np.nan), heights)), of_file)
        self.assert_same(draw(np.ma.masked_equal(heights, -9999)), of_file)
        # Planted: holes that stay, and heights below the sea floor.
        self.assert_differs(draw(heights, nodata=-9999, voids="holes"), of_file)
        self.assert_differs(draw(heights), of_file)

    def test_a_world_is_drawn_many_times(self):
        world = hachure.World(self.heights, transform=UTM, crs=UTM_CRS)
        self.assertEqual(world.shape, self.heights.shape)
        self.assertEqual(world.transform, UTM)
        first = world.draw("strokes", SIZE)
        world.draw("pencil", SIZE, map=True)
        world.draw("ink", (90, 60), exaggeration=3)
        self.assert_same(world.draw("strokes", SIZE).array, first.array)
        self.assert_same(world.draw("strokes", SIZE, view=first.camera).array, first.array)
        self.assert_same(hachure.draw(world, "strokes", SIZE).array, first.array)

    def test_heights_are_not_copied_before_the_world_takes_them(self):
        self.assertIs(hachure._heights(self.heights), self.heights)
        unmasked = np.ma.MaskedArray(self.heights)
        self.assertTrue(np.shares_memory(hachure._heights(unmasked), self.heights))
        # The world's own heights do not change with the array.
        world = hachure.World(self.heights, spacing_m=30)
        before = world.draw("ink", SIZE).array
        self.heights[:] = 0
        self.assert_same(world.draw("ink", SIZE).array, before)

    def test_pictures_are_saved_and_nothing_is_replaced(self):
        picture = hachure.draw(self.dem, "pen", SIZE)
        saved = self.path("saved.png")
        picture.save(saved)
        self.assert_same(hachure.read_png(saved), picture.array)
        with self.assertRaisesRegex(hachure.HachureError, "saved.png: exists already"):
            picture.save(saved)
        picture.save(saved, overwrite=True)
        with self.assertRaisesRegex(hachure.HachureError, "only"):
            picture.save(self.path("a.jpg"))
        shown = self.path("shown.png")
        with open(shown, "wb") as file:
            file.write(picture._repr_png_())
        self.assert_same(hachure.read_png(shown), picture.array)
        self.assertEqual(np.asarray(picture).shape, (SIZE[1], SIZE[0], 4))
        said, status = self.program("info", saved)
        self.assertEqual(status, 0, said)

    def test_files_of_all_kinds_are_written(self):
        world = hachure.World(self.heights, transform=UTM, crs=UTM_CRS)
        for name, style, options in [
            ("a.svg", "strokes", {}), ("a.pdf", "strokes", {}), ("a.exr", "ink", {"aov": "depth"}), ("a.jpg", "ink", {}),
            ("a.tif", "relief", {"map": True}), ("a.geojson", "pen", {"map": True}), ("a.png", "ink", {"title": "Hill"}),
        ]:
            world.render(self.path(name), style, SIZE if "title" not in options else (400, 300), **options)
            self.assertGreater(os.path.getsize(self.path(name)), 100, name)
            with self.assertRaises(hachure.HachureError):
                world.render(self.path(name), style, SIZE, **options)

    def test_eyes_are_side_by_side(self):
        expected = self.rendered(self.dem, "--eyes", "side-by-side")
        self.assert_same(hachure.draw(self.dem, "ink", SIZE, eyes="side-by-side").array, expected)
        self.assertEqual(expected.shape[1], 2 * SIZE[0])


if __name__ == "__main__":
    unittest.main()
