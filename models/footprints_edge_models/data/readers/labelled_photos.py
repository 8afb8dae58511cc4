"""Photos with label pictures: ``images/`` and, of the same name, ``labels/``."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.images import decode
from footprints_edge_models.data.copy_paste import CopyPastePhotos, CutoutClass, LabelledPhoto
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.readers.pictures import list_pictures
from footprints_edge_models.insertion.labels import decoded
from footprints_edge_models.sample import (
    FOOTPRINT,
    NO,
    UNKNOWN,
    UNLIKELY,
    YES,
    Sample,
    nearest,
    shrunk,
)
from footprints_edge_models.sequences.folders import WALKABLE

HORIZON_PERCENTILE = 15
"""The horizon of a collection's photos is this percentile of their highest rows of ground: all of
them were taken with one kind of camera."""
WIDEST_GAP = 0.06
"""Things between ground on both sides that are wider than this, as a share of the picture's width,
may stand at its end."""
COPY_PASTE_SEED = 0


@dataclass(frozen=True)
class PhotoLabels:
    """The meaning of the label ids of a folder.

    Attributes:
        walkable: ids of the traversable classes.
        void: ids without a label.
        barriers: ids behind which, above the highest visible ground, no ground is looked for.
        sky: ids behind which there is never ground.
        solid: ids behind which there is seldom ground: buildings, walls, fences, dense vegetation.
        things: classes that can be cut out and pasted elsewhere.
    """

    walkable: tuple[int, ...]
    void: tuple[int, ...]
    barriers: tuple[int, ...]
    sky: tuple[int, ...]
    solid: tuple[int, ...] = ()
    things: tuple[CutoutClass, ...] = ()


IDD_LITE = PhotoLabels(
    walkable=(0, 1),
    void=(255,),
    barriers=(2, 3, 4, 5, 6),
    sky=(6,),
    solid=(4, 5),
    things=(CutoutClass(2, solid_m=0.4, longest_m=0.8), CutoutClass(3, solid_m=1.6, longest_m=5.0)),
)
CAMVID = PhotoLabels(
    walkable=(3, 4),
    void=(11,),
    barriers=(1, 2, 5, 6, 7, 8, 9, 10, 0),
    sky=(0,),
    solid=(1, 5, 7),
    things=(
        CutoutClass(8, solid_m=1.6, longest_m=5.0),
        CutoutClass(9, solid_m=0.4, longest_m=0.8),
        CutoutClass(10, solid_m=0.5, longest_m=2.0),
    ),
)
ADE20K = PhotoLabels(
    walkable=WALKABLE,
    void=(0,),
    barriers=(1, 2, 3, 6, 9),
    sky=(3,),
    # wall, building, tree, ceiling, window, mountain, curtain, water, painting, house, sea, mirror
    solid=(1, 2, 5, 6, 9, 17, 19, 22, 23, 26, 27, 28),
)
"""The 31 most frequent classes of ADE20K; see the card of the model that made the labels."""


def read_photos(folder: Path, labels: PhotoLabels) -> Iterator[Sample]:
    """Photos in ``images/`` with a label picture of the same name in ``labels/``."""
    for image_path in list_pictures(folder / "images"):
        image = decode(image_path).rgb
        ids = _label_ids(folder / "labels" / f"{image_path.stem}.png", image.shape[:2])
        yield _sample(folder, image_path, image, *_said_by(ids, labels))


def read_inserted(folder: Path, labels: PhotoLabels) -> Iterator[Sample]:
    """Photos with models in them: where these hide floor of the photo, ground goes on behind."""
    for image_path in list_pictures(folder / "images"):
        image = decode(image_path).rgb
        path = folder / "labels" / f"{image_path.stem}.png"
        inserted = decoded(_label_ids(path, image.shape[:2]), labels.walkable[0])
        visible, ground = _said_by(inserted.ids, labels)
        visible[inserted.shows_model] = NO
        ground[inserted.taken] = FOOTPRINT
        yield _sample(folder, image_path, image, visible, ground)


def _said_by(
    ids: NDArray[np.uint8], labels: PhotoLabels
) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """What class ids say of visible ground, and of ground."""
    visible = np.where(np.isin(ids, labels.walkable), YES, NO).astype(np.uint8)
    visible[np.isin(ids, labels.void)] = UNKNOWN
    ground = np.full(visible.shape, UNKNOWN, np.uint8)
    ground[np.isin(ids, labels.sky)] = NO
    rows = np.flatnonzero((visible == YES).sum(axis=1) > 2)
    if rows.size:
        above = slice(0, max(0, rows[0] - round(0.04 * len(visible))))
        ground[above][np.isin(ids[above], labels.barriers)] = NO
        seldom = np.isin(ids, labels.solid) & ~goes_on_behind(visible == YES)
        ground[seldom & (ground == UNKNOWN)] = UNLIKELY
    ground[visible == YES] = YES
    return visible, ground


def _sample(
    folder: Path,
    path: Path,
    image: NDArray[np.uint8],
    visible: NDArray[np.uint8],
    ground: NDArray[np.uint8],
) -> Sample:
    camera = Intrinsics.assumed((image.shape[0], image.shape[1]))
    return shrunk(Sample(f"{folder.name}/{path.stem}", image, camera, visible, ground))


def goes_on_behind(seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Where ground surely goes on behind what stands there, bool (H, W).

    Namely where ground is seen farther away, above in the same column; or on both sides, with no
    more than ``WIDEST_GAP`` between.

    Args:
        seen: bool (H, W), visible ground.
    """
    mask = seen.astype(np.uint8)
    farther = np.maximum.accumulate(cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3))), axis=0)
    gap_px = max(1, round(WIDEST_GAP * seen.shape[1]))
    beside = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((1, gap_px)))
    behind: NDArray[np.bool_] = (farther > 0) | (beside > 0)
    return behind


def read_copy_paste(
    folder: Path, labels: PhotoLabels, samples: Sequence[Sample]
) -> CopyPastePhotos:
    """Photos of a folder with things of its own photos pasted into them.

    Args:
        folder: folder of the photos.
        labels: meaning of the label ids.
        samples: the photos to use, as :func:`read_photos` gives them.
    """
    tops = [np.argmax((s.visible_ground == YES).sum(axis=1) > 2) / len(s.image) for s in samples]
    seen = [top for top in tops if top > 0]
    horizon = float(np.percentile(seen, HORIZON_PERCENTILE)) if seen else 0.5
    photos = []
    for sample in samples:
        size = (sample.image.shape[0], sample.image.shape[1])
        ids = _label_ids(folder / "labels" / f"{sample.name.rsplit('/', 1)[-1]}.png", None)
        photos.append(LabelledPhoto(sample, nearest(ids, size), horizon * size[0]))
    return CopyPastePhotos(photos, labels.things, COPY_PASTE_SEED)


def _label_ids(path: Path, size: tuple[int, int] | None) -> NDArray[np.uint8]:
    try:
        ids = np.asarray(Image.open(path))
    except OSError as error:
        raise DatasetError(f"{path}: no readable label picture ({error})") from error
    if size is not None and ids.shape != size:
        raise DatasetError(f"{path}: labels are {ids.shape}, the picture is {size}")
    return ids
