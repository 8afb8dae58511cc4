"""Which folder holds which kind of truth, and the part of it that is asked for.

To add a kind, write a reader that yields the items of a folder and name it in ``KINDS``.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from footprints_edge_bench.ground_truth.base import Dataset, Item, TruthError
from footprints_edge_bench.ground_truth.clip import is_clip, read_clip
from footprints_edge_bench.ground_truth.kitti import is_kitti_truth, read_kitti_truth
from footprints_edge_bench.ground_truth.matterport import is_matterport_truth, read_matterport_truth
from footprints_edge_bench.ground_truth.photos import is_photo_folder, read_photos
from footprints_edge_bench.ground_truth.scenes import is_scene_folder, read_scenes


@dataclass(frozen=True)
class Reading:
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
class Kind:
    """A kind of truth: whether a folder holds it, and its items with names unique in the folder."""

    recognises: Callable[[Path], bool]
    read: Callable[[Path, Reading], Iterator[Item]]


KINDS: dict[str, Kind] = {
    "clip": Kind(is_clip, lambda folder, _: read_clip(folder)),
    "made scenes": Kind(is_scene_folder, lambda folder, _: read_scenes(folder)),
    "KITTI": Kind(is_kitti_truth, lambda folder, reading: read_kitti_truth(folder, reading.images)),
    "Matterport": Kind(
        is_matterport_truth, lambda folder, reading: read_matterport_truth(folder, reading.images)
    ),
    "photos": Kind(
        is_photo_folder, lambda folder, reading: read_photos(folder, reading.walkable, reading.void)
    ),
}
"""By name; the first that recognises a folder reads it (clips may have labels as photos do)."""


@dataclass(frozen=True)
class Part:
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
    def parse(cls, text: str, every: int = 1, *, held_out: bool = False) -> "Part":
        """From text such as ``0.8:1``, the last fifth.

        Raises:
            TruthError: the text is something else.
        """
        begin, colon, end = text.partition(":")
        try:
            part = cls(Fraction(begin or 0), Fraction(end or 1), every, held_out)
        except (ValueError, ZeroDivisionError):
            colon = ""
        if not colon or not 0 <= part.begin < part.end <= 1:
            raise TruthError(f"a part {text!r}: give shares of the images, such as 0.8:1")
        return part

    def of(self, dataset: str, items: tuple[Item, ...]) -> tuple[Item, ...]:
        """The items of this part of a dataset."""
        if self.held_out:
            from footprints_edge_models.data.splits import held_out

            items = tuple(held_out(dataset, items))
        begin, end = (int(share * len(items)) for share in (self.begin, self.end))
        return items[begin : end : self.every]


def open_dataset(folder: Path, reading: Reading, part: Part) -> Dataset:
    """The images of a folder that are asked for; their truth is read later.

    Raises:
        TruthError: the folder holds no truth of a known kind, or no image is left.
    """
    for name, kind in KINDS.items():
        if folder.is_dir() and kind.recognises(folder):
            title = folder.resolve().name
            named = (
                replace(item, name=f"{title}/{item.name}") for item in kind.read(folder, reading)
            )
            items = part.of(title, tuple(named))
            if not items:
                raise TruthError(f"{folder}: no image is left in the part that is asked for")
            return Dataset(title, name, items)
    raise TruthError(
        f"{folder}: no truth of a known kind; it needs sequence.json, scenes.json, *_combined.png "
        "(KITTI), *_groundtruth.npy (Matterport), or images/ and labels/ (docs/accuracy.md)"
    )


def open_datasets(folders: list[Path], reading: Reading, part: Part) -> tuple[Dataset, ...]:
    """The images of several folders.

    Raises:
        TruthError: as :func:`open_dataset`, or two folders have one name.
    """
    datasets = tuple(open_dataset(folder, reading, part) for folder in folders)
    names = [dataset.name for dataset in datasets]
    if twins := sorted({name for name in names if names.count(name) > 1}):
        raise TruthError(
            f"more than one folder is called {', '.join(twins)}; results are kept by name: "
            "rename one, or evaluate them one after the other"
        )
    return datasets
