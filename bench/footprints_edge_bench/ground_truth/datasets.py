"""Opens datasets: which reader a folder needs, and which of its images to use.

To add a kind of dataset, write a reader that yields the items of a folder and add it to ``KINDS``.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TypeVar

from footprints_edge_bench.ground_truth.base import EvaluationDataset, GroundTruthError, Item
from footprints_edge_bench.ground_truth.clip import is_clip, read_clip
from footprints_edge_bench.ground_truth.hand_drawn import is_hand_drawn_folder, read_hand_drawn
from footprints_edge_bench.ground_truth.kitti import is_kitti_folder, read_kitti
from footprints_edge_bench.ground_truth.matterport import is_matterport_folder, read_matterport
from footprints_edge_bench.ground_truth.panoramas import is_panorama_folder, read_panoramas
from footprints_edge_bench.ground_truth.photos import is_photo_folder, read_photos
from footprints_edge_bench.ground_truth.scenes import (
    is_scene_folder,
    read_scenes,
    views_of_scenes,
)

ItemT = TypeVar("ItemT")


@dataclass(frozen=True)
class ReadingOptions:
    """Facts that some readers need in addition to the folder.

    Attributes:
        images: where the images are, if they are elsewhere.
        walkable: class ids of ground, for labelled photos.
        void: class ids that are not scored.
    """

    images: Path | None = None
    walkable: tuple[int, ...] = ()
    void: tuple[int, ...] = ()


@dataclass(frozen=True)
class DatasetKind:
    """A kind of dataset.

    Attributes:
        recognises: whether a folder is of this kind, by the files in it.
        read: yields the items of a folder; their names are unique in the folder.
        in_groups: whether names begin with a group and a slash; each group is a dataset.
        views: how many pictures of a scene a folder has at most.
    """

    recognises: Callable[[Path], bool]
    read: Callable[[Path, ReadingOptions], Iterator[Item]]
    in_groups: bool = False
    views: Callable[[Path], int] = lambda _: 1


KINDS: dict[str, DatasetKind] = {
    "clip": DatasetKind(is_clip, lambda folder, _: read_clip(folder)),
    "synthetic scenes": DatasetKind(
        is_scene_folder, lambda folder, _: read_scenes(folder), views=views_of_scenes
    ),
    "KITTI": DatasetKind(
        is_kitti_folder, lambda folder, reading: read_kitti(folder, reading.images)
    ),
    "Matterport": DatasetKind(
        is_matterport_folder, lambda folder, reading: read_matterport(folder, reading.images)
    ),
    "hand-drawn ground": DatasetKind(
        is_hand_drawn_folder, lambda folder, _: read_hand_drawn(folder), in_groups=True
    ),
    "views of panoramas": DatasetKind(is_panorama_folder, lambda folder, _: read_panoramas(folder)),
    "photos": DatasetKind(
        is_photo_folder, lambda folder, reading: read_photos(folder, reading.walkable, reading.void)
    ),
}
"""By name. The first kind that recognises a folder reads it, since clips may have labels too."""


@dataclass(frozen=True)
class Subset:
    """The images of each dataset that are used.

    Attributes:
        begin: start, as a share of all images.
        end: end (exclusive), as a share of all images.
        every: use every Nth image between them.
        held_out: use only images that ``fp-train edge`` holds out of datasets it knows by name.
    """

    begin: Fraction = Fraction(0)
    end: Fraction = Fraction(1)
    every: int = 1
    held_out: bool = False

    @classmethod
    def parse(cls, text: str, every: int = 1, *, held_out: bool = False) -> "Subset":
        """From text such as ``0.8:1``, the last fifth.

        Raises:
            GroundTruthError: the text is not a range of shares.
        """
        begin, colon, end = text.partition(":")
        try:
            subset = cls(Fraction(begin or 0), Fraction(end or 1), every, held_out)
        except (ValueError, ZeroDivisionError):
            colon = ""
        if not colon or not 0 <= subset.begin < subset.end <= 1:
            raise GroundTruthError(
                f"{text!r} is not a part of a dataset; give two shares of its images, such as 0.8:1"
            )
        return subset

    @property
    def shares(self) -> str:
        """Begin and end as text, such as ``0.8:1``."""
        return f"{float(self.begin):g}:{float(self.end):g}"

    def of(self, dataset: str, items: tuple[Item, ...], views: int = 1) -> tuple[Item, ...]:
        """The items of this subset of a dataset, of so many views a scene."""
        if self.held_out:
            from footprints_edge_models.data.splits import held_out

            items = tuple(held_out(dataset, items, views))
        return tuple(self.of_sequence(items))

    def of_sequence(self, items: Sequence[ItemT]) -> Sequence[ItemT]:
        """The part of any sequence that this subset begins and ends with; `held_out` aside."""
        begin, end = (int(share * len(items)) for share in (self.begin, self.end))
        return items[begin : end : self.every]


def open_folder(folder: Path, reading: ReadingOptions, subset: Subset) -> list[EvaluationDataset]:
    """The images of a folder that are in the subset; no ground truth is read yet.

    Most folders are one dataset. One in groups is a dataset for each: FOLDER-GROUP.

    Raises:
        GroundTruthError: the folder is of no known kind, or the subset is empty.
    """
    for name, kind in KINDS.items():
        if folder.is_dir() and kind.recognises(folder):
            titled: dict[str, list[Item]] = {}
            for item in kind.read(folder, reading):
                group, image = item.name.split("/", 1) if kind.in_groups else ("", item.name)
                title = "-".join(filter(None, (folder.resolve().name, group)))
                titled.setdefault(title, []).append(replace(item, name=f"{title}/{image}"))
            found = [
                EvaluationDataset(title, name, items)
                for title, every in titled.items()
                if (items := subset.of(title, tuple(every), kind.views(folder)))
            ]
            if not found:
                raise GroundTruthError(
                    f"{folder}: no image is left in the requested part; widen --frames, or lower "
                    "--every"
                )
            return found
    raise GroundTruthError(
        f"{folder}: not a dataset with ground truth; it needs sequence.json (clip), scenes.json "
        "(synthetic scenes), *_combined.png (KITTI), *_groundtruth.npy (Matterport), truth.json "
        "(hand-drawn ground), panoramas.json (views of panoramas), or images/ and labels/ "
        "(photos); see docs/accuracy.md"
    )


def open_datasets(
    folders: Sequence[Path], reading: ReadingOptions, subset: Subset
) -> tuple[EvaluationDataset, ...]:
    """The images of several folders that are in the subset.

    Raises:
        GroundTruthError: see :func:`open_folder`; or two folders have the same name.
    """
    datasets = tuple(
        dataset for folder in folders for dataset in open_folder(folder, reading, subset)
    )
    names = [dataset.name for dataset in datasets]
    if twins := sorted({name for name in names if names.count(name) > 1}):
        raise GroundTruthError(
            f"more than one folder is called {', '.join(twins)}; results are kept by name: "
            "rename one, or evaluate them one after the other"
        )
    return datasets
