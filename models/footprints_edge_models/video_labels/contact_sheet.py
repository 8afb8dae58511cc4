"""A contact sheet of labels, to judge by eye: one frame per row, spread over the sequence."""

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.colormap import FARTHEST_M, colour_scale, colours_of, scale_position
from footprints_edge.drawing.style import FAINT, PAPER, WHITE
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.video_labels.files import frame_names, read_frame
from footprints_edge_models.video_labels.footprint_masks import (
    GROUND_PROBABILITY,
    NOT_GROUND_PROBABILITY,
)
from footprints_edge_models.video_labels.labeller import FrameLabels

WIDTH_PX = 1960
ROWS = 8
_MOST_HEIGHT_PX = 4000
_GAP_PX = 8
_LETTER_PX = 20
_TICKS_M = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0)

_VISIBLE, _HIDDEN = (64, 190, 110), (70, 130, 255)
_OBSTACLE, _MOVING = (235, 60, 50), (255, 205, 40)
_LEGEND = (
    (_VISIBLE, "visible ground"),
    (_HIDDEN, "hidden ground"),
    (_OBSTACLE, "untraversable"),
    (_MOVING, "moving"),
)

Picture = NDArray[np.uint8]


def write_contact_sheet(folder: Path) -> Path:
    """Draw the contact sheet of a folder of labels into it; returns its path."""
    path = folder / "contact-sheet.png"
    buffer = io.BytesIO()
    draw_contact_sheet(folder).save(buffer, "PNG")
    write_atomically(path, buffer.getvalue())
    return path


def draw_contact_sheet(folder: Path, rows: int = ROWS) -> Image.Image:
    """Draw some frames of a folder of labels.

    Columns: the image; the probability of visible ground, white is certain; the ground labels over
    the dimmed image; the depth of the ground, seen or hidden.

    Args:
        folder: folder of labels of at least one frame.
        rows: greatest number of frames.

    Returns:
        RGB image, ``WIDTH_PX`` wide.

    Raises:
        LabelFilesError: a frame's file is damaged.
    """
    names = frame_names(folder)
    chosen = [names[i] for i in np.unique(np.linspace(0, len(names) - 1, rows).round().astype(int))]
    frames = [read_frame(folder, name) for name in chosen]
    columns: tuple[tuple[str, Callable[[FrameLabels], Picture]], ...] = (
        ("picture", lambda labels: labels.image),
        ("ground probability", _probability),
        ("ground label", _label),
        ("ground distance", _distance),
    )
    width = (WIDTH_PX - (len(columns) + 1) * _GAP_PX) // len(columns)
    aspect = max(labels.image.shape[0] / labels.image.shape[1] for labels in frames)
    height = min(round(width * aspect), _MOST_HEIGHT_PX // len(frames))
    line = round(1.6 * _LETTER_PX)
    top = _GAP_PX + line
    sheet = Image.new("RGB", (WIDTH_PX, top + len(frames) * (height + line) + 3 * line), PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(_LETTER_PX)
    small = ImageFont.load_default(round(0.75 * _LETTER_PX))
    for column, (title, _) in enumerate(columns):
        x = _GAP_PX + column * (width + _GAP_PX)
        draw.text((x, _GAP_PX), title, WHITE, font)
    for row, labels in enumerate(frames):
        y = top + row * (height + line)
        for column, (_, paint) in enumerate(columns):
            tile = _fitted(paint(labels), (height, width))
            x = _GAP_PX + column * (width + _GAP_PX)
            sheet.paste(tile, (x + (width - tile.width) // 2, y))
        draw.text((_GAP_PX, y + height + 3), labels.name, FAINT, small)
    _draw_legend(sheet, top + len(frames) * (height + line) + line // 2)
    return sheet


def _probability(labels: FrameLabels) -> Picture:
    grey = np.rint(255 * np.clip(labels.ground_probability, 0, 1)).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


def _label(labels: FrameLabels) -> Picture:
    grey = np.asarray(Image.fromarray(labels.image).convert("L"), np.float32)[..., None]
    picture = np.repeat(0.55 * grey, 3, axis=2)
    ground, not_ground = (
        labels.ground_depth_m > 0,
        labels.ground_probability < NOT_GROUND_PROBABILITY,
    )
    for mask, colour in (
        ((labels.ground_probability > GROUND_PROBABILITY) | (ground & ~not_ground), _VISIBLE),
        (labels.moving & not_ground, _MOVING),
        (ground & not_ground, _HIDDEN),
        (labels.footprint_mask, _OBSTACLE),
    ):
        picture[mask] = 0.45 * picture[mask] + 0.6 * np.array(colour, np.float32)
    return np.asarray(np.rint(np.clip(picture, 0, 255)), np.uint8)


def _distance(labels: FrameLabels) -> Picture:
    picture = colours_of(labels.ground_depth_m)
    picture[labels.ground_depth_m <= 0] = 30
    return picture


def _fitted(picture: Picture, size: tuple[int, int]) -> Image.Image:
    scale = min(size[0] / picture.shape[0], size[1] / picture.shape[1])
    height, width = (max(1, round(scale * side)) for side in picture.shape[:2])
    smooth = Image.Resampling.BOX if scale < 1 else Image.Resampling.NEAREST
    return Image.fromarray(picture).resize((width, height), smooth)


def _draw_legend(sheet: Image.Image, y: int) -> None:
    """The meaning of the colours, and the scale of depth."""
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(_LETTER_PX)
    x = _GAP_PX
    for colour, word in _LEGEND:
        draw.rectangle((x, y, x + _LETTER_PX, y + _LETTER_PX), fill=colour)
        x += round(1.5 * _LETTER_PX)
        draw.text((x, y + _LETTER_PX / 2), word, WHITE, font, anchor="lm")
        x += round(font.getlength(word)) + 2 * _LETTER_PX
    left, right = x + 2 * _LETTER_PX, sheet.width - 3 * _LETTER_PX
    index = np.linspace(0, len(colour_scale()) - 1, right - left).round().astype(int)
    bar = np.repeat(colour_scale()[index][None], _LETTER_PX, axis=0)
    sheet.paste(Image.fromarray(bar), (left, y))
    for tick_m, position in zip(
        _TICKS_M, scale_position(np.array(_TICKS_M, np.float32)), strict=True
    ):
        place = float(position) / (len(colour_scale()) - 1)
        at = left + round(place * (right - left - 1))
        draw.line((at, y + _LETTER_PX, at, y + _LETTER_PX + 5), FAINT, 2)
        text = f"{tick_m:g}{'+' if tick_m == FARTHEST_M else ''} m"
        draw.text((at, y + _LETTER_PX + 8), text, FAINT, font, anchor="mt")
