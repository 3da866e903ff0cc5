"""Draws terrain as ink, pencil, wash or print.

Five lines draw an array of heights::

    import numpy as np, hachure
    y, x = np.mgrid[-1:1:400j, -1:1:600j]
    heights_m = 900 * np.exp(-4 * (x**2 + y**2)) * (1 + 0.2 * np.sin(12 * x) * np.cos(9 * y))
    picture = hachure.draw(heights_m, spacing_m=10, style="engraving", size=(900, 600))
    picture.save("hill.png")

- :func:`draw` draws one picture. A :class:`World` is opened once for many.
- :class:`Style` is a mapping of all parameters; :func:`styles` lists the presets.
- :class:`Camera` and :class:`Path` say from where the land is seen, :func:`film` flies along a path.
- :func:`hillshade`, :func:`tone` and :func:`slope` return arrays for further work.
- :func:`bench` measures what styles cost.

Options of the program are keywords: ``--sea-level 300`` is ``sea_level=300``. Pictures are those of the program, bit for
bit. Errors are :class:`HachureError`, with the one line that the program prints; its warnings are
:class:`HachureWarning`.

Units: heights and distances in metres, angles in degrees, sizes in pixels. Arrays are in the order of a picture: the first
row is the uppermost, and the first axis is the rows.
"""

from __future__ import annotations

import json
import math
import os
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _hachure
from ._hachure import HachureError, __version__

__all__ = [
    "Camera",
    "HachureError",
    "HachureWarning",
    "Parameter",
    "Path",
    "Picture",
    "Style",
    "World",
    "bench",
    "draw",
    "film",
    "hillshade",
    "layers",
    "read_png",
    "render",
    "slope",
    "styles",
    "tone",
    "__version__",
]

HachureError.__module__ = "hachure"


class HachureWarning(UserWarning):
    """The program would print this as a warning: the picture was drawn, but not all of it as requested."""


#: What can be drawn: a path, an address, the name of a built-in scene, an array, or an object with heights.
Dem = Any
#: A size in pixels, width first.
Size = Union[tuple[int, int], str]


def _warn(stacklevel: int = 3) -> None:
    for message in _hachure.take_warnings():
        warnings.warn(message, HachureWarning, stacklevel=stacklevel + 1)


def _text(value: Any) -> str:
    """Returns a value as the command line takes it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (np.integer, np.floating)):
        value = value.item()
    if isinstance(value, float) and value.is_integer() and abs(value) < 2**53:
        return str(int(value))
    if isinstance(value, (str, int, float, Camera)):
        return str(value)
    if isinstance(value, os.PathLike):
        return str(os.fspath(value))
    if isinstance(value, (Sequence, np.ndarray)):
        return ",".join(_text(part) for part in value)
    raise HachureError(f"{value!r}: cannot be an option; it must be a text, a number, a sequence or a flag")


#: Options that the package sets itself, or that only make sense in a terminal.
_OWN = {"output", "o", "json", "like", "adapter", "verbose", "help", "version"}

#: Options that may be repeated: a sequence is several values of them.
_REPEATED = {"layer", "set"}


def _words(options: Mapping[str, Any]) -> list[str]:
    """Returns keywords as words of the command line: ``sea_level=3`` is ``--sea-level=3``."""
    words = []
    for key, value in options.items():
        name = key.rstrip("_").replace("_", "-")
        if key in _OWN:
            raise HachureError(f"{key}: is an option of the program only")
        if value is None or value is False:
            continue
        repeated = key in _REPEATED and isinstance(value, Sequence) and not isinstance(value, str)
        for part in value if repeated else [value]:
            words.append(f"--{name}" if part is True else f"--{name}={_text(part)}")
    return words


def _size(size: Size | None) -> str | None:
    if size is None or isinstance(size, str):
        return size
    try:
        width, height = size
    except (TypeError, ValueError):
        raise HachureError(f"size: {size!r} must be (width, height) in pixels, like (1280, 720)") from None
    return f"{_text(width)}x{_text(height)}"


# Places -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Camera:
    """A camera: position, direction and lens.

    ``x_m`` and ``y_m`` are metres east and north of the middle of the world, ``z_m`` is the height in metres, or above the
    ground if ``above_ground``. ``yaw_deg`` is clockwise from north, ``pitch_deg`` above the horizon, and ``fov_deg`` is the
    vertical field of view.

    ``str(camera)`` is what ``hachure render --camera`` takes, and :meth:`parse` reads it.
    """

    x_m: float
    y_m: float
    z_m: float
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    fov_deg: float = 50.0
    above_ground: bool = False

    @classmethod
    def parse(cls, text: str) -> Camera:
        """Reads ``x,y,z,yaw,pitch,fov``, with a height above the ground as ``+h``."""
        fields = [field.strip() for field in text.split(",")]
        if len(fields) != 6:
            raise HachureError(f"a camera is x,y,z,yaw,pitch,fov (6 numbers), but this has {len(fields)}")
        try:
            numbers = [float(field) for field in fields]
        except ValueError:
            raise HachureError(f"{text!r}: a camera is x,y,z,yaw,pitch,fov (6 numbers)") from None
        x_m, y_m, z_m, yaw_deg, pitch_deg, fov_deg = numbers
        return cls(x_m, y_m, z_m, yaw_deg, pitch_deg, fov_deg, fields[2].startswith("+"))

    def __str__(self) -> str:
        z = ("+" if self.above_ground else "") + _number(self.z_m)
        angles = (self.yaw_deg, self.pitch_deg, self.fov_deg)
        return ",".join([_number(self.x_m), _number(self.y_m), z, *map(_number, angles)])

    def moved(self, **values: float) -> Camera:
        """Returns the camera with other values, such as ``yaw_deg=90``."""
        return replace(self, **values)  # type: ignore[arg-type]


def _number(value: float) -> str:
    value = float(value)
    if not math.isfinite(value):
        raise HachureError(f"a camera's numbers must be finite, and one is {value}")
    return str(int(value)) if value.is_integer() and abs(value) < 2**53 else repr(value)


class Path:
    """A camera path: cameras at times in seconds, between which the camera moves smoothly.

    ``keys`` is a sequence of ``(time_s, Camera)``. :meth:`save` writes the CSV that ``hachure --path`` takes, with the
    header ``t,x,y,z,yaw,pitch,fov``.
    """

    def __init__(self, keys: Sequence[tuple[float, Camera]]):
        self.keys = [(float(time_s), camera) for time_s, camera in keys]
        if not self.keys:
            raise HachureError("a camera path has at least one key")

    def csv(self) -> str:
        """Returns the path as CSV."""
        rows = [f"{_number(time_s)},{camera}" for time_s, camera in self.keys]
        return "\n".join(["t,x,y,z,yaw,pitch,fov", *rows]) + "\n"

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes the path as a CSV file."""
        _check_free(path, overwrite)
        with open(path, "w" if overwrite else "x", encoding="utf-8", newline="\n") as file:
            file.write(self.csv())

    @classmethod
    def around(
        cls, centre_m: tuple[float, float], radius_m: float, height_m: float, *, seconds: float = 4.0, pitch_deg: float = -20.0,
        fov_deg: float = 45.0, keys: int = 9,
    ) -> Path:
        """Returns a circle around a point (metres east and north), looking at it from ``height_m`` above the ground."""
        at = []
        for i in range(keys):
            yaw_deg = 360.0 * i / (keys - 1)
            angle = math.radians(yaw_deg)
            x_m, y_m = centre_m[0] - radius_m * math.sin(angle), centre_m[1] - radius_m * math.cos(angle)
            camera = Camera(round(x_m, 3), round(y_m, 3), height_m, yaw_deg, pitch_deg, fov_deg, above_ground=True)
            at.append((seconds * i / (keys - 1), camera))
        return cls(at)

    def __len__(self) -> int:
        return len(self.keys)

    def __repr__(self) -> str:
        return f"Path({len(self.keys)} keys, {self.keys[-1][0] - self.keys[0][0]:g} s)"


