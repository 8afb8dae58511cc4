"""A sheet of failure cases: photo, ground truth and prediction side by side."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.style import FAINT, PAPER, WHITE
from footprints_edge.foundation.types import Mask, Rgb
from footprints_edge_bench.accuracy.baselines import Estimate
from footprints_edge_bench.ground_truth.base import GroundTruth

_TILE_PX = 480
_LETTER_PX = 16
_GAP_PX = 8
_VISIBLE, _HIDDEN = (46, 134, 255), (255, 138, 0)
_STRIPES_PX = 12


@dataclass(frozen=True, eq=False)
class Example:
    """One row of the sheet.

    Attributes:
        title: name and scores of the image.
        rgb: the photo, uint8 (H, W, 3).
        ground_truth: the ground truth of the image.
        estimate: the model's estimate, at the size of the ground truth.
    """

    title: str
    rgb: Rgb
    ground_truth: GroundTruth
    estimate: Estimate


def draw_examples(examples: Sequence[Example]) -> Image.Image:
    """A sheet with a legend and one row per example.

    Visible ground is tinted blue, hidden ground is hatched in orange, unscored pixels are grey.
    """
    rows = [_row(example) for example in examples]
    legend = _legend(3 * _TILE_PX + 4 * _GAP_PX)
    sheet = Image.new("RGB", (legend.width, legend.height + sum(r.height for r in rows)), PAPER)
    y = 0
    for strip in [legend, *rows]:
        sheet.paste(strip, (0, y))
        y += strip.height
    return sheet


def _row(example: Example) -> Image.Image:
    ground_truth, estimate = example.ground_truth, example.estimate
    height = max(1, round(_TILE_PX * ground_truth.size[0] / ground_truth.size[1]))
    photo = Image.fromarray(example.rgb).resize((_TILE_PX, height), Image.Resampling.LANCZOS)
    everywhere = np.ones(ground_truth.size, bool)
    seen, ground = ground_truth.visible_ground, ground_truth.ground
    nothing = ~everywhere
    true_visible, true_hidden, valid = nothing, nothing, everywhere
    predicted_visible, predicted_hidden = nothing, nothing
    if seen is not None:
        predicted_visible = nothing if estimate.visible_ground is None else estimate.visible_ground
        true_visible, valid = seen.mask, seen.valid
    if ground is not None:
        valid = ground.valid
        # Ground whose visibility is unknown is shown as visible.
        unseen = nothing if seen is None else seen.valid & ~seen.mask
        true_visible, true_hidden = ground.mask & ~unseen, ground.mask & unseen
        predicted = nothing if estimate.ground is None else estimate.ground
        predicted_visible = predicted if seen is None else predicted & predicted_visible
        predicted_hidden = predicted & ~predicted_visible
    tiles = [
        photo,
        _tinted(photo, true_visible, true_hidden, ~valid),
        _tinted(photo, predicted_visible, predicted_hidden, ~valid),
    ]
    caption = round(1.9 * _LETTER_PX)
    strip = Image.new("RGB", (3 * _TILE_PX + 4 * _GAP_PX, caption + height + _GAP_PX), PAPER)
    draw = ImageDraw.Draw(strip)
    draw.text((_GAP_PX, caption / 2), example.title, WHITE, _font(), anchor="lm")
    for i, tile in enumerate(tiles):
        strip.paste(tile, (_GAP_PX + i * (_TILE_PX + _GAP_PX), caption))
    return strip


def _tinted(photo: Image.Image, visible: Mask, hidden: Mask, unscored: Mask) -> Image.Image:
    """The photo with masks, all of the same size, in their colours."""
    pixels = np.asarray(photo, np.float32)
    grey = np.asarray(photo.convert("L"), np.float32)[..., None]
    width, height = photo.size
    across = (np.arange(height)[:, None] + np.arange(width)) % _STRIPES_PX < _STRIPES_PX / 2

    def shown(mask: Mask) -> Mask:
        resized = Image.fromarray(mask).resize((width, height), Image.Resampling.NEAREST)
        return np.asarray(resized)[..., None]

    def mixed(colour: tuple[int, int, int]) -> np.ndarray:
        return 0.55 * np.array(colour, np.float32) + 0.45 * grey

    pixels = np.where(shown(visible), mixed(_VISIBLE), pixels)
    hatched = np.where(across[..., None], mixed(_HIDDEN), 0.6 * pixels)
    pixels = np.where(shown(hidden), hatched, pixels)
    pixels = np.where(shown(unscored), 0.25 * pixels + 0.25 * grey + 48, pixels)
    return Image.fromarray(np.rint(np.clip(pixels, 0, 255)).astype(np.uint8))


def _legend(width: int) -> Image.Image:
    strip = Image.new("RGB", (width, round(3.6 * _LETTER_PX)), PAPER)
    draw = ImageDraw.Draw(strip)
    y = 0.9 * _LETTER_PX
    x = float(_GAP_PX)
    flat = Image.new("RGB", (_LETTER_PX * 2, _LETTER_PX), (120, 120, 120))
    yes, no = np.ones((1, 1), bool), np.zeros((1, 1), bool)
    for word, masks in (
        ("visible ground", (yes, no, no)),
        ("hidden ground", (no, yes, no)),
        ("not scored", (no, no, yes)),
    ):
        strip.paste(_tinted(flat, *masks), (round(x), round(y - _LETTER_PX / 2)))
        x += 2.5 * _LETTER_PX
        draw.text((x, y), word, FAINT, _font(), anchor="lm")
        x += draw.textlength(word, _font()) + 2 * _LETTER_PX
    for i, word in enumerate(("photo", "ground truth", "prediction")):
        middle = _GAP_PX + i * (_TILE_PX + _GAP_PX) + _TILE_PX / 2
        draw.text((middle, 2.7 * _LETTER_PX), word, WHITE, _font(), anchor="mm")
    return strip


def _font() -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    return ImageFont.load_default(_LETTER_PX)
