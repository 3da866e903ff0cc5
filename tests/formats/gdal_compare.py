#!/usr/bin/env python3
"""Compares what hachure reads with what GDAL reads, file by file.

    tests/formats/gdal_compare.py make FOLDER                 writes rasters in all variants that GDAL writes
    tests/formats/gdal_compare.py compare HACHURE FOLDER...   prints a line for each file; status 1 if one differs
    tests/formats/gdal_compare.py golden FILE...              prints lines for tests/golden/heights.csv

Needs GDAL 3 with its Python bindings and numpy. `compare` bakes each file without loss and reads the pyramid with GDAL:
heights in metres and no-data must equal those that GDAL reads from the file, the georeference must be the same, and a
refusal must be one line that names the file. GDAL's mask, scale, offset and unit are applied to its values; what hachure
treats as no-data by its own rules (beyond 1000 km, undeclared -32768 and -32767 in 16 bits) is no-data there, too.
"""

import os
import re
import subprocess
import sys
import tempfile

import numpy as np
from osgeo import gdal, osr

gdal.UseExceptions()
gdal.PushErrorHandler("CPLQuietErrorHandler")

# Intended differences, by file name: see docs/formats.md.
KNOWN = [
    (r"alpha_(band|pixel)_(i16|f32)|greyalpha_uint32", "an alpha band is a mask for every type of sample"),
    (r"(?i)jpeg", "JPEG decoders round differently"),
    (r"no_transform", "a CRS without a geotransform"),
    (r"spearfish", "the no-data mark of GRASS, which GDAL reads as 0"),
    (r"terrarium|mapbox", "terrain-RGB, which GDAL reads as colours"),
]
UNITS = {"ft": 0.3048, "foot": 0.3048, "feet": 0.3048, "us survey foot": 1200 / 3937, "us-ft": 1200 / 3937, "km": 1e3,
         "cm": 0.01}
SIZE = (83, 61)  # not a multiple of the size of strips or tiles


def heights(kind=np.float64):
    """Returns hills with steps of a tenth of a metre, between 300 and 2700 m."""
    x, y = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    return np.round(1500 + 800 * np.sin(x * 0.11) + 400 * np.cos(y * 0.17 + x * 0.02), 1).astype(kind)


