"""What a known camera height, pitch and roll are worth: the depth of hidden ground with each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from footprints_edge.errors import GroundPlaneError
from footprints_edge.geometry.camera_pose import CameraPose
from footprints_edge.geometry.ground_plane import GroundPlane
from footprints_edge.maps.resize import resize_depth
from footprints_edge.prediction import Prediction
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.accuracy.metrics import DepthScores, depth
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.navigation.occupancy import exact_prediction

KNOWN: Mapping[str, Callable[[GroundPlane], CameraPose]] = {
    "nothing": lambda _: CameraPose(),
    "height": lambda plane: CameraPose(plane.camera_height_m),
    "pitch and roll": lambda plane: CameraPose(None, plane.pitch_deg, plane.roll_deg),
    "height, pitch and roll": lambda plane: CameraPose(
        plane.camera_height_m, plane.pitch_deg, plane.roll_deg
    ),
}
"""What is known of the true ground plane, by the name of the row."""


@dataclass(frozen=True)
class PoseScore:
    """One image with one kind of knowledge.

    Attributes:
        hidden: depth scores of truly hidden ground.
        distance: median of predicted / true depth of all true ground.
    """

    hidden: DepthScores
    distance: float


def score_known_poses(
    benchmark: Benchmark, progress: Callable[[str], None]
) -> dict[str, list[PoseScore]]:
    """Scores of every image by what is known, for the first model.

    Images that show no hidden ground, or whose true ground is not one plane, are left out.
    """
    scores: dict[str, list[PoseScore]] = {row: [] for row in KNOWN}
    for item in benchmark.items():
        ground_truth = item.load()
        model = next(iter(benchmark.models.values()))
        plain = model.predict(ground_truth.image, intrinsics=ground_truth.intrinsics, flatten=False)
        progress(item.name)
        assert ground_truth.ground_depth_m is not None and ground_truth.ground is not None
        assert ground_truth.visible_ground is not None
        hidden = ground_truth.ground.mask & ~ground_truth.visible_ground.mask
        hidden &= ground_truth.visible_ground.valid & ground_truth.ground.valid
        true_m = np.where(hidden, ground_truth.ground_depth_m, 0).astype(np.float32)
        try:
            plane = exact_prediction(ground_truth, plain).ground_plane()
        except GroundPlaneError:
            continue
        if not (true_m > 0).any():
            continue
        for row, known in KNOWN.items():
            posed: Prediction = replace(plain, pose=known(plane)).flattened()
            found_m = resize_depth(posed.unmasked_ground_depth_m, ground_truth.size)
            there = ground_truth.ground_depth_m > 0
            ratio = np.median(found_m[there] / ground_truth.ground_depth_m[there])
            scores[row].append(PoseScore(depth(found_m, true_m), float(ratio)))
    return scores


def as_markdown(scores: Mapping[str, Sequence[PoseScore]]) -> str:
    """A table of means over images; of the distance, the median."""
    rows = [
        [
            row,
            f"{np.mean([score.hidden.a1 for score in of_row]):.3f}" if of_row else "-",
            f"{np.mean([score.hidden.abs_rel for score in of_row]):.3f}" if of_row else "-",
            f"{np.median([score.distance for score in of_row]):.3f}" if of_row else "-",
        ]
        for row, of_row in scores.items()
    ]
    count = max((len(of_row) for of_row in scores.values()), default=0)
    return (
        f"## Depth of hidden ground by what is known of the camera: {count} images\n\n"
        f"{markdown_table(['Known', 'a1', 'Abs. rel.', 'Predicted / true distance'], rows)}\n"
    )