def _check_free(path: str | os.PathLike[str], overwrite: bool) -> str:
    name = os.fspath(path)
    if not isinstance(name, str):
        raise HachureError(f"{name!r}: a file name must be a text")
    if not overwrite and os.path.lexists(name):
        raise HachureError(f"{name}: exists already; pass overwrite=True to replace it")
    return name


# Pictures ---------------------------------------------------------------------------------------------------------------


class Picture:
    """A picture in memory. A notebook shows it.

    - ``array``: height × width × 4, uint8: sRGB red, green, blue, and an alpha of 255.
    - ``channels``: additional channels by name, each height × width, float32 or uint32 (see :func:`layers`).
    - ``camera``: the :class:`Camera` that drew it.
    - ``transform``: of a map, the affine transform from pixel corners to the reference system, six numbers in the order of
      ``rasterio`` (a, b, c, d, e, f); else None.
    - ``crs``: of a map, the reference system as Well-Known Text; None if the world has none.
    - ``report``: what was drawn: ``wall_ms``, ``triangles``, ``allowed_error_px`` and others.
    """

    def __init__(self, drawn: _hachure.Drawn):
        self.array: npt.NDArray[np.uint8] = drawn.array
        self.channels: dict[str, npt.NDArray[Any]] = drawn.channels
        self.camera = Camera.parse(drawn.camera)
        self.report: dict[str, Any] = drawn.report
        self.crs: str | None = drawn.crs
        self.transform: tuple[float, float, float, float, float, float] | None = None
        if drawn.crs_from_grid is not None:
            x0, a, b, y0, d, e = drawn.crs_from_grid
            # From pixel centres to pixel corners.
            self.transform = (a, b, x0 - 0.5 * (a + b), d, e, y0 - 0.5 * (d + e))
        self._imprint = drawn.imprint
        self._dpi = drawn.dpi

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.array.shape[1], self.array.shape[0]

    def gray(self) -> npt.NDArray[np.float32]:
        """Returns the luma of the picture: height × width, float32, 0 black to 1 white (Rec. 709 weights of sRGB values)."""
        weights = np.array([0.2126, 0.7152, 0.0722], np.float32) / np.float32(255.0)
        return self.array[..., :3].astype(np.float32) @ weights

    def png(self) -> bytes:
        """Returns the picture as the bytes of a PNG."""
        return _hachure.png_of(self.array)

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes the picture as a PNG, with the description of how it was drawn, which ``hachure info`` prints.

        For other formats use :func:`render`. An existing file is replaced only with ``overwrite=True``.
        """
        name = _check_free(path, overwrite)
        if not name.lower().endswith(".png"):
            raise HachureError(f"{name}: save writes .png only; hachure.render writes the other formats")
        _hachure.write_png(name, np.ascontiguousarray(self.array), self._imprint, self._dpi)

    def _repr_png_(self) -> bytes:
        return self.png()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        array = self.array if dtype is None else self.array.astype(dtype)
        return array.copy() if copy and array is self.array else array

    def __repr__(self) -> str:
        return f"Picture({self.size[0]}x{self.size[1]})"


def read_png(path: str | os.PathLike[str]) -> npt.NDArray[np.uint8]:
    """Returns the pixels of a PNG: height × width × 4, uint8."""
    return _hachure.read_png(os.fspath(path))


# Styles -----------------------------------------------------------------------------------------------------------------


def styles() -> list[str]:
    """Returns the names of the presets."""
    return list(_hachure.style_names())


@dataclass(frozen=True)
class Parameter:
    """The definition of a parameter of a style, and its value in one style.

    ``value`` is None if the style lacks the section. ``range`` says the allowed values in words; ``least`` and ``most`` are
    the ends of a number's range, and ``choices`` the allowed names. ``unit`` is for example ``px`` or ``°``.
    """

    key: str
    value: Any
    is_set: bool
    kind: str
    unit: str | None
    range: str
    least: float | None
    most: float | None
    choices: list[str] | None
    is_required: bool
    default: Any
    help: str


class Style(Mapping[str, Any]):
    """A style: a mapping from the keys of its parameters to their values.

    ``Style("engraving")`` is a preset, ``Style("mine.toml")`` a file, and ``Style("ink", {"strokes.width_px": 2})`` has other
    values at some keys; keyword arguments are sections: ``Style("ink", paper={"color": "#fff8e8"})``. A style does not
    change: :meth:`with_values` returns another one.

    ``style["paper.color"]`` is a value, ``style.paper.color`` too: ``dir(style)`` and the Tab key list sections and keys.
    ``style.parameter("paper.color")`` has its definition: help, unit, range, default.

    Errors: :class:`HachureError` for an unknown name or key, and for a value out of range.
    """

    def __init__(self, name: str | os.PathLike[str] = "ink", values: Mapping[str, Any] | None = None, **sections: Any):
        self._style = _hachure.Style.load(os.fspath(name), _values(values, sections))
        self._known: dict[str, Parameter] | None = None

    @classmethod
    def _of(cls, style: _hachure.Style) -> Style:
        this = cls.__new__(cls)
        this._style = style
        this._known = None
        return this

    @classmethod
    def parse(cls, text: str, name: str = "style") -> Style:
        """Reads a style from TOML text. Errors call it ``name``."""
        return cls._of(_hachure.Style.parse(name, text))

    @classmethod
    def of(cls, style: Style | str | os.PathLike[str] | Mapping[str, Any]) -> Style:
        """Returns a style, from a style, a preset, a file, or a dictionary.

        A dictionary has the keys of a style, flat or nested, and may name the style that it changes at ``"extends"``
        (``"ink"`` if it does not).
        """
        if isinstance(style, Style):
            return style
        if isinstance(style, Mapping):
            values = dict(style)
            return cls(values.pop("extends", "ink"), values)
        if not isinstance(style, (str, os.PathLike)):
            raise HachureError(f"style: {style!r} must be a preset, a file, a dictionary or a Style")
        return cls(style)

    def with_values(self, values: Mapping[str, Any] | None = None, **sections: Any) -> Style:
        """Returns the style with other values at some keys."""
        return self._of(self._style.with_values(_values(values, sections)))

    @property
    def name(self) -> str:
        """The preset's name, or the path of the file."""
        return self._style.name

    @property
    def description(self) -> str:
        """One sentence about the style."""
        return self._style.description

    def text(self) -> str:
        """Returns the style as TOML with every parameter that has a value. :meth:`parse` reads it."""
        return self._style.text()

    def save(self, path: str | os.PathLike[str], *, overwrite: bool = False) -> None:
        """Writes the style as a TOML file, which ``--style`` takes."""
        _check_free(path, overwrite)
        with open(path, "w" if overwrite else "x", encoding="utf-8", newline="\n") as file:
            file.write(self.text())

    def parameters(self) -> dict[str, Parameter]:
        """Returns the definitions of all parameters by their keys, also of those whose section the style lacks."""
        if self._known is None:
            rows = json.loads(self._style.parameters())
            self._known = {row["key"]: Parameter(**row) for row in rows}
        return self._known

    def parameter(self, key: str) -> Parameter:
        """Returns the definition of a parameter."""
        try:
            return self.parameters()[key]
        except KeyError:
            raise HachureError(f"{key}: the style {self.name} has no such parameter") from None

    def _values(self) -> dict[str, Any]:
        known = self.parameters()
        return {
            key: it.value
            for key, it in known.items()
            if it.value is not None and it.kind not in ("section", "layers") and not isinstance(it.value, dict)
            and not (it.kind == "list" and it.value and isinstance(it.value[0], dict))
        }

    def __getitem__(self, key: str) -> Any:
        return self._values()[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values())

    def __len__(self) -> int:
        return len(self._values())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Style) and self.text() == other.text()

    def __hash__(self) -> int:
        return hash(self.text())

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return _Section(self, "").__getattr__(name)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *_Section(self, "").__dir__()})

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def _repr_html_(self) -> str:
        def cell(value: Any) -> str:
            return str(value).replace("&", "&amp;").replace("<", "&lt;")

        rows = "".join(
            f"<tr><td><code>{cell(it.key)}</code></td><td>{cell(self[it.key])}</td><td>{cell(it.unit or '')}</td>"
            f"<td>{cell(it.range)}</td><td>{cell(it.help)}</td></tr>"
            for it in map(self.parameter, self)
        )
        head = "<tr><th>key</th><th>value</th><th>unit</th><th>allowed</th><th>help</th></tr>"
        return f"<p><b>{cell(self.name)}</b>: {cell(self.description)}</p><table>{head}{rows}</table>"

    def __repr__(self) -> str:
        return f"Style({self.name!r}, {len(self)} values)"


