"""Fast PNG encoding."""

import io
import struct
import zlib

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Rgb

_UP = 2  # a row holds its differences to the one above
_BAND_PX = 64  # rows packed at a time, to fit the processor's cache


def encode_png(image: Image.Image | Rgb) -> bytes:
    """The bytes of a PNG of an image, or of RGB pixels, uint8 (H, W, 3).

    Pillow's default zlib level takes several times as long, for files of the same size or a tenth
    smaller. It tries all filters on every row; for colour pictures, one for all rows takes half of
    the time, for files up to a tenth larger.
    """
    if isinstance(image, np.ndarray):
        return _encode_rgb(image)
    if image.mode == "RGB":
        return _encode_rgb(np.asarray(image))
    buffer = io.BytesIO()
    image.save(buffer, "PNG", compress_level=1, compress_type=Image.RLE)
    return buffer.getvalue()


def _encode_rgb(pixels: Rgb) -> bytes:
    """The file format of ISO/IEC 15948, with one filter for all rows."""
    height, width = pixels.shape[:2]
    rows = pixels.reshape(height, 3 * width)
    packer = zlib.compressobj(level=1, strategy=zlib.Z_RLE)
    packed = []
    filtered = np.empty((min(height, _BAND_PX), 1 + 3 * width), np.uint8)
    filtered[:, 0] = _UP
    for top in range(0, height, _BAND_PX):
        band = filtered[: min(height - top, _BAND_PX)]
        above = rows[top - 1] if top else 0
        np.subtract(rows[top], above, out=band[0, 1:])
        np.subtract(
            rows[top + 1 : top + len(band)], rows[top : top + len(band) - 1], out=band[1:, 1:]
        )
        packed.append(packer.compress(band.data))
    packed.append(packer.flush())
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"".join(
        (
            b"\x89PNG\r\n\x1a\n",
            *_chunk(b"IHDR", header),
            *_chunk(b"IDAT", *packed),
            *_chunk(b"IEND"),
        )
    )


def _chunk(kind: bytes, *parts: bytes) -> tuple[bytes, ...]:
    checksum = zlib.crc32(kind)
    for part in parts:
        checksum = zlib.crc32(part, checksum)
    length = struct.pack(">I", sum(map(len, parts)))
    return length, kind, *parts, struct.pack(">I", checksum)
