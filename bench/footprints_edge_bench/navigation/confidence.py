"""Whether confidence is what it says: reliability diagrams, and the fit of the curves.

Pictures are divided in two by their order in each dataset: the first half is for the fit, the
second is scored. Of clips only those frames are taken that training holds out.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from footprints_edge.errors import FootprintsError, GroundPlaneError
from footprints_edge.geometry.ground_plane import LEAST_AREA, GroundPlane, find_ground_plane
from footprints_edge.maps.confidence import (
    METRES_INPUTS,
    Curve,
    Curves,
    ground_inputs,
    metres_inputs,
)
from footprints_edge.maps.resize import resize_depth, resize_map
from footprints_edge.model import Model
from footprints_edge.prediction import Prediction
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.ground_truth.base import GroundTruth
from footprints_edge_bench.ground_truth.clip import is_clip
from footprints_edge_bench.ground_truth.datasets import ReadingOptions, Subset, open_folder
from footprints_edge_bench.ground_truth.without_ground import read_without_ground

RIGHT_IOU = 0.5
RIGHT_WITHIN = 1.25
"""Factor within which the median of predicted / true distance counts as right."""

MOST_REFUSED = 0.04
"""Share of the pictures whose ground is right that the gate may refuse, on the half for the fit."""

_DRAWN = 0.01
"""Share of the picture below which nothing counts as drawn."""

_KINDS = {True: "with ground", False: "without ground"}
_MOST_LEAST = 0.5
"""Pictures that rather show ground than none are never refused."""

_CLEAR_TOPS = np.arange(0, 6.5, 0.5)
"""Weights of a clear top, beside a peak of weight 1, among which the gate's is chosen."""

_BINS = 5
_SHRINKAGE = 1e-3
"""Weight of the squared weights in the fit: inputs that say the same share theirs."""


class ConfidenceError(FootprintsError):
    """A confidence cannot be fitted or scored on the given pictures."""


@dataclass(frozen=True, eq=False)
class Example:
    """One picture.

    Attributes:
        dataset: name of its folder.
        for_fit: whether it is in the half for the fit.
        shows_ground: whether it shows at least `LEAST_AREA` of ground.
        called_ground: share of the picture that the network calls ground, seen or hidden.
        has_plane: whether there is a ground plane, if this confidence refuses none.
        ground: inputs of `Confidence.ground`.
        ground_is_right: whether the picture's visible ground is right.
        metres: inputs of `Confidence.metres`; None without a plane or without true distances.
        metres_are_right: whether its distances are.
    """

    dataset: str
    for_fit: bool
    shows_ground: bool
    called_ground: float
    has_plane: bool
    ground: Mapping[str, float]
    ground_is_right: bool
    metres: Mapping[str, float] | None = None
    metres_are_right: bool = False


def collect(
    model: Model,
    folders: Sequence[Path],
    without: Sequence[Path],
    reading: ReadingOptions,
    most: int,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Example]:
    """Predicts pictures and looks at what they are worth.

    Args:
        model: the model.
        folders: datasets with ground truth. Pictures with less than `LEAST_AREA` of visible ground
            are left out: too little to find, and too much to be without.
        without: folders that pictures without ground are taken from.
        reading: facts that some datasets need.
        most: pictures from each dataset, evenly spread.
        progress: called with the name of each picture when it is done.
    """
    examples = []
    for folder in folders:
        subset = Subset(held_out=is_clip(folder))
        for dataset in open_folder(folder, reading, subset):
            items = _spread(dataset.items, most)
            for place, item in enumerate(items):
                ground_truth = item.load()
                prediction = model.predict(
                    ground_truth.image, intrinsics=ground_truth.intrinsics, flatten=False
                )
                first = 2 * place < len(items)
                example = _with_truth(dataset.name, first, prediction, ground_truth)
                if example.shows_ground:
                    examples.append(example)
                progress(item.name)
    for folder in without:
        pictures = _spread(read_without_ground(folder, reading, Subset()), most)
        for place, picture in enumerate(pictures):
            pixels = picture.load()
            if pixels is not None:
                prediction = model.predict(pixels, flatten=False)
                examples.append(
                    Example(
                        folder.resolve().name,
                        2 * place < len(pictures),
                        shows_ground=False,
                        called_ground=float(prediction.ground.mean()),
                        has_plane=fitted_plane(prediction) is not None,
                        ground=inputs_of(prediction),
                        ground_is_right=False,
                    )
                )
            progress(picture.name)
    return examples


def fitted_plane(prediction: Prediction) -> GroundPlane | None:
    """The ground plane by the gate's other rules, whatever the confidence that there is ground."""
    try:
        return find_ground_plane(
            prediction.unmasked_ground_depth_m,
            prediction.ground,
            prediction.intrinsics,
            prediction.pose,
        )
    except GroundPlaneError:
        return None


def inputs_of(prediction: Prediction) -> dict[str, float]:
    """The inputs of `Confidence.ground`."""
    return ground_inputs(prediction.ground_probability)


