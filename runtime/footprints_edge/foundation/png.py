"""Fast PNG encoding."""

import io

from PIL import Image


def encode_png(image: Image.Image) -> bytes:
    """The bytes of a PNG.

    Pillow's default zlib level takes several times as long, for files of the same size or a tenth
    smaller.
    """
    buffer = io.BytesIO()
    image.save(buffer, "PNG", compress_level=1, compress_type=Image.RLE)
    return buffer.getvalue()
