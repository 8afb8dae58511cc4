"""Plots of a training run: its curves, and predictions on held-out samples."""

import csv
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from footprints_edge_models.data.augmentation import render_view
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.networks.channels import disparity_to_depth_m

HELD_OUT = {
    "visible_ground_iou": "held out: visible ground IoU",
    "ground_depth_abs_rel": "held out: ground depth abs rel",
    "hidden_auc": "held out: AUC of hidden ground against footprints",
}
"""Columns of ``validation.csv`` that are plotted, and their titles."""

GREEN, BLUE = (40, 200, 90), (60, 120, 255)


def draw_curves(run: Path) -> None:
    """Plot the losses and held-out scores in a run folder to its ``curves.png``."""
    from matplotlib.figure import Figure

    with (run / "train.csv").open() as file:
        train = list(csv.DictReader(file))
    validation = []
    if (run / "validation.csv").exists():  # there is none where nothing is held out
        with (run / "validation.csv").open() as file:
            validation = list(csv.DictReader(file))
    figure = Figure(figsize=(20, 4))  # a layout that looks for its margins draws everything twice
    margins = {"left": 0.03, "right": 0.99, "bottom": 0.12, "top": 0.92, "wspace": 0.13}
    left, *others = figure.subplots(1, 4, gridspec_kw=margins)
    steps = np.array([int(row["step"]) for row in train])
    window = max(1, len(train) // 100)
    for name in ("visible_ground", "ground", "visible_depth", "ground_depth"):
        values = np.array([float(row[name]) for row in train])
        smooth = np.convolve(values, np.ones(window) / window, "valid")
        left.plot(steps[window - 1 :], smooth, label=name)
    left.set(title="training losses", xlabel="step", yscale="log")
    for axes, (column, title) in zip(others, HELD_OUT.items(), strict=True):
        for name in sorted({row["dataset"] for row in validation}):
            rows = [row for row in validation if row["dataset"] == name]
            scores = [float(row.get(column) or "nan") for row in rows]
            if np.isfinite(scores).any():
                axes.plot([int(row["step"]) for row in rows], scores, ".-", label=name)
        axes.set(title=title, xlabel="step")
    for axes in (left, *others):
        if axes.get_lines():
            axes.legend()
        axes.grid(alpha=0.3)
    figure.savefig(run / "curves.png", dpi=90)


@torch.no_grad()
def draw_predictions(
    network: nn.Module, datasets: dict[str, TrainingDataset], size: tuple[int, int], path: Path
) -> None:
    """Draw a grid: image; visible (green) and hidden (blue) ground; visible and ground depth."""
    was_training = network.training
    network.eval()
    device = next(network.parameters()).device
    rows = []
    for dataset in datasets.values():
        for sample in dataset.held_out[:: max(1, len(dataset.held_out) // 3)][:3]:
            image = render_view(sample, size).image
            batch = torch.tensor(image).permute(2, 0, 1)[None].float().to(device) / 255
            raw = network(batch)[0].cpu()
            visible, ground = (raw[:2] > 0).numpy()
            tinted = _tint(_tint(image, ground & ~visible, BLUE), visible, GREEN)
            visible_m, ground_m = disparity_to_depth_m(raw[2:]).numpy()
            depths = [_coloured(visible_m), _coloured(np.where(ground, ground_m, 0))]
            rows.append(np.hstack([image, tinted, *depths]))
    network.train(was_training)
    if rows:
        cv2.imwrite(str(path), cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR))


def _tint(
    image: NDArray[np.uint8], mask: NDArray[np.bool_], colour: tuple[int, int, int]
) -> NDArray[np.uint8]:
    tinted = image.copy()
    tinted[mask] = image[mask] // 2 + np.array(colour, np.uint8) // 2
    return tinted


def _coloured(depth_m: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Log distance from 0.5 (yellow) to 50 m (violet), black where 0."""
    scaled = np.log(np.maximum(depth_m, 0.5) / 0.5) / np.log(100)
    colours = cv2.applyColorMap(
        (255 * (1 - scaled.clip(0, 1))).astype(np.uint8), cv2.COLORMAP_VIRIDIS
    )
    rgb: NDArray[np.uint8] = cv2.cvtColor(colours, cv2.COLOR_BGR2RGB)
    return np.where((depth_m > 0)[..., None], rgb, np.uint8(0))