class _Section:
    """A section of a style, for completion with dots."""

    def __init__(self, style: Style, key: str):
        self._style, self._key = style, key

    def _within(self) -> dict[str, str]:
        start = f"{self._key}." if self._key else ""
        keys = {}
        for key in self._style:
            if key.startswith(start):
                name = key[len(start) :].split(".")[0]
                keys[name] = start + name
        return keys

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        key = self._within().get(name)
        if key is None:
            where = f"the section {self._key}" if self._key else "the style"
            raise AttributeError(f"{where} has no {name!r}; it has {', '.join(self._within())}")
        return self._style[key] if key in self._style else _Section(self._style, key)

    def __dir__(self) -> list[str]:
        return [name for name in self._within() if name.isidentifier()]

    def __repr__(self) -> str:
        return f"{self._style!r}.{self._key}: {', '.join(self._within())}"


def _values(values: Mapping[str, Any] | None, sections: Mapping[str, Any]) -> list[str]:
    """Returns values, flat or nested, as the command line's ``--set`` takes them."""

    def toml(value: Any) -> str:
        if isinstance(value, (np.integer, np.floating, np.bool_)):
            value = value.item()
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, (int, float)):
            return repr(value)
        if isinstance(value, str):
            return json.dumps(value, ensure_ascii=False)
        if isinstance(value, Mapping):
            return "{" + ", ".join(f"{json.dumps(key)} = {toml(part)}" for key, part in value.items()) + "}"
        if isinstance(value, (Sequence, np.ndarray)):
            return "[" + ", ".join(toml(part) for part in value) + "]"
        raise HachureError(f"{value!r}: cannot be the value of a style's parameter")

    found: list[str] = []

    def collect(prefix: str, of: Mapping[str, Any]) -> None:
        for key, value in of.items():
            if not isinstance(key, str):
                raise HachureError(f"{key!r}: the key of a style's parameter must be a text")
            if isinstance(value, Mapping):
                collect(f"{prefix}{key}.", value)
            else:
                found.append(f"{prefix}{key}={toml(value)}")

    collect("", values or {})
    collect("", sections)
    return found


