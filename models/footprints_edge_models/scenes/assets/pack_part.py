"""What scenes take from a pack: the assets of one kind and one split, the last ones in memory."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar, cast

from footprints_edge_models.asset_files.pack import AssetPack, Split

KeptT = TypeVar("KeptT")


@dataclass(frozen=True)
class PackPart:
    """Assets of a pack that belong to one split. Each process opens the pack by itself.

    Attributes:
        path: The pack.
        split: The split.
    """

    path: Path
    split: Split
    _kept: dict[Hashable, Any] = field(default_factory=dict, compare=False, repr=False)

    def __getstate__(self) -> dict[str, object]:
        """What another process needs: the file, not what was read from it."""
        return {"path": self.path, "split": self.split, "_kept": {}}

    @cached_property
    def _pack(self) -> AssetPack:
        return AssetPack(self.path)

    def _keep(self, key: Hashable, make: Callable[[], KeptT], most: int) -> KeptT:
        """What is in memory under a key, or is made; the ``most`` used last stay."""
        if key in self._kept:
            kept = self._kept.pop(key)
        else:
            if len(self._kept) >= most:
                del self._kept[next(iter(self._kept))]
            kept = make()
        self._kept[key] = kept  # the least recently used is the first
        return cast("KeptT", kept)
