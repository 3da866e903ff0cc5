"""Styles, channels, films, measurements, other packages' arrays, and threads."""

import os
import threading
import time
import unittest

import numpy as np

import hachure
from common import SIZE, UTM, UTM_CRS, Case, hill, write_geotiff


class Styles(Case):
    def test_a_style_is_a_mapping(self):
        self.assertIn("engraving", hachure.styles())
        style = hachure.Style("strokes")
        self.assertEqual(style["strokes.width_px"], style.strokes.width_px)
        self.assertEqual(dict(style)["paper.color"], style.paper.color)
        self.assertIn("strokes", dir(style))
        self.assertIn("width_px", dir(style.strokes))
        self.assertIn("strokes.width_px", style._ipython_key_completions_())
        width = style.parameter("strokes.width_px")
        self.assertEqual((width.unit, width.kind), ("px", "number"))
        self.assertTrue(width.help and width.range)
        changed = style.with_values({"strokes.width_px": 5.5})
        self.assertEqual((changed["strokes.width_px"], style["strokes.width_px"]), (5.5, width.value))
        self.assertEqual(hachure.Style("strokes", strokes={"width_px": 5.5}), changed)
        self.assertEqual(hachure.Style.of({"extends": "strokes", "strokes.width_px": 5.5}), changed)
        self.assertNotEqual(changed, style)
        self.assertEqual(hachure.Style.parse(changed.text(), "strokes")["strokes.width_px"], 5.5)
        file = self.path("mine.toml")
        changed.save(file)
        self.assertEqual(hachure.Style(file)["strokes.width_px"], 5.5)
        with self.assertRaises(hachure.HachureError):
            changed.save(file)
        with self.assertRaises(AttributeError):
            style.nothing
        self.assertIn("<table>", style._repr_html_())

    def test_all_presets_are_mappings_and_come_back(self):
        for name in hachure.styles():
            style = hachure.Style(name)
            self.assertGreater(len(style), 10, name)
            self.assertEqual(set(style), set(hachure.Style.parse(style.text(), name)), name)

    def test_a_style_draws_as_by_the_program(self):
        dem = self.path("hill.tif")
        write_geotiff(dem, hill(), UTM, 32632)
        expected = self.rendered(dem, "--style", "strokes", "--set", "strokes.width_px=4", "--set", "paper.color=#ffeecc")
        style = {"extends": "strokes", "strokes": {"width_px": 4}, "paper.color": "#ffeecc"}
        self.assert_same(hachure.draw(dem, style, SIZE).array, expected)
        self.assert_same(hachure.draw(dem, "strokes", SIZE, set={"strokes.width_px": 4, "paper.color": "#ffeecc"}).array, expected)
        self.assert_differs(hachure.draw(dem, {**style, "paper.color": "#ffeecd"}, SIZE).array, expected)


class Arrays(Case):
    def test_channels_have_the_shapes_of_the_picture(self):
        heights = hill()
        found = hachure.layers(heights, ["depth", "position", "normal", "tone", "surface"], "plain", SIZE, spacing_m=30, map=True)
        shape = (SIZE[1], SIZE[0])
        self.assertEqual([found[name].shape for name in found], [shape, (*shape, 3), (*shape, 3), shape, shape])
        self.assertEqual([found[name].dtype for name in ("depth", "tone", "surface")], [np.float32, np.float32, np.uint32])
        land = found["normal"].any(axis=-1)
        self.assertAlmostEqual(float(np.linalg.norm(found["normal"][land], axis=-1).mean()), 1, places=2)

    def test_a_plane_has_the_shade_and_slope_of_geometry(self):
        rows, columns, spacing_m = 60, 80, 10.0
        rise = np.tan(np.radians(30))  # toward the east
        heights = np.broadcast_to(rise * spacing_m * np.arange(columns), (rows, columns)).astype(np.float32)
        middle = (slice(20, 40), slice(25, 55))
        slope = hachure.slope(heights, spacing_m=spacing_m)
        self.assertEqual((slope.shape, slope.dtype), ((rows, columns), np.float32))
        self.assertLess(float(np.abs(slope[middle] - 30).max()), 0.1)
        # The normal points to the west: a sun in the west, 60 degrees high, shines along it.
        along = hachure.hillshade(heights, sun=(270, 60), spacing_m=spacing_m)
        self.assertGreater(float(along[middle].min()), 0.999)
        # Planted: the opposite sun.
        against = hachure.hillshade(heights, sun=(90, 60), spacing_m=spacing_m)
        self.assertLess(float(np.abs(against[middle] - 0.5).max()), 0.01)
        tone = hachure.tone(heights, "pencil", spacing_m=spacing_m)
        self.assertTrue(0 <= tone.min() and tone.max() <= 1)

    def test_rasters_of_other_packages(self):
        heights = hill()
        dem = self.path("hill.tif")
        write_geotiff(dem, heights, UTM, 32632)
        expected = hachure.draw(dem, "ink", SIZE).array

        class Dataset:
            """What of rasterio is used."""

            transform, crs, nodata = UTM, UTM_CRS, None

            def read(self, band, masked):
                return np.ma.MaskedArray(heights)

        self.assert_same(hachure.draw(Dataset(), "ink", SIZE).array, expected)
        try:
            import rasterio
        except ImportError:
            pass
        else:
            with rasterio.open(dem) as dataset:
                self.assert_same(hachure.draw(dataset, "ink", SIZE).array, expected)
        try:
            import xarray
        except ImportError:
            return
        x = UTM[2] + UTM[0] * (np.arange(heights.shape[1]) + 0.5)
        y = UTM[5] + UTM[4] * (np.arange(heights.shape[0]) + 0.5)
        array = xarray.DataArray(heights, coords={"y": y, "x": x}, dims=("y", "x"), attrs={"crs": UTM_CRS})
        self.assert_same(hachure.draw(array, "ink", SIZE).array, expected)
        self.assert_same(hachure.draw(array.transpose(), "ink", SIZE).array, expected)
        self.assert_same(hachure.draw(array.expand_dims("band"), "ink", SIZE).array, expected)
        self.assert_differs(hachure.draw(array.isel(x=slice(0, 60)), "ink", SIZE).array, expected)
        with self.assertRaisesRegex(hachure.HachureError, "evenly"):
            hachure.draw(array.assign_coords(x=x**1.1), "ink", SIZE)
        try:
            import rioxarray
        except ImportError:
            return
        with rioxarray.open_rasterio(dem) as opened:
            self.assert_same(hachure.draw(opened, "ink", SIZE).array, expected)


