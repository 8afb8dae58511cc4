"""The training mixture: which datasets there are, and how often each is drawn from.

To add a dataset, write a reader in ``readers/`` that yields :class:`Sample`, name it in
``DATASETS``, and its split in ``splits.SPLITS``.
"""

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from footprints_edge_models.asset_files.asset import AssetError, Credit
from footprints_edge_models.asset_files.dataset_credits import dataset_credits
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.readers.labelled_photos import (
    ADE20K,
    CAMVID,
    IDD_LITE,
    PhotoLabels,
    read_copy_paste,
    read_inserted,
    read_photos,
)
from footprints_edge_models.data.readers.panorama_views import read_panorama_views
from footprints_edge_models.data.readers.published import read_published
from footprints_edge_models.data.readers.published_kitti import read_kitti_training
from footprints_edge_models.data.readers.published_matterport import read_matterport_training
from footprints_edge_models.data.readers.rgbd_clip import read_rgbd_clip
from footprints_edge_models.data.readers.stereo_clip import read_stereo_clip
from footprints_edge_models.data.readers.synthetic_scenes import (
    SyntheticScenes,
    read_synthetic_scenes,
)
from footprints_edge_models.data.readers.video_labels import read_video_labels
from footprints_edge_models.data.splits import SPLITS, hold_out_clip_end, scenes_cut
from footprints_edge_models.panoramas.labels import PanoramaError
from footprints_edge_models.sample import Sample
from footprints_edge_models.scenes.storage.files import SceneFilesError
from footprints_edge_models.sequences.sequence import SequenceError
from footprints_edge_models.video_labels.files import ABOUT, LabelFilesError

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class TrainingDataset:
    """A dataset as training takes it.

    Attributes:
        train: samples to train on.
        held_out: samples held out.
        share: how often it is drawn from, relative to the others.
        credits: whom to credit for it.
        views: greatest number of pictures of a scene; see ``splits.scenes_cut``.
    """

    train: Sequence[Sample]
    held_out: Sequence[Sample]
    share: float
    credits: tuple[Credit, ...] = ()
    views: int = 1


@dataclass(frozen=True)
class DatasetEntry:
    """A dataset of the mixture.

    Attributes:
        read: from its folder to its samples: a sequence that decodes them when drawn, or an
            iterable whose samples are kept in memory.
        share: share of training pictures drawn from it, relative to the others.
    """

    read: Callable[[Path], Iterable[Sample]]
    share: float


@dataclass(frozen=True)
class CopyPasteEntry:
    """Copy-paste augmentation of a dataset's training photos.

    Attributes:
        labels: the photos' labels.
        photos: their folder below that of the dataset.
        share: see :class:`DatasetEntry`.
    """

    labels: PhotoLabels
    photos: str
    share: float


DATASETS = {
    "idd_lite": DatasetEntry(lambda folder: read_photos(folder, IDD_LITE), 0.26),
    "camvid": DatasetEntry(lambda folder: read_photos(folder / "train", CAMVID), 0.18),
    "houses": DatasetEntry(lambda folder: read_photos(folder, ADE20K), 0.24),
    "openimages": DatasetEntry(lambda folder: read_photos(folder, ADE20K), 0.24),
    "inserted": DatasetEntry(lambda folder: read_inserted(folder, ADE20K), 0.4),
    "hololens_office": DatasetEntry(read_rgbd_clip, 0.09),
    "seven_scenes_kitchen": DatasetEntry(read_rgbd_clip, 0.09),
    "kitti_grey_stereo": DatasetEntry(read_stereo_clip, 0.10),
    "kitti_raw": DatasetEntry(lambda folder: read_published(folder, read_kitti_training), 0.15),
    "matterport_raw": DatasetEntry(
        lambda folder: read_published(folder, read_matterport_training), 0.15
    ),
    "panoramas": DatasetEntry(read_panorama_views, 0.12),
    "synthetic_scenes": DatasetEntry(read_synthetic_scenes, 0.9),
}
"""By name of the dataset's folder."""
VIDEO_LABELS = DatasetEntry(read_video_labels, 0.15)
"""Any folder with ``labels.json``, whatever its name."""
COPY_PASTE = {
    "idd_lite": CopyPasteEntry(IDD_LITE, ".", 0.16),
    "camvid": CopyPasteEntry(CAMVID, "train", 0.08),
}
"""Datasets whose training photos are augmented by copy-paste, too, by name of their folder."""


def load_datasets(root: Path) -> dict[str, TrainingDataset]:
    """Every dataset of ``DATASETS``, and every folder of video labels, below a folder.

    All but synthetic scenes are kept in memory.

    Raises:
        DatasetError: none of them is there, one is not laid out as expected, or no sample is left
            to train on.
    """
    labels = {path.parent.name: VIDEO_LABELS for path in sorted(root.glob(f"*/{ABOUT}"))}
    datasets = {}
    for name, entry in (DATASETS | labels).items():
        if not (root / name).is_dir():
            continue
        dataset = load_dataset(root / name, entry)
        datasets[name] = dataset
        if name in COPY_PASTE:
            pasted = COPY_PASTE[name]
            augmented = read_copy_paste(root / name / pasted.photos, pasted.labels, dataset.train)
            datasets[f"{name} copy-paste"] = TrainingDataset(augmented, (), pasted.share)
        logger.info(
            "%s: %d to train on, %d held out", name, len(dataset.train), len(dataset.held_out)
        )
    if not any(dataset.train for dataset in datasets.values()):
        raise DatasetError(
            f"{root}: nothing to train on in the folders {', '.join(DATASETS)}, "
            f"nor in any with {ABOUT}"
        )
    return datasets


def load_dataset(folder: Path, entry: DatasetEntry) -> TrainingDataset:
    """One dataset.

    Raises:
        DatasetError: it is not laid out as expected.
    """
    samples = _samples(folder, entry)
    views = 1
    if isinstance(samples, SyntheticScenes):
        views = samples.views
        end, begin = scenes_cut(samples.names, views)
        parts: tuple[Sequence[Sample], Sequence[Sample]] = (samples[:end], samples[begin:])
    else:
        split = hold_out_clip_end if entry is VIDEO_LABELS else SPLITS[folder.name]
        parts = split(samples)
    try:
        credits = dataset_credits(folder)
    except AssetError as error:
        raise DatasetError(f"{error}; make it again, or write it by hand") from error
    return TrainingDataset(*parts, entry.share, credits, views)


def _samples(folder: Path, entry: DatasetEntry) -> Sequence[Sample]:
    try:
        samples = entry.read(folder)
        return samples if isinstance(samples, Sequence) else list(samples)
    except (
        *(OSError, ValueError, KeyError),
        *(LabelFilesError, PanoramaError, SceneFilesError, SequenceError),
    ) as error:
        raise DatasetError(f"{folder}: not laid out as expected: {error}") from error
