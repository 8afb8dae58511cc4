"""Decoding: any image source becomes upright 8-bit RGB, or raises an ImageError."""

import io
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import BinaryIO, TypeAlias

import numpy as np
from PIL import Image

from footprints_edge.errors import ImageError
from footprints_edge.foundation.addresses import is_address, without_password
from footprints_edge.foundation.computed_once import computed_once
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.damaged_files import lost_share, too_much_lost, with_end, without_notes
from footprints_edge.inputs.foreign_files import is_avif, is_heif, raw_reason, raw_tiff_reason
from footprints_edge.inputs.lens import Lens, read_lens
from footprints_edge.inputs.pillow_warnings import without_pillow_warnings

FORMATS = ("JPEG", "PNG", "WEBP", "TIFF", "BMP")
"""Decoders that an input may reach: Pillow's other decoders only add attack surface."""

_REDUCIBLE = {"JPEG", "MPO"}  # MPO: several JPEGs in one file, as some phones write

MAX_PIXELS = 178_000_000
"""Larger pictures are rejected before any pixel is decoded: half a gigabyte as RGB."""

MAX_JPEG_PIXELS = 205_000_000
"""The same for JPEG files, which are decoded at an eighth. The decoder of progressive ones holds
six bytes for each pixel."""

MAX_SIDE = 2**17
"""Pictures with a longer side are rejected: they have no shape that a network could take."""

MAX_BYTES = 512 * 2**20
"""Larger files are rejected: no picture within `MAX_PIXELS` needs more bytes."""

_WHOLE_PX = 32_000_000
"""Pictures with more pixels are reduced in parts, where the format has no smaller sizes: whole ones
would be in memory five times on their way to an array."""

_STRIP_PX = 2**22

ImageSource: TypeAlias = (
    "str | os.PathLike[str] | bytes | BinaryIO | Image.Image | Rgb | DecodedImage"
)

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
_AS_STORED: dict[int, Callable[[Rgb], Rgb]] = {
    2: lambda upright: upright[:, ::-1],
    3: lambda upright: upright[::-1, ::-1],
    4: lambda upright: upright[::-1],
    5: lambda upright: upright.transpose(1, 0, 2),
    6: np.rot90,
    7: lambda upright: upright[::-1, ::-1].transpose(1, 0, 2),
    8: lambda upright: np.rot90(upright, -1),
}
"""Views of an upright picture that have its pixels where the file has them."""


@dataclass(frozen=True, eq=False)
class ReducibleFile:
    """A file that was decoded at a fraction of its size, and can be decoded at others.

    Attributes:
        data: The encoded bytes.
        label: Name for messages.
        size: (H, W) of the upright picture at full size.
    """

    data: bytes
    label: str
    size: Size

    def decode(self, least: Size) -> Rgb:
        """Decodes the upright picture at the smallest of its sizes that covers `least`.

        Raises:
            ImageError: If the file is damaged.
        """
        with without_pillow_warnings(), _opened(self.data, self.label) as image:
            return _upright(image, self.label, least).pixels


