"""The overlay: ground tinted by distance, hidden ground hatched, a legend below."""

from functools import cache, lru_cache, partial

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
from footprints_edge.drawing.notes import picture_note
from footprints_edge.drawing.style import FAINT, PAPER, TINT, WHITE
from footprints_edge.foundation.png import encode_png
from footprints_edge.foundation.types import Floats, Mask, Rgb, Size
from footprints_edge.inputs.preprocessing import resized
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.maps.resize import resize_map, resize_rows
from footprints_edge.parallel.bands import at_once

LONGEST_PX = 1920
"""Larger pictures are drawn at this size; the maps themselves have far fewer pixels."""

NARROWEST_PX = 480
"""Narrower pictures are enlarged to this width, to make room for lines and letters."""

TICKS_M = (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)

_RIPPLE_PX = 12  # in pixels of the maps

_GREY = np.array([0.299, 0.587, 0.114], np.float32)

_LINE = 0.5  # opacity of an isoline

_BAND_PX = 32  # rows painted at a time, to fit the processor's cache

_PLACES, _PLACES_A_METRE = 2**15, np.float32(2**15 / 2.5)
"""Steps of the inverse depth in the table of colours, up to beyond the nearest colour."""

LEGEND_PX = 300
"""Least width of the legend. Very tall pictures get margins instead of a clipped legend."""


def encode_overlay(prediction: GroundMaps, *, bev: bool = False) -> bytes:
    """Encodes `draw_overlay` as PNG."""
    return encode_png(_drawn(prediction, bev=bev), at_once)


def draw_overlay(prediction: GroundMaps, *, bev: bool = False) -> Image.Image:
    """Draws a prediction on its picture.

    Visible ground is tinted and hidden ground hatched in the colour of its distance, both
    outlined; thin lines mark round distances. The legend is a strip below the picture. Where the
    picture shows no ground, nothing is drawn, and the legend says so.

    Args:
        prediction: The prediction to draw.
        bev: Whether to add a bird's-eye view beside the picture; it stays empty if there is too
            little ground for a plane.

    Returns:
        RGB image: the picture's size, limited by `NARROWEST_PX` and `LONGEST_PX`, plus the legend.
        The bird's-eye view is a square as high as both.
    """
    return Image.fromarray(_drawn(prediction, bev=bev))


def _drawn(prediction: GroundMaps, *, bev: bool) -> Rgb:
    """uint8 (H, W, 3): what `draw_overlay` draws."""
    height, width = size = _canvas_size(prediction.image_size)
    _require_depths(prediction)
    shown = prediction.shows_ground
    note = picture_note(prediction.intrinsics.source, shows_ground=shown)
    legend = _legend(max(width, LEGEND_PX), height, note)
    rows, columns = height + legend.shape[0], legend.shape[1]
    canvas = np.empty((rows, columns + rows * bev, 3), np.uint8)
    canvas[:height, :columns] = PAPER
    canvas[height:, :columns] = legend
    left = (columns - width) // 2
    pixels = canvas[:height, left : left + width]
    photo = prediction.picture.at_least(size)
    pixels[:] = photo if photo.shape[:2] == size else resized(photo, size, reducing_gap=2.0)
    if shown:
        _paint_ground(pixels, prediction)
    if bev:
        from footprints_edge.drawing.occupancy_grid import draw_bev

        canvas[:, columns:] = np.asarray(draw_bev(prediction, rows))
    return canvas


@lru_cache(maxsize=4)
def _legend(width: int, height: int, note: str) -> Rgb:
    """The pixels of `draw_legend`, which the pictures of a folder share."""
    return np.asarray(draw_legend(width, height, note))


def _require_depths(prediction: GroundMaps) -> Floats:
    """A file without depths is refused for every picture, not only for those that show ground."""
    return prediction.visible_depth_m


def _resized_mask(probability: Floats, threshold: float, size: Size) -> Mask:
    return resize_map(probability, size) > threshold


def _canvas_size(image_size: Size) -> Size:
    height, width = image_size
    scale = min(max(1.0, NARROWEST_PX / width), LONGEST_PX / max(height, width))
    # At least two rows and columns: isolines are computed from differences.
    return max(2, round(height * scale)), max(2, round(width * scale))


