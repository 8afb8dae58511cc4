"""Writes what tests in JavaScript compare with: what the Python runtime makes of the same input.

The test vectors of the bundled model are among it. Run `python runtime/js/tests/make_fixtures.py`
from anywhere. Everything is cut from the example picture `examples/room.jpg`; arrays are `.npy`,
facts are in `facts.json`, films for Chromium's fake camera are `.mjpeg`.
"""

import io
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, TiffImagePlugin
from PIL.ExifTags import IFD, Base

import footprints_edge as fp
from footprints_edge.drawing.colormap import colour_scale, scale_position
from footprints_edge.foundation.types import Size
from footprints_edge.geometry.camera import disparity_to_depth
from footprints_edge.inputs.lens import read_lens
from footprints_edge.inputs.preprocessing import FILTERS, preprocess, working_size
from footprints_edge_export.verification.test_vectors import write_vectors

FIXTURES = Path(__file__).parent / "fixtures"
ROOM = Path(__file__).parents[3] / "examples" / "room.jpg"

# from (H, W) to (h, w): smaller, larger, one side alone, both ways at once
RESIZES: tuple[tuple[Size, Size], ...] = (
    ((180, 320), (64, 96)),
    ((37, 53), (64, 96)),
    ((64, 96), (64, 96)),
    ((120, 96), (64, 96)),
    ((64, 75), (64, 96)),
    ((20, 300), (96, 64)),
    ((1, 1), (64, 64)),
)
SIZES = ((720, 1280), (1280, 720), (480, 640), (1000, 1000), (300, 4000), (33, 47), (1, 9000))
LENSES: dict[str, dict[str, Any]] = {
    "zoomed": {"focal": 26, "zoom": 2.5},
    "zoomed-by-an-iphone": {"focal": 26, "zoom": 2.5, "maker": "Apple"},
    "zoomed-impossibly": {"focal": 26, "zoom": 500.0},
    "not-zoomed": {"focal": 26, "zoom": 0.0},
    "short-name": {"focal": 26, "zoom": 2.0, "maker": "LG"},
    "too-short": {"focal": 3},
    "too-long": {"focal": 5001},
    "cropped": {"focal": 26, "taken": (400, 300)},
    "cropped-and-zoomed": {"focal": 26, "taken": (400, 300), "zoom": 2.0},
    "cropped-to-another-way-up": {"focal": 26, "taken": (400, 80), "size": (60, 80)},
    "turned": {"focal": 26, "taken": (160, 320), "size": (320, 160), "orientation": 6},
    "turned-by-a-program": {"focal": 26, "taken": (160, 320), "size": (320, 160)},
    "enlarged-to-another-shape": {"focal": 26, "taken": (64, 48)},
    "resized": {"focal": 26, "taken": (640, 320)},
    "size-not-stated": {"focal": 26, "taken": (0, 0)},
    "whole-turn": {"focal": 26, "pano": (8000, 8000)},
    "whole-turn-in-elements": {"pano": (8000, 8000), "elements": True},
    "part-of-a-turn": {"pano": (6000, 1000)},
    "part-of-a-turn-held-upright": {"pano": (6000, 1000), "orientation": 6},
    "flat-part-of-a-turn": {"focal": 26, "pano": (6000, 6000), "kind": "Rectilinear"},
    "turn-of-nonsense": {"focal": 26, "pano": ("many", 10)},
    "turn-of-an-iphone": {"focal": 26, "rendered": 6},
    "other-picture-of-an-iphone": {"focal": 26, "rendered": 8},
}
"""What JPEG files state: see `write_lens`."""

FILM_FRAMES, FILM_HZ = 30, 10
EXACT = {"session.x64quantprecision": "1"}
"""Lets onnxruntime multiply int8 without saturation on x86 processors that have no VNNI.

WebAssembly is exact, so the page would differ from what such a processor makes of full-range int8
weights. Elsewhere this changes nothing."""


def main() -> None:
    """Writes all fixtures."""
    FIXTURES.mkdir(exist_ok=True)
    room = Image.open(ROOM).convert("RGB")
    write_resizes()
    model = fp.load(session_options=EXACT)
    write_vectors(model, FIXTURES / "vectors")
    photos = {"room.jpg": ROOM.read_bytes(), **cut_outs(room), **with_lens(room)}
    facts = {
        "resizes": [[*a, *b] for a, b in RESIZES],
        "sizes": [[*size, *working_size(size)] for size in SIZES],
        "colours": colour_scale().ravel().tolist(),
        "positions": [
            [m, int(scale_position(np.array(m)))] for m in (0.1, 0.5, 1.7, 6.0, 20.0, 80)
        ],
        "depths": [
            [s, disparity_to_depth(s), disparity_to_depth(s, 0.5, 40)] for s in (0, 0.01, 1)
        ],
        "lenses": {name: write_lens(name, **stated) for name, stated in LENSES.items()},
        "photos": {name: write_photo(model, name, data) for name, data in photos.items()},
    }
    (FIXTURES / "facts.json").write_text(json.dumps(facts))
    write_film(room, "camera", (480, 640))
    write_film(room, "camera-upright", (640, 480))


