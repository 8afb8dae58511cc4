"""Decoding: any image source becomes upright 8-bit RGB, or raises an ImageError."""

import io
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import BinaryIO, TypeAlias

import numpy as np
from PIL import Image
from PIL.ExifTags import IFD, Base

from footprints_edge.errors import ImageError
from footprints_edge.foundation.types import Rgb, Size

FORMATS = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")
"""Decoders that an input may reach: Pillow's other decoders only add attack surface."""

_REDUCIBLE = {"JPEG", "MPO"}  # MPO: several JPEGs in one file, as some phones write

MAX_PIXELS = 178_000_000
"""Larger pictures are rejected before any pixel is decoded: half a gigabyte as RGB."""

MAX_BYTES = 512 * 2**20
"""Larger files are rejected: no picture within `MAX_PIXELS` needs more bytes."""

ImageSource: TypeAlias = "str | Path | bytes | BinaryIO | Image.Image | Rgb | DecodedImage"

_UPRIGHT = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}
_ON_ITS_SIDE = {5, 6, 7, 8}

_OTHER_SHAPE = 0.02
"""Difference of the logarithms of two aspect ratios from which one picture is a crop."""


@dataclass(frozen=True, eq=False)
class ReducibleFile:
    """A JPEG file that can be decoded at a half, a quarter or an eighth of its size.

    Attributes:
        data: The encoded bytes.
        label: Name for messages.
        size: (H, W) of the upright picture at full size.
    """

    data: bytes
    label: str
    size: Size

    def decode(self, least: Size) -> Rgb:
        """Decodes the upright picture at the smallest of these sizes that covers `least`.

        Raises:
            ImageError: If the file is damaged.
        """
        with _opened(self.data, self.label) as image:
            return _upright(image, self.label, least)[0]


@dataclass(frozen=True, eq=False)
class DecodedImage:
    """An upright picture and the metadata of its file.

    Attributes:
        pixels: uint8 (h, w, 3), RGB, upright: the whole picture, at full size or reduced.
        name: File name, for naming outputs; None if the source has none.
        path: The source file, which outputs must not overwrite; None if there is none.
        focal_35mm: 35 mm equivalent focal length in millimetres from EXIF, None if not stated.
        file: The JPEG file, if `pixels` were decoded at a reduced size; else None.
    """

    pixels: Rgb
    name: str | None = None
    path: Path | None = None
    focal_35mm: float | None = None
    file: ReducibleFile | None = None

    @property
    def size(self) -> Size:
        """(H, W) of the upright picture at full size."""
        return _size(self.pixels) if self.file is None else self.file.size

    @cached_property
    def rgb(self) -> Rgb:
        """uint8 (H, W, 3): the picture at full size, decoded on first access."""
        return self.at_least(self.size)

    def at_least(self, least: Size) -> Rgb:
        """uint8 (h, w, 3): the picture, no smaller than `least` unless its full size is.

        Fewer pixels are faster to decode and to resize.
        """
        if self.file is None or _covers(_size(self.pixels), least):
            return self.pixels
        return self.file.decode(least)


def decode(source: ImageSource, least_size: Callable[[Size], Size] | None = None) -> DecodedImage:
    """Decodes an image from any source that `Model.predict` accepts.

    All eight EXIF orientations are turned upright, for every source. Transparent pixels become
    white, as viewers show them: their colours are arbitrary. An animation or a multi-page file
    yields its first picture.

    Args:
        source: Path, encoded bytes, binary file object, PIL image, or uint8 array (H, W, 3) in
            RGB order (OpenCV delivers BGR: pass `frame[..., ::-1]`). An array is copied.
        least_size: Function from the upright picture's (H, W) to the size that is needed. A much
            larger JPEG is decoded at a reduced size, but no smaller than this. None decodes at
            full size.

    Returns:
        The upright picture. A `DecodedImage` is returned unchanged.

    Raises:
        ImageError: If the source is missing, not a picture, truncated, larger than
            `MAX_PIXELS`, or an array of another dtype or shape.
    """
    if isinstance(source, DecodedImage):
        return source
    if isinstance(source, np.ndarray):
        return DecodedImage(_checked_array(source))
    if isinstance(source, Image.Image):
        filename = getattr(source, "filename", "")
        path = Path(filename) if isinstance(filename, str) and filename else None
        return _from_pillow(source, path, f"PIL image {path.name if path else ''}".strip())
    if isinstance(source, (str, Path)):
        path = Path(source)
        return _from_bytes(_read(path), path, str(path), least_size)
    if isinstance(source, (bytes, bytearray, memoryview)):
        return _from_bytes(bytes(source), None, "image bytes", least_size)
    if callable(getattr(source, "read", None)):
        filename = getattr(source, "name", None)
        path = Path(filename) if isinstance(filename, str) and filename[:1] != "<" else None
        try:
            data = source.read()
        except (OSError, ValueError) as error:
            raise ImageError(f"{filename or 'the file object'} cannot be read: {error}") from error
        if not isinstance(data, bytes):
            raise ImageError(f"{filename or 'the file object'} yields text; open it with 'rb'")
        return _from_bytes(data, path, str(path) if path else "image file object", least_size)
    raise ImageError(
        f"cannot read an image from {type(source).__name__}; "
        "pass a path, bytes, a binary file object, a PIL image or a uint8 RGB array (H, W, 3)"
    )


