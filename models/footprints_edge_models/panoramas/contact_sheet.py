"""A contact sheet of views of panoramas, their labels painted over."""

import io
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.style import PAPER, WHITE
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.panoramas.files import ViewFile, read_views
from footprints_edge_models.panoramas.labels import FOOTPRINT, GROUND, IGNORED, VISIBLE_GROUND

COLUMNS, ROWS = 8, 6
_TILE_PX = 240
_COLOURS = {
    "visible ground": (64, 190, 110),
    "hidden ground": (255, 225, 40),
    "footprints": (235, 60, 50),
    "not decided": (150, 150, 160),
}


def write_contact_sheet(folder: Path) -> Path:
    """Draws views of all panoramas of a folder, evenly spread, as a PNG; returns its path.

    Raises:
        PanoramaError: a view is damaged, or there is none.
    """
    views = read_views(folder)
    places = np.unique(np.linspace(0, len(views) - 1, COLUMNS * ROWS).round().astype(int))
    sheet = Image.new("RGB", (COLUMNS * _TILE_PX, ROWS * (_TILE_PX + 16) + 30), PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(13)
    for tile, place in enumerate(places):
        picture = _painted(views[place])
        picture.thumbnail((_TILE_PX - 6, _TILE_PX - 6))
        x, y = tile % COLUMNS * _TILE_PX, tile // COLUMNS * (_TILE_PX + 16)
        sheet.paste(picture, (x + (_TILE_PX - picture.width) // 2, y))
        draw.text((x + 4, y + _TILE_PX - 6), views[place].name, WHITE, font)
    x = 8
    for word, colour in _COLOURS.items():
        draw.rectangle((x, sheet.height - 25, x + 18, sheet.height - 7), fill=colour)
        draw.text((x + 26, sheet.height - 16), word, WHITE, font, anchor="lm")
        x += 60 + round(font.getlength(word))
    buffer = io.BytesIO()
    sheet.save(buffer, "PNG")
    path = folder / "contact-sheet.png"
    write_atomically(path, buffer.getvalue())
    return path


def _painted(view: ViewFile) -> Image.Image:
    bits = view.read_bits()
    with Image.open(view.image) as opened:
        picture = np.asarray(opened.convert("RGB"), np.float32).copy()
    for colour, mask in zip(
        _COLOURS.values(),
        (
            bits & VISIBLE_GROUND > 0,
            (bits & GROUND > 0) & (bits & VISIBLE_GROUND == 0),
            bits & FOOTPRINT > 0,
            bits & IGNORED > 0,
        ),
        strict=True,
    ):
        picture[mask] = 0.55 * picture[mask] + 0.45 * np.array(colour, np.float32)
    return Image.fromarray(picture.astype(np.uint8))