# Worlds -----------------------------------------------------------------------------------------------------------------


def _crs_text(crs: Any) -> str | None:
    """Returns a reference system as a code or as Well-Known Text."""
    if crs is None or (isinstance(crs, str) and not crs.strip()):
        return None
    if isinstance(crs, (int, np.integer)):
        return f"EPSG:{crs}"
    if isinstance(crs, str):
        return crs
    to_epsg = getattr(crs, "to_epsg", None)
    code = to_epsg() if callable(to_epsg) else None
    if code is not None:
        return f"EPSG:{code}"
    to_wkt = getattr(crs, "to_wkt", None)
    if callable(to_wkt):
        return to_wkt() or None
    raise HachureError(f"crs: {crs!r} must be an EPSG code, Well-Known Text, or an object with to_wkt()")


def _grid_transform(transform: Any) -> list[float]:
    """Returns GDAL's geotransform of sample centres, from the six numbers of pixel corners in the order of rasterio."""
    try:
        a, b, c, d, e, f = (float(number) for number in list(transform)[:6])
    except (TypeError, ValueError):
        raise HachureError(f"transform: {transform!r} must have six numbers (a, b, c, d, e, f), as rasterio's Affine") from None
    return [c + 0.5 * (a + b), a, b, f + 0.5 * (d + e), d, e]


def _transform_of_axes(x: Any, y: Any) -> list[float]:
    """Returns GDAL's geotransform of sample centres from the coordinates of columns and rows."""
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    if x.ndim != 1 or y.ndim != 1 or len(x) < 2 or len(y) < 2:
        raise HachureError("the coordinates x and y must each have at least two values along one axis")
    steps = []
    for name, axis in (("x", x), ("y", y)):
        step = (axis[-1] - axis[0]) / (len(axis) - 1)
        even = axis[0] + step * np.arange(len(axis))
        if not np.all(np.isfinite(axis)) or step == 0 or np.max(np.abs(even - axis)) > 0.01 * abs(step):
            raise HachureError(f"the coordinates {name} are not evenly spaced; resample the heights to an even grid")
        steps.append(float(step))
    return [float(x[0]), steps[0], 0.0, float(y[0]), 0.0, steps[1]]


