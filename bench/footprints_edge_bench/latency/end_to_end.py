"""Latency of a whole frame: from the bytes of a phone's JPEG to masks and metres, by stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from statistics import median
from time import perf_counter

from footprints_edge.foundation.types import Size
from footprints_edge.model import Model
from footprints_edge_bench.latency.timing import TimingSummary, measure
from footprints_edge_bench.model_files.synthetic_photos import synthetic_jpeg

PHONE: Size = (3000, 4000)
"""(H, W) of a photo of 12 million pixels."""


@dataclass(frozen=True)
class EndToEnd:
    """Times of a model.

    Attributes:
        model: name of its row.
        image_size: (H, W) of the photo.
        jpeg_bytes: size of the JPEG.
        stages_ms: median time of each stage: decode, preprocess (resize), inference, postprocess
            (depth in metres), threshold (masks, the ground's plane, and its depth where it is).
        total: statistics of the whole frame.
    """

    model: str
    image_size: Size
    jpeg_bytes: int
    stages_ms: Mapping[str, float]
    total: TimingSummary


def end_to_end(
    models: Mapping[str, Model], trials: int, image_size: Size = PHONE
) -> Sequence[EndToEnd]:
    """Times models in turns on a synthetic photo.

    Args:
        models: models by the names of their rows.
        trials: timed frames of each.
        image_size: (H, W) of the photo.
    """
    jpeg = synthetic_jpeg(image_size)
    stages: dict[str, list[dict[str, float]]] = {name: [] for name in models}

    def frame_of(name: str, model: Model) -> None:
        prediction = model.predict(jpeg)
        start = perf_counter()
        _ = prediction.visible_ground, prediction.hidden_ground, prediction.ground_depth_m
        threshold_ms = 1000 * (perf_counter() - start)
        stages[name].append({**prediction.timings_ms, "threshold": threshold_ms})

    frames = {name: partial(frame_of, name, model) for name, model in models.items()}
    timed = measure(frames, trials, settle_ms=0)
    return [
        EndToEnd(
            name,
            image_size,
            len(jpeg),
            {
                stage: median(frame[stage] for frame in stages[name][-trials:])
                for stage in stages[name][0]
            },
            timed[name].summary(),
        )
        for name in models
    ]
