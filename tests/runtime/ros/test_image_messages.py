"""Pictures of messages, in every encoding."""

import io

import numpy as np
import pytest
from PIL import Image

from footprints_edge.errors import ImageError
from footprints_edge.ros.image_messages import picture_of

pytest.importorskip("rosbags")

from bags import Messages, picture

RGB = picture(7)
RGB[3:20, 5:30] = np.random.default_rng(0).integers(0, 255, (17, 25, 3))


def with_alpha(rgb):
    return np.dstack([rgb, np.full(rgb.shape[:2], 77, np.uint8)])


def wide(rgb, order):
    return (rgb.astype(np.uint16) << 8 | 0x5A).astype(order)


@pytest.mark.parametrize("ros", [1, 2])
@pytest.mark.parametrize(
    ("encoding", "pixels", "big"),
    [
        ("rgb8", RGB, 0),
        ("bgr8", RGB[..., ::-1], 0),
        ("8UC3", RGB[..., ::-1], 0),
        ("rgba8", with_alpha(RGB), 0),
        ("bgra8", with_alpha(RGB[..., ::-1]), 0),
        ("rgb16", wide(RGB, "<u2"), 0),
        ("bgr16", wide(RGB[..., ::-1], ">u2"), 1),
    ],
)
def test_colours_come_out_in_their_order(ros, encoding, pixels, big):
    message = Messages(ros).image(0, pixels, encoding, is_bigendian=big)
    np.testing.assert_array_equal(picture_of(message).pixels, RGB)


@pytest.mark.parametrize(("encoding", "bits"), [("mono8", 8), ("8UC1", 8), ("mono16", 16)])
def test_grey_is_grey_in_all_channels(encoding, bits):
    grey = RGB[..., 0]
    pixels = grey if bits == 8 else wide(grey, "<u2")
    got = picture_of(Messages(2).image(0, pixels, encoding)).pixels
    np.testing.assert_array_equal(got, np.repeat(grey[..., None], 3, axis=2))


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
@pytest.mark.parametrize("channel", "rgb")
def test_a_bayer_mosaic_of_one_colour_is_that_colour(pattern, channel):
    pytest.importorskip("cv2")
    mosaic = np.zeros((16, 16), np.uint8)
    for place, colour in enumerate(pattern):
        mosaic[place // 2 :: 2, place % 2 :: 2] = 200 * (colour == channel)
    got = picture_of(Messages(2).image(0, mosaic, f"bayer_{pattern}8")).pixels
    inner = got[4:-4, 4:-4].reshape(-1, 3).mean(axis=0)
    np.testing.assert_allclose(inner, [200 * (colour == channel) for colour in "rgb"], atol=1)


@pytest.mark.parametrize(("encoding", "pair"), [("yuv422", "uyvy"), ("yuv422_yuy2", "yuyv")])
def test_yuv_is_converted_by_the_studio_range_of_bt601(encoding, pair):
    """Pure red is Y 81, U 90, V 240."""
    pytest.importorskip("cv2")
    red = {"y": 81, "u": 90, "v": 240}
    pixels = np.array([[red[each] for each in pair] * 4] * 4, np.uint8).reshape(4, 8, 2)
    got = picture_of(Messages(2).image(0, pixels, encoding)).pixels
    np.testing.assert_allclose(got.reshape(-1, 3), [[255, 0, 0]] * 32, atol=2)


def test_padding_at_the_end_of_rows_is_left_out():
    padded = np.pad(RGB, ((0, 0), (0, 5), (0, 0)), constant_values=99)
    message = Messages(2).image(0, padded, width=RGB.shape[1], step=padded.shape[1] * 3)
    np.testing.assert_array_equal(picture_of(message).pixels, RGB)


def test_a_compressed_picture_is_that_of_its_file():
    buffer = io.BytesIO()
    Image.fromarray(RGB).save(buffer, "PNG")
    message = Messages(2).compressed(0, buffer.getvalue(), "rgb8; png compressed bgr8")
    np.testing.assert_array_equal(picture_of(message).pixels, RGB)


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"encoding": "16UC1"}, "depth"),
        ({"encoding": "nv99"}, "'nv99'; supported are rgb8"),
        ({"data": np.zeros(100, np.uint8)}, "does not fit its 100 bytes"),
        ({"step": 3}, "rows of 3 bytes"),
        ({"height": 0}, "64 x 0"),
        ({"height": 2**31, "width": 2**31}, "2147483648 x 2147483648"),
    ],
)
def test_a_message_that_holds_no_picture_says_why(changed, reason):
    with pytest.raises(ImageError, match=reason):
        picture_of(Messages(2).image(0, RGB, **changed))


@pytest.mark.parametrize(
    ("data", "kind", "reason"),
    [
        (b"", "jpeg", "empty"),
        (b"\xff\xd8no", "jpeg", "not an image"),
        (b"x", "16UC1; compressedDepth", "depth"),
    ],
)
def test_a_compressed_message_that_holds_no_picture_says_why(data, kind, reason):
    with pytest.raises(ImageError, match=reason):
        picture_of(Messages(2).compressed(0, data, kind))
