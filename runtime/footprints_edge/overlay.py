"""The picture for people: ground tinted by distance, hidden ground hatched, a legend below."""

from statistics import NormalDist

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from footprints_edge.arrays import Floats, Mask, Size
from footprints_edge.colours import FARTHEST_M, colour_scale, colours_of, scale_position
from footprints_edge.prediction import Prediction, resize_depth

LONGEST_PX = 1920
"""Longer pictures are drawn at this size; the maps themselves have far fewer pixels."""

NARROWEST_PX = 480
"""Narrower pictures are enlarged to this: lines and letters need the room."""

TICKS_M = (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)

_RIPPLE_PX = 12  # of the maps

_LEGEND_PX = 300  # a tower of a picture gets margins rather than a legend that is cut off

_WHITE, _INK, _PAPER, _FAINT = (255, 255, 255), (14, 16, 22), (22, 24, 31), (170, 176, 188)


def draw_overlay(prediction: Prediction) -> Image.Image:
    """Draws a prediction on its picture.

    Visible ground is a solid tint, hidden ground a hatching in the colour of its distance, both
    outlined; thin lines mark round distances. The legend has a strip of its own below.

    Returns:
        RGB image: the picture's size within `NARROWEST_PX` and `LONGEST_PX`, plus the legend.
    """
    size = _canvas_size(prediction.image_size)
    pen_px = max(1.0, max(size) / 700)
    photo = Image.fromarray(prediction.rgb).resize(
        (size[1], size[0]), Image.Resampling.LANCZOS, reducing_gap=2.0
    )
    large = prediction.at_size(size)
    depth_m = large.unmasked_ground_depth_m
    # Lines follow every ripple of a depth; those of the ground's broad shape can be read.
    broad_m = resize_depth(_broad(prediction.unmasked_ground_depth_m), size)
    blur_px = max(2 * pen_px, 0.5 * max(size) / max(prediction.map_size))
    visible = _signed_distance_px(large.visible_ground, blur_px)
    hidden = _signed_distance_px(large.hidden_ground, blur_px)

    pixels = np.array(photo, np.float32)
    tint = colours_of(depth_m).astype(np.float32)
    grey = np.asarray(photo.convert("L"), np.float32)[..., None]
    _paint(pixels, 0.62 * tint + 0.38 * grey, _inside(visible))
    _hatch(pixels, tint, _inside(hidden), pen_px)
    anywhere = _inside(np.maximum(visible, hidden))
    _paint(pixels, _WHITE, 0.5 * anywhere * _isolines(broad_m, pen_px))
    for distance_px in (hidden, visible):
        edge_px = np.abs(distance_px)
        _paint(pixels, _INK, 0.5 * _inside(np.float32(1.6 * pen_px) - edge_px))
        _paint(pixels, _WHITE, _inside(np.float32(0.7 * pen_px) - edge_px))

    picture = Image.fromarray(np.rint(pixels).astype(np.uint8))
    _label_isolines(picture, broad_m, large.ground | large.visible_ground)
    return _stacked(picture, _legend(max(picture.width, _LEGEND_PX), picture.height))


def _canvas_size(image_size: Size) -> Size:
    height, width = image_size
    scale = min(max(1.0, NARROWEST_PX / width), LONGEST_PX / max(height, width))
    # At least two rows and columns: lines of equal distance come from differences.
    return max(2, round(height * scale)), max(2, round(width * scale))


def _paint(pixels: Floats, colour: Floats | tuple[int, int, int], opacity: Floats) -> None:
    """Mixes a colour, or (H, W, 3) colours, into `pixels` where `opacity` (H, W) is not 0."""
    where = np.nonzero(opacity > 0)
    over = colour[where] if isinstance(colour, np.ndarray) else np.array(colour, np.float32)
    pixels[where] += opacity[where][:, None] * (over - pixels[where])


def _inside(distance_px: Floats) -> Floats:
    """Coverage of a pixel, 0 to 1, whose centre is so far inside an edge: antialiasing."""
    coverage: Floats = np.clip(distance_px + np.float32(0.5), 0, 1)
    return coverage


