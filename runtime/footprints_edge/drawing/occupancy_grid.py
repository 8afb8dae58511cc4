"""Pictures of occupancy grids: a bird's-eye view in the colours of the overlay."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.colormap import colours_of
from footprints_edge.drawing.notes import with_note
from footprints_edge.drawing.style import PAPER, WHITE, diagonal_stripes
from footprints_edge.errors import GroundPlaneError
from footprints_edge.foundation.png import encode_png
from footprints_edge.maps.ground_maps import GroundMaps
from footprints_edge.navigation.occupancy_grid import (
    HIDDEN,
    OCCUPIED,
    UNKNOWN,
    VISIBLE,
    OccupancyGrid,
    make_occupancy_grid,
)

HEIGHT_PX = 720
"""Height of a picture in its own file."""

BEV_RANGE_M = 10.0
"""Range ahead of the bird's-eye view beside an overlay."""

_BEV_CELL_M = 0.1
_RINGS_M = (0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
_UNKNOWN, _OCCUPIED = (44, 48, 58), (8, 9, 13)
_FAINT = (128, 134, 146)


def encode_occupancy_grid(grid: OccupancyGrid, note: str = "") -> bytes:
    """Encodes `draw_occupancy_grid` as PNG, with a note in a line below."""
    drawn = draw_occupancy_grid(grid.cells, grid.cell_m, HEIGHT_PX)
    return encode_png(with_note(drawn, note))


def draw_occupancy_grid(
    cells: NDArray[np.uint8], cell_m: float, height_px: int, *, square: bool = False
) -> Image.Image:
    """Draws a grid: forward is up, left is left, the camera is in the middle of the lower border.

    Visible ground is solid in the colour of its distance, hidden ground hatched, obstacles black,
    unknown cells grey; rings mark round distances from the camera.

    Args:
        cells: uint8 (rows, columns), see `OccupancyGrid`.
        cell_m: Side of a cell, metres.
        height_px: Height of the picture.
        square: Whether to crop both sides to a square.
    """
    if square:
        cells = _square(cells)
    rows, columns = cells.shape
    width_px = round(height_px * columns / rows)
    large = _enlarged(cells, height_px, width_px)
    ground = _ground_colours(height_px, width_px, rows * cell_m)
    picture = np.empty((height_px, width_px, 3), np.uint8)
    picture[:] = _UNKNOWN
    picture[large == OCCUPIED] = _OCCUPIED
    visible, hidden = large == VISIBLE, large == HIDDEN
    picture[visible] = ground[visible]
    stripe_px = 1.5 * max(2, height_px // 120)
    stripes = diagonal_stripes((height_px, width_px), 2 * stripe_px, stripe_px)
    picture[hidden] = np.where(stripes[..., None], ground, np.uint8(70))[hidden]
    image = Image.fromarray(picture)
    _draw_rings(image, rows * cell_m)
    return image


def colours_of_cells(
    values: NDArray[np.uint8], distance_m: NDArray[np.floating]
) -> NDArray[np.uint8]:
    """Colours of single cells, uint8 (N, 3): hidden ground is darker, as it cannot be hatched.

    Args:
        values: uint8 (N,), see `OccupancyGrid`.
        distance_m: (N,), metres from the camera.
    """
    colours = colours_of(distance_m.astype(np.float32)).copy()
    colours[values == HIDDEN] //= 2
    colours[values == OCCUPIED] = _OCCUPIED
    colours[values == UNKNOWN] = _UNKNOWN
    return colours


def draw_bev(prediction: GroundMaps, height_px: int) -> Image.Image:
    """Draws a square bird's-eye view of `BEV_RANGE_M`; empty if there is no plane, and says so."""
    try:
        cells = make_occupancy_grid(prediction, _BEV_CELL_M, BEV_RANGE_M).cells
    except GroundPlaneError:
        rows = round(BEV_RANGE_M / _BEV_CELL_M)
        cells = np.full((rows, 2 * rows), UNKNOWN, np.uint8)
        empty = draw_occupancy_grid(cells, _BEV_CELL_M, height_px, square=True)
        letter_px = max(10, height_px // 24)
        ImageDraw.Draw(empty).text(
            (empty.width / 2, empty.height / 4),
            "no ground plane: no map" if prediction.shows_ground else "no ground found: no map",
            WHITE,
            ImageFont.load_default(letter_px),
            anchor="mm",
        )
        return empty
    return draw_occupancy_grid(cells, _BEV_CELL_M, height_px, square=True)


def bev_layers(height_px: int) -> NDArray[np.uint32]:
    """What `paint_bev` needs: uint32 (4, H, W), four bytes R, G, B, 255 of each pixel.

    A layer is `draw_bev` of a grid whose cells all have one value, 0 to 3.
    """
    rows = round(BEV_RANGE_M / _BEV_CELL_M)
    layers = np.full((4, height_px, height_px, 4), 255, np.uint8)
    for value in range(len(layers)):
        cells = np.full((rows, 2 * rows), value, np.uint8)
        picture = draw_occupancy_grid(cells, _BEV_CELL_M, height_px, square=True)
        layers[value, ..., :3] = np.asarray(picture)
    return layers.view(np.uint32)[..., 0]


def paint_bev(prediction: GroundMaps, layers: NDArray[np.uint32]) -> NDArray[np.uint8]:
    """The same as `draw_bev`, in a millisecond: for many frames of one size.

    Returns:
        uint8 (H, W, 4): R, G, B, and 255, as that is how the layers are.
    """
    height_px = layers.shape[1]
    try:
        cells = make_occupancy_grid(prediction, _BEV_CELL_M, BEV_RANGE_M).cells
    except GroundPlaneError:
        return np.asarray(draw_bev(prediction, height_px).convert("RGBA"))
    values = _enlarged(_square(cells), height_px, height_px)
    offsets = np.arange(height_px * height_px, dtype=np.intp)
    offsets += values.ravel().astype(np.intp) * (height_px * height_px)
    return layers.take(offsets).view(np.uint8).reshape(height_px, height_px, 4)


def _square(cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The columns ahead, as many as there are rows."""
    rows, columns = cells.shape
    cut = (columns - rows) // 2
    return cells[:, cut : cut + rows]


def _enlarged(cells: NDArray[np.uint8], height_px: int, width_px: int) -> NDArray[np.uint8]:
    """The cell of each pixel, uint8 (height, width)."""
    rows, columns = cells.shape
    row, column = (
        np.arange(height_px) * rows // height_px,
        np.arange(width_px) * columns // width_px,
    )
    return np.asarray(cells.take(row, axis=0).take(column, axis=1), np.uint8)


@lru_cache(maxsize=4)
def _ground_colours(height_px: int, width_px: int, range_m: float) -> NDArray[np.uint8]:
    """uint8 (height, width, 3): the colour of each pixel's distance from the camera."""
    metres_per_px = range_m / height_px
    ahead = (height_px - np.arange(height_px) - 0.5)[:, None] * metres_per_px
    aside = (np.arange(width_px) + 0.5 - width_px / 2) * metres_per_px
    return colours_of(np.hypot(ahead, aside).astype(np.float32))


def _draw_rings(image: Image.Image, range_m: float) -> None:
    """Draws rings at round distances with their labels, and the camera."""
    draw = ImageDraw.Draw(image)
    px_per_m = image.height / range_m
    letter_px = max(10, image.height // 32)
    font = ImageFont.load_default(letter_px)
    x, y = image.width / 2, image.height
    for ring_m in _RINGS_M:
        radius = ring_m * px_per_m
        if letter_px * 2.5 < radius <= image.height:
            draw.arc((x - radius, y - radius, x + radius, y + radius), 180, 360, _FAINT)
            at = (x + 0.3 * letter_px, y - radius + 0.15 * letter_px)
            draw.text(at, f"{ring_m:g} m", WHITE, font, stroke_width=1, stroke_fill=PAPER)
    side = 0.6 * letter_px
    draw.polygon([(x - side, y), (x + side, y), (x, y - 1.6 * side)], WHITE, PAPER)
