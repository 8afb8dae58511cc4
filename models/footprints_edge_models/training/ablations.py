"""Ablations of the paper's loss and of what we added: trained alike, compared on held-out samples.

Everything else is equal: data, order of the pictures, steps, and the encoder trained on ImageNet
that all begin with.
"""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch

from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.data.targets import FOOTPRINT_WEIGHT
from footprints_edge_models.training.progress import Progress
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.trainer import train

PAPER: dict[str, Any] = {"hidden_weight": 1.0, "footprint_weight": FOOTPRINT_WEIGHT}
"""The weights of eq. 3 as the paper has them."""
ABLATIONS: dict[str, dict[str, Any]] = {
    "as asked": {},
    "without eq. 3b (untraversable pixels)": {"footprint_masks": False},
    "lambda 0": {"lambda_unknown": 0.0},
    "lambda 0.5": {"lambda_unknown": 0.5},
    "lambda 1": {"lambda_unknown": 1.0},
    "without moving-object masks": {"moving_objects": False},
    "hidden pixels weighted as in eq. 3": PAPER,
    "weighted by class in every batch": {**PAPER, "balance": "classes"},
    "focal": {**PAPER, "balance": "focal"},
    "with relative depth, 0.5": {"relative_depth": 0.5},
    "with soft Dice, 0.5": {"dice": 0.5},
    "one decoder": {"coarse_decoder": False},
    "all of the encoder learns": {"frozen_stages": 0},
}
"""By name: the fields of a recipe that an ablation changes."""

_COLUMNS = {
    "visible_ground_iou": "visible ground IoU",
    "ground_iou": "ground IoU",
    "hidden_auc": "AUC",
    "ground_depth_abs_rel": "ground depth abs. rel.",
    "ground_depth_a1": "ground depth a1",
}


def train_ablations(
    datasets: dict[str, TrainingDataset],
    recipe: Recipe,
    folder: Path,
    *,
    device: torch.device,
    progress: Callable[[str, Progress], None] | None = None,
) -> str:
    """Train every ablation of a recipe, each in a folder of its own, or resume them.

    Returns:
        Markdown tables of the last validation's scores, one for each dataset.

    Raises:
        TrainingError: a folder holds a run of another recipe.
    """
    scores = {}
    for name, change in ABLATIONS.items():
        run = folder / "".join(c if c.isalnum() else "-" for c in name.lower()).strip("-")

        def report(now: Progress, name: str = name) -> None:
            if progress is not None:
                progress(name, now)

        train(datasets, replace(recipe, **change), run, device=device, progress=report)
        scores[name] = _last_scores(run / "validation.csv")
    return "\n".join(_table(dataset, scores) for dataset in next(iter(scores.values())))


def _last_scores(path: Path) -> dict[str, dict[str, str]]:
    """Scores by dataset and column."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {row["dataset"]: row for row in rows if row["step"] == rows[-1]["step"]}


def _table(dataset: str, scores: dict[str, dict[str, dict[str, str]]]) -> str:
    shown = [c for c in _COLUMNS if scores[next(iter(scores))][dataset][c] != "nan"]
    lines = [
        f"### {dataset}\n",
        f"| | {' | '.join(_COLUMNS[column] for column in shown)} |",
        f"| --- |{' ---: |' * len(shown)}",
    ]
    for name, found in scores.items():
        values = (f"{float(found[dataset][column]):.3f}" for column in shown)
        lines.append(f"| {name} | {' | '.join(values)} |")
    return "\n".join([*lines, ""])
