"""The overlay: ground tinted by distance, hidden ground hatched, a legend below."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from footprints_edge.drawing.blending import (
    INK_PIXEL,
    WHITE_PIXEL,
    blurred_edge_px,
    hatch,
    inside,
    paint,
)
from footprints_edge.drawing.colormap import FARTHEST_M, colour_scale, scale_position
from footprints_edge.drawing.style import FAINT, PAPER, TINT, WHITE
from footprints_edge.foundation.png import encode_png
from footprints_edge.foundation.types import Floats, Mask, Rgb, Size
from footprints_edge.geometry.camera import ASSUMED_FOV_DEG, IntrinsicsSource
from footprints_edge.inputs.preprocessing import resized
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.maps.resize import resize_map

LONGEST_PX = 1920
"""Larger pictures are drawn at this size; the maps themselves have far fewer pixels."""

NARROWEST_PX = 480
"""Narrower pictures are enlarged to this width, to make room for lines and letters."""

TICKS_M = (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)

_RIPPLE_PX = 12  # in pixels of the maps

_GREY = np.array([0.299, 0.587, 0.114], np.float32)

_BAND_PX = 64  # rows painted at a time, to fit the processor's cache

LEGEND_PX = 300
"""Least width of the legend. Very tall pictures get margins instead of a clipped legend."""


def encode_overlay(prediction: GroundMaps, *, bev: bool = False) -> bytes:
    """Encodes `draw_overlay` as PNG."""
    return encode_png(draw_overlay(prediction, bev=bev))


def draw_overlay(prediction: GroundMaps, *, bev: bool = False) -> Image.Image:
    """Draws a prediction on its picture.

    Visible ground is tinted and hidden ground hatched in the colour of its distance, both
    outlined; thin lines mark round distances. The legend is a strip below the picture.

    Args:
        prediction: The prediction to draw.
        bev: Whether to add a bird's-eye view beside the picture; it stays empty if there is too
            little ground for a plane.

    Returns:
        RGB image: the picture's size, limited by `NARROWEST_PX` and `LONGEST_PX`, plus the legend.
        The bird's-eye view is a square as high as both.
    """
    size = _canvas_size(prediction.image_size)
    pen_px = max(1.0, max(size) / 700)
    blur_px = max(2 * pen_px, 0.5 * max(size) / max(prediction.map_size))
    photo = resized(prediction.picture.at_least(size), size, reducing_gap=2.0)
    # Isolines follow every ripple of a depth; smoothed inverse depth gives legible ones.
    inverse_depth = np.reciprocal(prediction.unmasked_ground_depth_m)
    smooth = resize_map(_smooth(inverse_depth), size)
    visible, ground = (
        resize_map(probability, size) > prediction.threshold
        for probability in (prediction.visible_ground_probability, prediction.ground_probability)
    )
    pixels = np.array(photo)
    _paint_ground(
        pixels, visible, ground & ~visible, resize_map(inverse_depth, size), smooth, pen_px, blur_px
    )
    picture = Image.fromarray(pixels)
    _label_isolines(picture, smooth, ground | visible)
    legend = draw_legend(
        max(picture.width, LEGEND_PX), picture.height, note=lens_note(prediction.intrinsics.source)
    )
    drawn = _stacked(picture, legend)
    if not bev:
        return drawn
    from footprints_edge.drawing.occupancy_grid import draw_bev

    both = Image.new("RGB", (drawn.width + drawn.height, drawn.height))
    both.paste(drawn, (0, 0))
    both.paste(draw_bev(prediction, drawn.height), (drawn.width, 0))
    return both


def _canvas_size(image_size: Size) -> Size:
    height, width = image_size
    scale = min(max(1.0, NARROWEST_PX / width), LONGEST_PX / max(height, width))
    # At least two rows and columns: isolines are computed from differences.
    return max(2, round(height * scale)), max(2, round(width * scale))


def _paint_ground(
    pixels: Rgb,
    visible: Mask,
    hidden: Mask,
    inverse_depth: Floats,
    smooth: Floats,
    pen_px: float,
    blur_px: float,
) -> None:
    """Paints the ground, its outlines and its isolines of distance.

    Args:
        pixels: uint8 (H, W, 3), modified in place.
        visible: Bool (H, W).
        hidden: Bool (H, W).
        inverse_depth: float32 (H, W), for the colours.
        smooth: float32 (H, W), smoothed inverse depth, for the isolines.
        pen_px: Width of a line.
        blur_px: Standard deviation of the Gaussian that smooths the masks' outlines.
    """
    height, width = visible.shape
    distance_of_px = blurred_edge_px(blur_px)
    is_near = distance_of_px > -(1.6 * pen_px + 0.5)
    levels = [_blurred(mask, blur_px) for mask in (visible, hidden)]
    colours = colour_scale().T.astype(np.float32)
    for top in range(0, height, _BAND_PX):
        rows = slice(top, top + _BAND_PX)
        seen, behind = (level[rows].ravel() for level in levels)
        where = np.flatnonzero(is_near[np.maximum(seen, behind)])
        if not where.size:
            continue
        band = pixels[rows].reshape(-1, 3)
        under = band.take(where, axis=0).T.astype(np.float32, order="C")
        visible_px, hidden_px = (distance_of_px.take(level.take(where)) for level in (seen, behind))
        depth_m = np.reciprocal(inverse_depth[rows].take(where))
        tint = colours.take(scale_position(depth_m), axis=1)
        grey = _GREY @ under
        paint(under, TINT * tint + (1 - TINT) * grey, inside(visible_px))
        if (hidden_px > -0.5).any():
            diagonal_px = (top + where // width + where % width).astype(np.float32)
            hatch(under, tint, inside(hidden_px), diagonal_px, pen_px)
        anywhere = inside(np.maximum(visible_px, hidden_px))
        lines = _isolines(smooth, rows, pen_px).take(where)
        paint(under, WHITE_PIXEL, 0.5 * anywhere * lines)
        for distance_px in (hidden_px, visible_px):
            edge_px = np.abs(distance_px)
            paint(under, INK_PIXEL, 0.5 * inside(np.float32(1.6 * pen_px) - edge_px))
            paint(under, WHITE_PIXEL, inside(np.float32(0.7 * pen_px) - edge_px))
        band[where] = np.rint(under).astype(np.uint8).T


def _blurred(mask: Mask, blur_px: float) -> NDArray[np.uint8]:
    """uint8 (H, W), from 0 outside to 255 inside."""
    image = Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0)))
    return np.asarray(image.filter(ImageFilter.GaussianBlur(blur_px)))


def _smooth(inverse_depth: Floats) -> Floats:
    """Smooths inverse depth with a moving mean, which preserves planes."""
    inverse_depth = inverse_depth.astype(np.float64)
    for axis in (0, 1, 0, 1):
        reach = min(_RIPPLE_PX, inverse_depth.shape[axis] - 1)
        around = [(reach, reach) if axis == each else (0, 0) for each in (0, 1)]
        # an odd reflection continues the slope: no flat rim at the picture's border
        padded = np.pad(inverse_depth, around, mode="reflect", reflect_type="odd")
        before = [(1, 0) if axis == each else (0, 0) for each in (0, 1)]
        sums = np.moveaxis(np.pad(padded.cumsum(axis), before), axis, 0)
        window = 2 * reach + 1
        inverse_depth = np.moveaxis((sums[window:] - sums[:-window]) / window, 0, axis)
    return np.maximum(inverse_depth, 1e-3).astype(np.float32)


def _isolines(inverse_depth: Floats, rows: slice, pen_px: float) -> Floats:
    """Coverage, 0 to 1, of the isolines at the legend's ticks, for some rows."""
    first = max(0, rows.start - 1)  # a slope needs the neighbours
    inverse_depth = inverse_depth[first : rows.stop + 1]
    down, right = np.gradient(inverse_depth)  # constant on a plane
    steepness = np.sqrt(down * down + right * right) + np.float32(1e-9)
    offset = np.full_like(inverse_depth, np.inf)
    for tick_m in TICKS_M:
        np.minimum(offset, np.abs(inverse_depth - np.float32(1 / tick_m)), out=offset)
    lines = inside(np.float32(0.5 * pen_px) - offset / steepness)
    return lines[rows.start - first :][: rows.stop - rows.start]


