"""The training loop: sizes by schedule, warm-up and cosine, averaged weights; resumable."""

import csv
import functools
import logging
from collections.abc import Callable, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import torch
from torch import nn

from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.checkpoint import load_weights, read_checkpoint
from footprints_edge_models.networks.registry import NETWORKS, Network
from footprints_edge_models.training.batches import batches
from footprints_edge_models.training.losses import multiscale_losses
from footprints_edge_models.training.plots import draw_curves, draw_predictions
from footprints_edge_models.training.recipe import Recipe, TrainingError, is_same_recipe, switched
from footprints_edge_models.training.validation import ValidationScores, validate_all

logger = logging.getLogger(__name__)


def train(
    datasets: dict[str, TrainingDataset],
    recipe: Recipe,
    run: Path,
    *,
    device: torch.device,
    validate_every: int = 500,
    save_every: int = 100,
    progress: Callable[[int, int, float], None] | None = None,
) -> Path:
    """Train a network, or resume the run in a folder.

    Writes ``train.csv``, ``validation.csv``, ``curves.png``, ``predictions.png``, the resumable
    ``last.pt`` and, from every validation on, ``weights.pt``: the moving average, a state dict
    in half precision.

    Args:
        datasets: see :func:`mixture.load_datasets`.
        recipe: what the run does.
        run: folder of the run, created if absent.
        device: CPU or CUDA.
        validate_every: steps between validations (one more at the end).
        save_every: steps between resumable checkpoints.
        progress: called with (step, steps, loss) after each step.

    Returns:
        The path of ``weights.pt``.

    Raises:
        TrainingError: the folder holds a run of another recipe.
    """
    run.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(recipe.seed)
    network, pretrained = _initial_network(recipe)
    network.to(device).to(memory_format=torch.channels_last)  # type: ignore[call-overload]
    optimizer = torch.optim.AdamW(_parameter_groups(network, recipe, pretrained=pretrained))
    average = torch.optim.swa_utils.AveragedModel(
        network,
        multi_avg_fn=functools.partial(_moving_average, recipe.ema_decay),
        use_buffers=True,
    )
    start = _resume(run, recipe, network, average, optimizer)
    sizes = recipe.sizes()
    network.train()
    if pretrained:
        _keep_statistics(network.encoder)
    for step, (image, targets) in enumerate(
        batches(datasets, sizes, recipe.batch, recipe.seed, start), start
    ):
        rate = recipe.lr_factor(step)
        for group in optimizer.param_groups:
            group["lr"] = group["peak"] * rate
        image = image.to(device, memory_format=torch.channels_last, non_blocking=True)  # noqa: PLW2901
        # bfloat16 keeps float32's range: no loss scaling; the outputs and losses stay float32.
        with torch.autocast(device.type, torch.bfloat16, enabled=_has_bfloat16(device)):
            scales = network.scales(image)
        parts = multiscale_losses(scales, switched(targets.to(device), recipe))
        optimizer.zero_grad(set_to_none=True)
        parts["loss"].backward()  # type: ignore[no-untyped-call]
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimizer.step()
        average.update_parameters(network)
        values = {name: value.item() for name, value in parts.items()}
        _append(run / "train.csv", {"step": step, **values})
        done = step + 1
        if progress is not None:
            progress(done, len(sizes), values["loss"])
        if done % validate_every == 0 or done == len(sizes):
            _validate(run, done, average.module, datasets, sizes[step])
        if done % save_every == 0 or done == len(sizes):
            state = {
                "step": done,
                "recipe": asdict(recipe),
                "network": network.state_dict(),
                "average": average.state_dict(),
                "optimizer": optimizer.state_dict(),
            }
            _save(state, run / "last.pt")
    return run / "weights.pt"


def _initial_network(recipe: Recipe) -> tuple[Network, bool]:
    """The network, and whether its encoder is trained already."""
    spec = NETWORKS[recipe.network]
    if recipe.init is None and spec.pretrained is not None:
        return spec.pretrained(), True
    network = spec.build()
    if recipe.init is not None:
        load_weights(network, read_checkpoint(Path(recipe.init)), recipe.init)
    return network, recipe.init is not None


