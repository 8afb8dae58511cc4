"""Whom to credit for what a run learns from."""

from collections.abc import Mapping
from pathlib import Path

from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import (
    CREDITS,
    ordered_credits,
    read_credits_file,
)
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.checkpoint import read_checkpoint
from footprints_edge_models.training.weight_credits import stated_credits


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
