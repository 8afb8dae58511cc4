"""Readers of the training data: labelled photos, RGB-D and stereo clips, labels made of video.

To add a dataset, write a reader that yields :class:`Sample` and name it in ``READERS``.
"""

import logging
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.geometry.camera import Intrinsics
from footprints_edge.inputs.image_files import IMAGE_SUFFIXES
from footprints_edge.inputs.images import decode
from footprints_edge_models.data.copy_paste import Composites, Kind, LabelledPhoto
from footprints_edge_models.mapping.floor_map import (
    FREE,
    OCCUPIED,
    Frame,
    build_floor_map,
    fit_floor,
    ground_by_depth,
)
from footprints_edge_models.mapping.stereo import fit_road, stereo_depth_m
from footprints_edge_models.sample import NO, UNKNOWN, UNSEEN, YES, Sample, nearest, shrunk
from footprints_edge_models.scenes.storage.dataset import read_scenes
from footprints_edge_models.scenes.storage.files import SceneFilesError
from footprints_edge_models.sequences.folders import WALKABLE, read_sequence_folder
from footprints_edge_models.sequences.kitti import read_kitti_training
from footprints_edge_models.sequences.matterport import read_matterport_training
from footprints_edge_models.sequences.sequence import SequenceError
from footprints_edge_models.video_labels.files import (
    ABOUT,
    LabelFilesError,
    frame_names,
    read_about,
    read_frame,
)
from footprints_edge_models.video_labels.training_targets import label_sample

logger = logging.getLogger(__name__)

MOST_BEHIND_M = 3.0
"""Floor farther than this behind what is seen (the next room, say) teaches guessing: unseen."""
MOST_STEREO_GROUND_M = 30.0
"""Farther away, half a metre of stereo depth is less than a disparity step: no telling ground."""


MOST_PUBLISHED = 3000
"""Samples taken of a published data set of tens of thousands: about half a megabyte each."""
LABELS_SHARE = 0.15
"""Share of the training pictures drawn from a folder of labels made of video."""


HORIZON_PERCENTILE = 15
"""Of the highest rows of ground in a collection's photos, all of one kind of camera."""
COMPOSITES_SEED = 0


Samples = Sequence[Sample]
"""In memory, or decoded when one is drawn."""


class Named(Protocol):
    """What can be told apart by name."""

    @property
    def name(self) -> str:
        """Dataset and frame."""


NamedT = TypeVar("NamedT", bound=Named)


class DatasetError(FootprintsError):
    """Training data is missing or not laid out as expected."""


@dataclass(frozen=True)
class Dataset:
    """Samples to train on, samples held out, and how often to draw from this dataset."""

    train: Sequence[Sample]
    held_out: Sequence[Sample]
    share: float


@dataclass(frozen=True)
class PhotoLabels:
    """Which label ids of a folder mean what.

    Attributes:
        walkable: ids of the traversable classes.
        void: ids that say nothing.
        barriers: ids behind which, above the highest visible ground, no ground is looked for.
        sky: ids behind which there is never ground.
        things: what can be cut out and set down elsewhere.
    """

    walkable: tuple[int, ...]
    void: tuple[int, ...]
    barriers: tuple[int, ...]
    sky: tuple[int, ...]
    things: tuple[Kind, ...] = ()


IDD_LITE = PhotoLabels(
    walkable=(0, 1),
    void=(255,),
    barriers=(2, 3, 4, 5, 6),
    sky=(6,),
    things=(Kind(2, solid_m=0.4, longest_m=0.8), Kind(3, solid_m=1.6, longest_m=5.0)),
)
CAMVID = PhotoLabels(
    walkable=(3, 4),
    void=(11,),
    barriers=(1, 2, 5, 6, 7, 8, 9, 10, 0),
    sky=(0,),
    things=(
        Kind(8, solid_m=1.6, longest_m=5.0),
        Kind(9, solid_m=0.4, longest_m=0.8),
        Kind(10, solid_m=0.5, longest_m=2.0),
    ),
)
ADE20K = PhotoLabels(walkable=WALKABLE, void=(0,), barriers=(1, 2, 3, 6, 9), sky=(3,))
"""The 31 most frequent classes of ADE20K; see the card of the model that made the labels."""


def read_photos(folder: Path, labels: PhotoLabels) -> Iterator[Sample]:
    """Photos in ``images/`` with a label picture of the same name in ``labels/``."""
    for image_path in _pictures(folder / "images"):
        image = decode(image_path).rgb
        ids = _label_ids(folder / "labels" / f"{image_path.stem}.png", image.shape[:2])
        visible = np.where(np.isin(ids, labels.walkable), YES, NO).astype(np.uint8)
        visible[np.isin(ids, labels.void)] = UNKNOWN
        ground = np.full(visible.shape, UNKNOWN, np.uint8)
        ground[np.isin(ids, labels.sky)] = NO
        rows = np.flatnonzero((visible == YES).sum(axis=1) > 2)
        if rows.size:
            above = slice(0, max(0, rows[0] - round(0.04 * len(visible))))
            ground[above][np.isin(ids[above], labels.barriers)] = NO
        ground[visible == YES] = YES
        height, width = visible.shape
        camera = Intrinsics.assumed((height, width))
        yield shrunk(Sample(f"{folder.name}/{image_path.stem}", image, camera, visible, ground))


