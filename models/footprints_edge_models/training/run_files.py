"""The files of a run's folder: tables that grow by rows, and checkpoints."""

import csv
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import torch
from torch import nn

from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.networks.checkpoint import CREDITS_KEY, FOCAL_PX_KEY
from footprints_edge_models.training.weight_credits import as_tensor


def save_weights(
    network: nn.Module, focal_px: float | None, path: Path, credits: Collection[Credit] = ()
) -> None:
    """A state dict with its canonical focal length and credits, in half precision, atomically.

    A weight's last bits are noise, and the file is half as large. What is beyond the range of half
    precision, as the variance of a norm may be, keeps its own.
    """
    halves = {name: _in_half(tensor) for name, tensor in network.state_dict().items()}
    if focal_px is not None:
        halves[FOCAL_PX_KEY] = torch.tensor(focal_px, dtype=torch.float64)
    if credits:
        halves[CREDITS_KEY] = as_tensor(credits)
    save(halves, path)


def _in_half(tensor: torch.Tensor) -> torch.Tensor:
    half = tensor.half() if tensor.is_floating_point() else tensor
    return half if half.isfinite().equal(tensor.isfinite()) else tensor


def save(state: Any, path: Path) -> None:  # noqa: ANN401
    """Save atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    torch.save(state, part)
    part.replace(path)


def append_row(path: Path, row: dict[str, Any]) -> None:
    """Adds a row to a CSV file, and its header to a new one."""
    is_new = not path.exists()
    with path.open("a", newline="") as file:
        writer = csv.DictWriter(file, row)
        if is_new:
            writer.writeheader()
        writer.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def drop_rows(path: Path, step: int, columns: Sequence[str] = ()) -> None:
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