@dataclass(frozen=True, eq=False)
class DecodedImage:
    """An upright picture and the metadata of its file.

    Attributes:
        pixels: uint8 (h, w, 3), RGB, upright: the whole picture, at full size or reduced.
        name: File name, for naming outputs; None if the source has none.
        path: The source file, which outputs must not overwrite; None if there is none.
        focal_35mm: 35 mm equivalent focal length in millimetres from EXIF or GPano, None if not
            stated.
        file: The file, if `pixels` were decoded at a reduced size; else None.
        notes: What is wrong or odd with the file, though it could be read.
        panorama: Whether it is a wide panorama, which no pinhole camera takes.
    """

    pixels: Rgb
    name: str | None = None
    path: Path | None = None
    focal_35mm: float | None = None
    file: ReducibleFile | None = None
    notes: tuple[str, ...] = field(default=())
    panorama: bool = False

    @property
    def size(self) -> Size:
        """(H, W) of the upright picture at full size."""
        return _size(self.pixels) if self.file is None else self.file.size

    @computed_once
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
    if isinstance(source, (str, os.PathLike)):
        path = Path(os.fsdecode(source))
        return _from_bytes(_read(path), path, str(path), least_size)
    if isinstance(source, (bytes, bytearray, memoryview)):
        return _from_bytes(bytes(source), None, "image bytes", least_size)
    if callable(getattr(source, "read", None)):
        filename = getattr(source, "name", None)
        path = Path(filename) if isinstance(filename, str) and filename[:1] != "<" else None
        try:
            data = source.read(MAX_BYTES + 1)
        except (OSError, ValueError, TypeError) as error:
            raise ImageError(f"{filename or 'the file object'} cannot be read: {error}") from error
        if not isinstance(data, bytes):
            raise ImageError(f"{filename or 'the file object'} yields text; open it with 'rb'")
        if len(data) > MAX_BYTES:
            raise ImageError(f"{filename or 'the file object'}: larger than {MAX_BYTES} bytes")
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


def _check_size(size: Size, label: str, most: int | None = None) -> None:
    most = MAX_PIXELS if most is None else most
    height, width = size
    if height < 1 or width < 1:
        raise ImageError(f"{label} is empty: {width} x {height} pixels; both sides need at least 1")
    if height * width > most or max(size) > MAX_SIDE:
        raise ImageError(
            f"{label} is {width} x {height} pixels; no more than {most / 1e6:.0f} million, and "
            f"{MAX_SIDE} along a side, are safe to decode; scale it down first"
        )


def _read(path: Path) -> bytes:
    if is_address(str(path)):
        raise ImageError(f"{without_password(str(path))} is an address; download the picture first")
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


@without_pillow_warnings()
def _from_bytes(
    data: bytes, path: Path | None, label: str, least_size: Callable[[Size], Size] | None
) -> DecodedImage:
    if reason := raw_reason(data, path):
        raise ImageError(f"{label} {reason}")
    try:
        return _decoded(data, path, label, least_size)
    except ImageError:
        for repaired, note in (
            (without_notes(data), "its texts or its profile are damaged or very long: not read"),
            (with_end(data), "its last bytes are missing"),
        ):
            if repaired is not None:
                picture = _decoded(repaired, path, label, least_size)
                if repaired.startswith(b"\xff\xd8") and too_much_lost(_stored_end_last(picture)):
                    break
                return replace(picture, notes=(*picture.notes, f"{label}: {note}"))
        raise


def _decoded(
    data: bytes, path: Path | None, label: str, least_size: Callable[[Size], Size] | None
) -> DecodedImage:
    with _opened(data, label) as image:
        reducible = image.format in _REDUCIBLE
        stored = (image.height, image.width)
        _check_size(stored, label, MAX_JPEG_PIXELS if reducible else MAX_PIXELS)
        if least_size is None or not (reducible or math.prod(stored) > _WHOLE_PX):
            return _from_pillow(image, path, label)
        size = _turned(stored, read_lens(image).orientation)
        upright = _upright(image, label, least_size(size))
    pixels = upright.pixels
    file = None if _size(pixels) == size else ReducibleFile(data, label, size)
    return _with_lens(pixels, path, upright.lens, label, file)


