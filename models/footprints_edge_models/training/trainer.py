"""The training loop: sizes by schedule, rates by course, averaged weights; resumable."""

import functools
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import torch
from torch import nn
from torch.optim.swa_utils import AveragedModel

from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import write_credits_file
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.checkpoint import read_checkpoint
from footprints_edge_models.networks.edge import former_focal_px
from footprints_edge_models.networks.registry import Network
from footprints_edge_models.training.batches import Batch, BatchPlan, batches
from footprints_edge_models.training.beginning import (
    has_bfloat16,
    initial_network,
    keep_statistics,
    moving_average,
    parameter_groups,
)
from footprints_edge_models.training.losses import multiscale_losses
from footprints_edge_models.training.plots import draw_curves, draw_predictions
from footprints_edge_models.training.process_group import ProcessGroup, in_parallel, process_group
from footprints_edge_models.training.progress import Progress, Stopwatch
from footprints_edge_models.training.recipe import Recipe, resumed_recipe, switched
from footprints_edge_models.training.run_credits import credits_of_run
from footprints_edge_models.training.run_files import append_row, drop_rows, save, save_weights
from footprints_edge_models.training.schedule import TrainingError, size_at
from footprints_edge_models.training.validation import ValidationScores, validate_all

logger = logging.getLogger(__name__)


@dataclass
class RunState:
    """All that changes during a run.

    Attributes:
        recipe: what it does.
        network: that is trained.
        average: the moving average of its weights.
        optimizer: with the moments of the gradients.
        focal_px: canonical focal length of the weights that it began with.
        step: steps taken.
        pictures_before: steps of the run that this one goes on from: its pictures were seen.
        spent_s: seconds spent.
        validation_s: seconds that a validation takes, the longest so far.
        is_decaying: whether the decay has begun.
    """

    recipe: Recipe
    network: Network
    average: AveragedModel
    optimizer: torch.optim.Optimizer
    focal_px: float
    step: int = 0
    pictures_before: int = 0
    spent_s: float = 0.0
    validation_s: float = 0.0
    is_decaying: bool = False

    def focal_px_at(self, size: tuple[int, int]) -> float:
        """The canonical focal length of the targets at a base size (H, W)."""
        return former_focal_px(size) if self.recipe.former_focal else self.focal_px

    def as_dict(self) -> dict[str, Any]:
        """What a checkpoint holds."""
        return {
            "step": self.step,
            "recipe": asdict(self.recipe),
            "network": self.network.state_dict(),
            "average": self.average.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "focal_px": self.focal_px,
            "pictures_before": self.pictures_before,
            "spent_s": self.spent_s,
            "validation_s": self.validation_s,
            "is_decaying": self.is_decaying,
        }


def train(
    datasets: dict[str, TrainingDataset],
    recipe: Recipe,
    run: Path,
    *,
    device: torch.device,
    validate_every: int = 500,
    save_every: int = 100,
    workers: int = 0,
    progress: Callable[[Progress], None] | None = None,
) -> Path:
    """Train a network, or resume the run in a folder.

    Writes ``train.csv``, ``validation.csv``, ``curves.png``, ``predictions.png``,
    ``credits.json``, the resumable ``last.pt`` and, from every validation on, ``weights.pt``: the
    moving average, a state dict in half precision with the credits of what it learned from. Under
    ``torchrun``, every process trains on pictures of its own and the first one writes.

    Args:
        datasets: see :func:`mixture.load_datasets`.
        recipe: what the run does.
        run: folder of the run, created if absent.
        device: CPU or CUDA.
        validate_every: steps between validations (one more at the end).
        save_every: steps between resumable checkpoints.
        workers: processes that prepare pictures; 0 for two threads.
        progress: called after each step.

    Returns:
        The path of ``weights.pt``.

    Raises:
        TrainingError: the folder holds a run of another recipe.
    """
    with process_group(device) as group:
        run.mkdir(parents=True, exist_ok=True)
        state = _begin(recipe, run, device, group)
        model = in_parallel(state.network, group)
        sources = [run] if recipe.decay_from is None else [run, Path(recipe.decay_from)]
        credits = credits_of_run(datasets, recipe.init, *sources)
        if credits and group.is_first:
            write_credits_file(run, credits)
        plan = BatchPlan(
            functools.partial(size_at, state.recipe.schedule),
            state.focal_px_at,
            recipe.batch,
            recipe.seed,
            offset=state.pictures_before,
            share=(group.rank, group.size),
        )
        last = None if recipe.minutes is not None else recipe.steps
        with closing(batches(datasets, plan, state.step, last, workers)) as stream:
            _loop(
                state,
                model,
                stream,
                functools.partial(_validate, run, state, datasets, credits),
                run=run,
                group=group,
                every=(validate_every, save_every),
                progress=progress,
            )
    return run / "weights.pt"


