"""Paths on visible ground and on all ground, side by side (the paper's first figure, f and g)."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.style import INK, PAPER, WHITE, diagonal_stripes
from footprints_edge.errors import NoPathError, OffGroundError
from footprints_edge.foundation.png import encode_png
from footprints_edge.foundation.types import Mask
from footprints_edge.inputs.preprocessing import resized
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.path_planning import GroundPath, find_path

_WIDEST_PX = 960  # of each of the two pictures
_NARROWEST_PX = 320
_SUPERSAMPLING = 2  # draw at twice the size, then shrink: smooth lines

_VISIBLE, _HIDDEN = (38, 166, 154), (240, 98, 146)  # they differ in lightness and hatching, too
_LINE, _HIDDEN_LINE = (255, 235, 59), (255, 145, 0)


def encode_path_picture(
    prediction: GroundMaps, start: Sequence[float], goal: Sequence[float], margin_m: float = 0.0
) -> bytes:
    """Encodes as PNG the cheapest path on visible ground (left) and on all ground (right).

    The left caption says so if there is no path on visible ground.

    Args:
        prediction: The maps, and the picture to draw on.
        start: x and y in pixels of the picture.
        goal: Likewise.
        margin_m: Distance in metres to keep from everything that is not ground.

    Raises:
        PlanningError: If there is no path on all ground either.
        GroundPlaneError: If there is too little ground to fit a plane.
    """
    hidden = find_path(prediction, start, goal, margin_m=margin_m)
    visible: GroundPath | None = None
    try:
        visible = find_path(prediction, start, goal, margin_m=margin_m, ground="visible")
        left = f"visible ground: {visible.length_m:.1f} m"
    except OffGroundError:
        left = "visible ground: an end is not on it"
    except NoPathError:
        left = "visible ground: no way"
    ends = [tuple(start), tuple(goal)]
    panels = [
        _panel(prediction, visible, ends, left, show_hidden=False),
        _panel(prediction, hidden, ends, f"with hidden ground: {hidden.length_m:.1f} m"),
    ]
    gap = max(4, panels[0].width // 120)
    both = Image.new("RGB", (2 * panels[0].width + gap, panels[0].height), PAPER)
    both.paste(panels[0], (0, 0))
    both.paste(panels[1], (panels[0].width + gap, 0))
    return encode_png(both)


def _panel(
    prediction: GroundMaps,
    path: GroundPath | None,
    ends: Sequence[tuple[float, ...]],
    caption: str,
    *,
    show_hidden: bool = True,
) -> Image.Image:
    """Draws the photo with tinted ground, the path on it, and a caption below."""
    height, width = prediction.image_size
    scale = min(max(1.0, _NARROWEST_PX / width), _WIDEST_PX / max(height, width))
    size = (max(1, round(height * scale)), max(1, round(width * scale)))
    fine = (_SUPERSAMPLING * size[0], _SUPERSAMPLING * size[1])
    photo = resized(prediction.picture.at_least(fine), fine, reducing_gap=None)
    pixels = photo.astype(np.float32) * np.float32(0.8)
    large = prediction.at_size(fine)
    pen = max(2.0, max(fine) / 220)
    _tint(pixels, large.visible_ground, _VISIBLE, 0.45)
    if show_hidden:
        stripes = diagonal_stripes(fine, 6 * pen, 3 * pen)
        _tint(pixels, large.hidden_ground & stripes, _HIDDEN, 0.75)
        _tint(pixels, large.hidden_ground & ~stripes, INK, 0.35)
    canvas = Image.fromarray(np.rint(pixels).astype(np.uint8))
    draw = ImageDraw.Draw(canvas)

    def drawn(points: Sequence[Sequence[float]]) -> list[tuple[float, float]]:
        """Converts pixels of the picture to pixels of the canvas."""
        y_scale, x_scale = fine[0] / height, fine[1] / width
        return [((x + 0.5) * x_scale - 0.5, (y + 0.5) * y_scale - 0.5) for x, y in points]

    if path is not None:
        line = drawn(path.pixels.tolist())
        for colour, thickness in ((INK, 2.6 * pen), (_LINE, 1.5 * pen)):
            draw.line(line, colour, round(thickness), joint="curve")
        for (a, b), behind in zip(pairwise(line), path.hidden[1:], strict=True):
            if behind:
                draw.line((a, b), _HIDDEN_LINE, round(1.5 * pen))
    font = ImageFont.load_default(4 * pen)
    for letter, (x, y) in zip("AB", drawn(ends), strict=True):
        for colour, radius in ((INK, 4.0 * pen), (WHITE, 3.5 * pen)):
            draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=colour)
        draw.text((x, y), letter, INK, font, anchor="mm")
    small = canvas.resize(size[::-1], Image.Resampling.LANCZOS)
    letter_px = max(12, size[1] // 36)
    panel = Image.new("RGB", (size[1], size[0] + round(2.4 * letter_px)), PAPER)
    panel.paste(small, (0, 0))
    ImageDraw.Draw(panel).text(
        (letter_px, size[0] + 1.2 * letter_px),
        caption,
        WHITE,
        ImageFont.load_default(letter_px),
        anchor="lm",
    )
    return panel


def _tint(pixels: np.ndarray, mask: Mask, colour: tuple[int, int, int], opacity: float) -> None:
    pixels[mask] += np.float32(opacity) * (np.array(colour, np.float32) - pixels[mask])
