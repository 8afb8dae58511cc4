"""A training run that fills a given time: data come in, weights go out, whatever happens."""

import logging
import math
import shutil
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch

from footprints_edge.foundation.cores import usable_cores
from footprints_edge_models.asset_files.credit_files import CREDITS, read_credits_file
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.batches import view_size
from footprints_edge_models.training.gpu_kit.device_colours import jitter
from footprints_edge_models.training.gpu_kit.device_store import BYTES_PER_PX, DeviceStore
from footprints_edge_models.training.gpu_kit.device_views import (
    DeviceBatch,
    cut_views,
    draw_cameras,
)
from footprints_edge_models.training.gpu_kit.kit_settings import (
    ASSETS,
    INITIAL_WEIGHTS,
    SHARD,
    KitSettings,
    read_kit_settings,
)
from footprints_edge_models.training.gpu_kit.learner import Learner
from footprints_edge_models.training.gpu_kit.scene_stream import SceneStream, SceneViews
from footprints_edge_models.training.gpu_kit.stored_view import as_sample, stored_view
from footprints_edge_models.training.gpu_kit.view_shard import read_shard
from footprints_edge_models.training.plots import draw_curves, draw_predictions
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.run_files import append_row, save_weights
from footprints_edge_models.training.schedule import ScheduleStage
from footprints_edge_models.training.validation import validate_all

logger = logging.getLogger(__name__)

SCENES = "synthetic_scenes"
"""The data set that made views belong to."""
OWN_SCENES = 1 << 30
"""Added to the seed of scenes: those of a folder, of which some are held out, are others."""
BASE_BATCH = 12
"""The recipe's learning rates are for this batch; they grow with the root of it."""
READ_EVERY = 20
"""Steps between two readings of the loss: a reading waits for the device."""


@dataclass(frozen=True)
class RunSize:
    """How large a run is.

    Attributes:
        size: (h, w) of a batch of landscape views.
        batch: Views a step.
        warmup_steps: Of linear warm-up.
        most_views: Views kept, if the device's memory holds them.
        tell_s: Seconds between two lines of ``machine.csv``.
        save_s: Seconds between two saves of the weights.
        validate_s: Seconds between two validations.
        reserve_s: Seconds of the time kept for the end.
        validated: Most held-out views of each data set.
    """

    size: tuple[int, int]
    batch: int = 96
    warmup_steps: int = 150
    most_views: int = 60_000
    tell_s: float = 10.0
    save_s: float = 45.0
    validate_s: float = 60.0
    reserve_s: float = 25.0
    validated: int = 24

    @property
    def slot_px(self) -> int:
        """Most pixels of a stored view: as many as the network sees, and some."""
        return math.ceil(1.15 * self.size[0] * self.size[1] / 1024) * 1024

    @classmethod
    def toy(cls) -> "RunSize":
        """For a rehearsal on a CPU."""
        return cls((64, 96), 4, 5, 200, 2.0, 4.0, 8.0, 5.0, 3)


def run_kit(
    kit: Path,
    out: Path,
    minutes: float,
    device: torch.device,
    *,
    batch: int | None = None,
    processes: int | None = None,
    toy: bool = False,
    started: float | None = None,
) -> Path:
    """Trains with an unpacked kit until the time is up; the path of the weights.

    Writes ``weights.pt`` (half precision, the moving average) again and again, ``train.csv``,
    ``validation.csv``, ``machine.csv`` and ``credits.json``, and at the end ``curves.png`` and
    ``predictions.png``.

    Args:
        kit: Folder of the unpacked kit.
        out: Folder of the results.
        minutes: From ``started`` to the return.
        device: Where to train.
        batch: Views a step; None: 96, half of it whenever memory runs out.
        processes: That make scenes; None: two fewer than there are cores.
        toy: A tiny run, to see that all works.
        started: ``time.monotonic()`` of the start; None: now.

    Raises:
        DatasetError: the kit is damaged.
    """
    started = time.monotonic() if started is None else started
    out.mkdir(parents=True, exist_ok=True)
    for name in ("train.csv", "validation.csv", "machine.csv"):
        (out / name).unlink(missing_ok=True)
    settings = read_kit_settings(kit)
    shutil.copyfile(kit / CREDITS, out / CREDITS)
    how = RunSize.toy() if toy else RunSize(settings.size)
    assets = kit / ASSETS
    job = SceneViews.of(
        assets if assets.is_file() else None, OWN_SCENES + settings.seed, how.size, how.slot_px
    )
    count = max(1, usable_cores() - 2) if processes is None else processes
    # Before CUDA starts, and first of all: these processes need the longest to get going.
    stream = SceneStream(job, count)
    logger.info("%d processes make scenes; %.1f minutes on %s", count, minutes, device)
    try:
        clock = _Clock(started, 60 * minutes - min(how.reserve_s, 15 * minutes))
        run = _TimedRun(kit, out, settings, how, batch or how.batch, device, stream, clock)
        run.train()
        return run.finish()
    finally:
        stream.close()


