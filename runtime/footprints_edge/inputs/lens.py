"""What a picture's file says of its lens: EXIF, and GPano of panoramas."""

import math
import re
from dataclasses import dataclass

from PIL import Image
from PIL.ExifTags import IFD, Base

FOCAL_35MM_RANGE = (4.0, 5000.0)
"""Millimetres; an EXIF focal length outside of it counts as not stated. No lens is there."""

_FARTHEST_ZOOM = 200.0
"""A digital zoom above it counts as not stated."""

_SAME_SHAPE = 0.02
"""Relative difference of two width-to-height ratios that rounding explains."""

_WIDEST_VIEW_DEG = 90.0
"""A part of a panorama up to this wide is near enough to the picture of a pinhole camera: towards
its sides it is off by 10 %."""

_DIAGONAL_35MM = math.hypot(36.0, 24.0)

_APPLE_PANORAMA = 6
"""`CustomRendered` of panoramas that iPhones take."""

_XMP_KEYS = ("xmp", "XML:com.adobe.xmp", "Raw profile type xmp")


@dataclass(frozen=True)
class Lens:
    """What is known of the picture's camera.

    Attributes:
        orientation: EXIF orientation, 1 if there is none.
        focal_35mm: 35 mm equivalent focal length of the whole picture in millimetres; None if it is
            not stated, or if there is none.
        panorama: Whether the picture is a wide panorama: no pinhole camera has taken it.
        notes: What is odd about it.
    """

    orientation: int = 1
    focal_35mm: float | None = None
    panorama: bool = False
    notes: tuple[str, ...] = ()


def read_lens(image: Image.Image, stored: tuple[int, int] | None = None) -> Lens:
    """Reads EXIF and XMP; a broken block counts as absent, as the picture is still good.

    Args:
        image: The picture.
        stored: Its width and height at full size; None means those of `image`.
    """
    now = stored or image.size
    try:
        exif = image.getexif()
        orientation = exif.get(Base.Orientation, 1)
        maker = str(exif.get(Base.Make, ""))
    except Exception:
        return Lens()
    try:
        more = exif.get_ifd(IFD.Exif)
        focal_mm = float(more.get(Base.FocalLengthIn35mmFilm, 0))  # EXIF writes 0 for unknown
        taken = (float(more.get(Base.ExifImageWidth, 0)), float(more.get(Base.ExifImageHeight, 0)))
    except Exception:
        more, focal_mm, taken = {}, 0.0, (0.0, 0.0)
    view_deg = _panorama_view_deg(image)
    if view_deg is None and more.get(Base.CustomRendered) == _APPLE_PANORAMA:
        view_deg = 360.0
    if view_deg is not None:
        if view_deg <= _WIDEST_VIEW_DEG:
            focal_mm = now[0] / math.radians(view_deg) * _DIAGONAL_35MM / math.hypot(*now)
            least, most = FOCAL_35MM_RANGE
            return Lens(orientation, focal_mm if least <= focal_mm <= most else None)
        note = (
            "a panorama, not a perspective picture: no distances; cut a view out of it, or give "
            "the camera"
        )
        return Lens(orientation, panorama=True, notes=(note,))
    least, most = FOCAL_35MM_RANGE
    if not least <= focal_mm <= most:
        return Lens(orientation)
    zoom = 1.0
    notes: tuple[str, ...] = ()
    if not maker.startswith("Apple"):  # iPhones state the focal length of what is left
        zoom = _digital_zoom(more.get(Base.DigitalZoomRatio))
    if zoom > 1:
        notes = (
            f"zoomed digitally by {zoom:.3g}: taken for the view of a {focal_mm * zoom:.0f} mm "
            "lens; give --hfov if it is not",
        )
    return Lens(orientation, _focal_of_rest(focal_mm * zoom, taken, now), notes=notes)


def _digital_zoom(stated: object) -> float:
    """The ratio that EXIF states; 1 if it says that none was used (0), or nonsense."""
    try:
        zoom = float(stated)  # type: ignore[arg-type] # whatever the file holds
    except (TypeError, ValueError, ZeroDivisionError):
        return 1.0
    return zoom if 1 < zoom <= _FARTHEST_ZOOM else 1.0


def _panorama_view_deg(image: Image.Image) -> float | None:
    """How many degrees a panorama shows from left to right, by its GPano; None if it has none.

    An equirectangular or cylindrical picture has equally many pixels for each degree of its row in
    the middle. What it shows is the cropped area, as a share of the full turn.
    """
    xmp = next((image.info[key] for key in _XMP_KEYS if key in image.info), None)
    if isinstance(xmp, bytes):
        xmp = xmp.decode("utf-8", "replace")
    if not isinstance(xmp, str) or "GPano" not in xmp:
        return None
    if _gpano(xmp, "ProjectionType").lower() == "rectilinear":
        return None
    try:
        full = float(_gpano(xmp, "FullPanoWidthPixels"))
        shown = float(_gpano(xmp, "CroppedAreaImageWidthPixels"))
    except ValueError:
        return 360.0
    if not (math.isfinite(full) and 0 < shown <= full):
        return 360.0
    return 360.0 * shown / full


def _gpano(xmp: str, name: str) -> str:
    """A property as attribute or as element; empty if it is not there."""
    found = re.search(rf"GPano:{name}\s*(?:=\s*[\"']|>)\s*([^\"'<]*)", xmp)
    return found.group(1).strip() if found else ""


def _focal_of_rest(
    focal_mm: float, taken: tuple[float, float], now: tuple[int, int]
) -> float | None:
    """The 35 mm equivalent focal length of what is left of a picture that was cropped.

    A picture of another shape than when it was taken has been cropped, and then no longer has the
    field of view that EXIF goes on to state. It is taken not to have been resized as well.

    Args:
        focal_mm: What EXIF states.
        taken: Width and height when it was taken, as EXIF states them; 0 is unknown.
        now: Width and height.
    """
    if not (all(map(math.isfinite, taken)) and min(taken) >= 1):
        return focal_mm
    upright_crop = now[1] == taken[1] or now[0] == taken[0]  # an edge is whole: never turned
    if (taken[0] > taken[1]) != (now[0] > now[1]) and not upright_crop:
        taken = taken[1], taken[0]  # turned by a program, which kept the block
    if abs(taken[0] / taken[1] * now[1] / now[0] - 1) <= _SAME_SHAPE:
        return focal_mm
    if now[0] > taken[0] or now[1] > taken[1]:
        return None
    return focal_mm * math.hypot(*taken) / math.hypot(*now)