class Films(Case):
    def setUp(self):
        super().setUp()
        self.dem = self.path("hill.tif")
        write_geotiff(self.dem, hill(), UTM, 32632)
        self.path_of_camera = hachure.Path.around((0, 0), 1500, 500, seconds=1.5, keys=7)

    def test_frames_are_those_of_the_program(self):
        csv = self.path("path.csv")
        self.path_of_camera.save(csv)
        pattern = self.path("%d.png")
        said, status = self.program(
            "render", self.dem, "--style", "strokes", "--path", csv, "--fps", "4", "--size", "160x100", "-o", pattern)
        self.assertEqual(status, 0, said)
        world = hachure.World(self.dem)
        frames = world.film(self.path_of_camera, style="strokes", size=SIZE, fps=4)
        self.assertEqual(len(frames), 7)
        for number, frame in enumerate(frames):
            self.assert_same(frame.array, hachure.read_png(pattern % number))
        self.assert_differs(frames[0].array, frames[1].array)

    def test_a_film_is_written(self):
        gif = self.path("film.gif")
        self.assertEqual(hachure.film(self.dem, self.path_of_camera, gif, style="pen", size=(64, 40), fps=3), [])
        with open(gif, "rb") as file:
            self.assertEqual(file.read(3), b"GIF")
        with self.assertRaises(hachure.HachureError):
            hachure.film(self.dem, self.path_of_camera, gif, style="pen", size=(64, 40), fps=3)

    def test_costs_are_measured(self):
        report = hachure.bench(
            self.dem, self.path_of_camera, self.path("report"), styles=["plain", "ink"], size=(64, 40), frames=4, steadiness_pairs=0)
        self.assertEqual(len(report["runs"]), 2)
        self.assertTrue(os.path.exists(self.path("report/report.json")))
        with self.assertRaisesRegex(hachure.HachureError, "heights in memory"):
            hachure.bench(hill(), self.path_of_camera, self.path("other"), spacing_m=30)


class Threads(Case):
    def test_other_threads_run_while_a_picture_is_drawn(self):
        world = hachure.World(hill(), spacing_m=30)
        world.draw("ink", SIZE)
        ticks, stop = [], threading.Event()

        def tick():
            while not stop.is_set():
                ticks.append(time.perf_counter())
                time.sleep(0.001)

        thread = threading.Thread(target=tick)
        thread.start()
        start = time.perf_counter()
        world.draw("engraving", (900, 600), samples=4)
        seconds = time.perf_counter() - start
        stop.set()
        thread.join()
        during = sum(start < at < start + seconds for at in ticks)
        self.assertGreater(during, 20 * seconds, f"{during} ticks in {seconds:.2f} s")

    def test_threads_share_a_world(self):
        world = hachure.World(hill(), spacing_m=30)
        expected = world.draw("pen", SIZE).array
        found = []
        threads = [threading.Thread(target=lambda: found.append(world.draw("pen", SIZE).array)) for _ in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertEqual(len(found), 4)
        for picture in found:
            self.assert_same(picture, expected)

    def test_drawing_in_a_loop_does_not_grow(self):
        def resident_mib():
            try:
                with open("/proc/self/statm") as file:
                    return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
            except OSError:
                self.skipTest("the memory of the process is unknown here")

        # Mesa's software driver itself keeps 0.2 to 0.8 MiB of each picture in styles with more passes than this one.
        world, heights = hachure.World(hill(), spacing_m=30), hill(40, 50)
        draws = int(os.environ.get("HACHURE_DRAWS", "200"))

        def draw(count):
            for number in range(count):
                world.draw("plain", (96, 60))
                if number % 4 == 0:
                    hachure.draw(heights, "plain", (96, 60), spacing_m=30, map=True)

        draw(draws // 4)
        before = resident_mib()
        draw(draws)
        grown = resident_mib() - before
        print(f"{draws} draws: {before:.0f} MiB before, {grown:+.1f} MiB after")
        # Pictures that stayed in memory would have 0.022 MiB each.
        self.assertLess(grown, 1 + 0.015 * draws)


if __name__ == "__main__":
    unittest.main()