def _paint_ground(pixels: Rgb, prediction: GroundMaps) -> None:
    """Paints the ground, its outlines, and labelled isolines of distance.

    Args:
        pixels: uint8 (H, W, 3), modified in place.
        prediction: The prediction to draw.
    """
    height, width = size = pixels.shape[0], pixels.shape[1]
    pen_px = max(1.0, max(size) / 700)
    blur_px = max(2 * pen_px, 0.5 * max(size) / max(prediction.map_size))
    # The blur hides the steps of outlines at half of the size, for a quarter of the work.
    coarse = -(-height // 2), -(-width // 2)
    inverse_depth = np.reciprocal(prediction.unmasked_ground_depth_m)
    # Isolines follow every ripple of a depth; smoothed inverse depth gives legible ones.
    smooth, visible, ground = at_once(
        [
            lambda: _smooth(inverse_depth),
            *(
                partial(_resized_mask, each, prediction.threshold, coarse)
                for each in (prediction.visible_ground_probability, prediction.ground_probability)
            ),
        ]
    )
    levels = at_once(
        partial(_blurred, mask, blur_px / 2, size) for mask in (visible, ground & ~visible)
    )
    distance_of_px = blurred_edge_px(blur_px)
    is_near = distance_of_px > -(1.6 * pen_px + 0.5)
    position_of, colours = _scale_by_inverse_depth(), colour_scale().T.astype(np.float32)
    tinted = _tinted()

    def paint_band(rows: slice) -> None:
        seen, behind = (level[rows].ravel() for level in levels)
        inner = (seen == 255) & (behind == 0)
        border = is_near[np.maximum(seen, behind)]
        border &= ~inner
        if not (inner.any() or border.any()):
            return
        band = np.ascontiguousarray(pixels[rows])
        places = resize_rows(inverse_depth, size, rows).ravel()
        places *= _PLACES_A_METRE
        np.minimum(places, len(position_of) - 1, out=places)
        positions = position_of.take(places.astype(np.intp))
        lines = _isolines(smooth, size, rows, pen_px)
        _paint_inner(band, np.flatnonzero(inner), positions, tinted, lines)
        band = band.reshape(-1, 3)
        where = np.flatnonzero(border)
        if where.size:
            under = band.take(where, axis=0).T.astype(np.float32, order="C")
            visible_px, hidden_px = (
                distance_of_px.take(each.take(where)) for each in (seen, behind)
            )
            tint = colours.take(positions.take(where), axis=1)
            paint(under, TINT * tint + (1 - TINT) * (_GREY @ under), inside(visible_px))
            if (hidden_px > -0.5).any():
                diagonal_px = (rows.start + where // width + where % width).astype(np.float32)
                hatch(under, tint, inside(hidden_px), diagonal_px, pen_px)
            if lines is not None:
                anywhere = inside(np.maximum(visible_px, hidden_px))
                paint(under, WHITE_PIXEL, _LINE * anywhere * lines.take(where))
            for distance_px in (hidden_px, visible_px):
                edge_px = np.abs(distance_px)
                paint(under, INK_PIXEL, 0.5 * inside(np.float32(1.6 * pen_px) - edge_px))
                paint(under, WHITE_PIXEL, inside(np.float32(0.7 * pen_px) - edge_px))
            band[where] = np.rint(under).astype(np.uint8).T
        pixels[rows] = band.reshape(-1, width, 3)

    tops = range(0, height, _BAND_PX)
    at_once(partial(paint_band, slice(top, min(height, top + _BAND_PX))) for top in tops)
    _label_isolines(pixels, resize_map(smooth, coarse), ground | visible)


def _paint_inner(
    band: Rgb,
    where: NDArray[np.intp],
    positions: NDArray[np.uint8],
    tinted: NDArray[np.uint32],
    lines: Floats | None,
) -> None:
    """Paints visible ground far from its outlines: most pixels, by one table.

    Args:
        band: uint8 (H, W, 3), modified in place.
        where: Indices of the pixels to paint.
        positions: uint8 (H W,), the place of each in the colour scale.
        tinted: What `_tinted` gives.
        lines: float32 (H, W), the coverage of isolines; None if there are none.
    """
    if not where.size:
        return
    grey = np.asarray(Image.fromarray(band).convert("L")).ravel()
    pairs = positions.astype(np.uint16)
    pairs <<= 8
    pairs |= grey
    painted = tinted.take(pairs.take(where)).view(np.uint8).reshape(-1, 4)
    flat = band.reshape(-1, 3)
    for channel in range(3):
        flat[where, channel] = painted[:, channel]
    if lines is None:
        return
    coverage = lines.take(where)
    covered = np.flatnonzero(coverage)
    on = where[covered]
    under = flat[on].T.astype(np.float32)
    paint(under, WHITE_PIXEL, _LINE * coverage[covered])
    flat[on] = np.rint(under).astype(np.uint8).T


@cache
def _tinted() -> NDArray[np.uint32]:
    """uint32 (65536,): four bytes R, G, B, 0 of a tinted pixel, by place in the scale and grey."""
    tint = TINT * colour_scale().astype(np.float32)[:, None]
    grey = (1 - TINT) * np.arange(256, dtype=np.float32)[:, None]
    table = np.zeros((256, 256, 4), np.uint8)
    table[..., :3] = np.rint(tint + grey)
    return table.reshape(-1, 4).view(np.uint32).ravel()


@cache
def _scale_by_inverse_depth() -> NDArray[np.uint8]:
    """The index in the colour scale, for inverse depths in steps of 1 / `_PLACES_A_METRE`.

    A table is faster than a logarithm for each pixel, and as exact as the eye.
    """
    inverse_m = (np.arange(_PLACES) + 0.5) / _PLACES_A_METRE
    return scale_position((1 / inverse_m).astype(np.float32)).astype(np.uint8)


def _blurred(mask: Mask, blur_px: float, size: Size) -> NDArray[np.uint8]:
    """uint8 of a larger size (H, W), from 0 outside to 255 inside."""
    height, width = size
    image = Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0)))
    if mask.any():
        image = image.filter(ImageFilter.GaussianBlur(blur_px))
    return np.asarray(image.resize((width, height), Image.Resampling.BILINEAR))


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


