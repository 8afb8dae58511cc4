"""Views kept in the memory of the device that trains: it grows while training goes on.

Every view has a slot of the same number of pixels, whatever its shape. Slots are allocated in
blocks, as they are needed. When no more fit, the oldest view that may go makes room.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from footprints_edge_models.training.gpu_kit.stored_view import StoredView

BYTES_PER_PX = 8


@dataclass(frozen=True)
class StoredBatch:
    """Some views of a store.

    Attributes:
        pixels: int32 (B, slot): the four bytes of each pixel, row by row.
        depths_m: int32 (B, slot): its two float16 depths.
        sizes: int64 (B, 2), on the host: (H, W) of each view.
        intrinsics: float64 (B, 4), on the host: fx, fy, cx, cy.
    """

    pixels: torch.Tensor
    depths_m: torch.Tensor
    sizes: NDArray[np.int64]
    intrinsics: NDArray[np.float64]


class DeviceStore:
    """Views by number, in slots of a device's memory, and their numbers by data set."""

    def __init__(
        self, device: torch.device, slot_px: int, most_views: int, block_views: int = 1024
    ) -> None:
        """An empty store.

        Args:
            device: Where the views are kept.
            slot_px: No view has more pixels.
            most_views: How many are kept.
            block_views: How many slots are allocated at a time.
        """
        self.slot_px = slot_px
        self.datasets: dict[str, list[int]] = {}
        self.replaced = 0
        self.device = device
        self._most = most_views
        self._block_views = min(block_views, most_views)
        self._blocks: list[tuple[torch.Tensor, torch.Tensor]] = []
        self._sizes = np.zeros((most_views, 2), np.int64)
        self._intrinsics = np.zeros((most_views, 4))
        self._count = 0
        self._may_go: dict[str, deque[int]] = {}
        # A copy to a GPU may still read its source after the call: the last ones are kept alive.
        self._recent: deque[torch.Tensor] = deque(maxlen=256)

    def __len__(self) -> int:
        """How many views there are."""
        return self._count

    def add(self, view: StoredView, dataset: str, *, may_go: bool) -> bool:
        """Adds a view.

        Args:
            view: The view.
            dataset: The data set that it belongs to.
            may_go: Whether a later view of its data set may take its place.

        Returns:
            False if there is no room for it.
        """
        height, width = view.size
        area = height * width
        if area > self.slot_px:
            raise ValueError(f"a view of {height}x{width}: slots have {self.slot_px} pixels")
        number = self._free_slot(dataset, may_go=may_go)
        if number is None:
            return False
        block, place = divmod(number, self._block_views)
        for memory, array in zip(self._blocks[block], (view.pixels, view.depths_m), strict=True):
            words = np.ascontiguousarray(array).reshape(-1).view(np.int32)
            assert words.size == area
            source = torch.from_numpy(words if words.flags.writeable else words.copy())
            memory[place, :area].copy_(source, non_blocking=True)
            self._recent.append(source)
        self._sizes[number] = height, width
        self._intrinsics[number] = view.intrinsics
        return True

    def batch(self, numbers: NDArray[np.int64]) -> StoredBatch:
        """Views by number."""
        rows = [divmod(int(number), self._block_views) for number in numbers]
        pixels, depths_m = (
            torch.stack([self._blocks[block][part][place] for block, place in rows])
            for part in (0, 1)
        )
        return StoredBatch(pixels, depths_m, self._sizes[numbers], self._intrinsics[numbers])

    def draw(
        self, count: int, shares: dict[str, float], rng: np.random.Generator
    ) -> NDArray[np.int64]:
        """Numbers of random views, data sets drawn by their shares."""
        names = [name for name in self.datasets if shares.get(name, 0) > 0]
        weights = np.array([shares[name] for name in names])
        chosen = rng.choice(len(names), count, p=weights / weights.sum())
        views = [self.datasets[names[choice]] for choice in chosen]
        return np.array([view[rng.integers(len(view))] for view in views], np.int64)

    def _free_slot(self, dataset: str, *, may_go: bool) -> int | None:
        old = self._may_go.setdefault(dataset, deque())
        if self._count == len(self._blocks) * self._block_views:
            self._grow()
        if self._count < min(self._most, len(self._blocks) * self._block_views):
            number = self._count
            self._count += 1
            self.datasets.setdefault(dataset, []).append(number)
        elif may_go and old:
            number = old.popleft()
            self.replaced += 1
        else:
            return None
        if may_go:
            old.append(number)
        return number

    def _grow(self) -> None:
        """One more block, if the device has the memory; else the store has its final size."""
        if self._count >= self._most:
            return
        shape = (self._block_views, self.slot_px)
        try:
            self._blocks.append(
                (
                    torch.zeros(shape, dtype=torch.int32, device=self.device),
                    torch.zeros(shape, dtype=torch.int32, device=self.device),
                )
            )
        except torch.OutOfMemoryError:
            self._most = self._count