def make(folder):
    """Writes every variant; prints and skips what this GDAL cannot write."""
    os.makedirs(folder, exist_ok=True)
    driver = gdal.GetDriverByName("GTiff")
    utm = osr.SpatialReference()
    utm.ImportFromEPSG(32610)
    types = {"u8": gdal.GDT_Byte, "u16": gdal.GDT_UInt16, "i16": gdal.GDT_Int16, "u32": gdal.GDT_UInt32,
             "i32": gdal.GDT_Int32, "f32": gdal.GDT_Float32, "f64": gdal.GDT_Float64, "c32": gdal.GDT_CFloat32,
             "ci16": gdal.GDT_CInt16}

    def write(name, kind="i16", options=(), bands=1, srs=utm, place=(594000, 30, 0, 5195000, 0, -30), then=None, data=None):
        path = os.path.join(folder, name + ".tif")
        try:
            file = driver.Create(path, *SIZE, bands, types[kind], list(options))
            if place:
                file.SetGeoTransform(place)
            if srs:
                file.SetProjection(srs.ExportToWkt())
            values = heights() if data is None else data
            if kind == "u8":
                values = values / 12
            for band in range(bands):
                file.GetRasterBand(band + 1).WriteArray((values + band).astype(gdal_type(file)))
            if then:
                then(file)
            file.FlushCache()
            file = None
        except Exception as error:  # this GDAL lacks a codec
            print(f"not made: {name}: {error}", file=sys.stderr)
            if os.path.exists(path):
                os.remove(path)

    def gdal_type(file):
        from osgeo import gdal_array
        return gdal_array.GDALTypeCodeToNumericTypeCode(file.GetRasterBand(1).DataType)

    codecs = ["NONE", "LZW", "PACKBITS", "DEFLATE", "ZSTD", "LZMA", "LERC", "LERC_DEFLATE", "LERC_ZSTD"]
    layouts = {"strip": ["BLOCKYSIZE=16"], "one": [f"BLOCKYSIZE={SIZE[1]}"], "row": ["BLOCKYSIZE=1"],
               "tile": ["TILED=YES", "BLOCKXSIZE=32", "BLOCKYSIZE=16"]}
    for codec in codecs:
        for layout, options in layouts.items():
            for kind in ["u8", "i16", "u16", "i32", "u32", "f32", "f64"]:
                write(f"{codec}_{layout}_{kind}".lower(), kind, [f"COMPRESS={codec}", *options])
        if codec in ("LZW", "DEFLATE", "ZSTD", "LZMA"):
            for kind in ["u8", "i16", "u16", "i32", "f32", "f64"]:
                write(f"{codec}_p2_{kind}".lower(), kind, [f"COMPRESS={codec}", "PREDICTOR=2", "BLOCKYSIZE=16"])
            for kind in ["f32", "f64"]:
                write(f"{codec}_p3_{kind}".lower(), kind, [f"COMPRESS={codec}", "PREDICTOR=3", "TILED=YES"])
        for inter in ["PIXEL", "BAND"]:
            for bands in [2, 4]:
                options = [f"COMPRESS={codec}", f"INTERLEAVE={inter}", "BLOCKYSIZE=16", "PHOTOMETRIC=MINISBLACK"]
                write(f"{codec}_{inter}_{bands}bands".lower(), "i16", options, bands)
        for order in ["BIG", "LITTLE"]:
            write(f"{codec}_{order}_big".lower(), "i16", [f"COMPRESS={codec}", f"ENDIANNESS={order}", "BIGTIFF=YES"])
            write(f"{codec}_{order}_f64".lower(), "f64", [f"COMPRESS={codec}", f"ENDIANNESS={order}"])
    for bits in [1, 2, 3, 4, 5, 6, 7]:
        write(f"nbits_{bits}", "u8", [f"NBITS={bits}"], data=heights() % (1 << bits) * 12)
    for bits in [9, 10, 11, 12, 13, 14, 15]:
        for order in ["BIG", "LITTLE"]:
            write(f"nbits_{bits}_{order}".lower(), "u16", [f"NBITS={bits}", f"ENDIANNESS={order}"], data=heights() % (1 << bits))
    for bits in [17, 20, 24, 31]:
        for order in ["BIG", "LITTLE"]:
            write(f"nbits_{bits}_{order}".lower(), "u32", [f"NBITS={bits}", f"ENDIANNESS={order}"])
    for bits in [16, 24]:
        for codec in ["NONE", "DEFLATE"]:
            for order in ["BIG", "LITTLE"]:
                options = [f"NBITS={bits}", f"COMPRESS={codec}", f"ENDIANNESS={order}"]
                write(f"float_{bits}_{codec}_{order}".lower(), "f32", options)
    write("float_16_p3", "f32", ["NBITS=16", "COMPRESS=DEFLATE", "PREDICTOR=3"])
    write("nbits_12_2bands", "u16", ["NBITS=12"], 2, data=heights() % 4000)
    write("signed_byte", "u8", ["PIXELTYPE=SIGNEDBYTE"])
    write("jpeg_u8", "u8", ["COMPRESS=JPEG", "TILED=YES"])
    write("jpeg_strip_u8", "u8", ["COMPRESS=JPEG", "BLOCKYSIZE=16"])
    write("webp_rgb", "u8", ["COMPRESS=WEBP", "WEBP_LOSSLESS=YES"], 3)
    write("ccitt", "u8", ["NBITS=1", "COMPRESS=CCITTFAX4"], data=heights() % 2 * 12)
    write("complex_f32", "c32")
    write("complex_i16", "ci16")
    write("minis_white", "i16", ["PHOTOMETRIC=MINISWHITE"])
    write("rgb", "u8", ["PHOTOMETRIC=RGB"], 3)
    write("palette", "u8", ["PHOTOMETRIC=PALETTE"])

    # Files that omit some of their blocks.
    for value in [None, -9999]:
        for layout in ["strip", "tile"]:
            path = os.path.join(folder, f"sparse_{layout}_{value}.tif")
            file = driver.Create(path, *SIZE, 1, gdal.GDT_Float32, ["SPARSE_OK=TRUE", "COMPRESS=DEFLATE", *layouts[layout]])
            file.SetGeoTransform((594000, 30, 0, 5195000, 0, -30))
            file.SetProjection(utm.ExportToWkt())
            if value is not None:
                file.GetRasterBand(1).SetNoDataValue(value)
            file.GetRasterBand(1).WriteArray(heights(np.float32)[:16], 0, 16)
            file = None

    # No-data.
    def no_data(value):
        return lambda file: file.GetRasterBand(1).SetNoDataValue(value)

    holes = heights()
    holes[10:20, 15:40] = -9999
    write("nodata_i16", "i16", then=no_data(-9999), data=holes)
    write("nodata_f32_decimals", "f32", then=no_data(-9999.1), data=np.where(holes < 0, -9999.1, holes))
    write("nodata_f64_decimals", "f64", then=no_data(-9999.1), data=np.where(holes < 0, -9999.1, holes))
    write("nodata_nan", "f32", then=no_data(float("nan")), data=np.where(holes < 0, np.nan, holes))
    write("nodata_nan_undeclared", "f32", data=np.where(holes < 0, np.nan, holes))
    write("nodata_beyond_type", "u16", then=no_data(-9999), data=np.abs(holes))
    write("nodata_lowest_f32", "f32", then=no_data(-3.4028234663852886e38), data=np.where(holes < 0, -3.4028234663852886e38, holes))
    write("nodata_zero", "i16", then=no_data(0), data=np.where(holes < 0, 0, holes))
    write("nodata_fraction_i16", "i16", then=no_data(-9999.5), data=np.where(holes < 0, -9999, holes))

    def mask(values=None):
        def then(file):
            file.CreateMaskBand(gdal.GMF_PER_DATASET)
            shown = np.full(SIZE[::-1], 255, np.uint8)
            shown[5:25, 10:50] = 0
            file.GetRasterBand(1).GetMaskBand().WriteArray(shown)
        return then

    for where in ["YES", "NO"]:
        gdal.SetConfigOption("GDAL_TIFF_INTERNAL_MASK", where)
        name = "internal" if where == "YES" else "msk"
        for codec in ["NONE", "DEFLATE", "LZW", "LZMA", "LERC"]:
            write(f"mask_{name}_{codec}".lower(), "f32", [f"COMPRESS={codec}"], then=mask())
        write(f"mask_{name}_tiled", "i16", ["TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16", "COMPRESS=DEFLATE"], then=mask())
        write(f"mask_{name}_nodata", "i16", then=lambda file: (mask()(file), no_data(-9999)(file)), data=holes)
        write(f"mask_{name}_big_endian", "i16", ["ENDIANNESS=BIG", "BIGTIFF=YES"], then=mask())
    gdal.SetConfigOption("GDAL_TIFF_INTERNAL_MASK", None)

    def alpha(file):
        shown = np.full(SIZE[::-1], 255, np.uint8)
        shown[5:25, 10:50] = 0
        file.GetRasterBand(file.RasterCount).WriteArray(shown)
    for inter in ["PIXEL", "BAND"]:
        for kind in ["u8", "u16", "i16", "f32"]:
            write(f"alpha_{inter}_{kind}".lower(), kind, ["ALPHA=YES", f"INTERLEAVE={inter}", "COMPRESS=LZW"], 2, then=alpha)
    write("alpha_plain_u16", "u16", ["ALPHA=YES"], 2, then=alpha)
    cog = gdal.GetDriverByName("COG")
    for source in ["mask_internal_deflate", "mask_msk_deflate", "alpha_pixel_u16", "nodata_i16"]:
        for codec in ["DEFLATE", "LZW", "ZSTD", "LERC"]:
            path = os.path.join(folder, source + ".tif")
            if os.path.exists(path):
                cog.CreateCopy(os.path.join(folder, f"cog_{source}_{codec.lower()}.tif"), gdal.Open(path),
                               options=[f"COMPRESS={codec}", "BLOCKSIZE=128"])

    # Scale, offset and unit.
    def meaning(scale=None, offset=None, unit=None):
        def then(file):
            band = file.GetRasterBand(1)
            if scale is not None:
                band.SetScale(scale)
            if offset is not None:
                band.SetOffset(offset)
            if unit is not None:
                band.SetUnitType(unit)
        return then
    write("scale_offset", "i16", then=meaning(0.1, -50))
    write("offset_alone", "i16", then=meaning(None, 12.5))
    for unit in ["m", "ft", "US survey foot", "metre", "foot"]:
        write("unit_" + unit.replace(" ", "_"), "i16", then=meaning(None, None, unit))

    # Georeferences.
    def crs(text):
        reference = osr.SpatialReference()
        reference.SetFromUserInput(text)
        return reference
    degrees = (-121.95, 1 / 1200, 0, 46.98, 0, -1 / 1200)
    for name, text, place in [
        ("wgs84", "EPSG:4326", degrees), ("nad83", "EPSG:4269", degrees), ("lv95", "EPSG:2056", (2600000, 10, 0, 1200000, 0, -10)),
        ("us_feet", "EPSG:2263", (980000, 30, 0, 200000, 0, -30)), ("mercator", "EPSG:3857", (1e6, 30, 0, 6e6, 0, -30)),
        ("egm2008", "EPSG:32610+3855", (594000, 30, 0, 5195000, 0, -30)), ("navd88_feet", "EPSG:26910+6360", (594000, 30, 0, 5195000, 0, -30)),
        ("navd88", "EPSG:26910+5703", (594000, 30, 0, 5195000, 0, -30)), ("esri_102003", "ESRI:102003", (-2e6, 90, 0, 3e5, 0, -90)),
        ("proj_laea", "+proj=laea +lat_0=46 +lon_0=8 +units=m", (0, 25, 0, 0, 0, -25)),
        ("proj_feet", "+proj=tmerc +lat_0=40 +lon_0=-75 +units=us-ft", (0, 25, 0, 0, 0, -25)),
        ("mars", "+proj=longlat +a=3396190 +b=3396190 +no_defs", degrees), ("ntf_grads", "EPSG:4807", (3, 0.001, 0, 50, 0, -0.001)),
        ("three_dimensional", "EPSG:4979", degrees),
    ]:
        for point in ["Area", "Point"]:
            then = (lambda file: file.SetMetadataItem("AREA_OR_POINT", "Point")) if point == "Point" else None
            try:
                write(f"crs_{name}_{point}".lower(), "i16", srs=crs(text), place=place, then=then)
                for flavour in ["ESRI_PE", "GEOTIFF1_1"]:
                    flag = ["GEOTIFF_KEYS_FLAVOR=ESRI_PE"] if flavour == "ESRI_PE" else ["GEOTIFF_VERSION=1.1"]
                    write(f"crs_{name}_{point}_{flavour}".lower(), "i16", flag, srs=crs(text), place=place, then=then)
            except Exception as error:
                print(f"not made: {name}: {error}", file=sys.stderr)
    write("rotated", place=(594000, 26, 15, 5195000, 15, -26))
    write("south_up", place=(594000, 30, 0, 5195000, 0, 30))
    write("west_first", place=(594000, -30, 0, 5195000, 0, -30))
    write("no_place", place=None, srs=None)
    write("no_crs", srs=None)
    write("no_transform", place=None)
    write("world_file", options=["TFW=YES", "PROFILE=BASELINE"])
    write("world_file_upper", options=["PROFILE=BASELINE"])
    base = os.path.join(folder, "world_file_upper")
    for left in [base + ".tif.aux.xml"]:
        if os.path.exists(left):
            os.remove(left)
    with open(base + ".TFW", "w") as file:
        file.write("30\n0\n0\n-30\n594015\n5194985\n")
    write("world_file_and_tags", options=["TFW=YES"])
    points = [gdal.GCP(594000, 5195000, 0, 0, 0), gdal.GCP(596490, 5195000, 0, 83, 0), gdal.GCP(594000, 5193170, 0, 0, 61)]
    write("gcps", place=None, srs=None, then=lambda file: file.SetGCPs(points, utm.ExportToWkt()))
    # Sidecar files. The profile keeps these values out of the tags.
    write("aux_all", options=["PROFILE=BASELINE"], then=no_data(-9999), data=holes)
    write("aux_scale", options=["PROFILE=BASELINE"], then=meaning(0.1, 5, "ft"))
    write("aux_over_tags", then=no_data(-9999), data=holes)
    with open(os.path.join(folder, "aux_over_tags.tif.aux.xml"), "w") as file:
        file.write("<PAMDataset><GeoTransform>600000, 20, 0, 5200000, 0, -20</GeoTransform><PAMRasterBand band=\"1\">"
                   "<NoDataValue>1500</NoDataValue></PAMRasterBand></PAMDataset>")
    for name, options in [("i16", []), ("u16", [])]:
        path = os.path.join(folder, f"nodata_{name}.tif")
        if not os.path.exists(path):
            continue
        for other, extension in [("ENVI", "bin"), ("EHdr", "bil"), ("AAIGrid", "asc"), ("XYZ", "xyz"), ("HFA", "img"),
                                 ("GSBG", "grd"), ("SRTMHGT", "hgt"), ("netCDF", "nc"), ("PNG", "png"), ("KEA", "kea"),
                                 ("RST", "rst"), ("PCRaster", "map"), ("SAGA", "sdat"), ("JP2OpenJPEG", "jp2"), ("VRT", "vrt")]:
            try:
                gdal.GetDriverByName(other).CreateCopy(os.path.join(folder, f"other_{other}.{extension}"), gdal.Open(path), strict=0)
            except Exception as error:
                print(f"not made: {other}: {error}", file=sys.stderr)
    # An Erdas file with an ENVI header of the same name.
    erdas = os.path.join(folder, "other_HFA.img")
    if os.path.exists(erdas):
        with open(erdas, "rb") as file, open(os.path.join(folder, "erdas_with_hdr.img"), "wb") as out:
            out.write(file.read())
        with open(os.path.join(folder, "erdas_with_hdr.hdr"), "w") as file:
            file.write("ENVI\nsamples = 20\nlines = 20\nbands = 1\ndata type = 2\ninterleave = bsq\nbyte order = 0\n")


