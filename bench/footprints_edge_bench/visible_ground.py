"""Visible-ground IoU of models on a folder of labelled photos.

    python -m footprints_edge_bench.visible_ground CAMVID/val --walkable 3 4 --void 11

The folder holds ``images/`` and ``labels/`` (class ids, same names, PNG). Each photo runs through
the whole runtime and is judged at its own size; IoU is over the pixels of all photos together.
"""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from PIL import Image

from footprints_edge.model import Model, load


@dataclass(frozen=True)
class VisibleGroundScore:
    """IoU of the mask at probability 0.5, void pixels left out."""

    model: str
    precision: str
    photos: int
    iou: float


def score(
    model: Model, folder: Path, walkable: Sequence[int], void: Sequence[int]
) -> VisibleGroundScore:
    """Score a model on every photo of a folder that has labels.

    Args:
        model: to judge.
        folder: with ``images/`` and ``labels/``.
        walkable: class ids of ground.
        void: class ids to leave out.
    """
    overlap = union = photos = 0
    for labels_path in sorted((folder / "labels").glob("*.png")):
        image_path = next((folder / "images").glob(f"{labels_path.stem}.*"), None)
        if image_path is None:
            raise SystemExit(f"{labels_path}: no picture of that name in {folder / 'images'}")
        ids = np.asarray(Image.open(labels_path))
        known = ~np.isin(ids, void)
        truth = np.isin(ids, walkable) & known
        found = model.predict(image_path).at_image_size().visible_ground & known
        overlap += int((truth & found).sum())
        union += int((truth | found).sum())
        photos += 1
    return VisibleGroundScore(
        model.path.name, model.metadata.precision, photos, overlap / max(union, 1)
    )


def main() -> None:
    """Print one JSON line a model."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("folder", type=Path, help="with images/ and labels/")
    parser.add_argument("--walkable", type=int, nargs="+", required=True, help="class ids")
    parser.add_argument("--void", type=int, nargs="*", default=[], help="class ids left out")
    parser.add_argument("--model", nargs="*", default=[None], help="files or names; the default")
    options = parser.parse_args()
    for name in options.model:
        result = score(load(name), options.folder, options.walkable, options.void)
        sys.stdout.write(json.dumps(asdict(result)) + "\n")


if __name__ == "__main__":
    main()