def read_composites(folder: Path, labels: PhotoLabels, samples: Sequence[Sample]) -> Composites:
    """Samples of a folder of photos with the folder's own things set down in them.

    Args:
        folder: of the photos.
        labels: which ids mean what.
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
    return Composites(photos, labels.things, COMPOSITES_SEED)


def read_rgbd_clip(folder: Path) -> Iterator[Sample]:
    """A folder with ``sequence.json``, ``images/`` and ``depth/`` (16-bit millimetres).

    Visible ground is what lies on the floor plane by depth; ground, seen or hidden, and its depth
    come from the floor map of the whole clip.
    """
    sequence = read_sequence_folder(folder)
    frames = [entry.measured() for entry in sequence.frames]
    plane = fit_floor(frames[::4], np.array(sequence.up))
    floor_map = build_floor_map(frames, plane)
    for entry, frame in zip(sequence.frames, frames, strict=True):
        cells, floor_depth_m = floor_map.project(frame)
        visible = ground_by_depth(frame, plane)
        gap_m = floor_depth_m - np.where(frame.depth_m > 0, frame.depth_m, floor_depth_m)
        reachable = (floor_depth_m > 0) & (floor_depth_m < 12) & (gap_m < MOST_BEHIND_M)
        ground = np.full(visible.shape, UNSEEN, np.uint8)
        ground[(cells == OCCUPIED) | (floor_depth_m <= 0)] = NO
        ground[(cells == FREE) & reachable] = YES
        ground[visible == YES] = YES
        yield shrunk(
            Sample(
                f"{folder.name}/{entry.name}",
                decode(entry.image).rgb,
                entry.intrinsics,
                visible,
                ground,
                frame.depth_m.astype(np.float16),
                np.where(ground == YES, floor_depth_m, 0).astype(np.float16),
            )
        )


def read_stereo_clip(folder: Path) -> Iterator[Sample]:
    """Rectified stereo pairs in ``image_l/`` and ``image_r/`` with KITTI's ``calib.txt``.

    The street is a plane fitted to the depth in front of the camera; what is hidden stays unknown.
    """
    left, right = np.loadtxt(folder / "calib.txt").reshape(2, 3, 4)
    baseline_m = -right[0, 3] / right[0, 0]
    camera = Intrinsics(left[0, 0], left[1, 1], left[0, 2], left[1, 2])
    for image_path in _pictures(folder / "image_l"):
        image = decode(image_path).rgb
        other = decode(folder / "image_r" / image_path.name).rgb
        depth_m = stereo_depth_m(image, other, camera.fx * baseline_m)
        frame = Frame(depth_m, camera, np.eye(4))
        plane = fit_road(frame)
        if plane is None:
            logger.warning("%s: no road plane found, frame left out", image_path)
            continue
        # A disparity error of a third of a pixel grows with the square of the distance.
        blur_m = depth_m**2 / (3 * camera.fx * baseline_m)
        visible = ground_by_depth(frame, plane, np.minimum(0.1 + blur_m, 0.35))
        visible[(visible == YES) & (depth_m > MOST_STEREO_GROUND_M)] = UNKNOWN
        plane_depth_m = frame.depth_to_m(plane)
        ground = np.full(visible.shape, UNKNOWN, np.uint8)
        ground[plane_depth_m <= 0] = NO
        ground[visible == YES] = YES
        yield shrunk(
            Sample(
                f"{folder.name}/{image_path.stem}",
                image,
                camera,
                visible,
                ground,
                np.where(depth_m < 60, depth_m, 0).astype(np.float16),
                np.where(ground == YES, plane_depth_m, 0).astype(np.float16),
            )
        )


def read_labels(folder: Path) -> Iterator[Sample]:
    """A folder that ``fp-train labels`` made, in the order of the frames' names.

    Raises:
        LabelFilesError: a frame's file is damaged.
    """
    name = read_about(folder)["sequence"]
    for frame in frame_names(folder):
        labels = read_frame(folder, frame)
        yield label_sample(
            f"{name}/{frame}",
            labels.image,
            labels.intrinsics,
            ground_probability=labels.ground_probability,
            ground_depth_m=labels.ground_depth_m,
            visible_depth_m=labels.visible_depth_m,
            untraversable=labels.untraversable,
            moving=labels.moving,
        )


def read_published(
    raw: Path, reader: Callable[[Path, Path, Iterable[str]], Iterator[Sample]]
) -> Iterator[Sample]:
    """Raw data in a folder NAME_raw, and beside it NAME_training_data, folder or zip.

    Of the split in ``train.txt`` in the raw folder, evenly spread lines are taken: all samples are
    kept in memory.
    """
    published = raw.with_name(raw.name.removesuffix("_raw") + "_training_data")
    packed = published.with_name(published.name + ".zip")
    if not published.is_dir() and not packed.is_file():
        raise DatasetError(f"{published}: no such folder, nor {packed.name}")
    lines = (raw / "train.txt").read_text(encoding="utf-8").splitlines()
    spread = lines[:: -(-len(lines) // MOST_PUBLISHED)] if lines else []
    return reader(raw, published if published.is_dir() else packed, spread)


def _pictures(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise DatasetError(f"{folder}: no such folder; see CONTRIBUTING.md for the data layout")
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES)


def _label_ids(path: Path, size: tuple[int, int] | None) -> NDArray[np.uint8]:
    try:
        ids = np.asarray(Image.open(path))
    except OSError as error:
        raise DatasetError(f"{path}: no readable label picture ({error})") from error
    if size is not None and ids.shape != size:
        raise DatasetError(f"{path}: labels are {ids.shape}, the picture is {size}")
    return ids


class Split(Protocol):
    """Tells what is trained on from what is held out."""

    def __call__(self, samples: Sequence[NamedT], /) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
        """Both, in order."""


def held_out(dataset: str, items: Sequence[NamedT]) -> Sequence[NamedT]:
    """What :func:`load_datasets` holds out of a dataset; all of one that it does not know.

    Args:
        dataset: name of its folder.
        items: all of it in order, named as its samples are: the folder's name, a slash, the file's.
    """
    return READERS[dataset][1](items)[1] if dataset in READERS else items


def _last_split(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
    """The last fiftieth, at most 100: made scenes are all different."""
    cut = len(samples) - min(100, len(samples) // 50)
    return samples[:cut], samples[cut:]


def _whole_clip_split(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
    """The last fifth of a clip is held out, and a twentieth before it left out.

    Neighbouring frames are alike.
    """
    return samples[: len(samples) * 3 // 4], samples[len(samples) * 4 // 5 :]


def _photo_split(one_in: int) -> Split:
    """One of so many, by a checksum of the name up to its last underscore (a drive, a house)."""

    def is_held_out(sample: Named) -> bool:
        return zlib.crc32(sample.name.rsplit("_", 1)[0].encode()) % one_in == 0

    def split(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
        return [s for s in samples if not is_held_out(s)], [s for s in samples if is_held_out(s)]

    return split


def _all_train(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
    return samples, []


Reader = tuple[Callable[[Path], Iterator[Sample] | Samples], Split, float]
"""Reader, split, and the share of training pictures drawn from it."""

READERS: dict[str, Reader] = {
    "idd_lite": (lambda p: read_photos(p, IDD_LITE), _photo_split(5), 0.26),
    "camvid": (lambda p: read_photos(p / "train", CAMVID), _all_train, 0.18),
    "houses": (lambda p: read_photos(p, ADE20K), _photo_split(20), 0.24),
    "hololens_office": (read_rgbd_clip, _whole_clip_split, 0.18),
    "seven_scenes_kitchen": (read_rgbd_clip, _whole_clip_split, 0.09),
    "kitti_grey_stereo": (read_stereo_clip, _whole_clip_split, 0.10),
    "kitti_raw": (lambda p: read_published(p, read_kitti_training), _whole_clip_split, 0.15),
    "matterport_raw": (
        lambda p: read_published(p, read_matterport_training),
        _whole_clip_split,
        0.15,
    ),
    "made_scenes": (read_scenes, _last_split, 0.9),
}
"""By folder name."""
COMPOSITES: dict[str, tuple[PhotoLabels, str, float]] = {
    "idd_lite": (IDD_LITE, ".", 0.16),
    "camvid": (CAMVID, "train", 0.08),
}
"""Of which datasets' training photos composites are made, too: their labels, where the photos are,
and the share of training pictures drawn from the composites."""
LABELS: Reader = (read_labels, _whole_clip_split, LABELS_SHARE)
"""Of a folder with ``labels.json``, whatever its name."""


def load_datasets(root: Path) -> dict[str, Dataset]:
    """Every dataset of READERS, and every folder of labels, that stands below a folder.

    All but made scenes are kept in memory.

    Raises:
        DatasetError: none of them is there, one is not laid out as expected, or no sample is left
            to train on.
    """
    made = {path.parent.name: LABELS for path in sorted(root.glob(f"*/{ABOUT}"))}
    datasets = {}
    for name, (reader, split, share) in (READERS | made).items():
        if (root / name).is_dir():
            try:
                samples = reader(root / name)
                kept = samples if isinstance(samples, Sequence) else list(samples)
                train, held_out = split(kept)
            except (
                *(OSError, ValueError, KeyError),
                *(LabelFilesError, SceneFilesError, SequenceError),
            ) as error:
                raise DatasetError(f"{root / name}: not laid out as expected: {error}") from error
            datasets[name] = Dataset(train, held_out, share)
            if name in COMPOSITES:
                labels, inside, share_composed = COMPOSITES[name]
                composed = read_composites(root / name / inside, labels, train)
                datasets[f"{name} composites"] = Dataset(composed, (), share_composed)
            logger.info("%s: %d to train on, %d held out", name, len(train), len(held_out))
    if not any(dataset.train for dataset in datasets.values()):
        raise DatasetError(
            f"{root}: nothing to train on in the folders {', '.join(READERS)}, "
            f"nor in any with {ABOUT}"
        )
    return datasets
