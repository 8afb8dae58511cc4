import io
import math
import struct
import warnings
import zlib
from contextlib import suppress

import numpy as np
import pytest
from PIL import Image, TiffImagePlugin
from PIL.ExifTags import IFD, Base
from PIL.PngImagePlugin import PngInfo

from footprints_edge.errors import ImageError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs import images
from footprints_edge.inputs.images import decode

# what a viewer does to the stored pixels, by EXIF orientation (EXIF 2.3, tag 0x0112)
STORED_TO_UPRIGHT = {
    1: lambda a: a,
    2: lambda a: a[:, ::-1],
    3: lambda a: a[::-1, ::-1],
    4: lambda a: a[::-1],
    5: lambda a: a.swapaxes(0, 1),
    6: lambda a: a.swapaxes(0, 1)[:, ::-1],
    7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
    8: lambda a: a.swapaxes(0, 1)[::-1],
}
UPRIGHT_TO_STORED = {**STORED_TO_UPRIGHT, 6: STORED_TO_UPRIGHT[8], 8: STORED_TO_UPRIGHT[6]}


def encoded(image, kind="PNG", **options):
    buffer = io.BytesIO()
    image.save(buffer, kind, **options)
    return buffer.getvalue()


def exif_of(orientation=1, focal_35mm=None):
    exif = Image.Exif()
    exif[0x0112] = orientation
    if focal_35mm is not None:
        exif.get_ifd(0x8769)[0xA405] = focal_35mm
    return exif


def stored(picture, orientation):
    return Image.fromarray(np.ascontiguousarray(UPRIGHT_TO_STORED[orientation](picture)))


@pytest.mark.parametrize("kind", ["PNG", "TIFF", "WEBP"])
@pytest.mark.parametrize("orientation", range(1, 9))
def test_every_orientation_from_every_source_is_the_upright_picture(
    picture, orientation, kind, tmp_path
):
    options = {"lossless": True} if kind == "WEBP" else {}
    data = encoded(stored(picture, orientation), kind, exif=exif_of(orientation), **options)
    path = tmp_path / "turned"
    path.write_bytes(data)
    with path.open("rb") as file:
        for source in (path, str(path), data, file, Image.open(io.BytesIO(data))):
            np.testing.assert_array_equal(decode(source).rgb, picture)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("kind", ["PNG", "JPEG", "PIL"])
def test_very_large_pictures_are_the_same_in_strips(orientation, kind, picture, monkeypatch):
    image = stored(picture, orientation)
    data = encoded(image, "JPEG" if kind == "JPEG" else "PNG", exif=exif_of(orientation))

    def source():
        return Image.open(io.BytesIO(data)) if kind == "PIL" else data

    at_once = decode(source()).rgb
    monkeypatch.setattr(images, "_WHOLE_PX", 1000)
    monkeypatch.setattr(images, "_STRIP_PX", 700)
    in_strips = decode(source(), lambda size: size).rgb
    np.testing.assert_array_equal(in_strips, at_once)
    assert in_strips.flags.c_contiguous


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGBA", "CMYK", "I;16", "I", "F"])
def test_modes_are_the_same_in_strips(mode, monkeypatch):
    grey = np.random.default_rng(0).integers(0, 60_000, (50, 70))
    if mode in {"I;16", "I", "F"}:
        kind = {"I;16": np.uint16, "I": np.int32, "F": np.float32}[mode]
        image = Image.fromarray(grey.astype(kind))
    else:
        image = Image.fromarray((grey >> 8).astype(np.uint8)).convert("RGB").convert(mode)
    at_once = decode(image).rgb
    monkeypatch.setattr(images, "_WHOLE_PX", 1000)
    monkeypatch.setattr(images, "_STRIP_PX", 700)
    np.testing.assert_array_equal(decode(image).rgb, at_once)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_jpeg_orientations(picture, orientation):
    turned = stored(picture, orientation)
    data = encoded(turned, "JPEG", exif=exif_of(orientation), quality=95, subsampling=0)
    rgb = decode(data).rgb
    assert rgb.shape == picture.shape
    assert np.abs(rgb.astype(int) - picture).mean() < 3


