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

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.foundation.version import __version__
from footprints_edge.model import Model
from footprints_edge.model_files.metadata import OUTPUTS, ModelMetadata
from footprints_edge_export.architectures import ARCHITECTURES, trained
from footprints_edge_export.errors import ExportError, VerificationError
from footprints_edge_export.graph.fp16_weights import store_weights_in_half
from footprints_edge_export.graph.ort_format import to_ort_format
from footprints_edge_export.graph.torch_export import to_graph
from footprints_edge_export.graph.uint8_input import (
    correct_first_bias,
    join_uint8_image,
    join_uint8_image_quantized,
    split_normalisation,
)
from footprints_edge_export.passes.pad_as_slices import pad_as_slices
from footprints_edge_export.passes.registry import PASSES, Stage, apply_passes
from footprints_edge_export.quantization.calibration import network_inputs, split_photos
from footprints_edge_export.quantization.quantize import quantize
from footprints_edge_export.targets import TARGETS
from footprints_edge_export.verification.compare import CHANNELS, Difference, compare_models
from footprints_edge_export.verification.contract import check_file, set_metadata
from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M
from footprints_edge_models.networks.checkpoint import file_sha256

logger = logging.getLogger(__name__)

TOLERANCE = 1e-4
"""Largest difference allowed between torch and ONNX float32, in any pixel of any map."""

IR_VERSION = 8
"""The oldest that goes with opset 18, so that runtimes of 2023 read the files too."""

BOUNDS = {"fp16": (0.99, 0.01), "ort of fp32": (0.999, 0.001), "ort of int8": (0.98, 0.05)}
"""The least IoU of a mask and the largest mean relative difference of the visible depths: of
weights in half precision against float32, and of an ``.ort`` file against its model."""


@dataclass(frozen=True)
class Conversion:
    """What to make of a checkpoint.

    Attributes:
        architecture: key of ``ARCHITECTURES``.
        size: (H, W) to fix the input to; None leaves both free.
        precision: ``fp32``, ``fp16`` (weights only) or ``int8``.
        calibration: folders of photos, each drawn from alike; int8 needs one.
        target: key of ``targets.TARGETS``.
        name: what the model calls itself.
        licence: of the weights; None for the architecture's own.
        training: on what they were trained, in words.
        outputs: which maps the file has, a key of ``footprints_edge.metadata.OUTPUTS``.
        scale: of the head that they come from: 1, or 2 or 4 for one of that fraction of the
            picture's sides, where the architecture has one.
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
    training: str
    outputs: str = "all"
    scale: int = 1
    focal_px: float | None = None


@dataclass(frozen=True)
class Report:
    """What was converted and what was measured; written as JSON beside the model.

    Attributes:
        model: file name, bytes and SHA-256.
        metadata: as in the file.
        torch_to_fp32: largest difference of each map, over ``parity_sizes``.
        parity_sizes: (H, W) of the pictures that torch and ONNX were compared on.
        fp32_to_fp16: see :class:`compare.Difference`; None for fp32 and int8.
        fp32_to_int8: likewise; None for fp32 and fp16.
        calibration_photos: how many the int8 ranges were taken from.
        target: what the file is for; None where every target's would be the same.
        ort: file name, bytes and SHA-256 of the file in onnxruntime's format; None where the
            target or precision has none.
        model_to_ort: see :class:`compare.Difference`; None where there is no such file.
        versions: of the programs that made it.
        scale: of the head that the maps come from.
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


