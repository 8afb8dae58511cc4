"""Perspective views of a panorama: what a camera at its place would have taken."""

import zlib
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import Intrinsics, rays
from footprints_edge.inputs.preprocessing import resized
from footprints_edge_models.panoramas.labels import IGNORED, Panorama
from footprints_edge_models.sample import LONGEST_SIDE_PX

ASPECTS = ((9, 16), (9, 16), (3, 4), (16, 9), (4, 3))
"""(height, width) of views: three in five are landscape."""
FOV_DEG = (60.0, 105.0)
"""Field of view along the longer side: the panoramas have too few pixels for narrower ones."""
PITCH_DEG = (-30.0, 8.0)
ROLL_DEG = 3.0
"""Standard deviation."""

_GOLDEN_TURN = (5**0.5 - 1) / 2
"""Headings that advance by this share of a turn spread evenly, however many there are."""
_SUPERSAMPLING = 2
_MOST_IGNORED = 0.5
_TRIES = 20


@dataclass(frozen=True)
class PanoramaCamera:
    """A camera at the place of a panorama.

    Attributes:
        size: (H, W) of its picture.
        intrinsics: in pixels of the picture.
        heading_deg: azimuth that it looks along, clockwise.
        pitch_deg: how far it looks up.
        roll_deg: how far it is turned clockwise about its axis.
    """

    size: tuple[int, int]
    intrinsics: Intrinsics
    heading_deg: float
    pitch_deg: float
    roll_deg: float

    @property
    def rotation(self) -> NDArray[np.float64]:
        """(3, 3), from camera axes to those of a level camera that looks along azimuth 0."""
        heading, pitch, roll = np.radians([self.heading_deg, self.pitch_deg, self.roll_deg])
        turn = np.array(
            [
                [np.cos(heading), 0, np.sin(heading)],
                [0, 1, 0],
                [-np.sin(heading), 0, np.cos(heading)],
            ]
        )
        lift = np.array(
            [[1, 0, 0], [0, np.cos(pitch), -np.sin(pitch)], [0, np.sin(pitch), np.cos(pitch)]]
        )
        tilt = np.array(
            [[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1]]
        )
        rotation: NDArray[np.float64] = turn @ lift @ tilt
        return rotation


@dataclass(frozen=True)
class PanoramaView:
    """A view: its camera, picture uint8 (H, W, 3) and labels uint8 (H, W), bits as a panorama's."""

    camera: PanoramaCamera
    image: NDArray[np.uint8] = field(repr=False)
    bits: NDArray[np.uint8] = field(repr=False)


def draw_view(panorama: Panorama, number: int, seed: int) -> PanoramaView:
    """One of a panorama's views, always the same for its number and seed.

    Directions in which more than half of the picture is not decided are drawn again.
    """
    name = zlib.crc32(panorama.name.encode())
    rng = np.random.default_rng((seed, name, number))
    first = np.random.default_rng((seed, name)).random()
    for attempt in range(_TRIES):
        turn = first + number * _GOLDEN_TURN if attempt == 0 else rng.random()
        camera = _draw_camera(360 * (turn % 1), rng)
        bits = cut_labels(panorama, camera)
        if np.mean(bits == IGNORED) <= _MOST_IGNORED:
            break
    return PanoramaView(camera, cut_picture(panorama, camera), bits)


def _draw_camera(heading_deg: float, rng: np.random.Generator) -> PanoramaCamera:
    high, wide = ASPECTS[rng.integers(len(ASPECTS))]
    unit = LONGEST_SIDE_PX / max(high, wide)
    size = (round(high * unit), round(wide * unit))
    focal_px = max(size) / 2 / np.tan(np.radians(rng.uniform(*FOV_DEG)) / 2)
    return PanoramaCamera(
        size,
        Intrinsics.from_focal_px(float(focal_px), size),
        heading_deg,
        rng.uniform(*PITCH_DEG),
        rng.normal(0, ROLL_DEG),
    )


def cut_picture(panorama: Panorama, camera: PanoramaCamera) -> NDArray[np.uint8]:
    """The picture that a camera takes: finer than needed, then shrunk by the runtime's filter."""
    height, width = camera.size
    fine = (_SUPERSAMPLING * height, _SUPERSAMPLING * width)
    x, y = _coordinates(camera, fine, panorama.image.shape)
    # columns go around, rows end at the poles
    margin = 8
    wrapped = cv2.copyMakeBorder(panorama.image, 0, 0, margin, margin, cv2.BORDER_WRAP)
    picture = cv2.remap(wrapped, x + margin, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    return resized(picture.astype(np.uint8), camera.size)


def cut_labels(panorama: Panorama, camera: PanoramaCamera) -> NDArray[np.uint8]:
    """The labels under the centres of a camera's pixels, uint8 (H, W)."""
    height, width = panorama.bits.shape
    x, y = _coordinates(camera, camera.size, panorama.bits.shape)
    rows = np.clip(np.rint(y).astype(int), 0, height - 1)
    labels: NDArray[np.uint8] = panorama.bits[rows, np.rint(x).astype(int) % width]
    return labels


def _coordinates(
    camera: PanoramaCamera, size: tuple[int, int], panorama: tuple[int, ...]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Where the pixels of a view of a size are in a panorama, x and y of pixels' centres."""
    own = rays(camera.intrinsics.scaled(camera.size, size), size)
    x, y, z = np.moveaxis(own @ camera.rotation.T.astype(np.float32), -1, 0)
    azimuth = np.arctan2(x, z) / (2 * np.pi) % 1
    elevation = np.arctan2(-y, np.hypot(x, z)) / np.pi
    height, width = panorama[:2]
    return (
        (azimuth * width - 0.5).astype(np.float32),
        ((0.5 - elevation) * height - 0.5).astype(np.float32),
    )
