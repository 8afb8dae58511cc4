"""The whole conversion: checkpoint in, one verified model file and its report out.

Everything is made and checked in a temporary folder; the output appears only when all holds.
"""

import json
import logging
import tempfile
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import onnx
import torch
from numpy.typing import NDArray
from torch import nn

from footprints_edge.metadata import ModelMetadata
from footprints_edge.model import Model
from footprints_edge.session import Session
from footprints_edge.version import __version__
from footprints_edge_models.checkpoint import file_sha256, load_weights, read_checkpoint
from footprints_edge_models.maps import MAX_DEPTH_M, MIN_DEPTH_M, raw_to_maps

from .architectures import ARCHITECTURES
from .compare import CHANNELS, Difference, compare_models
from .contract import check_file, set_metadata
from .errors import ExportError, VerificationError
from .graph import to_graph
from .image_input import (
    correct_first_bias,
    join_uint8_image,
    join_uint8_image_quantized,
    split_normalisation,
)
from .passes.registry import Stage, apply_passes
from .photos import list_photos, network_inputs, spread
from .quantize import quantize

logger = logging.getLogger(__name__)

TOLERANCE = 1e-4
"""Largest difference allowed between torch and ONNX float32, in any pixel of any map."""

MOST_CALIBRATION_PHOTOS = 200
HELD_OUT_EVERY = 5
"""One calibration photo in five is kept from the calibration, to judge it."""


@dataclass(frozen=True)
class Conversion:
    """What to make of a checkpoint.

    Attributes:
        architecture: key of ``ARCHITECTURES``.
        size: (H, W) to fix the input to; None leaves both free.
        precision: ``fp32`` or ``int8``.
        calibration: folders of photos, each drawn from alike; int8 needs one.
        target: key of ``quantize.TARGETS``; counts for int8.
        name: what the model calls itself.
        licence: of the weights; None for the architecture's own.
        training: on what they were trained, in words.
    """

    architecture: str
    size: tuple[int, int] | None
    precision: str
    calibration: tuple[Path, ...]
    target: str
    name: str
    licence: str | None
    training: str


@dataclass(frozen=True)
class Report:
    """What was converted and what was measured; written as JSON beside the model.

    Attributes:
        model: file name, bytes and SHA-256.
        metadata: as in the file.
        torch_to_fp32: largest difference of each map, over ``parity_sizes``.
        parity_sizes: (H, W) of the pictures that torch and ONNX were compared on.
        fp32_to_int8: see :class:`compare.Difference`; None for fp32.
        calibration_photos: how many the int8 ranges were taken from.
        target: kind of CPU the integers are for; None for fp32.
        versions: of the programs that made it.
    """

    model: dict[str, object]
    metadata: dict[str, object]
    torch_to_fp32: dict[str, float]
    parity_sizes: list[tuple[int, int]]
    fp32_to_int8: dict[str, object] | None
    calibration_photos: int
    target: str | None
    versions: dict[str, str]


def convert(checkpoint: Path, output: Path, conversion: Conversion, *, overwrite: bool) -> Report:
    """Convert a checkpoint to a model file, verify it, and write both it and ``OUTPUT.json``.

    Raises:
        ExportError: bad options, too few photos, or the output exists and is not to be replaced.
        ModelError: the checkpoint is not one of the architecture.
        VerificationError: the result differs from the checkpoint; nothing is left behind.
    """
    _check_options(checkpoint, output, conversion, overwrite)
    architecture = ARCHITECTURES[conversion.architecture]
    network = architecture.build().eval()
    load_weights(network, read_checkpoint(checkpoint), str(checkpoint))
    calibration, held_out = _photo_split(conversion)
    calibrated_on = 0
    with tempfile.TemporaryDirectory(dir=output.parent, prefix=".fp-export-") as folder:
        fp32_path, int8_path = Path(folder, "fp32.onnx"), Path(folder, "int8.onnx")
        logger.info("exporting %s", checkpoint)
        graph = to_graph(network, conversion.size)
        normalisation = split_normalisation(graph)
        graph = apply_passes(graph, Stage.FLOAT, architecture.passes)
        quantizable = onnx.ModelProto()
        quantizable.CopyFrom(graph)
        join_uint8_image(graph, normalisation)
        graph = apply_passes(graph, Stage.FP32, architecture.passes)
        metadata = _metadata(checkpoint, conversion)
        _write(graph, replace(metadata, precision="fp32"), fp32_path)
        fp32 = Model(Session(fp32_path))
        sizes = [conversion.size] if conversion.size else [(96, 128), (160, 96), (256, 448)]
        parity = _parity(network, fp32, sizes)
        logger.info("torch against ONNX fp32, largest difference: %s", _short(parity))
        final, difference = fp32, None
        if conversion.precision == "int8":
            correct_first_bias(quantizable, normalisation)
            images = network_inputs(calibration, fp32)
            calibrated_on = len(images)
            logger.info("calibrating on %d photos", calibrated_on)
            int8_graph = quantize(quantizable, normalisation, images, conversion.target)
            join_uint8_image_quantized(int8_graph, normalisation)
            int8_graph = apply_passes(int8_graph, Stage.INT8, architecture.passes)
            _write(int8_graph, metadata, int8_path)
            final = Model(Session(int8_path))
            difference = _quantization_loss(fp32, final, held_out)
        report = Report(
            {"file": output.name, "bytes": final.path.stat().st_size, "sha256": final.sha256},
            asdict(metadata),
            parity,
            sizes,
            None if difference is None else difference.as_dict(),
            calibrated_on,
            None if difference is None else conversion.target,
            _versions(),
        )
        report_part = Path(folder, "report.json")
        report_part.write_text(json.dumps(asdict(report), indent=2) + "\n")
        final.path.replace(output)
        report_part.replace(report_path(output))
    return report