def said_by_gdal(path):
    """Returns heights in metres with NaN for no-data, the transform to sample centres, and the kind of CRS."""
    file = gdal.Open(path)
    band = file.GetRasterBand(1)
    # GDAL applies the scale and the vertical unit of a sidecar through the band.
    values, shown = band.ReadAsArray(), band.GetMaskBand().ReadAsArray()
    kind = values.dtype
    if np.iscomplexobj(values):
        return None
    flat = values.astype(np.float64)
    void = (shown == 0) | ~np.isfinite(flat)
    if kind == np.int16 and band.GetNoDataValue() is None:
        void |= flat <= -32767
    scale, offset = band.GetScale() or 1.0, band.GetOffset() or 0.0
    unit = UNITS.get((band.GetUnitType() or "m").lower(), 1.0)
    metres = (flat * scale + offset) * unit
    void |= np.abs(metres) > 1e6
    metres[void] = np.nan
    transform = file.GetGeoTransform(can_return_null=True)
    centre = None
    if transform:
        x, a, b, y, c, d = transform
        centre = (x + (a + b) / 2, a, b, y + (c + d) / 2, c, d)
    reference = file.GetSpatialRef()
    crs = "none"
    if reference is not None:
        crs = "geographic" if reference.IsGeographic() else "projected" if reference.IsProjected() else "local"
        if crs == "projected":
            crs += f" {reference.GetLinearUnits():.9g}"
    return metres.astype(np.float32), centre, crs