def _checked_array(array: Rgb) -> Rgb:
    """A copy of a uint8 RGB array (H, W, 3), so that a reused video buffer cannot change it."""
    if array.ndim != 3 or array.shape[2] != 3:
        raise ImageError(
            f"an image array must have shape (H, W, 3), not {array.shape}; "
            "for grey use np.repeat(grey[..., None], 3, axis=2), for RGBA use rgba[..., :3]"
        )
    if array.dtype != np.uint8:
        raise ImageError(
            f"an image array must be uint8 from 0 to 255, not {array.dtype}; "
            "for floats in [0, 1] use (array * 255).round().astype(np.uint8)"
        )
    _check_size((array.shape[0], array.shape[1]), "the image array")
    return np.array(array, order="C")


def _check_size(size: Size, label: str) -> None:
    height, width = size
    if height < 1 or width < 1:
        raise ImageError(f"{label} is empty: {width} x {height} pixels; both sides need at least 1")
    if height * width > MAX_PIXELS:
        raise ImageError(
            f"{label} is {width} x {height} pixels, more than the {MAX_PIXELS / 1e6:.0f} million "
            "that are safe to decode; scale it down first"
        )


def _read(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        if len(data) > MAX_BYTES:
            raise ImageError(f"{path}: larger than {MAX_BYTES} bytes; scale the picture down first")
        return data
    except FileNotFoundError as error:
        raise ImageError(f"{path}: no such file") from error
    except IsADirectoryError as error:
        raise ImageError(f"{path} is a folder; give a picture in it") from error
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise ImageError(f"{path!s} cannot be read: {error}") from error


def _from_bytes(
    data: bytes, path: Path | None, label: str, least_size: Callable[[Size], Size] | None
) -> DecodedImage:
    with _opened(data, label) as image:
        if least_size is None or image.format not in _REDUCIBLE:
            return _from_pillow(image, path, label)
        _check_size((image.height, image.width), label)
        size = _turned((image.height, image.width), _exif(image).orientation)
        pixels, exif = _upright(image, label, least_size(size))
    file = None if _size(pixels) == size else ReducibleFile(data, label, size)
    return DecodedImage(pixels, path.name if path else None, path, exif.focal_35mm, file)


def _opened(data: bytes, label: str) -> Image.Image:
    if not data:
        raise ImageError(f"{label} is empty (0 bytes)")
    try:
        return Image.open(io.BytesIO(data), formats=FORMATS)
    except Image.DecompressionBombError as error:
        raise ImageError(f"{label}: {error}; scale it down first") from error
    except Exception as error:  # Pillow's plugins raise almost anything on hostile headers
        raise ImageError(
            f"{label} is not an image in a supported format ({', '.join(FORMATS)})"
        ) from error


def _from_pillow(image: Image.Image, path: Path | None, label: str) -> DecodedImage:
    _check_size((image.height, image.width), label)
    pixels, exif = _upright(image, label)
    return DecodedImage(pixels, path.name if path else None, path, exif.focal_35mm)


def _upright(image: Image.Image, label: str, least: Size | None = None) -> tuple[Rgb, "_Exif"]:
    """Decodes an opened image, at a reduced size if the format and `least` (h, w) allow it."""
    full = image.size
    try:
        covered = None
        if least is not None:
            height, width = _turned(least, _exif(image).orientation)
            drafted = image.draft(None, (width, height))
            covered = drafted[1] if drafted else None
        image.load()
        exif = _exif(
            image
        )  # after load(): the TIFF decoder turns upright itself and resets the tag
        rgb = _to_rgb(image)
        if covered is not None and covered != (0, 0, *rgb.size):
            # The last row and column of a reduced picture may cover fewer pixels than the others.
            rgb = rgb.resize(rgb.size, Image.Resampling.BICUBIC, box=covered)
    except ImageError as error:
        raise ImageError(f"{label}: {error}") from error
    except Exception as error:
        raise ImageError(f"{label} is damaged or truncated: {error}") from error
    turn = _UPRIGHT.get(exif.orientation)
    return np.array(rgb if turn is None else rgb.transpose(turn)), _of_crop(exif, full)


def _of_crop(exif: "_Exif", size: tuple[int, int]) -> "_Exif":
    """The focal length of a picture (width, height) that was cut out of a larger one.

    A 35 mm equivalent refers to the whole shot, whose size EXIF keeps. Another shape tells a crop
    from a smaller copy, which sees all of it.
    """
    if exif.focal_35mm is None or exif.shot is None:
        return exif
    (width, height), (shot_width, shot_height) = size, exif.shot
    smaller = width <= shot_width and height <= shot_height
    shape = width / height * shot_height / shot_width
    if not smaller or abs(math.log(shape)) < _OTHER_SHAPE:
        return exif
    longer = math.hypot(shot_width, shot_height) / math.hypot(width, height)
    return replace(exif, focal_35mm=exif.focal_35mm * longer)


def _turned(size: Size, orientation: int) -> Size:
    """Converts (H, W) between stored and upright."""
    return (size[1], size[0]) if orientation in _ON_ITS_SIDE else size


def _size(pixels: Rgb) -> Size:
    return pixels.shape[0], pixels.shape[1]


def _covers(size: Size, least: Size) -> bool:
    return size[0] >= least[0] and size[1] >= least[1]


def _to_rgb(image: Image.Image) -> Image.Image:
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        return _wide_grey_to_rgb(image)
    try:
        if not image.has_transparency_data:
            return image.convert("RGB")
        rgba = image.convert("RGBA")
    except ValueError as error:  # such as La, premultiplied grey
        raise ImageError(f"mode {image.mode} has no conversion to RGB; convert it first") from error
    rgb = Image.new("RGB", rgba.size, "white")
    rgb.paste(rgba, mask=rgba.getchannel("A"))
    return rgb


def _wide_grey_to_rgb(image: Image.Image) -> Image.Image:
    """Scales grey of 16 bits and more. Pillow's own conversion clips it at 255 instead."""
    if image.mode.startswith("I;16"):
        to_bytes = np.rint(np.arange(2**16) / 257).astype(np.uint8)
        return Image.fromarray(to_bytes[np.asarray(image)]).convert("RGB")
    grey = np.asarray(image).astype(np.float64)
    if not np.isfinite(grey).all():
        raise ImageError("some pixels are not finite numbers; save it as 8- or 16-bit grey")
    # 32-bit integers and floats state no white level: take the smallest usual one that fits
    levels = (1.0, 255.0, 65535.0) if image.mode == "F" else (65535.0,)
    white = next((level for level in levels if grey.max() <= level), None)
    if white is None or grey.min() < 0:
        raise ImageError(
            f"grey values from {grey.min():g} to {grey.max():g} have no known white level; "
            "save it as 8- or 16-bit grey"
        )
    return Image.fromarray(np.rint(grey * (255.0 / white)).astype(np.uint8)).convert("RGB")


@dataclass(frozen=True)
class _Exif:
    orientation: int = 1
    focal_35mm: float | None = None
    shot: tuple[int, int] | None = None
    """Width and height of the whole shot, as stored, if stated."""


def _exif(image: Image.Image) -> _Exif:
    """Reads EXIF; a broken block counts as absent, as the picture is still good."""
    try:
        exif = image.getexif()
        orientation = exif.get(Base.Orientation, 1)
    except Exception:
        return _Exif()
    try:
        of_shot = exif.get_ifd(IFD.Exif)
        focal_mm = float(of_shot.get(Base.FocalLengthIn35mmFilm, 0))
        width, height = (
            int(of_shot.get(tag, 0)) for tag in (Base.ExifImageWidth, Base.ExifImageHeight)
        )
    except Exception:
        focal_mm, width, height = 0.0, 0, 0
    stated = math.isfinite(focal_mm) and focal_mm > 0  # EXIF writes 0 for unknown
    shot = (width, height) if width > 0 and height > 0 else None
    return _Exif(orientation, focal_mm if stated else None, shot)