def _spread(items: Sequence[Any], most: int) -> list[Any]:
    if len(items) <= most:
        return list(items)
    places = np.linspace(0, len(items) - 1, most).round().astype(int)
    return [items[place] for place in places]


def _with_truth(
    dataset: str, for_fit: bool, prediction: Prediction, ground_truth: GroundTruth
) -> Example:
    truth = ground_truth.visible_ground
    assert truth is not None
    found = resize_map(prediction.visible_ground_probability, ground_truth.size)
    found_mask = (found > prediction.threshold) & truth.valid
    either = np.count_nonzero(found_mask | truth.mask)
    overlap = np.count_nonzero(found_mask & truth.mask)
    plane = fitted_plane(prediction)
    example = Example(
        dataset,
        for_fit,
        shows_ground=bool(truth.mask.mean() >= LEAST_AREA),
        called_ground=float(prediction.ground.mean()),
        has_plane=plane is not None,
        ground=inputs_of(prediction),
        ground_is_right=bool(either and overlap / either >= RIGHT_IOU),
    )
    if ground_truth.ground_depth_m is None or plane is None:
        return example
    depth_m = np.reciprocal(
        np.maximum(plane.inverse_depth(prediction.intrinsics, prediction.map_size), 1e-3)
    )
    there = ground_truth.ground_depth_m > 0
    if not there.any():
        return example
    ratio = np.median(
        resize_depth(depth_m, ground_truth.size)[there] / ground_truth.ground_depth_m[there]
    )
    return replace(
        example,
        metres=metres_inputs(
            plane, prediction.visible_depth_m, prediction.visible_ground, prediction.intrinsics
        ),
        metres_are_right=bool(1 / RIGHT_WITHIN < ratio < RIGHT_WITHIN),
    )


def fit(examples: Sequence[Example]) -> Curves:
    """Fits both curves to the half for the fit, and the least confidence that there is ground.

    Raises:
        ConfidenceError: there are not enough pictures of both kinds.
    """
    half = [each for each in examples if each.for_fit]
    with_metres = [each for each in half if each.metres is not None]
    ground, least = _fit_ground(half)
    metres = fit_curve(
        [each.metres or {} for each in with_metres],
        [each.metres_are_right for each in with_metres],
        METRES_INPUTS,
        balanced=False,
    )
    return Curves(ground, metres, least)


def _fit_ground(half: Sequence[Example]) -> tuple[Curve, float]:
    """The curve, and its least value, with which the gate refuses most pictures without ground.

    The likelihood alone would give the clear top less weight: most pictures without ground need
    none of it, but walls do.
    """
    right = [each.ground_is_right for each in half]
    wrong = [each for each in half if not each.shows_ground]
    best, most = None, -1.0
    for weight in _CLEAR_TOPS.tolist():
        evidence = [
            {"all": each.ground["peak"] + weight * each.ground["clear_top"]} for each in half
        ]
        fitted = fit_curve(evidence, right, ("all",))
        slope = fitted.weights["all"]
        curve = Curve(fitted.offset, {"peak": slope, "clear_top": round(slope * weight, 4)})
        shown = sorted(curve.at(each.ground) for each in half if each.ground_is_right)
        least = min(_MOST_LEAST, shown[math.floor(MOST_REFUSED * len(shown))])
        refused = sum(curve.at(each.ground) < least or not each.has_plane for each in wrong)
        if refused > most:
            best, most = (curve, math.floor(1000 * least) / 1000), refused
    assert best is not None
    return best