def _loop(
    state: RunState,
    model: nn.Module,
    stream: Iterator[Batch],
    validate: Callable[[], None],
    *,
    run: Path,
    group: ProcessGroup,
    every: tuple[int, int],
    progress: Callable[[Progress], None] | None,
) -> None:
    """All steps to the end of the run."""
    recipe, watch = state.recipe, Stopwatch(state.spent_s)
    budget_s = None if recipe.minutes is None else 60 * recipe.minutes
    begun = state.step

    def timed_validation() -> None:
        before_s = watch.spent_s
        validate()
        watch.skip()
        state.validation_s = max(state.validation_s, watch.spent_s - before_s)

    if budget_s is not None and begun == 0 and group.is_first:
        timed_validation()  # scores to compare with; and the last one takes as long

    def decayed() -> float:
        spent = 0.0 if budget_s is None else (watch.spent_s + state.validation_s) / budget_s
        return group.agreed(recipe.decayed(state.step, spent))

    while (share := decayed()) < 1:
        if share > 0 and not state.is_decaying:
            state.is_decaying = True
            if recipe.decay < 1:  # the weights move on now: what was averaged before is soon old
                state.average.n_averaged.zero_()
        rate = recipe.lr_factor(state.step, share)
        for parameters in state.optimizer.param_groups:
            parameters["lr"] = parameters["peak"] * rate
        values = _step(state, model, next(stream), group)
        row = {"step": state.step, **values}
        state.step += 1
        state.spent_s = watch.spent_s
        if not group.is_first:
            continue
        append_row(run / "train.csv", row)
        step_s = watch.step_s()
        seen = Progress(
            state.step,
            recipe.steps if budget_s is None else None,
            values["loss"],
            recipe.batch * group.size / step_s,
            step_s * (recipe.steps - state.step) if budget_s is None else budget_s - state.spent_s,
        )
        if progress is not None:
            progress(seen)
        if budget_s is None and state.step == recipe.steps:
            continue  # the end follows
        if state.step % every[0] == 0:
            timed_validation()
        if state.step % every[1] == 0:
            logger.info("%s", seen)
            save(state.as_dict(), run / "last.pt")
    if group.is_first and state.step > begun:
        validate()
        state.spent_s = max(watch.spent_s, budget_s or 0.0)
        save(state.as_dict(), run / "last.pt")


def _step(state: RunState, model: nn.Module, batch: Batch, group: ProcessGroup) -> dict[str, float]:
    """One step of the optimizer; the losses of the whole batch."""
    device = next(state.network.parameters()).device
    image, targets = batch
    image = image.to(device, non_blocking=True).float() / 255
    targets = switched(targets.to(device), state.recipe)
    # bfloat16 keeps float32's range: no loss scaling; the outputs and losses stay float32.
    with torch.autocast(device.type, torch.bfloat16, enabled=has_bfloat16(device)):
        scales = model(image.contiguous(memory_format=torch.channels_last))
    parts = multiscale_losses(scales, targets, state.recipe.terms)
    state.optimizer.zero_grad(set_to_none=True)
    parts["loss"].backward()  # type: ignore[no-untyped-call]
    nn.utils.clip_grad_norm_(state.network.parameters(), 5.0)
    state.optimizer.step()
    state.average.update_parameters(state.network)
    values = group.mean(torch.stack(list(parts.values())).detach())
    return dict(zip(parts, values.tolist(), strict=True))


