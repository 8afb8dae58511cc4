"""Batches that depend on the seed and the step alone, so that a resumed run sees the same ones.

Worker threads prepare batches ahead; OpenCV and numpy release the interpreter lock.
"""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import torch

from footprints_edge_models.data.augmentation import VirtualView, render_view
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.data.targets import Targets
from footprints_edge_models.networks.edge import focal_px_at

Batch = tuple[torch.Tensor, Targets]
"""RGB float32 (B, 3, h, w) in [0, 1], and its targets."""


def view_size(size: tuple[int, int], rng: np.random.Generator) -> tuple[int, int]:
    """The size of one batch: landscape as given, 20 % portrait, 15 % square of the same area."""
    dice = rng.random()
    if dice < 0.2:
        return size[1], size[0]
    if dice < 0.35:
        side = round((size[0] * size[1]) ** 0.5 / 32) * 32
        return side, side
    return size


def stack(views: list[VirtualView]) -> Batch:
    """Stacks views of one size into a batch."""
    images = torch.from_numpy(np.stack([view.image for view in views]))
    targets = {
        field.name: torch.from_numpy(np.stack([getattr(view, field.name) for view in views]))
        for field in fields(Targets)
    }
    return images.permute(0, 3, 1, 2).float() / 255, Targets(**targets)


def make_batch(
    datasets: dict[str, TrainingDataset], size: tuple[int, int], count: int, seed: int, step: int
) -> Batch:
    """The batch of one step: datasets drawn by their shares, all views of one size."""
    rng = np.random.default_rng((seed, step))
    filled = [dataset for dataset in datasets.values() if dataset.train]
    shares = np.array([dataset.share for dataset in filled])
    focal_px = focal_px_at(size)
    size = view_size(size, rng)
    views = []
    for choice in rng.choice(len(filled), count, p=shares / shares.sum()):
        samples = filled[choice].train
        views.append(render_view(samples[rng.integers(len(samples))], size, rng, focal_px))
    return stack(views)


def batches(
    datasets: dict[str, TrainingDataset],
    sizes: list[tuple[int, int]],
    count: int,
    seed: int,
    start: int,
    ahead: int = 4,
) -> Iterator[Batch]:
    """The batches from step ``start`` on; ``sizes`` holds the base size of each step."""
    queue: deque[Future[Batch]] = deque()
    steps = iter(range(start, len(sizes)))
    with ThreadPoolExecutor(2, thread_name_prefix="batches") as pool:
        while True:
            while len(queue) < ahead and (step := next(steps, None)) is not None:
                queue.append(pool.submit(make_batch, datasets, sizes[step], count, seed, step))
            if not queue:
                return
            yield queue.popleft().result()
