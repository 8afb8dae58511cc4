"""Batches that depend on the seed and the step alone, so that a resumed run sees the same ones.

Threads prepare batches ahead, as OpenCV and numpy release the interpreter lock; or processes do.
"""

import functools
import itertools
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, fields

import cv2
import numpy as np
import torch

from footprints_edge_models.data.augmentation import VirtualView, render_view
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.data.targets import Targets

Batch = tuple[torch.Tensor, Targets]
"""RGB uint8 (B, 3, h, w), and its targets."""


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
    return images.permute(0, 3, 1, 2), Targets(**targets)


@dataclass(frozen=True)
class BatchPlan:
    """What each step of a run is given.

    Attributes:
        size_of: base size (H, W) of a step.
        focal_px_of: canonical focal length at a base size.
        count: pictures of a batch.
        seed: of the run.
        offset: added to the step: pictures before it were seen by another run.
        share: (i, n): this is the i-th of n processes, and gets the i-th of n parts of every batch.
    """

    size_of: Callable[[int], tuple[int, int]]
    focal_px_of: Callable[[tuple[int, int]], float]
    count: int
    seed: int
    offset: int = 0
    share: tuple[int, int] = (0, 1)


def make_batch(datasets: dict[str, TrainingDataset], plan: BatchPlan, step: int) -> Batch:
    """The batch of one step: datasets drawn by their shares, all views of one size."""
    key = (plan.seed, step + plan.offset)
    rng = np.random.default_rng(key)
    filled = [dataset for dataset in datasets.values() if dataset.train]
    shares = np.array([dataset.share for dataset in filled])
    size = plan.size_of(step)
    focal_px = plan.focal_px_of(size)
    size = view_size(size, rng)
    part, parts = plan.share
    choices = rng.choice(len(filled), plan.count * parts, p=shares / shares.sum())
    views = []
    for place in range(part * plan.count, (part + 1) * plan.count):
        rng = np.random.default_rng((*key, place))
        samples = filled[choices[place]].train
        views.append(render_view(samples[rng.integers(len(samples))], size, rng, focal_px))
    return stack(views)


def batches(
    datasets: dict[str, TrainingDataset],
    plan: BatchPlan,
    start: int,
    stop: int | None = None,
    workers: int = 0,
) -> Generator[Batch]:
    """The batches from step ``start`` on, to ``stop`` or without end.

    Args:
        datasets: to draw from.
        plan: of the run.
        start: first step.
        stop: step after the last.
        workers: processes that make them; 0 for two threads.
    """
    steps = itertools.count(start) if stop is None else iter(range(start, stop))
    if workers:
        yield from _from_processes(functools.partial(make_batch, datasets, plan), steps, workers)
    else:
        yield from _from_threads(functools.partial(make_batch, datasets, plan), steps)


def _from_threads(
    make: Callable[[int], Batch], steps: Iterator[int], ahead: int = 4
) -> Iterator[Batch]:
    queue: deque[Future[Batch]] = deque()
    pool = ThreadPoolExecutor(2, thread_name_prefix="batches")
    try:
        while True:
            while len(queue) < ahead and (step := next(steps, None)) is not None:
                queue.append(pool.submit(make, step))
            if not queue:
                return
            yield queue.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


class _Steps(torch.utils.data.Dataset[Batch]):
    """Batches by step, for torch's loader."""

    def __init__(self, make: Callable[[int], Batch]) -> None:
        self._make = make

    def __getitem__(self, step: int) -> Batch:
        return self._make(step)


def _from_processes(
    make: Callable[[int], Batch], steps: Iterator[int], workers: int
) -> Iterator[Batch]:
    """Forked, so that samples in memory are shared; each with one thread."""
    loader = torch.utils.data.DataLoader(
        _Steps(make),
        batch_size=None,
        sampler=steps,
        num_workers=workers,
        multiprocessing_context="fork",
        pin_memory=torch.cuda.is_available(),
    )
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # ends OpenCV's threads: a child that was forked beside them may hang
    made = iter(loader)
    cv2.setNumThreads(threads)
    yield from made