@pytest.mark.parametrize("orientation", [0, 9, 77])
def test_meaningless_orientations_change_nothing(picture, orientation):
    data = encoded(Image.fromarray(picture), exif=exif_of(orientation))
    np.testing.assert_array_equal(decode(data).rgb, picture)


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "TIFF", "BMP"])
def test_every_format(picture, kind):
    decoded = decode(encoded(Image.fromarray(picture), kind))
    assert decoded.rgb.dtype == np.uint8
    assert decoded.size == (60, 100)
    assert np.abs(decoded.rgb.astype(int) - picture).mean() < 8


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "YCbCr", "HSV", "CMYK"])
def test_opaque_modes_look_as_pillow_shows_them(picture, mode):
    image = Image.fromarray(picture).convert(mode)
    np.testing.assert_array_equal(decode(image).rgb, np.asarray(image.convert("RGB")))


@pytest.mark.parametrize("mode", ["LA", "PA", "RGBA", "RGBa"])
def test_transparent_pixels_become_white_and_opaque_ones_stay(mode):
    image = Image.new("RGBA", (4, 2), (40, 40, 40, 255))
    image.putpixel((0, 0), (9, 9, 9, 0))
    rgb = decode(image.convert(mode)).rgb
    np.testing.assert_array_equal(rgb[0, 0], [255] * 3)
    np.testing.assert_array_equal(rgb[1, 3], [40] * 3)


def test_transparency_of_a_palette():
    image = Image.new("P", (2, 1), 0)
    image.putpalette([10, 20, 30, 200, 100, 50])
    image.putpixel((1, 0), 1)
    rgb = decode(encoded(image, transparency=0)).rgb
    np.testing.assert_array_equal(rgb[0], [[255, 255, 255], [200, 100, 50]])


def test_16_bit_grey_is_scaled_not_clipped():
    grey = np.array([[0, 255, 257, 32896, 65535]], np.uint16)
    expected = [0, 1, 1, 128, 255]
    for data in (encoded(Image.fromarray(grey)), encoded(Image.fromarray(grey), "TIFF")):
        np.testing.assert_array_equal(decode(data).rgb[0, :, 0], expected)


def test_16_bit_rgb_png_is_scaled():
    row = np.array([0, 0x1234, 0xFFFF], ">u2")

    def chunk(kind, body):
        return (
            struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        )

    data = (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 16, 2, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(b"\0" + row.tobytes()))
        + chunk(b"IEND", b"")
    )
    np.testing.assert_array_equal(decode(data).rgb[0, 0], [0, 0x12, 0xFF])


@pytest.mark.parametrize(
    ("values", "expected"), [([0, 0.5, 1], [0, 128, 255]), ([0, 7, 255], [0, 7, 255])]
)
def test_float_grey_has_the_smallest_usual_white_level(values, expected):
    image = Image.fromarray(np.array([values], np.float32))
    np.testing.assert_array_equal(decode(image).rgb[0, :, 0], expected)


def test_32_bit_grey_counts_as_16_bit():
    image = Image.fromarray(np.array([[0, 65535]], np.int32))
    np.testing.assert_array_equal(decode(image).rgb[0, :, 2], [0, 255])


@pytest.mark.parametrize("values", [[np.nan, 1], [-1, 1], [0, 1e9]])
def test_float_grey_without_a_white_level_is_refused(values):
    with pytest.raises(ImageError, match="8- or 16-bit"):
        decode(Image.fromarray(np.array([values], np.float32)))


def test_modes_without_a_way_to_rgb_are_named():
    with pytest.raises(ImageError, match="mode La has no conversion to RGB"):
        decode(Image.new("La", (2, 2)))


