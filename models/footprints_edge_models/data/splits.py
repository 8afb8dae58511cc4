"""Which samples of a dataset are trained on and which are held out.

Rules look at names and order only: they split samples, and whatever else is named as samples are.
To add a dataset, name its rule in ``SPLITS``.
"""

import zlib
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

from footprints_edge_models.asset_files.pictures import HELD_OUT_PANORAMAS


class Named(Protocol):
    """Has the name of a sample."""

    @property
    def name(self) -> str:
        """Dataset and frame."""


NamedT = TypeVar("NamedT", bound=Named)


class SplitRule(Protocol):
    """Divides samples into those trained on and those held out."""

    def __call__(self, samples: Sequence[NamedT], /) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
        """Both, in order."""


def train_on_all(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
    """Holds nothing out."""
    return samples, []


def scenes_cut(names: Sequence[str], views: int) -> tuple[int, int]:
    """The end of the synthetic scenes that are trained on, and the beginning of those held out.

    The last fiftieth is held out, at most 100 pictures. Views of a scene that would stand on both
    sides are trained on or dropped; where they are all that would be held out, they are all.

    Args:
        names: of the pictures in order, each a number, perhaps behind a folder and a slash.
        views: greatest number of pictures of a scene: number of a picture = number of its scene
            times this + number of the view.
    """
    end = len(names) - min(100, len(names) // 50)
    if end == len(names) or views == 1:
        return end, end
    scenes = [int(name.rpartition("/")[2]) // views for name in names]
    begin = bisect_left(scenes, scenes[end])
    if begin == end:
        return end, end
    after = bisect_right(scenes, scenes[end])
    return (end, after) if after < len(names) else (begin, begin)


def halves_cut(names: Sequence[str], views: int = 1) -> int:
    """Where names fall into two halves, all pictures of a place in one of them.

    A place is a scene of so many views (see :func:`scenes_cut`), else a drive, house or panorama:
    the name up to its last underscore. The cut is at the end of a place that is nearest to the
    middle: len(names) if there is only one.
    """

    def place(name: str) -> str | int:
        own = name.rpartition("/")[2]
        return int(own) // views if views > 1 else own.rpartition("_")[0] or own

    places = [place(name) for name in names]
    ends = [k for k in range(1, len(names)) if places[k] != places[k - 1]]
    return min(ends, key=lambda k: abs(2 * k - len(names)), default=len(names))


def hold_out_clip_end(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
    """Holds out the last fifth of a clip and drops the twentieth before it.

    Neighbouring frames are alike: the gap keeps them from being on both sides.
    """
    return samples[: len(samples) * 3 // 4], samples[len(samples) * 4 // 5 :]


def hold_out_groups(one_in: int) -> SplitRule:
    """Holds out one group in ``one_in``: a drive or a house, the name up to its last underscore.

    A checksum of that name decides, so that adding photos moves no other photo.
    """
    return _hold_out_where(lambda group: zlib.crc32(group.encode()) % one_in == 0)


def hold_out_panoramas(
    samples: Sequence[NamedT],
) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
    """Holds out all views of ``HELD_OUT_PANORAMAS``."""
    split = _hold_out_where(lambda group: group.rpartition("/")[2] in HELD_OUT_PANORAMAS)
    return split(samples)


def _hold_out_where(is_held_out: Callable[[str], bool]) -> SplitRule:
    """Holds out the groups, names up to their last underscore, for which this is true."""

    def split(samples: Sequence[NamedT]) -> tuple[Sequence[NamedT], Sequence[NamedT]]:
        chosen = [is_held_out(sample.name.rsplit("_", 1)[0]) for sample in samples]
        pairs = list(zip(samples, chosen, strict=True))
        return [sample for sample, out in pairs if not out], [
            sample for sample, out in pairs if out
        ]

    return split


SPLITS: dict[str, SplitRule] = {
    "idd_lite": hold_out_groups(5),
    "camvid": train_on_all,
    "houses": hold_out_groups(20),
    "openimages": hold_out_groups(20),
    "inserted": train_on_all,
    "hololens_office": hold_out_clip_end,
    "seven_scenes_kitchen": hold_out_clip_end,
    "kitti_grey_stereo": hold_out_clip_end,
    "kitti_raw": hold_out_clip_end,
    "matterport_raw": hold_out_clip_end,
    "panoramas": hold_out_panoramas,
}
"""By name of the dataset's folder; :func:`scenes_cut` is the rule of ``SCENES``."""
SCENES = "synthetic_scenes"


def held_out(dataset: str, items: Sequence[NamedT], views: int = 1) -> Sequence[NamedT]:
    """The part of a dataset that training holds out; all of a dataset without a rule.

    Args:
        dataset: name of its folder.
        items: all of it in order, named as its samples are: folder name, slash, file name.
        views: of each scene, of synthetic scenes.
    """
    if dataset == SCENES:
        return items[scenes_cut([item.name for item in items], views)[1] :]
    return SPLITS[dataset](items)[1] if dataset in SPLITS else items