def report_path(output: Path) -> Path:
    """Where the report of a model file lies."""
    return output.with_name(output.name + ".json")


def _check_options(checkpoint: Path, output: Path, conversion: Conversion, overwrite: bool) -> None:
    if conversion.precision == "int8" and not conversion.calibration:
        raise ExportError("int8 needs photos to calibrate on, 100 or more: --calibration DIR")
    if conversion.size and (min(conversion.size) < 64 or any(s % 32 for s in conversion.size)):
        raise ExportError(f"size {conversion.size}: both sides must be multiples of 32, from 64 on")
    if output.suffix != ".onnx":
        raise ExportError(f"{output}: a model file ends in .onnx")
    if not output.parent.is_dir():
        raise ExportError(f"{output.parent}: no such folder to write to")
    for path in (output, report_path(output)):
        if path.resolve() == checkpoint.resolve():
            raise ExportError(f"{path} is the checkpoint itself; name another output")
        if path.exists() and not overwrite:
            raise ExportError(f"{path} exists; --overwrite replaces it")


def _photo_split(conversion: Conversion) -> tuple[list[Path], list[Path]]:
    calibration: list[Path] = []
    held_out: list[Path] = []
    folders = conversion.calibration if conversion.precision == "int8" else ()
    for folder in folders:
        photos = spread(
            list_photos(folder, at_least=HELD_OUT_EVERY), MOST_CALIBRATION_PHOTOS // len(folders)
        )
        for index, photo in enumerate(photos, 1):
            (held_out if index % HELD_OUT_EVERY == 0 else calibration).append(photo)
    return calibration, held_out


def _metadata(checkpoint: Path, conversion: Conversion) -> ModelMetadata:
    architecture = ARCHITECTURES[conversion.architecture]
    return ModelMetadata(
        name=conversion.name,
        architecture=conversion.architecture,
        precision=conversion.precision,
        depth_range_m=(MIN_DEPTH_M, MAX_DEPTH_M),
        focal_px=architecture.focal_px,
        resize="lanczos",
        licence=conversion.licence or architecture.licence,
        source_sha256=file_sha256(checkpoint),
        producer=f"footprints-edge {__version__}",
        training=conversion.training,
    )


def _write(model: onnx.ModelProto, metadata: ModelMetadata, path: Path) -> None:
    standard = [opset for opset in model.opset_import if not opset.domain]
    del model.opset_import[:]
    model.opset_import.extend(standard)
    del model.graph.value_info[:]
    set_metadata(model, metadata)
    onnx.save(model, path)
    check_file(path)


def _parity(network: nn.Module, model: Model, sizes: list[tuple[int, int]]) -> dict[str, float]:
    """Largest difference of each map between torch and a float32 file, on seeded pictures."""
    rng = np.random.default_rng(0)
    worst = np.zeros(4)
    for height, width in sizes:
        image = _test_picture(height, width, rng)
        x = torch.from_numpy(image).permute(0, 3, 1, 2).float() / 255
        with torch.no_grad():
            expected = raw_to_maps(network(x)).numpy()
        worst = np.maximum(worst, np.abs(model.session.run(image) - expected).max(axis=(0, 2, 3)))
    found = dict(zip(CHANNELS, worst.tolist(), strict=True))
    if not worst.max() <= TOLERANCE:  # also where it is NaN
        raise VerificationError(
            f"ONNX float32 differs from torch by more than {TOLERANCE:g}: {_short(found)}; "
            "no file was written"
        )
    return found


def _test_picture(height: int, width: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Smooth colour ramps with noise on them: every byte value, every frequency."""
    y, x = np.mgrid[0:height, 0:width] / max(height, width)
    ramps = np.stack([x, y, 1 - (x + y) / 2], axis=-1) * 200
    return (ramps + rng.integers(0, 56, (height, width, 3))).astype(np.uint8)[None]


def _quantization_loss(fp32: Model, int8: Model, held_out: list[Path]) -> Difference:
    difference = compare_models(fp32, int8, network_inputs(held_out, fp32))
    if not np.isfinite(list(difference.max_abs.values())).all():
        raise VerificationError("the int8 model gives maps that are not numbers; no file written")
    return difference


def _versions() -> dict[str, str]:
    import onnxruntime

    return {
        "footprints-edge": __version__,
        "torch": torch.__version__,
        "onnx": onnx.__version__,
        "onnxruntime": onnxruntime.__version__,
    }


def _short(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.2g}" for name, value in values.items())