def test_focal_length_of_exif(picture):
    data = encoded(Image.fromarray(picture), "JPEG", exif=exif_of(6, 26))
    assert decode(data).focal_35mm == 26
    assert decode(Image.open(io.BytesIO(data))).focal_35mm == 26


@pytest.mark.parametrize("focal_35mm", [None, 0])
def test_unknown_focal_length(picture, focal_35mm):
    assert (
        decode(encoded(Image.fromarray(picture), "JPEG", exif=exif_of(1, focal_35mm))).focal_35mm
        is None
    )


@pytest.mark.parametrize("cut", range(8, 60, 4))
def test_broken_exif_neither_loses_the_picture_nor_warns(picture, cut):
    exif = exif_of(1, 26).tobytes()
    data = encoded(Image.fromarray(picture), "JPEG", exif=exif[:cut] + b"\xff" * (len(exif) - cut))
    filters = list(warnings.filters)
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        assert decode(data).rgb.shape[2] == 3
        with suppress(ImageError):
            decode(data[:-100])
    assert [warning for warning in warned if "PIL" in warning.filename] == []
    assert warnings.filters == filters


def test_names_and_paths(picture, tmp_path):
    path = tmp_path / "übung 写真.png"
    Image.fromarray(picture).save(path)
    assert (decode(path).name, decode(path).path) == ("übung 写真.png", path)
    assert decode(Image.open(path)).name == "übung 写真.png"
    with path.open("rb") as file:
        assert decode(file).name == "übung 写真.png"
    assert decode(path.read_bytes()).name is None
    assert decode(picture).name is None


def test_arrays_are_copied(picture):
    decoded = decode(picture)
    picture[:] = 0
    assert decoded.rgb.any()


@pytest.mark.parametrize(
    ("array", "advice"),
    [
        (np.zeros((4, 4, 3), np.float32), r"\* 255"),
        (np.zeros((4, 4), np.uint8), "np.repeat"),
        (np.zeros((4, 4, 4), np.uint8), r":3\]"),
        (np.zeros((0, 4, 3), np.uint8), "is empty"),
    ],
)
def test_wrong_arrays_are_refused_with_advice(array, advice):
    with pytest.raises(ImageError, match=advice):
        decode(array)


def test_invalid_sources_are_refused(tmp_path):
    with pytest.raises(ImageError, match="no such file"):
        decode(tmp_path / "nothing.jpg")
    with pytest.raises(ImageError, match="folder"):
        decode(tmp_path)
    with pytest.raises(ImageError, match="int"):
        decode(3)
    with pytest.raises(ImageError, match="'rb'"):
        decode(io.StringIO("text"))
    with pytest.raises(ImageError, match="cannot be read"):
        decode("a\0b.jpg")
    with pytest.raises(ImageError, match="empty"):
        decode(b"")


@pytest.mark.parametrize("kind", ["JPEG", "PNG", "WEBP", "TIFF", "BMP"])
def test_truncated_pictures_are_refused(picture, kind, tmp_path):
    path = tmp_path / "cut.img"
    data = encoded(Image.fromarray(picture), kind)
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(ImageError, match=r"cut\.img"):
        decode(path)


def test_other_files_are_refused(picture, tmp_path):
    path = tmp_path / "page.jpg"
    path.write_text("<html>")
    with pytest.raises(ImageError, match=r"page\.jpg is not an image"):
        decode(path)
    with pytest.raises(ImageError, match=r"supported format \(JPEG, PNG"):
        decode(encoded(Image.fromarray(picture), "GIF"))


def png_header(width, height):
    body = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    header = struct.pack(">I", 13) + body + struct.pack(">I", zlib.crc32(body))
    return b"\x89PNG\r\n\x1a\n" + header + struct.pack(">I", 9) + b"IDAT" + bytes(9)