def _isolines(inverse_depth: Floats, size: Size, rows: slice, pen_px: float) -> Floats | None:
    """Coverage, 0 to 1, of the isolines at the legend's ticks, for some rows of a larger size.

    None where no isoline passes.
    """
    scale = inverse_depth.shape[0] / size[0]
    near = inverse_depth[
        max(0, int((rows.start - 4) * scale) - 1) : int((rows.stop + 4) * scale) + 2
    ]
    least, most = near.min(), near.max()
    passing = [1 / tick_m for tick_m in TICKS_M if least <= 1 / tick_m <= most]
    if not passing:
        return None
    first = max(0, rows.start - 1)  # a slope needs the neighbours
    part = resize_rows(inverse_depth, size, slice(first, min(size[0], rows.stop + 1)))
    down, right = np.gradient(part)  # constant on a plane
    steepness: Floats = np.hypot(down, right)
    steepness += np.float32(1e-9)
    offset = np.abs(part - np.float32(passing[0]))
    for other in passing[1:]:
        np.minimum(offset, np.abs(part - np.float32(other)), out=offset)
    offset /= steepness
    lines = inside(np.float32(0.5 * pen_px) - offset)
    return lines[rows.start - first :][: rows.stop - rows.start]


def _label_isolines(pixels: Rgb, inverse_depth: Floats, ground: Mask) -> None:
    """Labels every isoline that is long enough with its distance.

    Args:
        pixels: uint8 (H, W, 3), modified in place.
        inverse_depth: float32 of half of the sides.
        ground: Bool, likewise.
    """
    height, width = pixels.shape[:2]
    font = ImageFont.load_default(max(11, round(max(height, width) / 80)))
    measure = ImageDraw.Draw(Image.new("RGB", (1, 1)))
    placed: list[tuple[int, int, int, int]] = []
    passed = np.zeros(inverse_depth.shape, np.uint8)
    for tick_m in TICKS_M:
        passed += inverse_depth <= 1 / tick_m
    crossings = np.nonzero((passed[:-1] > passed[1:]) & ground[:-1] & ground[1:])
    above, below = passed[:-1][crossings], passed[1:][crossings]
    for index, tick_m in enumerate(TICKS_M):
        rows, columns = (2 * places[(above > index) & (below <= index)] for places in crossings)
        text = f"{tick_m:g} m"
        left, top, right, bottom = measure.textbbox((0, 0), text, font, anchor="mm")
        if 2 * len(columns) < 3 * (right - left):
            continue
        at = np.argsort(columns)[len(columns) // 2]
        x, y = int(columns[at]), int(rows[at])
        pad = 0.3 * (bottom - top)
        box = (
            round(x + left - 2 * pad),
            round(y + top - pad),
            round(x + right + 2 * pad),
            round(y + bottom + pad),
        )
        fits = box[0] >= 0 and box[1] >= 0 and box[2] < width and box[3] < height
        if not fits or any(_overlap(box, other) for other in placed):
            continue
        placed.append(box)
        under = pixels[box[1] : box[3], box[0] : box[2]]
        label = Image.fromarray(under)
        label.paste(PAPER, (0, 0), _pill(label.width, label.height))
        at_label = (x - box[0], y - box[1])
        ImageDraw.Draw(label).text(at_label, text, WHITE, font, anchor="mm")
        under[:] = np.asarray(label)


def _pill(width: int, height: int) -> Image.Image:
    """Mask of a label: an antialiased box with round ends."""
    fine = Image.new("L", (4 * width, 4 * height))
    ImageDraw.Draw(fine).rounded_rectangle(
        (0, 0, 4 * width - 1, 4 * height - 1), radius=2 * height, fill=255
    )
    return fine.resize((width, height), Image.Resampling.BOX)


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


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