def _begin(recipe: Recipe, run: Path, device: torch.device, group: ProcessGroup) -> RunState:
    """The state of a run to start or to go on with."""
    torch.manual_seed(recipe.seed)
    network, focal_px, pretrained = initial_network(recipe)
    network.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    network.train()
    if pretrained:
        keep_statistics(network.encoder)
    average = AveragedModel(
        network,
        multi_avg_fn=functools.partial(moving_average, recipe.ema_decay),
        use_buffers=True,
    )
    optimizer = torch.optim.AdamW(
        parameter_groups(network, recipe, pretrained=pretrained), fused=True
    )
    state = RunState(recipe, network, average, optimizer, focal_px)
    if (run / "last.pt").exists():
        _resume(state, run, group)
    elif group.is_first:
        for name in ("train.csv", "validation.csv"):
            (run / name).unlink(missing_ok=True)
    if recipe.decay_from is not None and state.step == 0:
        _go_on_from(state, Path(recipe.decay_from))
    return state


def _resume(state: RunState, run: Path, group: ProcessGroup) -> None:
    stored = _read_state(run)
    recipe = resumed_recipe(stored["recipe"], state.recipe)
    if recipe is None:
        raise TrainingError(
            f"{run} holds a run of another recipe ({stored['recipe']}); name another folder"
        )
    state.recipe = recipe
    _load(state, stored)
    state.step = int(stored["step"])
    state.pictures_before = int(stored.get("pictures_before", 0))
    state.spent_s = float(stored.get("spent_s", 0.0))
    state.validation_s = float(stored.get("validation_s", 0.0))
    state.is_decaying = bool(stored.get("is_decaying", False))
    if group.is_first:  # steps after the checkpoint come again
        drop_rows(run / "train.csv", state.step)
        scores = [field.name for field in fields(ValidationScores)]
        drop_rows(run / "validation.csv", state.step + 1, scores)
        logger.info("%s: resuming from step %d", run, state.step)


def _go_on_from(state: RunState, source: Path) -> None:
    """The weights, average and moments of another run's checkpoint; its pictures were seen."""
    if not (source / "last.pt").exists():
        raise TrainingError(f"{source}: no last.pt of a run to go on from")
    stored = _read_state(source)
    for name, what in (
        ("network", "network"),
        ("coarse_decoder", "coarse decoder"),
        ("frozen_stages", "frozen stages"),
    ):
        theirs = stored["recipe"].get(name, getattr(Recipe, name))
        if theirs != getattr(state.recipe, name):
            raise TrainingError(f"{source}: its {what}: {theirs}; this run's must be the same")
    peaks = [parameters["peak"] for parameters in state.optimizer.param_groups]
    _load(state, stored)
    for parameters, peak in zip(state.optimizer.param_groups, peaks, strict=True):
        parameters["peak"] = peak
    state.pictures_before = int(stored["step"]) + int(stored.get("pictures_before", 0))
    if stored["recipe"].get("former_focal", True):  # begun by an earlier version
        stages = stored["recipe"].get("schedule") or stored["recipe"]["stages"]
        state.focal_px = former_focal_px(tuple(stages[-1]["size"]))
    logger.info("going on from step %d of %s", stored["step"], source)


def _read_state(run: Path) -> dict[str, Any]:
    state = read_checkpoint(run / "last.pt")
    if not isinstance(state, dict) or "recipe" not in state:
        raise TrainingError(f"{run / 'last.pt'} is not of a training run; name another folder")
    return state


def _load(state: RunState, stored: dict[str, Any]) -> None:
    state.network.load_state_dict(stored["network"])
    state.average.load_state_dict(stored["average"])
    for parameters in stored["optimizer"]["param_groups"]:  # of earlier versions: not fused
        parameters.update(fused=True, foreach=None)
    state.optimizer.load_state_dict(stored["optimizer"])
    state.focal_px = float(stored.get("focal_px", state.focal_px))


def _validate(
    run: Path,
    state: RunState,
    datasets: dict[str, TrainingDataset],
    credits: Sequence[Credit],
) -> None:
    """Scores, plots, and the weights as they are now."""
    network = state.average.module
    size = size_at(state.recipe.schedule, max(0, state.step - 1))
    focal_px = state.focal_px_at(size)
    for name, scores in validate_all(network, datasets, size, focal_px).items():
        append_row(run / "validation.csv", {"step": state.step, "dataset": name, **asdict(scores)})
        logger.info("step %d, %s: %s", state.step, name, scores)
    save_weights(network, focal_px, run / "weights.pt", credits)
    if state.step:
        draw_curves(run)
    draw_predictions(network, datasets, size, run / "predictions.png")