def _opened(data: bytes, label: str) -> Image.Image:
    if not data:
        raise ImageError(f"{label} is empty (0 bytes)")
    heif, avif = is_heif(data), is_avif(data)
    if heif and not reads_heif():
        raise ImageError(
            f"{label} is a HEIC picture; install the package that reads it: pip install "
            "pillow-heif, or convert it to JPEG"
        )
    if avif and not reads_avif():
        raise ImageError(f"{label} is an AVIF picture, which this Pillow lacks; convert it to JPEG")
    try:
        if data.startswith(b"\xff\xd8"):  # Image.open has a limit of its own, of full size
            return _jpeg(io.BytesIO(data))
        formats = FORMATS + ("HEIF",) * heif + ("AVIF",) * avif
        return Image.open(io.BytesIO(data), formats=formats)
    except Image.DecompressionBombError as error:
        raise ImageError(f"{label}: {error}; scale it down first") from error
    except Exception as error:  # Pillow's plugins raise almost anything on hostile headers
        raise ImageError(
            f"{label} is not an image in a supported format ({', '.join(FORMATS)})"
        ) from error


def _jpeg(file: BinaryIO) -> Image.Image:
    from PIL.JpegImagePlugin import jpeg_factory

    image: Image.Image = jpeg_factory(file, "")
    return image


@cache
def reads_heif() -> bool:
    """Whether HEIC pictures can be read: the package pillow-heif is installed."""
    try:
        import_module("pillow_heif").register_heif_opener()
    except Exception:  # absent, or not made for this Pillow
        return False
    return True


@cache
def reads_avif() -> bool:
    """Whether AVIF pictures can be read: this Pillow was built with them."""
    from PIL import features

    return bool(features.check("avif"))


def _stored_end_last(picture: DecodedImage) -> Rgb:
    """The pixels with the end of the file below, whatever way up the picture is."""
    pixels = picture.pixels
    turns = [pixels, pixels[::-1], pixels.transpose(1, 0, 2), pixels.transpose(1, 0, 2)[::-1]]
    return max(turns, key=lost_share)


@without_pillow_warnings()
def _from_pillow(image: Image.Image, path: Path | None, label: str) -> DecodedImage:
    if not path or image.format not in _REDUCIBLE:
        _check_size((image.height, image.width), label)
    upright = _upright(image, label)
    return _with_lens(upright.pixels, path, upright.lens, label)


def _with_lens(
    pixels: Rgb, path: Path | None, lens: Lens, label: str, file: ReducibleFile | None = None
) -> DecodedImage:
    return DecodedImage(
        pixels,
        path.name if path else None,
        path,
        lens.focal_35mm,
        file,
        tuple(f"{label}: {note}" for note in lens.notes),
        panorama=lens.panorama,
    )


@dataclass(frozen=True, eq=False)
class _Upright:
    pixels: Rgb
    lens: Lens


