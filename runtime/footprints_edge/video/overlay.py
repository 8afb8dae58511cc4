"""The overlay of videos: a fast version of `drawing.overlay`, a few milliseconds per frame."""

import numpy as np

from footprints_edge.drawing.colormap import colour_scale, scale_position
from footprints_edge.drawing.notes import picture_note
from footprints_edge.drawing.occupancy_grid import bev_layers, paint_bev
from footprints_edge.drawing.overlay import LEGEND_PX, draw_legend
from footprints_edge.drawing.style import (
    HATCH_PERIOD,
    HATCH_STRIPE,
    PAPER,
    TINT,
    WHITE,
    diagonal_stripes,
)
from footprints_edge.foundation.opencv import opencv
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.geometry.camera import IntrinsicsSource
from footprints_edge.maps.ground_maps import GroundMaps

_STRIPE, _SHADE = 0.9, 0.5
"""Opacity of a stripe, and brightness of the picture between stripes."""


class VideoOverlay:
    """Draws predictions of frames; caches everything that frames share."""

    def __init__(self, *, bev: bool = False) -> None:
        """Prepares the drawing.

        Args:
            bev: Whether to add a bird's-eye view beside each frame.

        Raises:
            VideoError: If OpenCV is missing.
        """
        self._cv2 = opencv()
        self._bev = bev
        self._size: Size | None = None
        self._stripes: Rgb = np.zeros((0, 0), np.uint8)
        self._legends: dict[bool, Rgb] = {}
        self._canvas: Rgb = np.zeros((0, 0, 3), np.uint8)
        self._rows = 0
        self._bev_layers = np.zeros((4, 0, 0), np.uint32)
        self._colours = np.ascontiguousarray(colour_scale()[:, None, ::-1])

    def draw(self, prediction: GroundMaps) -> Rgb:
        """Draws a frame: visible ground tinted, hidden ground hatched, and a legend below.

        Returns:
            uint8 (H, W, 3), BGR as in OpenCV; both sides are even.
        """
        cv2 = self._cv2
        size = prediction.image_size
        if size != self._size:
            self._prepare(size, prediction.intrinsics.source)
        photo = cv2.cvtColor(prediction.rgb, cv2.COLOR_RGB2BGR)
        at_size = {"dsize": size[::-1], "interpolation": cv2.INTER_LINEAR}
        least = prediction.threshold if prediction.shows_ground else np.inf
        visible, ground = (
            (cv2.resize(probability, **at_size) > least).view(np.uint8) * np.uint8(255)
            for probability in (
                prediction.visible_ground_probability,
                prediction.ground_probability,
            )
        )
        # Resize one channel and colour it, instead of resizing three.
        position = scale_position(prediction.unmasked_ground_depth_m).astype(np.uint8)
        tint = cv2.applyColorMap(cv2.resize(position, **at_size), self._colours)
        grey = cv2.cvtColor(cv2.cvtColor(photo, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)
        hidden = ground & ~visible
        drawn = photo.copy()
        for part, over in (
            (visible, cv2.addWeighted(grey, 1 - TINT, tint, TINT, 0)),
            (hidden & self._stripes, cv2.addWeighted(photo, 1 - _STRIPE, tint, _STRIPE, 0)),
            (hidden & ~self._stripes, cv2.convertScaleAbs(photo, alpha=_SHADE)),
        ):
            cv2.copyTo(over, part, drawn)
        thickness = max(1, round(max(size) / 600))
        for part in (hidden, visible):
            edges, _ = cv2.findContours(part, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
            cv2.drawContours(drawn, edges, -1, WHITE, thickness, cv2.LINE_AA)
        return self._composed(drawn, prediction)

    def _prepare(self, size: Size, source: IntrinsicsSource) -> None:
        height, width = size
        self._size = size
        pen_px = max(1.0, max(size) / 700)
        along_row = np.sqrt(2) * pen_px
        stripes = diagonal_stripes(size, HATCH_PERIOD * along_row, HATCH_STRIPE * along_row)
        self._stripes = np.where(stripes, np.uint8(255), np.uint8(0))
        # a blank line keeps frames that show no ground as high as the others
        self._legends = {
            shown: np.asarray(
                draw_legend(
                    max(width, LEGEND_PX), height, picture_note(source, shows_ground=shown) or " "
                )
            )[..., ::-1]
            for shown in (True, False)
        }
        legend = self._legends[True]
        self._rows = rows = height + legend.shape[0]
        if self._bev:
            self._bev_layers = bev_layers(rows)
        columns = max(width, legend.shape[1])
        all_columns = columns + (rows if self._bev else 0)
        self._canvas = np.empty((rows + rows % 2, all_columns + all_columns % 2, 3), np.uint8)
        self._canvas[:] = PAPER[::-1]

    def _composed(self, drawn: Rgb, prediction: GroundMaps) -> Rgb:
        """Adds the legend below the drawn frame, and the bird's-eye view beside it."""
        height, width = drawn.shape[:2]
        canvas = self._canvas.copy()
        left = (max(width, LEGEND_PX) - width) // 2
        canvas[:height, left : left + width] = drawn
        legend = self._legends[prediction.shows_ground]
        canvas[height : self._rows, : legend.shape[1]] = legend
        if self._bev:
            bev = self._cv2.cvtColor(
                paint_bev(prediction, self._bev_layers), self._cv2.COLOR_RGBA2BGR
            )
            columns = max(width, LEGEND_PX)
            canvas[: self._rows, columns : columns + bev.shape[1]] = bev
        return canvas