def _keep_statistics(encoder: nn.Module) -> None:
    """Batch norms keep their statistics: those of a mix of sources are no better.

    What int8 folds into the weights is then what was trained, and a step on a CPU is much faster.
    """
    for module in encoder.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.eval()


def _moving_average(
    decay: float,
    averages: list[torch.Tensor],
    currents: list[torch.Tensor],
    count: torch.Tensor | int,
) -> None:
    """Exponential, but plain at first, so that the fresh weights are soon forgotten; in place."""
    step = int(count)
    weight = 1 - min(decay, (1 + step) / (10 + step))
    for average, current in zip(averages, currents, strict=True):
        if average.is_floating_point():
            average.lerp_(current, weight)
        else:
            average.copy_(current)


def _parameter_groups(
    network: nn.Module, recipe: Recipe, *, pretrained: bool
) -> list[dict[str, Any]]:
    groups = []
    encoder_lr = recipe.encoder_lr if pretrained else recipe.decoder_lr
    for is_encoder, peak in ((True, encoder_lr), (False, recipe.decoder_lr)):
        for is_matrix in (True, False):  # norms and biases are not decayed
            parameters = [
                p
                for name, p in network.named_parameters()
                if name.startswith("encoder.") == is_encoder and (p.ndim > 1) == is_matrix
            ]
            decay = recipe.weight_decay if is_matrix else 0.0
            groups.append({"params": parameters, "peak": peak, "lr": 0.0, "weight_decay": decay})
    return groups


def _has_bfloat16(device: torch.device) -> bool:
    """Whether bfloat16 is faster than float32: without it, a CPU emulates it, which is slow."""
    return device.type != "cpu" or bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())


def _resume(
    run: Path,
    recipe: Recipe,
    network: nn.Module,
    average: nn.Module,
    optimizer: torch.optim.Optimizer,
) -> int:
    if not (run / "last.pt").exists():
        for name in ("train.csv", "validation.csv"):
            (run / name).unlink(missing_ok=True)
        return 0
    state = read_checkpoint(run / "last.pt")
    if not isinstance(state, dict) or "recipe" not in state:
        raise TrainingError(f"{run / 'last.pt'} is not of a training run; name another folder")
    if not is_same_recipe(state["recipe"], recipe):
        raise TrainingError(
            f"{run} holds a run of another recipe ({state['recipe']}); name another folder"
        )
    network.load_state_dict(state["network"])
    average.load_state_dict(state["average"])
    optimizer.load_state_dict(state["optimizer"])
    # steps after the checkpoint come again
    _truncate(run / "train.csv", state["step"])
    scores = [field.name for field in fields(ValidationScores)]
    _truncate(run / "validation.csv", state["step"] + 1, scores)
    logger.info("%s: resuming from step %d", run, state["step"])
    return int(state["step"])


def _validate(
    run: Path,
    step: int,
    network: nn.Module,
    datasets: dict[str, TrainingDataset],
    size: tuple[int, int],
) -> None:
    for name, scores in validate_all(network, datasets, size).items():
        _append(run / "validation.csv", {"step": step, "dataset": name, **asdict(scores)})
        logger.info("step %d, %s: %s", step, name, scores)
    _save_weights(network, run / "weights.pt")
    draw_curves(run)
    draw_predictions(network, datasets, size, run / "predictions.png")


def _save_weights(network: nn.Module, path: Path) -> None:
    """Half precision: a weight's last bits are noise, and the file is half as large."""
    weights = network.state_dict()
    _save({k: v.half() if v.is_floating_point() else v for k, v in weights.items()}, path)


def _save(state: Any, path: Path) -> None:  # noqa: ANN401
    """Save atomically."""
    part = path.with_suffix(".part")
    torch.save(state, part)
    part.replace(path)


def _append(path: Path, row: dict[str, Any]) -> None:
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, row)
        if is_new:
            writer.writeheader()
        writer.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def _truncate(path: Path, step: int, columns: Sequence[str] = ()) -> None:
    """Drops the rows from a step on; adds columns that earlier versions did not write."""
    if path.exists():
        with path.open(newline="") as file:
            reader = csv.DictReader(file, restval="")
            written = reader.fieldnames or ()
            names = [*written, *(name for name in columns if name not in written)]
            kept = [row for row in reader if int(row["step"]) < step]
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, names)
            writer.writeheader()
            writer.writerows(kept)
