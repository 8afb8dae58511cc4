import io

import numpy as np
import pytest
from PIL import Image

from footprints_edge.foundation.png import encode_png
from footprints_edge.parallel.bands import at_once


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (5, 1), (33, 47), (150, 3)])
@pytest.mark.parametrize("kind", ["RGB", "L", "I;16"])
def test_another_decoder_gives_the_picture_back(kind, size):
    rng = np.random.default_rng(0)
    shape = (*size, 3) if kind == "RGB" else size
    pixels = rng.integers(0, 2**16 if kind == "I;16" else 256, shape)
    pixels = pixels.astype(np.uint16 if kind == "I;16" else np.uint8)
    data = encode_png(Image.fromarray(pixels))
    with Image.open(io.BytesIO(data)) as checked:
        checked.verify()
    with Image.open(io.BytesIO(data)) as image:
        assert (image.format, image.mode) == ("PNG", kind)
        np.testing.assert_array_equal(np.asarray(image), pixels)
    if kind == "RGB":
        assert encode_png(pixels) == data == encode_png(pixels, at_once)


def test_opencv_reads_it_too():
    cv2 = pytest.importorskip("cv2")
    pixels = np.random.default_rng(1).integers(0, 256, (20, 30, 3), np.uint8)
    data = np.frombuffer(encode_png(Image.fromarray(pixels)), np.uint8)
    np.testing.assert_array_equal(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1], pixels)


def test_even_rows_are_packed():
    smooth = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 256, 1)
    assert len(encode_png(Image.fromarray(np.stack([smooth] * 3, -1)))) < 5000