def _upright(image: Image.Image, label: str, least: Size | None = None) -> _Upright:
    """Decodes an opened image, at a reduced size if `least` (h, w) allows it."""
    try:
        if image.format == "TIFF" and (reason := raw_tiff_reason(getattr(image, "tag_v2", None))):
            raise ImageError(reason)
        covered, factor = None, 1
        stored = image.size
        if least is not None:
            height, width = _turned(least, read_lens(image).orientation)
            drafted = image.draft(None, (width, height))
            covered = drafted[1] if drafted else None
            if image.format not in _REDUCIBLE:
                factor = max(1, min(image.width // width, image.height // height))
        image.load()
        # after load(): the TIFF decoder turns upright itself and resets the tag
        lens = read_lens(image, stored)
        whole = factor == 1 and covered in {None, (0, 0, *image.size)}
        if whole and math.prod(image.size) > _WHOLE_PX:
            return _Upright(_pixels_in_strips(image, lens.orientation), lens)
        rgb = _to_rgb(image) if factor == 1 else _reduced_rgb(image, factor)
        if covered is not None and covered != (0, 0, *rgb.size):
            # The last row and column of a reduced picture may cover fewer pixels than the others.
            rgb = rgb.resize(rgb.size, Image.Resampling.BICUBIC, box=covered)
    except ImageError as error:
        raise ImageError(
            f"{label} {error}" if "raw file" in str(error) else f"{label}: {error}"
        ) from error
    except Exception as error:
        raise ImageError(f"{label} is damaged or truncated: {error}") from error
    turn = _UPRIGHT.get(lens.orientation)
    return _Upright(np.array(rgb if turn is None else rgb.transpose(turn)), lens)


def _pixels_in_strips(image: Image.Image, orientation: int) -> Rgb:
    """The upright pixels of a large picture, without a copy of it on the way."""
    width, height = image.size
    upright = np.empty((*_turned((height, width), orientation), 3), np.uint8)
    as_stored = _AS_STORED.get(orientation)
    stored = upright if as_stored is None else as_stored(upright)
    white = _white_level(image) if image.mode in {"I", "F"} else None
    rows = max(1, _STRIP_PX // width)
    for top in range(0, height, rows):
        strip = image.crop((0, top, width, min(height, top + rows)))
        stored[top : top + rows] = np.asarray(_to_rgb(strip, white))
    return upright


def _reduced_rgb(image: Image.Image, factor: int) -> Image.Image:
    """The means of blocks of `factor` x `factor` pixels, computed in strips to save memory."""
    width, height = image.size
    rgb = Image.new("RGB", (-(-width // factor), -(-height // factor)))
    white = _white_level(image) if image.mode in {"I", "F"} else None
    rows = max(1, _STRIP_PX // width // factor) * factor
    for top in range(0, height, rows):
        strip = image.crop((0, top, width, min(height, top + rows)))
        rgb.paste(_to_rgb(strip, white).reduce(factor), (0, top // factor))
    return rgb


def _turned(size: Size, orientation: int) -> Size:
    """Converts (H, W) between stored and upright."""
    return (size[1], size[0]) if orientation in _ON_ITS_SIDE else size


def _size(pixels: Rgb) -> Size:
    return pixels.shape[0], pixels.shape[1]


def _covers(size: Size, least: Size) -> bool:
    return size[0] >= least[0] and size[1] >= least[1]


def _to_rgb(image: Image.Image, white: float | None = None) -> Image.Image:
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        return _wide_grey_to_rgb(image, white)
    try:
        if not image.has_transparency_data:
            return image if image.mode == "RGB" else image.convert("RGB")  # which would copy it
        rgba = image.convert("RGBA")
    except ValueError as error:  # such as La, premultiplied grey
        raise ImageError(f"mode {image.mode} has no conversion to RGB; convert it first") from error
    rgb = Image.new("RGB", rgba.size, "white")
    rgb.paste(rgba, mask=rgba.getchannel("A"))
    return rgb


def _wide_grey_to_rgb(image: Image.Image, white: float | None = None) -> Image.Image:
    """Scales grey of 16 bits and more. Pillow's own conversion clips it at 255 instead."""
    if image.mode.startswith("I;16"):
        to_bytes = np.rint(np.arange(2**16) / 257).astype(np.uint8)
        return Image.fromarray(to_bytes[np.asarray(image)]).convert("RGB")
    white = _white_level(image) if white is None else white
    grey = np.asarray(image).astype(np.float64)
    if not np.isfinite(grey).all():
        raise ImageError(_NOT_FINITE)
    return Image.fromarray(np.rint(grey * (255.0 / white)).astype(np.uint8)).convert("RGB")


_NOT_FINITE = "some pixels are not finite numbers; save it as 8- or 16-bit grey"


def _white_level(image: Image.Image) -> float:
    """The white level of 32-bit integers and floats, which state none: the smallest usual one."""
    least, most = map(float, np.ravel(image.getextrema()))
    if not (math.isfinite(least) and math.isfinite(most)):
        raise ImageError(_NOT_FINITE)
    levels = (1.0, 255.0, 65535.0) if image.mode == "F" else (65535.0,)
    white = next((level for level in levels if most <= level), None)
    if white is None or least < 0:
        raise ImageError(
            f"grey values from {least:g} to {most:g} have no known white level; "
            "save it as 8- or 16-bit grey"
        )
    return white