def _label_isolines(picture: Image.Image, inverse_depth: Floats, ground: Mask) -> None:
    """Labels every isoline that is long enough with its distance."""
    height, width = ground.shape
    font = ImageFont.load_default(max(11, round(max(height, width) / 80)))
    draw = ImageDraw.Draw(picture)
    placed: list[tuple[float, float, float, float]] = []
    passed = np.zeros(inverse_depth.shape, np.uint8)
    for tick_m in TICKS_M:
        passed += inverse_depth <= 1 / tick_m
    crossings = np.nonzero((passed[:-1] > passed[1:]) & ground[:-1] & ground[1:])
    above, below = passed[:-1][crossings], passed[1:][crossings]
    for index, tick_m in enumerate(TICKS_M):
        rows, columns = (places[(above > index) & (below <= index)] for places in crossings)
        text = f"{tick_m:g} m"
        left, top, right, bottom = draw.textbbox((0, 0), text, font, anchor="mm")
        if len(columns) < 3 * (right - left):
            continue
        at = np.argsort(columns)[len(columns) // 2]
        x, y = int(columns[at]), int(rows[at])
        pad = 0.3 * (bottom - top)
        box = (x + left - 2 * pad, y + top - pad, x + right + 2 * pad, y + bottom + pad)
        fits = box[0] >= 0 and box[1] >= 0 and box[2] < width and box[3] < height
        if not fits or any(_overlap(box, other) for other in placed):
            continue
        placed.append(box)
        pill = _pill(round(box[2] - box[0]), round(box[3] - box[1]))
        picture.paste(PAPER, (round(box[0]), round(box[1])), pill)
        draw.text((x, y), text, WHITE, font, anchor="mm")


def _pill(width: int, height: int) -> Image.Image:
    """Mask of a label: an antialiased box with round ends."""
    fine = Image.new("L", (4 * width, 4 * height))
    ImageDraw.Draw(fine).rounded_rectangle(
        (0, 0, 4 * width - 1, 4 * height - 1), radius=2 * height, fill=255
    )
    return fine.resize((width, height), Image.Resampling.BOX)


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def lens_note(source: IntrinsicsSource) -> str:
    """What a picture says about its camera: nothing if it is known."""
    if source == "assumed":
        return f"lens assumed: {ASSUMED_FOV_DEG:g} degrees; all metres depend on it"
    return "rectified picture" if source == "rectified" else ""


def draw_legend(width: int, height: int, note: str = "") -> Image.Image:
    """Draws the strip below the picture: a swatch for each kind of ground, and the colour scale.

    Args:
        width: Width of the strip, pixels.
        height: Height of the picture above it.
        note: A line of text at the bottom, if any.
    """
    letter = max(11, round(min(width / 42, max(width, height) / 62)))
    font = ImageFont.load_default(letter)
    margin = round(1.4 * letter)
    swatches = _swatches(letter, font)
    one_row = width >= swatches.width + 22 * letter + 3 * margin
    bar_width = width - 2 * margin - (swatches.width + 2 * margin if one_row else 0)
    bar = _bar(bar_width, letter, font)
    rows = max(swatches.height, bar.height) if one_row else swatches.height + bar.height + letter
    strip = Image.new("RGB", (width, rows + 2 * letter), PAPER)
    if one_row:
        strip.paste(swatches, (margin, letter + (rows - swatches.height) // 2))
        strip.paste(bar, (width - margin - bar.width, letter + (rows - bar.height) // 2))
    else:
        strip.paste(swatches, (margin, letter))
        strip.paste(bar, (margin, letter + swatches.height + letter))
    if not note:
        return strip
    line = Image.new("RGB", (width, round(1.6 * letter)), PAPER)
    small = ImageFont.load_default(max(10, round(0.85 * letter)))
    ImageDraw.Draw(line).text((margin, 0.4 * letter), note, FAINT, small, anchor="lm")
    return _stacked(strip, line)


def _swatches(letter: int, font: ImageFont.ImageFont | ImageFont.FreeTypeFont) -> Image.Image:
    side, gap = round(1.7 * letter), round(0.6 * letter)
    words = ("visible ground", "hidden ground")
    lengths = [round(font.getbbox(word)[2]) for word in words]
    between = round(1.8 * letter)
    strip = Image.new("RGB", (2 * (side + gap) + sum(lengths) + between, side), PAPER)
    draw = ImageDraw.Draw(strip)
    colour = np.repeat(colour_scale()[110].astype(np.float32)[:, None], side * side, axis=1)
    hatched = np.full_like(colour, 110)
    diagonal_px = np.add.outer(np.arange(side), np.arange(side)).astype(np.float32).ravel()
    hatch(hatched, colour, np.ones_like(diagonal_px), diagonal_px, letter / 14)
    line = max(1, letter // 10)
    x = 0
    for word, length, tile in zip(words, lengths, (colour, hatched), strict=True):
        square = np.rint(tile.T).astype(np.uint8).reshape(side, side, 3)
        strip.paste(Image.fromarray(square), (x, 0))
        draw.rectangle((x, 0, x + side - 1, side - 1), outline=WHITE, width=line)
        draw.text((x + side + gap, side / 2), word, WHITE, font, anchor="lm")
        x += side + gap + length + between
    return strip


def _bar(
    width: int, letter: int, font: ImageFont.ImageFont | ImageFont.FreeTypeFont
) -> Image.Image:
    """Draws the colour scale with its ticks in metres."""
    bar_height, tick = round(0.9 * letter), max(2, round(0.35 * letter))
    side = round(1.6 * letter)  # half a label hangs over each end
    span = max(2, width - 2 * side)
    strip = Image.new("RGB", (width, bar_height + tick + round(1.6 * letter)), PAPER)
    index = np.rint(np.linspace(0, len(colour_scale()) - 1, span)).astype(int)
    strip.paste(Image.fromarray(np.repeat(colour_scale()[index][None], bar_height, 0)), (side, 0))
    draw = ImageDraw.Draw(strip)
    positions = scale_position(np.array(TICKS_M, np.float32))
    for tick_m, position in zip(TICKS_M, positions, strict=True):
        x = side + round(float(position) / (len(colour_scale()) - 1) * (span - 1))
        draw.line((x, bar_height, x, bar_height + tick), FAINT, max(1, letter // 12))
        more = "+" if tick_m == FARTHEST_M else ""
        text = f"{tick_m:g}{more} m"
        draw.text((x, bar_height + tick + 0.3 * letter), text, FAINT, font, anchor="mt")
    return strip


def _stacked(above: Image.Image, below: Image.Image) -> Image.Image:
    stack = Image.new("RGB", (below.width, above.height + below.height), PAPER)
    stack.paste(above, ((below.width - above.width) // 2, 0))
    stack.paste(below, (0, above.height))
    return stack