def _signed_distance_px(mask: Mask, blur_px: float) -> Floats:
    """How far inside (positive) or outside the mask's smoothed outline a pixel is, near to it.

    A straight edge blurred by a Gaussian is that Gaussian's distribution function of the
    distance: its inverse gives the distance back, and the blur rounds off the maps' pixels.
    """
    blurred = Image.fromarray(np.where(mask, np.uint8(255), np.uint8(0)))
    levels = np.asarray(blurred.filter(ImageFilter.GaussianBlur(blur_px)))
    inverse = NormalDist(0, blur_px).inv_cdf
    distances = np.array([inverse((level + 0.5) / 256) for level in range(256)], np.float32)
    distances[[0, -1]] = -1e3, 1e3
    distance_px: Floats = distances[levels]
    return distance_px


def _hatch(pixels: Floats, colour: Floats, opacity: Floats, pen_px: float) -> None:
    """Diagonal stripes of the colour, lit on one side, with the picture darkened in between.

    Light against dark: the stripes show on any picture, in any colour, and in grey print.
    """
    height, width = opacity.shape
    period_px, stripe_px = 10 * pen_px, 4.4 * pen_px
    across = (np.arange(height)[:, None] + np.arange(width)) / np.sqrt(2)
    position_px = (across % period_px).astype(np.float32) - np.float32(period_px / 2)
    stripe = _inside(stripe_px / 2 - np.abs(position_px))
    rim = _inside(0.6 * pen_px - np.abs(position_px + stripe_px / 2))
    _paint(pixels, _INK, 0.45 * opacity * (1 - stripe))
    _paint(pixels, colour, opacity * (0.12 + 0.83 * stripe))
    _paint(pixels, _WHITE, 0.8 * opacity * rim)


def _broad(depth_m: Floats) -> Floats:
    """The depth without its ripples: a moving mean of its inverse, which keeps planes planes."""
    nearness = np.reciprocal(depth_m, dtype=np.float64)
    for axis in (0, 1, 0, 1):
        reach = min(_RIPPLE_PX, nearness.shape[axis] - 1)
        around = [(reach, reach) if axis == each else (0, 0) for each in (0, 1)]
        # an odd reflection goes on as the slope does: no flat rim at the picture's border
        padded = np.pad(nearness, around, mode="reflect", reflect_type="odd")
        window = sliding_window_view(padded, 2 * reach + 1, axis=axis)
        nearness = window.mean(axis=-1)
    return np.reciprocal(np.maximum(nearness, 1e-3)).astype(np.float32)


def _isolines(depth_m: Floats, pen_px: float) -> Floats:
    """Lines of equal distance at the legend's ticks, as coverage (H, W) from 0 to 1."""
    nearness = np.reciprocal(depth_m)  # affine on a plane: its gradient is even and well-behaved
    down, right = np.gradient(nearness)
    steepness = np.hypot(down, right) + np.float32(1e-9)
    lines = np.zeros_like(depth_m)
    for tick_m in TICKS_M:
        away_px = np.abs(nearness - np.float32(1 / tick_m)) / steepness
        np.maximum(lines, _inside(np.float32(0.5 * pen_px) - away_px), out=lines)
    return lines


