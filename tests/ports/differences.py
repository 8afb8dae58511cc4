"""How far each port is from the test vectors of the bundled model: see `run.py`.

Prints a row for each folder of a port's outputs, named by NAME=FOLDER. The first columns compare
with the vectors, so they hold what engines round otherwise; the others with what the Python runtime
makes of the port's own maps, so they hold the port's arithmetic alone. Each is the largest of all
vectors.

    python differences.py VECTORS NAME=FOLDER...
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.geometry.camera import disparity_to_depth
from footprints_edge_export.verification.check_metres import equal_cells, equal_ranges
from footprints_edge_export.verification.check_vectors import check_vectors, read_manifest
from footprints_edge_export.verification.vector_metres import (
    FLAT_DEPTH,
    GRID,
    PATH,
    RANGES,
    judge_path,
    metres,
    prediction_of,
)

Row = dict[str, float]


def differences(vectors: Path, entry: dict[str, Any], outputs: Path, threshold: float) -> Row:
    """Of one vector; what the port did not write is left out."""
    maps, expected = (np.load(folder / "maps.npy") for folder in (outputs, vectors))
    levels = [np.load(folder / "input.npy").astype(int) for folder in (outputs, vectors)]
    depths = [disparity_to_depth(each[0, 2:]) for each in (maps, expected)]
    found = {
        "input, levels": np.abs(levels[0] - levels[1]).max(),
        "p, p*: mean": np.abs(maps - expected)[0, :2].mean(axis=(1, 2)).max(),
        "p, p*: largest": np.abs(maps - expected)[0, :2].max(),
        "depths: half within": np.median(np.abs(depths[0] / depths[1] - 1), axis=(1, 2)).max(),
    }
    prediction = prediction_of(maps, entry, threshold)
    own = metres(prediction, {**entry, "path": None})
    compared: dict[str, tuple[str, Callable[..., float]]] = {
        "flat depth": (FLAT_DEPTH, _apart),
        "grid cells": (GRID, lambda a, b: 1 - equal_cells(a, b)),
        "nearest obstacles": (RANGES[0], lambda a, b: 1 - equal_ranges(a, b)),
        "scan": (RANGES[1], lambda a, b: 1 - equal_ranges(a, b)),
    }
    for label, (name, apart) in compared.items():
        file = outputs / f"{name}.npy"
        if file.is_file() and name in own:
            found[label] = apart(np.load(file), own[name])
    if (outputs / f"{PATH}.npy").is_file():
        best = judge_path(prediction, metres(prediction, entry)[PATH], entry)
        judged = judge_path(prediction, np.load(outputs / f"{PATH}.npy"), entry)
        found["path's length"] = abs(judged.length_m / best.length_m - 1)
    return found


def _apart(found: NDArray[np.floating], expected: NDArray[np.floating]) -> float:
    """The 99th percentile of the relative difference, where both have a value."""
    both = np.isfinite(found) & np.isfinite(expected)
    return float(np.percentile(np.abs(found[both] / expected[both] - 1), 99)) if both.any() else 0.0


def _text(label: str, value: float | None) -> str:
    if value is None:
        return ""
    if label.startswith("input"):
        return f"{value:.0f}"
    return f"{value:.4f}" if label.startswith("p,") else f"{100 * value:.2g} %"


def main(vectors: Path, ports: dict[str, Path]) -> None:
    manifest = read_manifest(vectors)
    columns: list[str] = []
    rows: dict[str, Row] = {}
    for name, outputs in ports.items():
        row: Row = {}
        for entry in manifest["vectors"]:
            folders = vectors / entry["name"], outputs / entry["name"]
            found = differences(folders[0], entry, folders[1], manifest["threshold"])
            row |= {key: max(row.get(key, 0.0), float(value)) for key, value in found.items()}
        columns += [key for key in row if key not in columns]
        failed = sum(not finding.holds for finding in check_vectors(vectors, outputs))
        rows[f"{name}{f' ({failed} out of tolerance)' if failed else ''}"] = row
    print(f"| {manifest['model']['file']} | {' | '.join(columns)} |")
    print(f"| --- |{' ---: |' * len(columns)}")
    for name, row in rows.items():
        print(f"| {name} | {' | '.join(_text(key, row.get(key)) for key in columns)} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), {n: Path(f) for n, _, f in (w.partition("=") for w in sys.argv[2:])})