def fit_curve(
    inputs: Sequence[Mapping[str, float]],
    right: Sequence[bool],
    names: Sequence[str],
    *,
    balanced: bool = True,
) -> Curve:
    """Logistic regression with weights of at least 0, by maximum likelihood.

    Args:
        inputs: of each picture, by name.
        right: whether it is right.
        names: the inputs to use.
        balanced: whether right and wrong pictures count as equally frequent.

    Raises:
        ConfidenceError: all pictures are right, or none is.
    """
    from scipy.optimize import minimize

    values = np.array([[each[name] for name in names] for each in inputs])
    target = np.asarray(right, np.float64)
    if not 0 < target.sum() < len(target):
        raise ConfidenceError(
            f"{int(target.sum())} of {len(target)} pictures are right; a curve needs some that are "
            "and some that are not"
        )
    weight = _weights(target) if balanced else np.full(len(target), 1 / len(target))
    middle, spread = values.mean(0), values.std(0) + 1e-9
    scaled = np.column_stack([np.ones(len(values)), (values - middle) / spread])

    def loss(parameters: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        logit = scaled @ parameters
        likelihood = weight @ (np.logaddexp(0, logit) - target * logit)
        slope = scaled.T @ (weight * (1 / (1 + np.exp(-logit)) - target))
        slope[1:] += 2 * _SHRINKAGE * parameters[1:]
        return float(likelihood + _SHRINKAGE * (parameters[1:] ** 2).sum()), slope

    bounds = [(None, None), *[(0.0, None)] * len(names)]
    start = np.zeros(1 + len(names))
    found = minimize(loss, start, jac=True, bounds=bounds, method="L-BFGS-B").x
    weights = found[1:] / spread
    offset = found[0] - weights @ middle
    return Curve(
        round(float(offset), 4),
        {name: round(float(each), 4) for name, each in zip(names, weights, strict=True)},
    )


@dataclass(frozen=True)
class Reliability:
    """How often pictures of like confidence are right.

    Attributes:
        said: mean confidence in each bin of equally many pictures.
        right: share of them that are right.
        count: pictures in all bins.
        error: mean of |said - right| over pictures, the expected calibration error.

    All means are weighted as the pictures are.
    """

    said: tuple[float, ...]
    right: tuple[float, ...]
    count: int
    error: float


def reliability(
    said: Sequence[float], right: Sequence[bool], *, balanced: bool = False
) -> Reliability:
    """Bins pictures by their confidence.

    Args:
        said: the confidence of each picture.
        right: whether it is right.
        balanced: whether right and wrong pictures count as equally frequent, as in the fit.
    """
    if not said:
        return Reliability((), (), 0, math.nan)
    target = np.asarray(right, np.float64)
    weight = _weights(target) if balanced else np.full(len(target), 1 / len(target))
    order = np.argsort(said, kind="stable")
    bins = np.array_split(order, min(_BINS, len(order)))
    sizes = np.array([weight[each].sum() for each in bins])
    mean = [float(np.average(np.take(said, each), weights=weight[each])) for each in bins]
    share = [float(np.average(target[each], weights=weight[each])) for each in bins]
    error = float(np.abs(np.subtract(mean, share)) @ sizes / sizes.sum())
    return Reliability(tuple(mean), tuple(share), len(order), error)


def _weights(target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of pictures with which right and wrong ones are equally frequent."""
    right = max(1.0, target.sum())
    wrong = max(1.0, len(target) - target.sum())
    weights: NDArray[np.float64] = np.where(target > 0, 0.5 / right, 0.5 / wrong)
    return weights


def score(examples: Sequence[Example], curves: Curves) -> dict[str, Reliability]:
    """The reliability of both confidences on the half that was not fitted."""
    half = [each for each in examples if not each.for_fit]
    known = [each for each in half if each.metres is not None]
    return {
        "ground": reliability(
            [curves.ground.at(each.ground) for each in half],
            [each.ground_is_right for each in half],
            balanced=True,
        ),
        "metres": reliability(
            [curves.metres.at(each.metres or {}) for each in known],
            [each.metres_are_right for each in known],
        ),
    }


def as_markdown(
    examples: Sequence[Example], curves: Curves, scores: Mapping[str, Reliability]
) -> str:
    """Tables: the reliability of both, and how many pictures of each dataset the gate refuses."""
    parts = []
    for name, found in scores.items():
        rows = [
            [f"{said:.2f}", f"{right:.2f}"]
            for said, right in zip(found.said, found.right, strict=True)
        ]
        parts.append(
            f"## Confidence: {name}, {found.count} pictures, expected calibration error "
            f"{found.error:.3f}\n\n{markdown_table(['Said', 'Right'], rows)}\n"
        )
    rows = []
    for dataset in dict.fromkeys(each.dataset for each in examples):
        for shows in (True, False):
            of_it = [
                each
                for each in examples
                if (each.dataset, each.shows_ground, each.for_fit) == (dataset, shows, False)
            ]
            if of_it:
                rows.append([dataset, _KINDS[shows], *_shares(of_it, curves)])
    for shows in (True, False):
        of_it = [each for each in examples if each.shows_ground == shows and not each.for_fit]
        if of_it:
            rows.append(["all", _KINDS[shows], *_shares(of_it, curves)])
    heading = [
        "Dataset",
        "Pictures",
        "Count",
        "Refused",
        "Called ground",
        "No plane without this gate",
        "No plane",
        "Nothing drawn",
    ]
    return "\n".join([*parts, markdown_table(heading, rows)]) + "\n"


def _shares(examples: Sequence[Example], curves: Curves) -> list[str]:
    refused = np.array([curves.ground.at(each.ground) < curves.least_ground for each in examples])
    called = np.array([each.called_ground for each in examples])
    flat = np.array([each.has_plane for each in examples])
    nothing = refused | (called < _DRAWN)
    shares = [refused, called, ~flat, refused | ~flat, nothing]
    return [str(len(examples)), *(f"{np.mean(each):.1%}" for each in shares)]


def draw(scores: Mapping[str, Reliability], path: Path) -> None:
    """Draws the reliability diagram of each confidence, as PNG."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.8 * len(scores), 3.8), layout="constrained")
    for index, (name, found) in enumerate(scores.items()):
        axes = figure.add_subplot(1, len(scores), index + 1)
        axes.plot([0, 1], [0, 1], color="#999999", linewidth=1)
        axes.plot(found.said, found.right, marker="o", color="#1b6ca8")
        axes.set(
            title=f"{name}: {found.count} pictures, error {found.error:.3f}",
            xlabel="confidence",
            ylabel="share that is right",
            xlim=(0, 1),
            ylim=(0, 1),
            aspect="equal",
        )
    figure.savefig(path, dpi=110)