def _heights(array: Any) -> npt.NDArray[np.float32]:
    """Returns heights as a float32 array; masked samples are NaN. A C-contiguous float32 array is not copied here."""
    if isinstance(array, np.ma.MaskedArray):
        # A mask without a masked sample needs no copy.
        mask = np.ma.getmaskarray(array)
        array = np.where(mask, np.float32(np.nan), array.data.astype(np.float32, copy=False)) if mask.any() else array.data
    array = np.asarray(array)
    if array.ndim == 3 and array.shape[0] == 1:
        array = array[0]
    if array.ndim != 2:
        raise HachureError(f"heights must be an array of rows and columns, and this has the shape {array.shape}")
    if array.dtype.kind not in "fiu":
        raise HachureError(f"heights must be numbers, and these are {array.dtype}")
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    with np.errstate(over="ignore", invalid="ignore"):
        heights: npt.NDArray[np.float32] = np.ascontiguousarray(array, np.float32)
    return heights


class World:
    """A world that is opened once and drawn many times.

    ``dem`` is one of

    - a path or an address of a DEM, a folder, a scene file or a model, or the name of a built-in scene, as for the program;
      None is the built-in world,
    - an array of heights in metres, rows × columns, the first row in the north (or where ``transform`` says); NaN, masked
      samples and ``nodata`` are no-data,
    - an ``xarray.DataArray``, with ``rioxarray``'s accessor, or with ``x`` and ``y`` coordinates and the attribute ``crs``,
    - an open ``rasterio`` dataset, whose first band is read.

    ``transform`` has six numbers (a, b, c, d, e, f) in the order of ``rasterio``: ``x = a*column + b*row + c`` and
    ``y = d*column + e*row + f`` of pixel corners, in units of ``crs``. ``crs`` is an EPSG code, Well-Known Text, or an
    object with ``to_wkt()``. Without a transform, samples are ``spacing_m`` metres apart, and the world has no position on
    the earth.

    Other keywords are the options of the program for worlds: ``exaggeration``, ``sun=(azimuth, elevation)``, ``haze``,
    ``sea_level``, ``trees``, ``date``, ``place``, ``voids`` and so on. ``adapter`` is the GPU: "best", "software", or a part
    of its name.

    Copies: a C-contiguous float32 array is read once, into the world's own heights (4 bytes per sample, and 1⅓ for coarser
    levels); nothing in between copies it. Other arrays are converted to float32 first. The world does not change when the
    array is changed later.

    Threads: Python's other threads run while a world is opened and drawn. Calls of one world wait for each other.

    Errors: :class:`HachureError` for what cannot be read or drawn.
    """

    def __init__(
        self,
        dem: Dem = None,
        *,
        transform: Sequence[float] | None = None,
        crs: Any = None,
        nodata: float | None = None,
        spacing_m: float | None = None,
        adapter: str = "best",
        **options: Any,
    ):
        given = {"transform": transform, "crs": crs, "spacing_m": spacing_m}
        array, grid, of_crs, of_nodata = _read(dem, transform, crs, nodata, spacing_m)
        if array is None:
            wrong = next((name for name, value in given.items() if value is not None), None)
            if wrong is not None:
                raise HachureError(f"{wrong}: is for arrays; a file has its own")
            words = _words({"nodata": nodata, **options} if nodata is not None else options)
            name = "" if dem is None else os.fspath(dem)
            with _Hush():
                self._world = _hachure.World.open(name, words, adapter)
        else:
            with _Hush():
                self._world = _hachure.World.of_heights(array, grid, of_crs, of_nodata, _words(options), adapter)
        _warn()

    @property
    def name(self) -> str:
        """The name of the file, or "heights in memory"."""
        return self._world.name

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the heights."""
        width, height = self._world.size
        return height, width

    @property
    def crs(self) -> str | None:
        """The reference system as Well-Known Text; None if the world has none."""
        return self._world.place[0]

    @property
    def transform(self) -> tuple[float, ...]:
        """The transform from pixel corners to the reference system, in the order of ``rasterio``."""
        x0, a, b, y0, d, e = self._world.place[1]
        return (a, b, x0 - 0.5 * (a + b), d, e, y0 - 0.5 * (d + e))

    def draw(
        self,
        style: Style | str | os.PathLike[str] | Mapping[str, Any] = "ink",
        size: Size | None = None,
        *,
        view: Camera | str | Sequence[float] | None = None,
        map: bool | str | Sequence[float] | None = None,
        layers: str | Sequence[str] | None = None,
        **options: Any,
    ) -> Picture:
        """Draws a picture.

        - ``style``: a preset, a file, a dictionary or a :class:`Style`.
        - ``size``: width and height in pixels; (1280, 720) if it is not given.
        - ``view``: a :class:`Camera`. Without it, the most prominent summit is seen as ``hachure render`` sees it.
        - ``map``: True for a map of all of the land, or ``(east_m, north_m, width_m)``.
        - ``layers``: additional channels: depth, position, normal, surface, lsa, strokes, tone, hatch (see :func:`layers`).
        - Other keywords are the options of ``hachure render``: ``look_at=(lat, lon)``, ``at=(lat, lon)``, ``title``, ``names``,
          ``samples``, ``dpi``, ``paper``, ``eyes``, ``lod_error``, ``sun``, ``haze``, ``exaggeration`` and so on.

        Returns a :class:`Picture`: the pixels that the program writes with the same options, bit for bit.

        Errors: :class:`HachureError`.
        """
        options = _picture_options(size, view, map, layers, options)
        if "path" in options:
            raise HachureError("path: draws many pictures; use hachure.film")
        pictures: list[Picture] = []
        self._world.draw(_options_style(style, options)._style, _words(options), lambda drawn: pictures.append(Picture(drawn)))
        _warn()
        return pictures[0]

    def render(
        self,
        output: str | os.PathLike[str],
        style: Style | str | os.PathLike[str] | Mapping[str, Any] = "ink",
        size: Size | None = None,
        *,
        view: Camera | str | Sequence[float] | None = None,
        map: bool | str | Sequence[float] | None = None,
        overwrite: bool = False,
        **options: Any,
    ) -> None:
        """Draws into a file, as ``hachure render -o OUTPUT`` does: .png, .jpg, .exr, .svg, .pdf, with ``map`` .tif and
        .geojson, with ``path`` .mp4, .gif or frames named by a pattern like ``dir/%05d.png``.

        Replaces an existing output only with ``overwrite=True``.
        """
        output = _check_free(output, overwrite)
        options = _picture_options(size, view, map, None, options)
        if overwrite:
            options["overwrite"] = True
        style = _options_style(style, options)
        with _PathFile(options):
            self._world.write(output, style._style, _words(options))
        _warn()

    def film(
        self,
        path: Path | str | os.PathLike[str],
        output: str | os.PathLike[str] | None = None,
        style: Style | str | os.PathLike[str] | Mapping[str, Any] = "ink",
        size: Size | None = None,
        *,
        fps: float = 30,
        on_frame: Callable[[Picture], None] | None = None,
        overwrite: bool = False,
        **options: Any,
    ) -> list[Picture]:
        """Flies along a camera path.

        ``path`` is a :class:`Path`, a CSV file, or a built-in path (tour, valley, teleport, ascent). With ``output`` (.mp4,
        which needs ffmpeg, .gif, or a pattern of frames) the film is written, and the list is empty. Without it the frames
        are returned, or passed to ``on_frame`` one by one, which must not draw.
        """
        if output is not None:
            if on_frame is not None:
                raise HachureError("on_frame: is for a film without output")
            self.render(output, style, size, overwrite=overwrite, path=path, fps=fps, **options)
            return []
        options = _picture_options(size, None, None, options.pop("layers", None), {**options, "path": path, "fps": fps})
        frames: list[Picture] = []
        take = on_frame or frames.append
        style = _options_style(style, options)
        with _PathFile(options):
            self._world.draw(style._style, _words(options), lambda drawn: take(Picture(drawn)))
        _warn()
        return frames

    def bench(
        self,
        path: Path | str | os.PathLike[str],
        output: str | os.PathLike[str],
        styles: Sequence[str] = ("ink",),
        size: Size | None = None,
        *,
        frames: int | None = None,
        **options: Any,
    ) -> dict[str, Any]:
        """Measures what styles cost along a camera path, as ``hachure bench`` does.

        Writes report.json, report.html and frames.csv into the folder ``output``, and returns the report as a dictionary.
        Worlds with a name only: heights in memory must be saved to a file.
        """
        options = {**options, "path": path, "styles": list(styles), "size": _size(size), "frames": frames}
        with _PathFile(options):
            report = self._world.bench([*_words(options), f"--output={os.fspath(output)}"])
        _warn()
        found: dict[str, Any] = json.loads(report)
        return found

    def __repr__(self) -> str:
        rows, columns = self.shape
        return f"World({self.name!r}, {columns}x{rows} samples)"


class _Hush:
    """On Linux without a desktop, keeps Mesa's driver from writing about XDG_RUNTIME_DIR while a GPU is opened."""

    def __enter__(self) -> None:
        self.is_set = sys.platform == "linux" and not os.environ.get("XDG_RUNTIME_DIR")
        if self.is_set:
            os.environ["XDG_RUNTIME_DIR"] = "/nonexistent"

    def __exit__(self, *_: Any) -> None:
        if self.is_set:
            os.environ.pop("XDG_RUNTIME_DIR", None)