def convert(checkpoint: Path, output: Path, conversion: Conversion, *, overwrite: bool) -> Report:
    """Convert a checkpoint to a model file, verify it, and write both it and ``OUTPUT.json``.

    A target of onnxruntime's own format also has its ``.ort`` file and the list of its operators.

    Raises:
        ExportError: bad options, too few photos, or an output exists and is not to be replaced.
        ModelError: the checkpoint is not one of the architecture.
        VerificationError: the result differs from the checkpoint; nothing is left behind.
    """
    target = TARGETS[conversion.target]
    conversion = replace(conversion, size=conversion.size or target.size)
    outputs = _checked_outputs(checkpoint, output, conversion, overwrite)
    network = _network(checkpoint, conversion)
    folders = conversion.calibration if conversion.precision != "fp32" else ()
    calibration, held_out = split_photos(folders)
    calibrated_on = 0
    with tempfile.TemporaryDirectory(dir=output.parent, prefix=".fp-export-") as folder:
        fp32_path, final_path = Path(folder, "fp32.onnx"), Path(folder, "final.onnx")
        logger.info("exporting %s", checkpoint)
        graph = to_graph(network, conversion.size, gives_maps=True)
        normalisation = split_normalisation(graph)
        graph = apply_passes(graph, Stage.FLOAT, PASSES)
        quantizable = onnx.ModelProto()
        quantizable.CopyFrom(graph)
        join_uint8_image(graph, normalisation)
        graph = apply_passes(graph, Stage.FP32, PASSES)
        graph = pad_as_slices(graph) if target.plain_padding else graph
        metadata = _metadata(checkpoint, conversion)
        fp32 = _write(graph, replace(metadata, precision="fp32"), fp32_path)
        sizes = [conversion.size] if conversion.size else [(96, 128), (160, 96), (256, 448)]
        parity = _parity(network, fp32, sizes)
        logger.info("torch against ONNX fp32, largest difference: %s", _short(parity))
        final, half_difference, difference = fp32, None, None
        if conversion.precision == "fp16":
            store_weights_in_half(graph)
            final = _write(graph, metadata, final_path)
            half_difference = compare_models(fp32, final, _pictures(fp32, held_out, sizes))
            _hold("fp16", half_difference)
        if conversion.precision == "int8":
            correct_first_bias(quantizable, normalisation)
            images = network_inputs(calibration, fp32)
            calibrated_on = len(images)
            logger.info("calibrating on %d photos", calibrated_on)
            int8_graph = quantize(quantizable, normalisation, images, conversion.target)
            join_uint8_image_quantized(int8_graph, normalisation)
            int8_graph = apply_passes(int8_graph, Stage.INT8, PASSES)
            int8_graph = pad_as_slices(int8_graph) if target.plain_padding else int8_graph
            final = _write(int8_graph, metadata, final_path)
            difference = _quantization_loss(fp32, final, held_out)
        parts = {output: final.path}
        ort, ort_difference = None, None
        if len(outputs) > 2:
            ort_parts, ort, ort_difference = _write_ort(
                final, outputs[2:], _pictures(fp32, held_out, sizes)
            )
            parts |= ort_parts
        report = Report(
            _file(output, final),
            asdict(metadata),
            parity,
            sizes,
            None if half_difference is None else half_difference.as_dict(),
            None if difference is None else difference.as_dict(),
            calibrated_on,
            conversion.target if difference is not None or target.plain_padding else None,
            ort,
            None if ort_difference is None else ort_difference.as_dict(),
            _versions(),
            conversion.scale,
        )
        parts[outputs[1]] = Path(folder, "report.json")
        parts[outputs[1]].write_text(json.dumps(asdict(report), indent=2) + "\n")
        for path, made in parts.items():
            made.replace(path)
    return report


def report_path(output: Path) -> Path:
    """Where the report of a model file lies."""
    return output.with_name(output.name + ".json")


def _checked_outputs(
    checkpoint: Path, output: Path, conversion: Conversion, overwrite: bool
) -> list[Path]:
    """The files that a conversion writes: model, report, and ``.ort`` and its list if any."""
    if conversion.precision == "int8" and not conversion.calibration:
        raise ExportError("int8 needs photos to calibrate on, 100 or more: --calibration DIR")
    scales = ARCHITECTURES[conversion.architecture].scales
    if conversion.scale not in scales:
        raise ExportError(
            f"scale {conversion.scale}: {conversion.architecture} has trained heads of scale "
            f"{', '.join(map(str, scales))} only"
        )
    if conversion.size and (min(conversion.size) < 64 or any(s % 32 for s in conversion.size)):
        raise ExportError(f"size {conversion.size}: both sides must be multiples of 32, from 64 on")
    if output.suffix != ".onnx":
        raise ExportError(f"{output}: a model file ends in .onnx")
    if not output.parent.is_dir():
        raise ExportError(f"{output.parent}: no such folder to write to")
    outputs = [output, report_path(output)]
    # The format's converter folds the casts of half precision: it would be the fp32 file again.
    if TARGETS[conversion.target].ort_format and conversion.precision != "fp16":
        outputs += [output.with_suffix(".ort"), output.with_suffix(".operators.config")]
    for path in outputs:
        if path.resolve() == checkpoint.resolve():
            raise ExportError(f"{path} is the checkpoint itself; name another output")
        if path.exists() and not overwrite:
            raise ExportError(f"{path} exists; --overwrite replaces it")
    return outputs