def write_resizes() -> None:
    """Noise at every brightness, the hardest thing to resize alike, and what becomes of it."""
    rng = np.random.default_rng(7)
    for i, (size, to) in enumerate(RESIZES):
        rgb = rng.integers(0, 256, (*size, 3), dtype=np.uint8)
        rgb[:, ::2] //= 2
        np.save(FIXTURES / f"resize-{i}.npy", rgb)
        for name in FILTERS:
            np.save(FIXTURES / f"resize-{i}-{name}.npy", preprocess(rgb, to, name)[0])


def cut_outs(room: Image.Image) -> dict[str, bytes]:
    """Pictures of other shapes, as PNG without EXIF."""
    boxes = {
        "upright": (740, 0, 1280, 720),
        "square": (0, 0, 720, 720),
        "small": (320, 180, 960, 720),
    }
    pieces = {name: room.crop(box) for name, box in boxes.items()}
    pieces["small"].thumbnail((200, 200))
    return {f"{name}.png": _encoded(piece, "PNG") for name, piece in pieces.items()}


def write_photo(model: fp.Model, name: str, data: bytes) -> dict[str, object]:
    """Writes the photo and its maps; returns its camera."""
    (FIXTURES / name).write_bytes(data)
    prediction = model.predict(data)
    maps: list[NDArray[np.float32]] = [
        prediction.visible_ground_probability,
        prediction.ground_probability,
        prediction.visible_depth_m,
        prediction.unmasked_ground_depth_m,
    ]
    np.save(FIXTURES / f"{name}.npy", np.stack(maps))
    camera = prediction.intrinsics
    return {"camera": [camera.fx, camera.fy, camera.cx, camera.cy, camera.source]}


def write_lens(
    name: str,
    size: Size = (100, 200),
    focal: int = 0,
    taken: tuple[int, int] | None = None,
    zoom: float | None = None,
    rendered: int | None = None,
    orientation: int = 1,
    maker: str = "maker",
    pano: tuple[object, object] | None = None,
    kind: str = "equirectangular",
    *,
    elements: bool = False,
) -> dict[str, object]:
    """Writes a JPEG file that states this; returns what the runtime reads.

    `taken` is the width and height when it was taken, `pano` the full and the shown width in GPano.
    """
    xmp = b""
    if pano is not None:
        stated = {
            "ProjectionType": kind,
            "FullPanoWidthPixels": pano[0],
            "CroppedAreaImageWidthPixels": pano[1],
        }
        form = "<GPano:{0}>{1}</GPano:{0}>" if elements else ' GPano:{0}="{1}"'
        said = "".join(form.format(*each) for each in stated.items())
        xmp = f"<rdf:D>{said}</rdf:D>".encode() if elements else f"<rdf:D{said}/>".encode()
    data = _with_exif(
        Image.new("RGB", size[::-1]), focal, taken, zoom, rendered, orientation, maker, xmp
    )
    (FIXTURES / f"lens-{name}.jpg").write_bytes(data)
    with Image.open(io.BytesIO(data)) as image:
        lens = read_lens(image)
    return {"focal35mm": lens.focal_35mm, "panorama": lens.panorama}


def with_lens(room: Image.Image) -> dict[str, bytes]:
    """Photos whose lens is not the one that EXIF states: cropped, and digitally zoomed."""
    cropped = room.crop((400, 20, 1000, 720))
    zoomed = room.crop((320, 180, 960, 540))
    return {
        "cropped.jpg": _with_exif(cropped, 30, room.size),
        "zoomed.jpg": _with_exif(zoomed, 30, zoomed.size, 2.0),
    }


def _with_exif(
    image: Image.Image,
    focal: int,
    taken: tuple[int, int] | None = None,
    zoom: float | None = None,
    rendered: int | None = None,
    orientation: int = 1,
    maker: str = "maker",
    xmp: bytes = b"",
) -> bytes:
    exif = Image.Exif()
    exif[Base.Make], exif[Base.Orientation] = maker, orientation
    stated: dict[int, object] = {Base.FocalLengthIn35mmFilm: focal}
    if taken is not None:
        stated |= {Base.ExifImageWidth: taken[0], Base.ExifImageHeight: taken[1]}
    if zoom is not None:
        stated[Base.DigitalZoomRatio] = TiffImagePlugin.IFDRational(zoom)
    if rendered is not None:
        stated[Base.CustomRendered] = rendered
    exif[IFD.Exif] = stated
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=95, exif=exif, **({"xmp": xmp} if xmp else {}))
    return buffer.getvalue()


def write_film(room: Image.Image, name: str, size: Size) -> None:
    """A pan over the picture, there and back, as a stream of JPEG pictures."""
    height, width = size
    span = room.height * width // height
    way = np.sin(np.linspace(0, np.pi, FILM_FRAMES)) * (room.width - span)
    frames = [
        room.crop((int(x), 0, int(x) + span, room.height)).resize((width, height)) for x in way
    ]
    assert any(a != b for a, b in pairwise(frames))
    (FIXTURES / f"{name}.mjpeg").write_bytes(b"".join(_encoded(each, "JPEG") for each in frames))


def _encoded(image: Image.Image, kind: str) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, kind, quality=90)
    return buffer.getvalue()


if __name__ == "__main__":
    main()