def _label_isolines(picture: Image.Image, depth_m: Floats, ground: Mask) -> None:
    """Writes the distance on every line that is long enough to carry it."""
    height, width = ground.shape
    font = ImageFont.load_default(max(11, round(max(height, width) / 80)))
    draw = ImageDraw.Draw(picture)
    taken: list[tuple[float, float, float, float]] = []
    beyond = depth_m[:-1] >= np.array(TICKS_M, np.float32)[:, None, None]
    for tick_m, above in zip(TICKS_M, beyond, strict=True):
        crossing = above & (depth_m[1:] < tick_m) & ground[:-1] & ground[1:]
        rows, columns = np.nonzero(crossing)
        text = f"{tick_m:g} m"
        left, top, right, bottom = draw.textbbox((0, 0), text, font, anchor="mm")
        if len(columns) < 3 * (right - left):
            continue
        at = np.argsort(columns)[len(columns) // 2]
        x, y = int(columns[at]), int(rows[at])
        pad = 0.3 * (bottom - top)
        box = (x + left - 2 * pad, y + top - pad, x + right + 2 * pad, y + bottom + pad)
        fits = box[0] >= 0 and box[1] >= 0 and box[2] < width and box[3] < height
        if not fits or any(_overlap(box, other) for other in taken):
            continue
        taken.append(box)
        pill = _pill(round(box[2] - box[0]), round(box[3] - box[1]))
        picture.paste(_PAPER, (round(box[0]), round(box[1])), pill)
        draw.text((x, y), text, _WHITE, font, anchor="mm")


def _pill(width: int, height: int) -> Image.Image:
    """The mask of a label: a box with round ends, antialiased."""
    fine = Image.new("L", (4 * width, 4 * height))
    ImageDraw.Draw(fine).rounded_rectangle(
        (0, 0, 4 * width - 1, 4 * height - 1), radius=2 * height, fill=255
    )
    return fine.resize((width, height), Image.Resampling.BOX)


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _legend(width: int, height: int) -> Image.Image:
    """The strip below the picture: a swatch for each kind of ground, and the colour scale."""
    letter = max(11, round(min(width / 42, max(width, height) / 62)))
    font = ImageFont.load_default(letter)
    margin = round(1.4 * letter)
    swatches = _swatches(letter, font)
    one_row = width >= swatches.width + 22 * letter + 3 * margin
    bar_width = width - 2 * margin - (swatches.width + 2 * margin if one_row else 0)
    bar = _bar(bar_width, letter, font)
    rows = max(swatches.height, bar.height) if one_row else swatches.height + bar.height + letter
    strip = Image.new("RGB", (width, rows + 2 * letter), _PAPER)
    if one_row:
        strip.paste(swatches, (margin, letter + (rows - swatches.height) // 2))
        strip.paste(bar, (width - margin - bar.width, letter + (rows - bar.height) // 2))
    else:
        strip.paste(swatches, (margin, letter))
        strip.paste(bar, (margin, letter + swatches.height + letter))
    return strip


def _swatches(letter: int, font: ImageFont.ImageFont | ImageFont.FreeTypeFont) -> Image.Image:
    side, gap = round(1.7 * letter), round(0.6 * letter)
    words = ("visible ground", "hidden ground")
    lengths = [round(font.getbbox(word)[2]) for word in words]
    between = round(1.8 * letter)
    strip = Image.new("RGB", (2 * (side + gap) + sum(lengths) + between, side), _PAPER)
    draw = ImageDraw.Draw(strip)
    colour = np.tile(colour_scale()[110].astype(np.float32), (side, side, 1))
    solid = colour.copy()
    hatched = np.full((side, side, 3), 110, np.float32)
    _hatch(hatched, colour, np.ones((side, side), np.float32), letter / 14)
    line = max(1, letter // 10)
    x = 0
    for word, length, tile in zip(words, lengths, (solid, hatched), strict=True):
        strip.paste(Image.fromarray(np.rint(tile).astype(np.uint8)), (x, 0))
        draw.rectangle((x, 0, x + side - 1, side - 1), outline=_WHITE, width=line)
        draw.text((x + side + gap, side / 2), word, _WHITE, font, anchor="lm")
        x += side + gap + length + between
    return strip


def _bar(
    width: int, letter: int, font: ImageFont.ImageFont | ImageFont.FreeTypeFont
) -> Image.Image:
    """The colour scale with its ticks in metres."""
    bar_height, tick = round(0.9 * letter), max(2, round(0.35 * letter))
    side = round(1.6 * letter)  # half a label hangs over each end
    span = max(2, width - 2 * side)
    strip = Image.new("RGB", (width, bar_height + tick + round(1.6 * letter)), _PAPER)
    index = np.rint(np.linspace(0, len(colour_scale()) - 1, span)).astype(int)
    strip.paste(Image.fromarray(np.repeat(colour_scale()[index][None], bar_height, 0)), (side, 0))
    draw = ImageDraw.Draw(strip)
    positions = scale_position(np.array(TICKS_M, np.float32))
    for tick_m, position in zip(TICKS_M, positions, strict=True):
        x = side + round(float(position) / (len(colour_scale()) - 1) * (span - 1))
        draw.line((x, bar_height, x, bar_height + tick), _FAINT, max(1, letter // 12))
        more = "+" if tick_m == FARTHEST_M else ""
        text = f"{tick_m:g}{more} m"
        draw.text((x, bar_height + tick + 0.3 * letter), text, _FAINT, font, anchor="mt")
    return strip


def _stacked(above: Image.Image, below: Image.Image) -> Image.Image:
    stack = Image.new("RGB", (below.width, above.height + below.height), _PAPER)
    stack.paste(above, ((below.width - above.width) // 2, 0))
    stack.paste(below, (0, above.height))
    return stack