def said_by_hachure(binary, path, scratch):
    """Returns the same for a bake by hachure, or the line with which hachure refuses the file."""
    out = os.path.join(scratch, "baked.tif")
    for left in (out, out + ".tiles"):
        if os.path.exists(left):
            os.remove(left)
    run = subprocess.run([binary, "bake", path, "-o", out, "--max-error", "0"], capture_output=True, text=True, timeout=120)
    if run.returncode != 0:
        lines = [line for line in run.stderr.strip().splitlines() if line.startswith("hachure: ")]
        return None, lines[-1][9:] if lines else f"status {run.returncode}: {run.stderr[-200:]}"
    metres, centre, crs = said_by_gdal(out)
    return (metres, centre, crs), ""


def compare_one(binary, path, scratch):
    """Returns (verdict, words): same, known, refused, differs, GDAL (GDAL does not open the file), or BAD (a refusal that
    does not name the file)."""
    name = os.path.basename(path)
    try:
        theirs = said_by_gdal(path)
    except Exception as error:
        theirs = str(error).splitlines()[0] if str(error) else "cannot open"
    ours, refusal = said_by_hachure(binary, path, scratch)
    if ours is None:
        verdict = "refused" if os.path.splitext(name)[0] in refusal and len(refusal) < 400 else "BAD"
        return verdict, refusal.replace(os.path.dirname(path) + "/", "") + (f" [GDAL: {theirs}]" if isinstance(theirs, str) else "")
    if theirs is None or isinstance(theirs, str):
        return "GDAL", f"hachure reads it; GDAL: {theirs}"
    (metres, centre, crs), (expected, place, expected_crs) = ours, theirs
    words = []
    if metres.shape != expected.shape:
        return "differs", f"{metres.shape[::-1]} samples, expected {expected.shape[::-1]}"
    same = (np.isnan(metres) & np.isnan(expected)) | (np.abs(metres - expected) <= 1e-6 * np.abs(expected) + 1e-6)
    if not same.all():
        row, column = np.argwhere(~same)[0]
        words.append(f"{(~same).sum()} heights, first ({column}, {row}) {metres[row, column]}, expected {expected[row, column]}")
    if place and (not centre or any(abs(a - b) > 1e-9 * max(1.0, abs(b)) for a, b in zip(centre, place))):
        words.append(f"the transform is {centre}, expected {place}")
    # A grid without a CRS is in metres; where its coordinates can only be degrees, hachure warns.
    if expected_crs != crs and expected_crs not in ("local", "none"):
        words.append(f"the CRS is {crs}, expected {expected_crs}")
    if not words:
        return "same", ""
    known = next((reason for pattern, reason in KNOWN if re.search(pattern, name)), None)
    return ("known", known) if known else ("differs", "; ".join(words))


