"""Whom to credit for what a network learned from: kept beside the weights, and from run to run."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch

from footprints_edge.errors import ModelError
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import (
    CREDITS,
    ordered_credits,
    read_credits_file,
)
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.checkpoint import CREDITS_KEY, read_checkpoint


def stated_credits(weights: Any, name: str) -> list[Credit]:  # noqa: ANN401 - of any checkpoint
    """The credits that a state dict states; none where it states none.

    Raises:
        ModelError: what is stated is no list of credits.
    """
    if not isinstance(weights, dict) or CREDITS_KEY not in weights:
        return []
    try:
        facts = json.loads(bytes(weights[CREDITS_KEY].to(torch.uint8).tolist()))
        return [Credit(**each) for each in facts]
    except (AttributeError, ValueError, TypeError) as error:
        raise ModelError(f"{name}: {CREDITS_KEY} is no list of credits ({error})") from error


def as_tensor(credits: Iterable[Credit]) -> torch.Tensor:
    """Credits as a state dict holds them, uint8 (N,)."""
    text = json.dumps([asdict(each) for each in ordered_credits(credits)])
    return torch.tensor(list(text.encode()), dtype=torch.uint8)


def credits_of_run(
    datasets: Mapping[str, TrainingDataset], init: str | None, *folders: Path
) -> list[Credit]:
    """Whom to credit for a run.

    Args:
        datasets: that it trains on.
        init: weights that it begins with; what those learned from counts.
        folders: of runs that it goes on from, its own included.
    """
    found = [credit for dataset in datasets.values() for credit in dataset.credits]
    if init is not None:
        found += stated_credits(read_checkpoint(Path(init)), init)
    for folder in folders:
        if (folder / CREDITS).is_file():
            found += read_credits_file(folder / CREDITS)
    return ordered_credits(found)