class _PathFile:
    """A camera path as a file while it is used: a :class:`Path` is written into a temporary folder."""

    def __init__(self, options: dict[str, Any]):
        self.options = options
        self.folder: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> None:
        path = self.options.get("path")
        if isinstance(path, Path):
            self.folder = tempfile.TemporaryDirectory(prefix="hachure-")
            name = os.path.join(self.folder.name, "path.csv")
            path.save(name)
            self.options["path"] = name

    def __exit__(self, *_: Any) -> None:
        if self.folder is not None:
            self.folder.cleanup()


def _options_style(style: Any, options: dict[str, Any]) -> Style:
    """Returns the style; ``set`` in the options gives other values."""
    values = options.pop("set", None)
    of = Style.of(style)
    if values is None:
        return of
    if not isinstance(values, Mapping):
        raise HachureError('set: must be a dictionary, such as {"strokes.width_px": 2}')
    return of.with_values(values)


def _picture_options(size: Any, view: Any, map: Any, layers: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    all = dict(options)
    all["size"] = _size(size)
    if view is not None:
        all["camera"] = view
    if map is not None and map is not False:
        all["map"] = map
    if layers is not None:
        all["aov"] = layers if isinstance(layers, str) else ",".join(layers)
    return all


def _read(
    dem: Any, transform: Any, crs: Any, nodata: float | None, spacing_m: float | None
) -> tuple[npt.NDArray[np.float32] | None, list[float], str | None, float | None]:
    """Returns the heights, geotransform, reference system and no-data value of a DEM; no heights for a name."""
    if dem is None or isinstance(dem, (str, os.PathLike)):
        return None, [], None, None
    x = y = None
    heights = dem
    if hasattr(dem, "read") and hasattr(dem, "transform") and hasattr(dem, "crs"):
        # rasterio
        heights = dem.read(1, masked=True)
        transform = dem.transform if transform is None else transform
        crs = dem.crs if crs is None else crs
    elif hasattr(dem, "dims") and hasattr(dem, "coords") and hasattr(dem, "values"):
        heights, x, y, own_crs, own_transform = _of_xarray(dem)
        transform = own_transform if transform is None else transform
        crs = own_crs if crs is None else crs
        nodata = dem.attrs.get("_FillValue", dem.attrs.get("nodata")) if nodata is None else nodata
    heights = _heights(heights)
    rows, columns = heights.shape
    if transform is not None:
        if spacing_m is not None:
            raise HachureError("spacing_m: the transform has the spacing already; give one of them")
        grid = _grid_transform(transform)
    elif spacing_m is None and x is not None and y is not None:
        grid = _transform_of_axes(x, y)
    else:
        spacing = 1.0 if spacing_m is None else float(spacing_m)
        if not (math.isfinite(spacing) and spacing > 0):
            raise HachureError(f"heights in memory: a spacing of {spacing} m is not possible; it must be a finite number above 0")
        grid = [-0.5 * (columns - 1) * spacing, spacing, 0.0, 0.5 * (rows - 1) * spacing, 0.0, -spacing]
    nodata = None if nodata is None or math.isnan(float(nodata)) else float(nodata)
    return heights, grid, _crs_text(crs), nodata


def _of_xarray(dem: Any) -> tuple[Any, Any, Any, Any, Any]:
    """Returns the values, coordinates, reference system and transform of an xarray.DataArray."""
    dims = list(dem.dims)
    if len(dims) == 3 and dem.shape[0] == 1:
        dem = dem[0]
        dims = dims[1:]
    if len(dims) != 2:
        raise HachureError(f"heights must have two dimensions, and this DataArray has {', '.join(map(str, dims))}")
    rows, columns = dims
    if str(rows).lower() in ("x", "lon", "longitude", "easting") or str(columns).lower() in ("y", "lat", "latitude", "northing"):
        dem = dem.transpose()
        rows, columns = columns, rows
    rio = getattr(dem, "rio", None)
    crs = getattr(rio, "crs", None) if rio is not None else None
    crs = dem.attrs.get("crs") if crs is None else crs
    x = dem.coords[columns].values if columns in dem.coords else None
    y = dem.coords[rows].values if rows in dem.coords else None
    # rioxarray keeps the transform of the file, which has more digits than the coordinates.
    transform = None
    reference = dem.coords.get("spatial_ref") if hasattr(dem.coords, "get") else None
    text = reference.attrs.get("GeoTransform") if reference is not None else None
    if text:
        c, a, b, f, d, e = (float(number) for number in str(text).split())
        # A part of the file may have the transform of the whole, and a transposed raster that of the original.
        first = [] if x is None or y is None else [(c + 0.5 * a, x[0], a), (f + 0.5 * e, y[0], e)]
        if all(abs(centre - of_axis) < 0.01 * abs(step) for centre, of_axis, step in first):
            transform = (a, b, c, d, e, f)
    if transform is None and "transform" in dem.attrs:
        transform = dem.attrs["transform"]
    return dem.values, x, y, crs, transform


# Functions --------------------------------------------------------------------------------------------------------------


#: Keywords that only an unopened world takes.
_OPENING = ("transform", "crs", "nodata", "spacing_m", "adapter")
#: Options of the program that decide how a world is opened; an open one is opened again for them.
_OF_WORLD = (
    "voids", "encoding", "height_unit", "height_scale", "height_offset", "tile_rows", "exaggeration", "sea_level", "trees",
    "seed", "water", "layer", "graticule", "date", "place", "trust_scene",
)  # fmt: skip


def _opened(dem: Dem, options: dict[str, Any]) -> World:
    names = _OPENING if isinstance(dem, World) else _OPENING + _OF_WORLD
    own = {key: options.pop(key) for key in names if key in options}
    if isinstance(dem, World):
        if own:
            raise HachureError(f"{next(iter(own))}: the world is open already")
        return dem
    return World(dem, **own)


def draw(
    dem: Dem = None,
    style: Style | str | os.PathLike[str] | Mapping[str, Any] = "ink",
    size: Size | None = None,
    **options: Any,
) -> Picture:
    """Draws heights, and returns a :class:`Picture`.

    ``dem``, ``transform``, ``crs``, ``nodata`` and ``spacing_m`` are those of :class:`World`; a World may be given too. All
    other options are those of :meth:`World.draw`.

    >>> hachure.draw("dem.tif", style="engraving", size=(1600, 900), view=hachure.Camera(0, -3000, 800, pitch_deg=-10))
    """
    return _opened(dem, options).draw(style, size, **options)


def render(dem: Dem, output: str | os.PathLike[str], **options: Any) -> None:
    """Draws into a file: see :meth:`World.render`."""
    _opened(dem, options).render(output, **options)


def film(dem: Dem, path: Path | str | os.PathLike[str], output: Any = None, **options: Any) -> list[Picture]:
    """Flies along a camera path: see :meth:`World.film`."""
    return _opened(dem, options).film(path, output, **options)


def bench(dem: Dem, path: Path | str | os.PathLike[str], output: Any, **options: Any) -> dict[str, Any]:
    """Measures styles along a camera path: see :meth:`World.bench`."""
    return _opened(dem, options).bench(path, output, **options)


#: Channels of :func:`layers`, with what the program calls them.
_CHANNELS = {
    "depth": ["depth.V"],
    "position": ["position.X", "position.Y", "position.Z"],
    "normal": ["normal.X", "normal.Y", "normal.Z"],
    "surface": ["surface.id"],
    "tone": ["tone.V"],
    "hatch": ["hatch.V"],
    "strokes": ["strokes.id"],
}


def layers(
    dem: Dem, names: Sequence[str] = ("depth", "normal", "tone"), style: Any = "plain", size: Size | None = None, **options: Any
) -> dict[str, npt.NDArray[Any]]:
    """Returns what a picture is made of, as arrays: one sample at the centre of each pixel.

    - ``depth``: height × width, float32: metres along the view axis; sky is infinite.
    - ``position``: height × width × 3, float32: metres from the camera, east, north, up; sky is 0.
    - ``normal``: height × width × 3, float32: unit normals, east, north, up; sky is 0.
    - ``tone``: height × width, float32: the tone that the style requests, 0 black to 1 white.
    - ``hatch``: the tone after hatching.
    - ``surface``, ``strokes``: height × width, uint32: numbers of surface patches and of strokes; 0 is none.

    Options are those of :func:`draw`; ``map=True`` gives arrays on a grid of the land.
    """
    names = [names] if isinstance(names, str) else list(names)
    picture = draw(dem, style, size, layers=names, **options)
    found = {}
    for name in names:
        held = [key for key in picture.channels if key.split(".")[0] == name]
        held = _CHANNELS.get(name, held)
        if not all(key in picture.channels for key in held) or not held:
            raise HachureError(f"{name}: the picture has no such channel; it has {', '.join(picture.channels)}")
        parts = [picture.channels[key] for key in held]
        found[name] = parts[0] if len(parts) == 1 else np.stack(parts, axis=-1)
    return found


def _map_size(dem: Dem, size: Size | None) -> Size:
    if size is not None:
        return size
    rows, columns = dem.shape
    return columns, rows


def hillshade(
    dem: Dem, *, sun: tuple[float, float] = (315.0, 45.0), size: Size | None = None, **options: Any
) -> npt.NDArray[np.float32]:
    """Returns the shading of a map under a sun: height × width, float32, 0 in the shade to 1 in full light; NaN without land.

    It is the cosine of the angle between the surface's normal and the direction of the sun (azimuth clockwise from north,
    elevation, in degrees), on the surface that is drawn. ``size`` is that of the DEM if it is not given, and the map shows
    all of the land with a free margin of 1 %; ``map=(east_m, north_m, width_m)`` chooses another area.
    """
    normal = _normals(dem, size, options)
    azimuth, elevation = (math.radians(angle) for angle in sun)
    to_sun = [math.sin(azimuth) * math.cos(elevation), math.cos(azimuth) * math.cos(elevation), math.sin(elevation)]
    shade = np.clip(normal @ np.array(to_sun, np.float32), 0.0, 1.0)
    shade[~normal.any(axis=-1)] = np.nan
    return shade


def slope(dem: Dem, *, size: Size | None = None, **options: Any) -> npt.NDArray[np.float32]:
    """Returns the slope of the land on a map: height × width, float32, degrees; NaN without land."""
    normal = _normals(dem, size, options)
    degrees = np.degrees(np.arccos(np.clip(normal[..., 2], -1.0, 1.0)))
    degrees[~normal.any(axis=-1)] = np.nan
    return degrees


def tone(dem: Dem, style: Any = "pencil", *, size: Size | None = None, **options: Any) -> npt.NDArray[np.float32]:
    """Returns the tone that a style requests on a map: height × width, float32, 0 black to 1 white."""
    world = _opened(dem, options)
    return layers(world, ["tone"], style, _map_size(world, size), **{"map": True, **options})["tone"]


def _normals(dem: Dem, size: Size | None, options: dict[str, Any]) -> npt.NDArray[np.float32]:
    world = _opened(dem, options)
    return layers(world, ["normal"], "plain", _map_size(world, size), **{"map": True, **options})["normal"]