def compare(binary, folders):
    """Prints a line for each file, and the number of files by verdict."""
    counts = {}
    with tempfile.TemporaryDirectory() as scratch:
        for folder in folders:
            paths = [folder] if os.path.isfile(folder) else sorted(
                os.path.join(where, name) for where, _, names in os.walk(folder) for name in names)
            for path in paths:
                if re.search(r"\.(msk|aux\.xml|tfw|TFW|prj|hdr|toml|ovr|txt|md|json|csv)$", path):
                    continue
                verdict, words = compare_one(binary, path, scratch)
                counts[verdict] = counts.get(verdict, 0) + 1
                print(f"{verdict:8} {os.path.relpath(path, folder) if path != folder else path}  {words}", flush=True)
    print(", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    return 1 if counts.get("differs") or counts.get("BAD") else 0


def golden(paths):
    """Prints sums as src/tests/source.rs computes them."""
    for path in paths:
        metres, centre, _ = said_by_gdal(path)
        voids = int(np.isnan(metres).sum())
        flat = np.nan_to_num(metres.astype(np.float64).ravel())
        weights = np.arange(flat.size) % 97 + 1
        x, y = (centre[0], centre[3]) if centre else (0.0, 0.0)
        height, width = metres.shape
        print(f"{path},{width},{height},{voids},{float(flat.sum())!r},{float((flat * weights).sum())!r},{x!r},{y!r}")
    return 0


if __name__ == "__main__":
    if len(sys.argv) >= 3 and sys.argv[1] == "make":
        make(sys.argv[2])
    elif len(sys.argv) >= 4 and sys.argv[1] == "compare":
        sys.exit(compare(sys.argv[2], sys.argv[3:]))
    elif len(sys.argv) >= 3 and sys.argv[1] == "golden":
        sys.exit(golden(sys.argv[2:]))
    else:
        sys.exit(__doc__)
