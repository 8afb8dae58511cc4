"""The metadata of a model file, stored in the `metadata_props` of the ONNX file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from footprints_edge.errors import ModelError

FORMAT_VERSION = "1"
"""Version of the file contract: input `image`, output `maps`, and these keys."""

PREFIX = "footprints."

OUTPUTS = {"all": (0, 1, 2, 3), "masks": (0, 1), "depths": (2, 3)}
"""Channels in a file, by the value of its key `outputs`; most files have all four."""

MAX_TEXT = 1000
"""Longest value of a key."""

MIN_DEPTH_M, MAX_DEPTH_M = 1e-3, 1e6
MIN_FOCAL_PX, MAX_FOCAL_PX = 1.0, 1e6

_KEYS = (
    "format",
    "name",
    "architecture",
    "precision",
    "depth_range_m",
    "camera",
    "resize",
    "licence",
    "source_sha256",
    "producer",
    "training",
)
_CONVERT = "fp-export convert CHECKPOINT -o OUT.onnx --arch edge"


@dataclass(frozen=True)
class ModelMetadata:
    """The facts about a model that its user and the runtime need.

    Attributes:
        name: Name of the model.
        architecture: `edge` or `reference`.
        precision: `fp32`, `fp16` (weights only) or `int8`.
        depth_range_m: Depths in metres at disparity 1 and 0: (nearest, farthest).
        focal_px: Focal length of the camera that the depths are for, in pixels of the network's
            input; None keeps the depths as trained, for any camera. Key `camera`.
        resize: Filter that resizes pictures to the network's input, see `preprocessing.FILTERS`.
        licence: Licence of the weights.
        source_sha256: SHA-256 of the checkpoint that the file was converted from.
        producer: Program and version that wrote the file.
        training: Description of the training data.
        outputs: Key of `OUTPUTS`. Only files that lack maps state it.
        format: Version of the file contract.
    """

    name: str
    architecture: str
    precision: str
    depth_range_m: tuple[float, float]
    focal_px: float | None
    resize: str
    licence: str
    source_sha256: str
    producer: str
    training: str
    outputs: str = "all"
    format: str = FORMAT_VERSION

    def to_props(self) -> dict[str, str]:
        """The `metadata_props` entries of an ONNX file."""
        nearest_m, farthest_m = self.depth_range_m
        values = {key: getattr(self, key) for key in _KEYS if key != "camera"}
        values["depth_range_m"] = f"{nearest_m:g},{farthest_m:g}"
        values["camera"] = "none" if self.focal_px is None else f"focal_px={self.focal_px!r}"
        partial = {} if self.outputs == "all" else {PREFIX + "outputs": self.outputs}
        return {PREFIX + key: values[key] for key in _KEYS} | partial

    @classmethod
    def from_props(cls, props: Mapping[str, str], file: Path | str) -> "ModelMetadata":
        """Reads what `to_props` wrote.

        Args:
            props: The file's `metadata_props`; entries of other programs are ignored.
            file: The model file, for the message.

        Raises:
            ModelError: If keys are missing, the format differs, or a value is invalid.
        """
        values = {key: props[PREFIX + key] for key in _KEYS if PREFIX + key in props}
        missing = [key for key in _KEYS if key not in values]
        if len(missing) == len(_KEYS):
            raise ModelError(
                f"{file} is an ONNX model, but not one of footprints-edge (it has no "
                f"{PREFIX}* metadata); convert one with: {_CONVERT}"
            )
        if missing:
            raise ModelError(
                f"{file} lacks the metadata {', '.join(PREFIX + key for key in missing)}; "
                f"convert it again with: {_CONVERT}"
            )
        for key, text in values.items():
            if len(text) > MAX_TEXT or not text.isprintable():
                raise ModelError(
                    f"{file}: {PREFIX}{key} is {text[:40]!r}, of {len(text)} characters; expected "
                    f"one line of at most {MAX_TEXT}; convert the model again with: {_CONVERT}"
                )
        _check_format(values["format"], file)
        return cls(
            depth_range_m=_depth_range_m(values.pop("depth_range_m"), file),
            focal_px=_focal_px(values.pop("camera"), file),
            outputs=_outputs(props.get(PREFIX + "outputs", "all"), file),
            **values,
        )


def _check_format(version: str, file: Path | str) -> None:
    if version == FORMAT_VERSION:
        return
    newer = version.isdecimal() and int(version) > int(FORMAT_VERSION)
    advice = (
        "upgrade with: pip install --upgrade footprints-edge, or git pull in a checkout"
        if newer
        else f"convert the model again with: {_CONVERT}"
    )
    raise ModelError(
        f"{file} has format {version!r}, this version of footprints-edge reads {FORMAT_VERSION!r}; "
        + advice
    )


def _depth_range_m(text: str, file: Path | str) -> tuple[float, float]:
    try:
        nearest_m, farthest_m = (float(part) for part in text.split(","))
    except ValueError:
        nearest_m = farthest_m = 0.0
    if not MIN_DEPTH_M <= nearest_m < farthest_m <= MAX_DEPTH_M:
        raise ModelError(
            f"{file}: {PREFIX}depth_range_m is {text!r}, expected metres as 'nearest,farthest' "
            f"such as '0.1,100'; convert the model again with: {_CONVERT}"
        )
    return nearest_m, farthest_m


def _outputs(text: str, file: Path | str) -> str:
    if text not in OUTPUTS:
        raise ModelError(
            f"{file}: {PREFIX}outputs is {text[:40]!r}, expected one of {', '.join(OUTPUTS)}; "
            f"convert the model again with: {_CONVERT}"
        )
    return text


def _focal_px(text: str, file: Path | str) -> float | None:
    if text == "none":
        return None
    try:
        focal_px = float(text.removeprefix("focal_px="))
    except ValueError:
        focal_px = 0.0
    if not (text.startswith("focal_px=") and MIN_FOCAL_PX <= focal_px <= MAX_FOCAL_PX):
        raise ModelError(
            f"{file}: {PREFIX}camera is {text!r}, expected 'none' or a value such as "
            f"'focal_px=400'; convert the model again with: {_CONVERT}"
        )
    return focal_px
