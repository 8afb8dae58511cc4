"""Which folder holds which kind of ground truth, and the part of it that is asked for.

To add a kind, write a reader that yields the items of a folder and name it in ``KINDS``.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from footprints_edge_bench.ground_truth.base import EvaluationDataset, GroundTruthError, Item
from footprints_edge_bench.ground_truth.clip import is_clip, read_clip
from footprints_edge_bench.ground_truth.kitti import is_kitti_folder, read_kitti
from footprints_edge_bench.ground_truth.matterport import is_matterport_folder, read_matterport
from footprints_edge_bench.ground_truth.photos import is_photo_folder, read_photos
from footprints_edge_bench.ground_truth.scenes import is_scene_folder, read_scenes


@dataclass(frozen=True)
class ReadingOptions:
    """What a reader may need to know beside the folder.

    Attributes:
        images: where the pictures are, if elsewhere.
        walkable: class ids of ground, for labelled photos.
        void: class ids that are not scored.
    """

    images: Path | None = None
    walkable: tuple[int, ...] = ()
    void: tuple[int, ...] = ()


@dataclass(frozen=True)
class DatasetKind:
    """A kind of ground truth: whether a folder holds it, and its items with names unique in the folder."""

    recognises: Callable[[Path], bool]
    read: Callable[[Path, ReadingOptions], Iterator[Item]]


KINDS: dict[str, DatasetKind] = {
    "clip": DatasetKind(is_clip, lambda folder, _: read_clip(folder)),
    "synthetic scenes": DatasetKind(is_scene_folder, lambda folder, _: read_scenes(folder)),
    "KITTI": DatasetKind(
        is_kitti_folder, lambda folder, reading: read_kitti(folder, reading.images)
    ),
    "Matterport": DatasetKind(
        is_matterport_folder, lambda folder, reading: read_matterport(folder, reading.images)
    ),
    "photos": DatasetKind(
        is_photo_folder, lambda folder, reading: read_photos(folder, reading.walkable, reading.void)
    ),
}
"""By name; the first that recognises a folder reads it (clips may have labels as photos do)."""


@dataclass(frozen=True)
class Subset:
    """Which images of each dataset are scored.

    Attributes:
        begin: the first one, as a share of all.
        end: the one after the last, likewise.
        every: every so manieth of these.
        held_out: only those that ``fp-train edge`` holds out of a dataset that it knows by name.
    """

    begin: Fraction = Fraction(0)
    end: Fraction = Fraction(1)
    every: int = 1
    held_out: bool = False

    @classmethod
    def parse(cls, text: str, every: int = 1, *, held_out: bool = False) -> "Subset":
        """From text such as ``0.8:1``, the last fifth.

        Raises:
            GroundTruthError: the text is something else.
        """
        begin, colon, end = text.partition(":")
        try:
            part = cls(Fraction(begin or 0), Fraction(end or 1), every, held_out)
        except (ValueError, ZeroDivisionError):
            colon = ""
        if not colon or not 0 <= part.begin < part.end <= 1:
            raise GroundTruthError(f"a part {text!r}: give shares of the images, such as 0.8:1")
        return part

    def of(self, dataset: str, items: tuple[Item, ...]) -> tuple[Item, ...]:
        """The items of this part of a dataset."""
        if self.held_out:
            from footprints_edge_models.data.datasets import held_out

            items = tuple(held_out(dataset, items))
        begin, end = (int(share * len(items)) for share in (self.begin, self.end))
        return items[begin : end : self.every]


def open_dataset(folder: Path, reading: ReadingOptions, part: Subset) -> EvaluationDataset:
    """The images of a folder that are asked for; their ground truth is read later.

    Raises:
        GroundTruthError: the folder holds no ground truth of a known kind, or no image is left.
    """
    for name, kind in KINDS.items():
        if folder.is_dir() and kind.recognises(folder):
            title = folder.resolve().name
            named = (
                replace(item, name=f"{title}/{item.name}") for item in kind.read(folder, reading)
            )
            items = part.of(title, tuple(named))
            if not items:
                raise GroundTruthError(f"{folder}: no image is left in the part that is asked for")
            return EvaluationDataset(title, name, items)
    raise GroundTruthError(
        f"{folder}: no ground truth of a known kind; it needs sequence.json, scenes.json, *_combined.png "
        "(KITTI), *_groundtruth.npy (Matterport), or images/ and labels/ (docs/accuracy.md)"
    )


def open_datasets(
    folders: list[Path], reading: ReadingOptions, part: Subset
) -> tuple[EvaluationDataset, ...]:
    """The images of several folders.

    Raises:
        GroundTruthError: as :func:`open_dataset`, or two folders have one name.
    """
    datasets = tuple(open_dataset(folder, reading, part) for folder in folders)
    names = [dataset.name for dataset in datasets]
    if twins := sorted({name for name in names if names.count(name) > 1}):
        raise GroundTruthError(
            f"more than one folder is called {', '.join(twins)}; results are kept by name: "
            "rename one, or evaluate them one after the other"
        )
    return datasets
