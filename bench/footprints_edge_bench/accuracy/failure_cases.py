"""The images on which a model scores worst."""

from footprints_edge_bench.accuracy.baselines import estimate_of
from footprints_edge_bench.accuracy.benchmark import Benchmark
from footprints_edge_bench.accuracy.failure_sheet import Example
from footprints_edge_bench.accuracy.results import Results
from footprints_edge_bench.accuracy.scoring import MethodScores
from footprints_edge_bench.ground_truth.base import Item

COUNT = 10
"""Number of images that are shown."""


def failure_cases(benchmark: Benchmark, results: Results) -> list[Example]:
    """Images with the lowest freespace IoU of the first model, worst first.

    Where no dataset has ground truth of freespace, those with the lowest IoU of visible ground.
    """
    row = next(iter(benchmark.models))
    items = {item.name: item for item in benchmark.items() if item.name in results.images}
    for part in ("freespace", "visible_ground"):
        ious = {name: results.images[name][row].value(part, "iou") for name in items}
        scored = sorted((iou, name) for name, iou in ious.items() if iou is not None)
        if scored:
            worst = [name for _, name in scored[:COUNT]]
            return [_example(benchmark, items[name], results.images[name][row]) for name in worst]
    return []


def _example(benchmark: Benchmark, item: Item, scores: MethodScores) -> Example:
    ground_truth = item.load()
    model = next(iter(benchmark.models.values()))
    prediction = model.predict(ground_truth.image, intrinsics=ground_truth.intrinsics)
    values = {
        "freespace IoU": scores.value("freespace", "iou"),
        "footprint IoU": scores.value("footprint", "iou"),
        "visible ground IoU": scores.value("visible_ground", "iou"),
        "hidden depth a1": scores.value("ground_depth", "a1"),
    }
    captions = [f"{label} {value:.2f}" for label, value in values.items() if value is not None]
    title = "     ".join([item.name, *captions])
    return Example(title, prediction.rgb, ground_truth, estimate_of(prediction, ground_truth.size))