@pytest.mark.parametrize("size", [(60_000, 60_000), (13_350, 13_350)])
def test_decompression_bombs_are_refused_before_they_are_decoded(size, monkeypatch):
    monkeypatch.setattr(Image.Image, "load", lambda _: pytest.fail("it was decoded"))
    with pytest.raises(ImageError, match="scale it down"):
        decode(png_header(*size))


def test_bombs_are_refused_even_where_pillows_own_limit_is_off(monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", None)
    with pytest.raises(ImageError, match="178 million"):
        decode(png_header(60_000, 60_000))


def test_large_pictures_within_the_limit_are_fine(monkeypatch, picture):
    monkeypatch.setattr(images, "MAX_PIXELS", 6000)
    assert decode(picture).size == (60, 100)
    monkeypatch.setattr(images, "MAX_PIXELS", 5999)
    with pytest.raises(ImageError):
        decode(picture)


def test_sixteen_bit_grey_keeps_every_level_in_order():
    levels = np.arange(65536, dtype=np.uint16).reshape(256, 256)
    buffer = io.BytesIO()
    Image.fromarray(levels).save(buffer, "PNG")
    found = decode(buffer.getvalue()).rgb[..., 0]
    assert np.abs(found - levels / 257).max() <= 0.5


def test_an_endless_file_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("footprints_edge.inputs.images.MAX_BYTES", 1000)
    (tmp_path / "endless.png").write_bytes(bytes(1001))
    with pytest.raises(ImageError, match="1000 bytes"):
        decode(tmp_path / "endless.png")


def photo(size):
    """uint8 (h, w, 3): smooth, so that JPEG changes little; brighter to the right and downwards."""
    y, x = np.mgrid[: size[0], : size[1]]
    ramps = (255 * x / size[1], 255 * y / size[0], 127 + 60 * np.sin(x / 90) * np.sin(y / 70))
    return np.stack(ramps, axis=-1).astype(np.uint8)


def shrunk(rgb, size):
    return np.asarray(Image.fromarray(rgb).resize(size[::-1], Image.Resampling.BOX)).astype(int)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("size", [(640, 960), (641, 961)])
def test_a_large_jpeg_is_decoded_smaller_and_stays_the_same_picture(orientation, size, tmp_path):
    upright = photo(size)
    path = tmp_path / "large.jpg"
    turned = stored(upright, orientation)
    turned.save(path, exif=exif_of(orientation, 26), quality=95, subsampling=0)
    decoded = decode(path, lambda found: (found[0] // 5, found[1] // 5))
    assert decoded.pixels.shape == (-(-size[0] // 4), -(-size[1] // 4), 3)
    assert decoded.size == size
    assert (decoded.name, decoded.path, decoded.focal_35mm) == ("large.jpg", path, 26)
    off = shrunk(decoded.pixels, (40, 60)) - shrunk(upright, (40, 60))
    assert np.abs(off).max() <= 5
    # reduced sums round a little upwards; a row of pixels too many, stretched over, makes it 0.9
    assert np.abs(off.mean(axis=(0, 1))).max() < 0.5
    np.testing.assert_array_equal(decoded.rgb, decode(path).rgb)
    assert decoded.rgb is decoded.rgb


def test_a_picture_is_decoded_no_smaller_than_needed():
    data = encoded(Image.fromarray(photo((400, 800))), "JPEG")
    for least, expected in {
        (400, 800): (400, 800),
        (201, 100): (400, 800),
        (200, 400): (200, 400),
        (100, 401): (400, 800),
        (100, 200): (100, 200),
        (1, 1): (50, 100),
        (999, 999): (400, 800),
    }.items():
        decoded = decode(data, lambda _, least=least: least)
        assert decoded.pixels.shape[:2] == expected
        assert decoded.size == (400, 800)
    small = decode(data, lambda _: (50, 100))
    assert small.at_least((50, 100)) is small.pixels
    assert small.at_least((51, 100)).shape == (100, 200, 3)


@pytest.mark.parametrize("kind", ["PNG", "WEBP", "TIFF", "BMP"])
def test_other_formats_and_sources_are_decoded_as_they_are(picture, kind):
    data = encoded(Image.fromarray(picture), kind)
    for source in (data, Image.open(io.BytesIO(data)), picture):
        decoded = decode(source, lambda _: (1, 1))
        np.testing.assert_array_equal(decoded.pixels, decode(source).rgb)
        assert decoded.rgb is decoded.pixels


def test_a_truncated_jpeg_is_refused_at_any_size():
    data = encoded(Image.fromarray(photo((400, 800))), "JPEG")
    with pytest.raises(ImageError, match="damaged"):
        decode(data[: len(data) // 2], lambda _: (1, 1))


def test_a_jpeg_is_decoded_twice_only_on_demand(monkeypatch):
    data = encoded(Image.fromarray(photo((400, 800))), "JPEG")
    decoded = decode(data, lambda _: (100, 200))
    monkeypatch.setattr(images, "_opened", lambda *_: pytest.fail("it was decoded again"))
    assert decoded.size == (400, 800)
    assert decoded.at_least((90, 200)).shape == (100, 200, 3)


def jpeg_of(picture, **options):
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, "JPEG", quality=90, **options)
    return buffer.getvalue()


def noisy(height=320, width=480):
    return np.random.default_rng(0).integers(0, 256, (height, width, 3), np.uint8)


def with_focal(focal_mm, size=None, taken=None, orientation=1):
    exif = Image.Exif()
    exif[Base.Orientation] = orientation
    block = exif.get_ifd(IFD.Exif)
    block[Base.FocalLengthIn35mmFilm] = focal_mm
    if taken is not None:
        block[Base.ExifImageWidth], block[Base.ExifImageHeight] = taken
    return decode(jpeg_of(noisy(*(size or (40, 60))), exif=exif))


@pytest.mark.parametrize("focal_mm", [0, 1, 3, 6000, 65535])
def test_a_focal_length_of_no_lens_counts_as_not_stated(focal_mm):
    assert with_focal(focal_mm).focal_35mm is None
    assert with_focal(28).focal_35mm == 28


@pytest.mark.parametrize(
    ("size", "taken", "expected"),
    [
        ((360, 640), (640, 360), 28),
        ((180, 320), (640, 360), 28),  # resized
        ((270, 320), (640, 360), 28 * math.hypot(640, 360) / math.hypot(320, 270)),  # cropped
        ((350, 300), (640, 360), 28 * math.hypot(640, 360) / math.hypot(350, 300)),  # upright crop
        ((640, 360), (640, 360), 28),  # turned
        ((360, 203), (640, 360), 28 * math.hypot(640, 360) / math.hypot(360, 203)),  # portrait crop
        ((800, 640), (640, 360), None),  # neither
    ],
)
@pytest.mark.parametrize("orientation", [1, 6])
def test_a_cropped_picture_keeps_its_lens(size, taken, expected, orientation):
    found = with_focal(28, size, taken, orientation).focal_35mm
    assert found == (None if expected is None else pytest.approx(expected))


def lens_of(size=(40, 60), make="", **tags):
    exif = Image.Exif()
    exif[Base.Make] = make
    block = exif.get_ifd(IFD.Exif)
    for name, value in tags.items():
        block[Base[name]] = value
    return decode(jpeg_of(noisy(*size), exif=exif))


@pytest.mark.parametrize(
    ("make", "zoom", "expected"),
    [
        ("any", 2.0, 52),
        ("any", 0, 26),
        ("any", 1, 26),
        ("Apple", 2.0, 26),
        ("", 1e9, 26),
    ],
)
def test_a_digital_zoom_lengthens_the_lens(make, zoom, expected):
    """iPhones state the focal length of what is left, others that of the lens."""
    found = lens_of(make=make, FocalLengthIn35mmFilm=26, DigitalZoomRatio=zoom)
    assert found.focal_35mm == pytest.approx(expected)
    assert [("zoomed digitally" in note) for note in found.notes] == [True] * (expected == 52)


def panorama(full=None, shown=None, kind="equirectangular", *, elements=False, size=(50, 100)):
    """A JPEG with GPano, as attributes or as elements."""
    values = {
        "ProjectionType": kind,
        "FullPanoWidthPixels": full,
        "CroppedAreaImageWidthPixels": shown,
    }
    stated = {name: value for name, value in values.items() if value is not None}
    attributes = "" if elements else " ".join(f'GPano:{k}="{v}"' for k, v in stated.items())
    inside = "".join(f"<GPano:{k}>{v}</GPano:{k}>" for k, v in stated.items()) if elements else ""
    xmp = f"<rdf:Description {attributes}>{inside}</rdf:Description>".encode()
    return decode(jpeg_of(noisy(*size), xmp=xmp))


@pytest.mark.parametrize("elements", [False, True])
def test_a_full_panorama_is_said_to_be_none_of_a_lens(elements):
    found = panorama(8000, 8000, elements=elements)
    assert found.panorama and found.focal_35mm is None
    assert "a panorama, not a perspective picture" in found.notes[0]


@pytest.mark.parametrize(("full", "shown"), [(None, None), ("many", 10), (0, 10), (100, 4000)])
def test_a_panorama_of_nonsense_numbers_is_a_full_one(full, shown):
    assert panorama(full, shown).panorama


def test_a_narrow_part_of_a_panorama_has_the_lens_of_its_angle():
    """100 pixels show 60 degrees, whatever size they had: f = 100 / (pi / 3) in the middle."""
    found = panorama(6000, 1000)
    assert not found.panorama and not found.notes
    focal_px = Intrinsics.from_focal_35mm(found.focal_35mm, found.size).focal_px
    assert focal_px == pytest.approx(100 / (math.pi / 3))


def test_a_rectilinear_part_of_a_panorama_is_an_ordinary_picture():
    assert not panorama(6000, 6000, "rectilinear").panorama


def test_panoramas_of_iphones_are_known_without_gpano():
    assert lens_of(FocalLengthIn35mmFilm=26, CustomRendered=6).panorama
    assert not lens_of(FocalLengthIn35mmFilm=26, CustomRendered=8).panorama


@pytest.mark.parametrize("orientation", [1, 3, 6, 8])
@pytest.mark.parametrize("taken", [(400, 300), (300, 400)])
def test_a_phones_upright_shot_has_one_lens_however_its_size_is_stated(orientation, taken):
    """The sensor lies on its side; phones state the size before or after turning."""
    found = with_focal(26, (300, 400), taken, orientation)
    camera = Intrinsics.from_focal_35mm(found.focal_35mm, found.size)
    assert found.size == ((400, 300) if orientation in {6, 8} else (300, 400))
    assert camera.focal_px == pytest.approx(26 * 500 / math.hypot(36, 24))


def png_with(text=b"", *, break_checksum=False):
    notes = PngInfo()
    notes.add_text("workflow", text.decode(), zip=True)
    buffer = io.BytesIO()
    Image.fromarray(noisy()).save(buffer, "PNG", pnginfo=notes)
    data = bytearray(buffer.getvalue())
    if break_checksum:
        data[data.index(b"zTXt") + 10] ^= 1
    return bytes(data)


@pytest.mark.parametrize(
    "data", [png_with(b"x" * 2_000_000), png_with(b"note", break_checksum=True)]
)
def test_notes_in_a_png_do_not_stop_it(data):
    picture = decode(data)
    np.testing.assert_array_equal(picture.pixels, noisy())
    assert "texts" in picture.notes[0]
    assert decode(png_with(b"short")).notes == ()


def test_a_png_with_damaged_pixels_is_refused():
    data = bytearray(png_with(b"note"))
    data[data.index(b"IDAT") + 50] ^= 255
    with pytest.raises(ImageError):
        decode(bytes(data))


def test_a_jpeg_without_its_last_bytes_is_read_with_a_note():
    whole = jpeg_of(noisy())
    assert decode(whole).notes == ()
    for cut in (2, 20, 500):
        picture = decode(whole[:-cut])
        assert "last bytes" in picture.notes[0]
        same = (picture.pixels == decode(whole).pixels).all(axis=(1, 2))
        assert same[: len(same) * 9 // 10].all()


@pytest.mark.parametrize("share", [0.5, 0.8])
@pytest.mark.parametrize("options", [{}, {"progressive": True}])
def test_half_a_jpeg_is_refused(share, options):
    whole = jpeg_of(noisy(), **options)
    with pytest.raises(ImageError, match="truncated"):
        decode(whole[: round(share * len(whole))])


@pytest.mark.parametrize("mode", ["L", "P", "RGBA", "1", "F", "I;16", "LA"])
def test_large_pictures_are_reduced_in_parts(mode, monkeypatch, tmp_path):
    suffix = "tif" if mode in {"F", "I;16"} else "png"
    grey = Image.fromarray(noisy()[..., 0])
    if mode in {"F", "I;16"}:
        kind = np.float32 if mode == "F" else np.uint16
        image = Image.fromarray(np.asarray(grey).astype(kind) * kind(1 if mode == "F" else 257))
    else:
        image = grey.convert(mode)
    image.save(tmp_path / f"a.{suffix}")
    whole = decode(tmp_path / f"a.{suffix}")
    monkeypatch.setattr(images, "_WHOLE_PX", 1000)
    monkeypatch.setattr(images, "_STRIP_PX", 480 * 7)
    reduced = decode(tmp_path / f"a.{suffix}", lambda _: (100, 150))
    assert reduced.size == whole.size == (320, 480)
    assert reduced.pixels.shape == (107, 160, 3)
    expected = np.asarray(Image.fromarray(whole.pixels).reduce(3))
    np.testing.assert_allclose(reduced.pixels.astype(int), expected, atol=1)
    np.testing.assert_array_equal(reduced.rgb, whole.pixels)


def test_a_long_side_has_a_limit():
    with pytest.raises(ImageError, match="along a side"):
        decode(np.zeros((1, images.MAX_SIDE + 1, 3), np.uint8))


def test_a_jpeg_may_be_larger_than_other_pictures(monkeypatch):
    monkeypatch.setattr(images, "MAX_PIXELS", 1000)
    assert decode(jpeg_of(noisy()), lambda _: (40, 60)).size == (320, 480)


def test_raw_files_are_refused_by_name_and_by_content(tmp_path):
    (tmp_path / "a.DNG").write_bytes(jpeg_of(noisy()))
    with pytest.raises(ImageError, match="raw file of a camera"):
        decode(tmp_path / "a.DNG")
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    tags[50706] = b"\x01\x04\x00\x00"
    Image.fromarray(noisy()).save(tmp_path / "b.tif", tiffinfo=tags)
    with pytest.raises(ImageError, match=r"b\.tif is a raw file of a camera"):
        decode(tmp_path / "b.tif")


def test_heic_is_named(monkeypatch):
    monkeypatch.setattr(images, "reads_heif", lambda: False)
    with pytest.raises(ImageError, match=r"HEIC.*pip install pillow-heif"):
        decode(b"\0\0\0\x18ftypheic" + bytes(200))


def test_any_path_and_any_reader_within_the_limit(tmp_path, monkeypatch):
    class Folder:
        def __fspath__(self):
            return str(tmp_path / "a.jpg")

    (tmp_path / "a.jpg").write_bytes(jpeg_of(noisy()))
    assert decode(Folder()).name == "a.jpg"
    monkeypatch.setattr(images, "MAX_BYTES", 100)
    with pytest.raises(ImageError, match="larger than 100 bytes"):
        decode(io.BytesIO(bytes(101)))