@dataclass(frozen=True)
class _Clock:
    """The time of the training.

    Attributes:
        started: ``time.monotonic()`` of the start.
        length_s: All of it.
    """

    started: float
    length_s: float

    @property
    def s(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self.started


class _TimedRun:
    """A network that learns from a store that fills."""

    def __init__(
        self,
        kit: Path,
        out: Path,
        settings: KitSettings,
        how: RunSize,
        batch: int,
        device: torch.device,
        stream: SceneStream,
        clock: _Clock,
    ) -> None:
        self._out, self._settings, self._how, self._batch = out, settings, how, batch
        self._device, self._stream, self._clock = device, stream, clock
        if device.type == "cuda":
            torch.backends.cudnn.benchmark = True  # three shapes of batches, each very often
            torch.set_num_threads(2)  # the other cores make scenes
        scale = math.sqrt(batch / BASE_BATCH)
        self._recipe = Recipe(
            (ScheduleStage(how.size, 1),),
            batch=batch,
            encoder_lr=Recipe.encoder_lr * scale,
            decoder_lr=Recipe.decoder_lr * scale,
            seed=settings.seed,
            warmup_steps=how.warmup_steps,
            minutes=clock.length_s / 60,
            init=str(kit / INITIAL_WEIGHTS),
            **settings.recipe,
        )
        self._learner = Learner(self._recipe, device)
        self._store = DeviceStore(device, how.slot_px, _most_views(how, device))
        self._held_out = self._fill(kit)
        self._rng = np.random.default_rng(settings.seed)
        self._generator = torch.Generator(device).manual_seed(settings.seed)
        self._weights = out / "weights.pt"
        self._credits = read_credits_file(kit / CREDITS)
        self._window: list[dict[str, torch.Tensor]] = []
        self._is_decaying = False
        self._step = self._pictures = 0
        self._caution = 1.0
        self._validated = 0
        self._told = (clock.s, 0, 0)

    def train(self) -> None:
        """Until the time is up."""
        self._keep()
        how = self._how
        logger.info("%.1f s: %d views at hand", self._clock.s, len(self._store))
        saved = validated = told = self._clock.s
        # at least one step: a run never ends without anything to look at
        while (now := self._clock.s) < self._clock.length_s or (
            len(self._store) and not self._step
        ):
            for view in self._stream.ready(2 * self._batch):
                self._store.add(view, SCENES, may_go=True)
            if not len(self._store):  # a kit without views, and no scene yet
                time.sleep(0.1)
                continue
            if not self._learn(now / self._clock.length_s):
                continue
            if len(self._window) == READ_EVERY:
                self._read()
            if now - told >= how.tell_s:
                self._guarded(self._tell)
                told = now
            if now - saved >= how.save_s:
                self._guarded(self._keep)
                saved = now
            if now - validated >= how.validate_s:
                self._guarded(self._validate)
                validated = self._clock.s

    def finish(self) -> Path:
        """Saves the weights, then all that is said about them; the path of the weights."""
        self._read()
        self._keep()
        self._guarded(self._tell)
        self._guarded(self._validate)
        self._guarded(self._draw)
        logger.info(
            "%.1f s: done; %d steps, %d pictures, %d scenes",
            *(self._clock.s, self._step, self._pictures, self._stream.scenes),
        )
        return self._weights

    def _fill(self, kit: Path) -> dict[str, TrainingDataset]:
        """Puts the kit's views into the store; the held-out ones by data set."""
        held_out: dict[str, list[Sample]] = {}
        for number, each in enumerate(read_shard(kit / SHARD, min(8, usable_cores()))):
            sample = as_sample(each.view, f"{each.dataset}/{number}")
            if each.split == "train":
                # smaller where this run is; scenes make room for fresh ones, in the end
                view = stored_view(sample, self._how.slot_px)
                self._store.add(view, each.dataset, may_go=each.dataset == SCENES)
            else:
                held_out.setdefault(each.dataset, []).append(sample)
        return {name: TrainingDataset((), samples, 0) for name, samples in held_out.items()}

    def _learn(self, time_share: float) -> bool:
        """One step; False where memory ran out: the next one is smaller."""
        decayed = self._recipe.decayed(self._step, time_share)
        if decayed > 0 and not self._is_decaying:
            self._is_decaying = True
            self._learner.restart_average()
        rate = self._caution * self._recipe.lr_factor(self._step, decayed)
        try:
            if self._step == 0 and self._device.type == "cuda":
                self._warm_up()
            self._window.append(self._learner.step(self._cut(), rate))
        except torch.OutOfMemoryError:
            if self._batch == 1:
                raise
            self._batch //= 2
            logger.warning("out of memory: from here on %d views a step", self._batch)
        else:
            self._step += 1
            self._pictures += self._batch
            return True
        self._window.clear()
        torch.cuda.empty_cache()
        return False

    def _warm_up(self) -> None:
        """Chooses the faster memory layout, and says what a step's parts take."""
        cutting_s = self._timed(self._cut)
        batch = self._cut()
        by_layout = {}
        for layout in (torch.contiguous_format, torch.channels_last):
            self._learner.lay_out(layout)
            by_layout[layout] = self._timed(lambda: self._learner.gradients(batch))
        self._learner.lay_out(min(by_layout, key=lambda layout: by_layout[layout]))
        logger.info(
            "%d views: cut in %.1f ms, gradients in %s ms",
            *(self._batch, 1e3 * cutting_s),
            ", ".join(f"{1e3 * s:.1f} ({layout})" for layout, s in by_layout.items()),
        )

    def _timed(self, work: Callable[[], object], repeats: int = 3) -> float:
        """Seconds on the device, after a first time."""
        work()
        torch.cuda.synchronize(self._device)
        start = time.monotonic()
        for _ in range(repeats):
            work()
        torch.cuda.synchronize(self._device)
        return (time.monotonic() - start) / repeats

    def _cut(self) -> DeviceBatch:
        """A random batch; all its work is done by the device."""
        size = view_size(self._how.size, self._rng)
        numbers = self._store.draw(self._batch, self._settings.shares, self._rng)
        stored = self._store.batch(numbers)
        cameras = draw_cameras(
            stored.sizes, stored.intrinsics, size, self._learner.focal_px, self._rng
        )
        with torch.no_grad():
            image, targets = cut_views(stored, cameras, size)
            return jitter(image, self._rng, self._generator), targets

    def _read(self) -> None:
        """Writes the mean losses since the last reading; goes back where they are no numbers."""
        if not self._window:
            return
        names = list(self._window[0])
        sums = torch.stack([part for parts in self._window for part in parts.values()])
        values = sums.reshape(-1, len(names)).mean(dim=0).tolist()
        self._window.clear()
        if all(map(math.isfinite, values)):
            row = {"step": self._step, **dict(zip(names, values, strict=True))}
            append_row(self._out / "train.csv", row)
            return
        self._caution /= 2
        logger.warning(
            "step %d: losses are %s; back to the weights saved last, at %g of the learning rate",
            *(self._step, values, self._caution),
        )
        self._learner.go_back()

    def _keep(self) -> None:
        """Saves the weights if they are numbers."""
        tensors = self._learner.average.state_dict().values()
        if torch.stack([tensor.float().sum() for tensor in tensors]).isfinite().all():
            self._learner.keep()
            save_weights(
                self._learner.average, self._learner.focal_px, self._weights, self._credits
            )

    def _validate(self) -> None:
        if self._validated == self._step:
            return
        self._validated = self._step
        scores = validate_all(
            self._learner.average,
            self._held_out,
            self._how.size,
            self._learner.focal_px,
            self._how.validated,
        )
        for name, each in scores.items():
            row = {"step": self._step, "dataset": name, **asdict(each)}
            append_row(self._out / "validation.csv", row)
            logger.info("step %d, %s: %s", self._step, name, each)

    def _draw(self) -> None:
        draw_curves(self._out)
        path = self._out / "predictions.png"
        draw_predictions(self._learner.average, self._held_out, self._how.size, path)

    def _tell(self) -> None:
        """One line of ``machine.csv``: how fast everything is."""
        before_s, pictures, scenes = self._told
        self._told = (self._clock.s, self._pictures, self._stream.scenes)
        seconds = max(self._clock.s - before_s, 1e-3)
        on_gpu = self._device.type == "cuda"
        row = {
            "seconds": self._clock.s,
            "step": self._step,
            "batch": self._batch,
            "pictures": self._pictures,
            "pictures_per_s": (self._pictures - pictures) / seconds,
            "scenes": self._stream.scenes,
            "scenes_per_s": (self._stream.scenes - scenes) / seconds,
            "failed_scenes": self._stream.failed,
            "views": len(self._store),
            "replaced_views": self._store.replaced,
            "views_waiting": self._stream.waiting,
            "device_gb": torch.cuda.max_memory_allocated(self._device) / 1e9 if on_gpu else 0.0,
        }
        append_row(self._out / "machine.csv", row)
        told = (f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items())
        logger.info("%s%s", ", ".join(told), "" if self._stream.alive else "; no more scenes")

    def _guarded(self, work: Callable[[], None]) -> None:
        """The run goes on whatever happens to what is said about it."""
        try:
            work()
        except Exception:
            logger.exception("step %d: training goes on", self._step)


def _most_views(how: RunSize, device: torch.device) -> int:
    """As many as fit beside the training."""
    if device.type != "cuda":
        return how.most_views
    free, _ = torch.cuda.mem_get_info(device)
    return max(1, min(how.most_views, int(0.6 * free) // (BYTES_PER_PX * how.slot_px)))