def _file(output: Path, model: Model) -> dict[str, object]:
    return {"file": output.name, "bytes": model.path.stat().st_size, "sha256": model.sha256}


def _network(checkpoint: Path, conversion: Conversion) -> nn.Module:
    """The network, as far as it is asked for."""
    network = trained(conversion.architecture, checkpoint)
    part = ARCHITECTURES[conversion.architecture].part
    return part(network, conversion.outputs, conversion.scale).eval()


def _metadata(checkpoint: Path, conversion: Conversion) -> ModelMetadata:
    architecture = ARCHITECTURES[conversion.architecture]
    return ModelMetadata(
        name=conversion.name,
        architecture=conversion.architecture,
        precision=conversion.precision,
        depth_range_m=(MIN_DEPTH_M, MAX_DEPTH_M),
        focal_px=conversion.focal_px or architecture.focal_px,
        resize="lanczos",
        licence=conversion.licence or architecture.licence,
        source_sha256=file_sha256(checkpoint),
        producer=f"footprints-edge {__version__}",
        training=conversion.training,
        outputs=conversion.outputs,
    )


def _write(model: onnx.ModelProto, metadata: ModelMetadata, path: Path) -> Model:
    standard = [opset for opset in model.opset_import if not opset.domain]
    del model.opset_import[:]
    model.opset_import.extend(standard)
    del model.graph.value_info[:]
    set_metadata(model, metadata)
    model.ir_version = IR_VERSION
    onnx.save(model, path)
    check_file(path)
    return Model(OnnxRuntimeEngine(path))


def _parity(network: nn.Module, model: Model, sizes: list[tuple[int, int]]) -> dict[str, float]:
    """Largest difference of each map between torch and a float32 file, on seeded pictures."""
    rng = np.random.default_rng(0)
    channels = OUTPUTS[model.metadata.outputs]
    worst = np.zeros(len(channels))
    for height, width in sizes:
        image = _test_picture(height, width, rng)
        x = torch.from_numpy(image).permute(0, 3, 1, 2).float() / 255
        with torch.no_grad():
            expected = network(x).numpy()
        worst = np.maximum(worst, np.abs(model.engine.run(image) - expected).max(axis=(0, 2, 3)))
    found = {CHANNELS[channel]: float(off) for channel, off in zip(channels, worst, strict=True)}
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


def _pictures(
    model: Model, held_out: list[Path], sizes: list[tuple[int, int]]
) -> list[NDArray[np.uint8]]:
    """Photos that nothing was calibrated on; made pictures where there are none."""
    if held_out:
        return network_inputs(held_out, model)
    rng = np.random.default_rng(1)
    return [_test_picture(height, width, rng) for height, width in sizes]


def _hold(kind: str, difference: Difference) -> None:
    """Refuse a difference that is beyond its ``BOUNDS``."""
    least_iou, most_abs_rel = BOUNDS[kind]
    worst = min(difference.visible_ground_iou, difference.ground_iou)
    if worst < least_iou or not difference.visible_depth_abs_rel <= most_abs_rel:
        raise VerificationError(
            f"{kind} changes the masks (IoU {worst:.4f}, at least {least_iou:g}) or the depths (by "
            f"{difference.visible_depth_abs_rel:.2g} of the distance, at most {most_abs_rel:g}) "
            "too much; no file was written"
        )


def _write_ort(
    model: Model, outputs: list[Path], pictures: list[NDArray[np.uint8]]
) -> tuple[dict[Path, Path], dict[str, object], Difference]:
    """Make the ``.ort`` file and its list beside a model.

    Returns:
        Where each output lies for now, the file's facts, and how far its maps are from the model's.
    """
    ort_path, list_path = outputs
    parts = {path: model.path.with_name(f"made{path.suffix}") for path in outputs}
    data, operators = to_ort_format(model.path, ort_path.name)
    parts[ort_path].write_bytes(data)
    parts[list_path].write_text(operators)
    ort = Model(OnnxRuntimeEngine(parts[ort_path]))
    difference = compare_models(model, ort, pictures)
    _hold(f"ort of {model.metadata.precision}", difference)
    return parts, _file(ort_path, ort), difference


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
