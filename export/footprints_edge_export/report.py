"""What to make of a checkpoint, and the report of what was made."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Conversion:
    """What to make of a checkpoint.

    Attributes:
        architecture: key of ``ARCHITECTURES``.
        size: (H, W) to fix the input to; None leaves both free.
        precision: ``fp32``, ``fp16`` (weights only) or ``int8``.
        calibration: folders of photos, all sampled alike; int8 needs at least one.
        target: key of ``targets.TARGETS``.
        name: name of the model in its metadata.
        licence: licence of the weights; None for the architecture's own.
        training: what the weights were trained on, in words; None: as their credits say.
        outputs: which maps the file has, a key of ``footprints_edge.model_files.metadata.OUTPUTS``.
        scale: decoder scale: 1, or 2 or 4 for maps that are predicted at that fraction of the
            image's sides, where the architecture has such heads.
        focal_px: focal length, in pixels of the input, of the camera that the depths are for; None
            for the architecture's own.
    """

    architecture: str
    size: tuple[int, int] | None
    precision: str
    calibration: tuple[Path, ...]
    target: str
    name: str
    licence: str | None
    training: str | None
    outputs: str = "all"
    scale: int = 1
    focal_px: float | None = None


@dataclass(frozen=True, kw_only=True)
class Report:
    """What was converted and what was measured; written as JSON beside the model.

    Attributes:
        model: file name, bytes and SHA-256.
        metadata: the metadata in the file.
        torch_to_fp32: largest difference of each map, over ``parity_sizes``.
        parity_sizes: (H, W) of the images that torch and ONNX were compared on.
        fp32_to_fp16: see :class:`verification.compare.Difference`; None for fp32 and int8.
        fp32_to_int8: likewise; None for fp32 and fp16.
        calibration_photos: number of photos that the int8 ranges were taken from.
        target: what the file is for; None if all targets would get the same file.
        ort: file name, bytes and SHA-256 of the file in onnxruntime's format; None if the target
            or precision has none.
        model_to_ort: see :class:`verification.compare.Difference`; None if there is no such file.
        versions: versions of the programs that made the file.
        scale: decoder scale of the maps.
    """

    model: dict[str, object]
    metadata: dict[str, object]
    torch_to_fp32: dict[str, float]
    parity_sizes: list[tuple[int, int]]
    fp32_to_fp16: dict[str, object] | None
    fp32_to_int8: dict[str, object] | None
    calibration_photos: int
    target: str | None
    ort: dict[str, object] | None
    model_to_ort: dict[str, object] | None
    versions: dict[str, str]
    scale: int


def report_path(output: Path) -> Path:
    """Path of the report of a model file."""
    return output.with_name(output.name + ".json")
