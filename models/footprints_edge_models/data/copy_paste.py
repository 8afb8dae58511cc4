"""Copy-paste augmentation: hidden ground with exact labels in real photos.

A vehicle or a person is cut out of one labelled photo and pasted onto the visible ground of another
photo of the same collection, scaled by its distance. The ground that it covers is hidden ground
with a label; where it stands is its footprint.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.sample import FOOTPRINT, NO, UNKNOWN, YES, Sample

CAMERA_HEIGHT_M = 1.5
"""Height of the cameras that took the photos: turns rows into metres, for footprints only."""
LEAST_SHARE = 0.004
"""Smaller cut-outs, as a share of the photo, are too coarse."""
MOST_THINGS = 4
_TRIES = 12


@dataclass(frozen=True)
class CutoutClass:
    """A class of objects that stand on the ground.

    Attributes:
        label: id in the label pictures.
        solid_m: least depth of a footprint, from where the object touches the ground.
        longest_m: greatest depth of a footprint.
    """

    label: int
    solid_m: float
    longest_m: float


@dataclass(frozen=True)
class LabelledPhoto:
    """A photo's sample, its label picture uint8 (H, W), and the row of its horizon."""

    sample: Sample
    ids: NDArray[np.uint8]
    horizon_row: float


@dataclass(frozen=True)
class Cutout:
    """An object cut out of a photo.

    Attributes:
        image: uint8 (h, w, 3), RGB.
        mask: bool (h, w).
        rows_below_horizon: rows from the horizon of its photo to its lowest row.
        brightness: mean of its photo.
        kind: its class.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.bool_]
    rows_below_horizon: float
    brightness: float
    kind: CutoutClass


class CopyPastePhotos(Sequence[Sample]):
    """Photos with objects of other photos pasted into them, when they are drawn.

    Each index always gives the same image.
    """

    def __init__(
        self, photos: Sequence[LabelledPhoto], kinds: Sequence[CutoutClass], seed: int
    ) -> None:
        """Cuts the objects out of all photos."""
        self._photos = photos
        self._labels = [kind.label for kind in kinds]
        self._cutouts = [thing for photo in photos for thing in cut_out(photo, kinds)]
        self._seed = seed

    def __len__(self) -> int:
        """As many as there are photos, none where there is nothing to paste."""
        return len(self._photos) if self._cutouts else 0

    def __getitem__(self, index: int) -> Sample:  # type: ignore[override]  # slices are not needed
        """One photo with objects pasted into it."""
        if not 0 <= index < len(self):
            raise IndexError(index)
        rng = np.random.default_rng((self._seed, index))
        photo = self._photos[index]
        for _ in range(rng.integers(1, MOST_THINGS + 1)):
            cutout = self._cutouts[rng.integers(len(self._cutouts))]
            photo = paste(photo, cutout, self._labels, rng) or photo
        return photo.sample


def cut_out(photo: LabelledPhoto, kinds: Sequence[CutoutClass]) -> list[Cutout]:
    """The whole objects of a photo: away from its borders, their feet on visible ground."""
    found = []
    image, ids = photo.sample.image, photo.ids
    height, width = ids.shape
    ground = photo.sample.visible_ground == YES
    for kind in kinds:
        count, regions, stats, _ = cv2.connectedComponentsWithStats((ids == kind.label).view("u1"))
        for region in range(1, count):
            x, y, w, h, area = (int(value) for value in stats[region])
            if area < LEAST_SHARE * ids.size or area < 0.45 * w * h or h < 24:
                continue
            if x < 2 or y < 2 or x + w > width - 2 or y + h > height - 4:
                continue
            mask = regions[y : y + h, x : x + w] == region
            # what lies right below the lower contour must be ground
            lowest = y + h - 1 - np.argmax(mask[::-1], axis=0)
            columns = np.arange(x, x + w)
            feet = lowest > y + 0.85 * h
            below = ground[np.minimum(lowest + 3, height - 1), columns]
            contact = y + h - 1 - photo.horizon_row
            if not feet.any() or below[feet].mean() < 0.8 or contact < 0.05 * height:
                continue
            found.append(
                Cutout(image[y : y + h, x : x + w], mask, contact, float(image.mean()), kind)
            )
    return found


def paste(
    photo: LabelledPhoto, cutout: Cutout, labels: Sequence[int], rng: np.random.Generator
) -> LabelledPhoto | None:
    """The photo with an object pasted onto its visible ground, or None where there is no room.

    Args:
        photo: the photo to paste into; not changed.
        cutout: of the same collection, so that its size follows from the rows.
        labels: ids of the classes of objects.
        rng: draws the place, and whether the object is mirrored.
    """
    width = photo.ids.shape[1]
    ground = photo.sample.visible_ground == YES
    rows, columns = np.nonzero(ground)
    if not rows.size:
        return None
    mirrored = rng.random() < 0.5
    for _ in range(_TRIES):
        place = rng.integers(rows.size)
        foot, middle = int(rows[place]), int(columns[place])
        scale = (foot - photo.horizon_row) / cutout.rows_below_horizon
        if not 0.35 < scale < 1.7:  # farther: a speck; nearer: a blur
            continue
        size = [max(1, round(side * scale)) for side in cutout.mask.shape]
        top, left = foot + 1 - size[0], middle - size[1] // 2
        if size[0] < 16 or top < 0 or left < 0 or left + size[1] > width:
            continue
        window = (slice(top, foot + 1), slice(left, left + size[1]))
        alpha = cv2.resize(cutout.mask.astype(np.float32), size[::-1], interpolation=cv2.INTER_AREA)
        alpha = cv2.GaussianBlur(cv2.erode(alpha, np.ones((2, 2))), (0, 0), 0.6)
        if mirrored:
            alpha = np.ascontiguousarray(alpha[:, ::-1])
        mask = alpha > 0.5
        if not mask.any() or not _stands_free(photo, window, mask, labels):
            continue
        image = cv2.resize(cutout.image, size[::-1], interpolation=cv2.INTER_AREA)
        image = image[:, ::-1] if mirrored else image
        lit = np.clip(photo.sample.image.mean() / cutout.brightness, 0.6, 1.6)
        picture = _with_shadow(photo.sample.image, window, mask)
        blend = alpha[..., None]
        picture[window] = np.clip(image * lit * blend + picture[window] * (1 - blend), 0, 255)
        border = (alpha > 0.02) & (alpha < 0.98)
        visible, below = photo.sample.visible_ground.copy(), photo.sample.ground.copy()
        visible[window][mask] = NO
        visible[window][border & (visible[window] != NO)] = UNKNOWN
        below[window] = _ground_below(photo, window, mask, cutout.kind)
        ids = photo.ids.copy()
        ids[window][mask] = cutout.kind.label
        return LabelledPhoto(
            replace(photo.sample, image=picture, visible_ground=visible, ground=below),
            ids,
            photo.horizon_row,
        )
    return None


def _stands_free(
    photo: LabelledPhoto,
    window: tuple[slice, slice],
    mask: NDArray[np.bool_],
    labels: Sequence[int],
) -> bool:
    """Whether the thing's feet are on ground and nothing nearer is in its way."""
    height = len(photo.ids)
    lowest = window[0].start + len(mask) - 1 - np.argmax(mask[::-1], axis=0)
    feet = mask.any(axis=0) & (lowest > window[0].stop - 1 - 0.15 * len(mask))
    columns = np.arange(window[1].start, window[1].stop)
    if (photo.sample.visible_ground[lowest[feet], columns[feet]] != YES).any():
        return False
    nearer = photo.ids[window[0].stop : window[0].stop + max(2, height // 12), window[1]]
    if np.isin(nearer, labels).any():
        return False
    # a thing in the window that also reaches below its lowest row stands in front
    beneath = np.isin(photo.ids[min(window[0].stop, height - 1), window[1]], labels)
    return not beneath.any()


def _with_shadow(
    image: NDArray[np.uint8], window: tuple[slice, slice], mask: NDArray[np.bool_]
) -> NDArray[np.uint8]:
    """The picture with the dark that gathers where a thing touches the ground."""
    height, width = image.shape[:2]
    rows, columns = window
    spread = max(2.0, 0.06 * len(mask))
    shade = np.zeros((height, width), np.float32)
    lowest = rows.start + len(mask) - 1 - np.argmax(mask[::-1], axis=0)
    near = mask.any(axis=0) & (lowest > rows.stop - 1 - 0.3 * len(mask))
    reach = max(1, round(0.05 * len(mask)))
    for row, column in zip(lowest[near], np.arange(columns.start, columns.stop)[near], strict=True):
        shade[max(0, row - reach) : row + reach + 1, column] = 1
    shade = cv2.GaussianBlur(shade, (0, 0), spread, sigmaY=spread / 2)
    darkened: NDArray[np.uint8] = (image * (1 - 0.6 * np.minimum(shade, 1))[..., None]).astype("u1")
    return darkened


def _ground_below(
    photo: LabelledPhoto, window: tuple[slice, slice], mask: NDArray[np.bool_], kind: CutoutClass
) -> NDArray[np.uint8]:
    """S* in the window: footprint, what may be footprint, and the ground that goes on behind."""
    focal_px = photo.sample.intrinsics.focal_px
    top = window[0].start
    lowest = top + len(mask) - 1 - np.argmax(mask[::-1], axis=0)
    below_horizon = np.arange(top, top + len(mask))[:, None] - photo.horizon_row
    scale = focal_px * CAMERA_HEIGHT_M
    with np.errstate(divide="ignore"):
        distance_m = np.where(below_horizon > 0, scale / below_horizon, np.inf)
    behind_m = distance_m - scale / np.maximum(lowest - photo.horizon_row, 1)
    ground = photo.sample.ground[window].copy()
    ground[mask & (ground == YES) & (behind_m < kind.longest_m)] = UNKNOWN
    ground[mask & (behind_m < kind.solid_m)] = FOOTPRINT
    return ground
