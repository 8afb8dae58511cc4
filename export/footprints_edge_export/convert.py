"""The whole conversion, as a chain: export -> fp32 -> fp16 or int8 -> ort -> report.

Each step takes and returns one artifact. All files are made and verified in a temporary folder;
the output appears only when every check holds.
"""

import json
import logging
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import onnx
import onnx_ir as ir
import onnxruntime
import torch
from numpy.typing import NDArray
from onnx_ir.passes.common import RemoveUnusedOpsetsPass

from footprints_edge.engines.onnxruntime_engine import OnnxRuntimeEngine
from footprints_edge.foundation.parts import part_folder
from footprints_edge.foundation.version import __version__
from footprints_edge.model import Model
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge_export.architectures import canonical_focal_px, trained
from footprints_edge_export.artifact import Artifact, ExportedGraph
from footprints_edge_export.credits_section import summary
from footprints_edge_export.graph.editing import to_proto
from footprints_edge_export.graph.fp16_weights import store_weights_in_half
from footprints_edge_export.graph.ort_format import operators_path, to_ort_format
from footprints_edge_export.graph.torch_export import to_graph
from footprints_edge_export.graph.uint8_input import (
    correct_first_bias,
    join_uint8_image,
    join_uint8_image_quantized,
    split_normalisation,
)
from footprints_edge_export.job import Job
from footprints_edge_export.passes.pad_as_slices import pad_as_slices
from footprints_edge_export.passes.registry import PASSES, PassStage, apply_passes
from footprints_edge_export.quantization.calibration import network_inputs
from footprints_edge_export.quantization.quantize import quantize
from footprints_edge_export.report import Conversion, Report, report_path
from footprints_edge_export.verification.bounds import check_bounds, check_finite
from footprints_edge_export.verification.compare import Difference, compare_models
from footprints_edge_export.verification.contract import check_file, set_metadata
from footprints_edge_export.verification.parity import check_parity, in_short
from footprints_edge_export.verification.test_vectors import EXAMPLE_PHOTO
from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M
from footprints_edge_models.networks.checkpoint import file_sha256, read_checkpoint
from footprints_edge_models.training.weight_credits import stated_credits

logger = logging.getLogger(__name__)

IR_VERSION = 8
"""The oldest version for opset 18, so that runtimes of 2023 can read the files too."""


def convert(checkpoint: Path, output: Path, conversion: Conversion, *, overwrite: bool) -> Report:
    """Convert a checkpoint to a model file, verify it, and write both it and ``OUTPUT.json``.

    If the target uses onnxruntime's own format, also write the ``.ort`` file and the list of its
    operators.

    Raises:
        ExportError: bad options, too few photos, or an output exists and ``overwrite`` is false.
        ModelError: the checkpoint does not fit the architecture.
        VerificationError: the result differs from the checkpoint; no file is left behind.
    """
    job = Job.checked(checkpoint, output, conversion, overwrite=overwrite)
    with part_folder(output.parent) as folder:
        fp32 = to_fp32(export(job, folder))
        artifact = to_ort(_TO_PRECISION[conversion.precision](fp32))
        report = to_report(artifact)
        _publish(artifact, report)
    return report


def export(job: Job, folder: Path) -> ExportedGraph:
    """Load the checkpoint and export the part of the network that the job asks for."""
    conversion = job.conversion
    whole = trained(conversion.architecture, job.checkpoint)
    network = job.architecture.part(whole, conversion.outputs, conversion.scale).eval()
    logger.info("exporting %s", job.checkpoint)
    graph = to_graph(network, conversion.size)
    normalisation = split_normalisation(graph)
    apply_passes(graph, PassStage.FLOAT, PASSES)
    return ExportedGraph(
        job=job,
        folder=folder,
        network=network,
        graph=graph,
        normalisation=normalisation,
    )


def to_fp32(exported: ExportedGraph) -> Artifact:
    """Write the float32 file.

    Raises:
        VerificationError: its maps are not torch's.
    """
    graph = exported.graph.clone()
    join_uint8_image(graph, exported.normalisation)
    _apply_passes(graph, PassStage.FP32, exported.job)
    model = _write(exported, graph, "fp32")
    parity = check_parity(exported.network, model, exported.job.test_sizes)
    logger.info("torch against ONNX fp32, largest difference: %s", in_short(parity))
    return Artifact(exported=exported, graph=graph, fp32=model, torch_to_fp32=parity, model=model)


def to_fp16(artifact: Artifact) -> Artifact:
    """Store the weights of the float32 file in half precision.

    Raises:
        ExportError: a weight is too large for half precision.
        VerificationError: the maps change too much.
    """
    graph = artifact.graph.clone()
    store_weights_in_half(graph)
    model = _write(artifact.exported, graph, "fp16")
    difference = compare_models(artifact.fp32, model, _verification_images(artifact))
    check_bounds("fp16", difference)
    return replace(artifact, model=model, difference=difference)


def to_int8(artifact: Artifact) -> Artifact:
    """Quantize the exported graph.

    Raises:
        ExportError: none of the photos can be read, or the network cannot be quantized.
        VerificationError: the maps are not numbers.
    """
    exported, job = artifact.exported, artifact.job
    graph = exported.graph.clone()
    correct_first_bias(graph, exported.normalisation)
    held_out = _verification_images(artifact)  # first: that none can be read is said at once
    images = network_inputs(job.calibration, artifact.fp32)
    logger.info("calibrating on %d photos", len(images))
    graph = quantize(graph, exported.normalisation, images, job.conversion.target)
    join_uint8_image_quantized(graph, exported.normalisation)
    _apply_passes(graph, PassStage.INT8, job)
    model = _write(exported, graph, "int8")
    difference = compare_models(artifact.fp32, model, held_out)
    check_finite(difference)
    return replace(artifact, model=model, difference=difference, calibration_photos=len(images))


def to_ort(artifact: Artifact) -> Artifact:
    """Write the file in onnxruntime's own format, if the job asks for one.

    Raises:
        VerificationError: onnxruntime's converter fails, or the maps change too much.
    """
    if artifact.job.ort is None:
        return artifact
    ort = Model(OnnxRuntimeEngine(to_ort_format(artifact.model.path, artifact.job.ort.name)))
    difference = compare_models(artifact.model, ort, _verification_images(artifact))
    check_bounds(f"ort of {artifact.model.metadata.precision}", difference)
    return replace(artifact, ort=ort, ort_difference=difference)


def to_report(artifact: Artifact) -> Report:
    """Everything that was measured on the way."""
    job, precision = artifact.job, artifact.job.conversion.precision
    is_for_target = precision == "int8" or job.target.plain_padding
    return Report(
        model=_file_facts(job.output, artifact.model),
        metadata=asdict(artifact.model.metadata),
        torch_to_fp32=artifact.torch_to_fp32,
        parity_sizes=job.test_sizes,
        fp32_to_fp16=_facts(artifact.difference) if precision == "fp16" else None,
        fp32_to_int8=_facts(artifact.difference) if precision == "int8" else None,
        calibration_photos=artifact.calibration_photos,
        target=job.conversion.target if is_for_target else None,
        ort=None if job.ort is None or artifact.ort is None else _file_facts(job.ort, artifact.ort),
        model_to_ort=_facts(artifact.ort_difference),
        versions={
            "footprints-edge": __version__,
            "torch": torch.__version__,
            "onnx": onnx.__version__,
            "onnxruntime": onnxruntime.__version__,
        },
        scale=job.conversion.scale,
    )


_TO_PRECISION: Mapping[str, Callable[[Artifact], Artifact]] = {
    "fp32": lambda fp32: fp32,
    "fp16": to_fp16,
    "int8": to_int8,
}


def _publish(artifact: Artifact, report: Report) -> None:
    """Move the verified files to where the caller wants them, the report last."""
    job = artifact.job
    moves = {job.output: artifact.model.path}
    if job.ort is not None and artifact.ort is not None:
        moves[job.ort] = artifact.ort.path
        moves[operators_path(job.ort)] = operators_path(artifact.ort.path)
    report_file = artifact.exported.folder / "report.json"
    report_file.write_text(json.dumps(asdict(report), indent=2) + "\n")
    moves[report_path(job.output)] = report_file
    for path, made in moves.items():
        made.replace(path)


def _write(exported: ExportedGraph, graph: ir.Model, precision: str) -> Model:
    """Write a graph with its metadata, check the file, and load it."""
    RemoveUnusedOpsetsPass()(graph)
    set_metadata(graph, _metadata(exported.job, precision))
    graph.ir_version = IR_VERSION
    path = exported.folder / f"{precision}.onnx"
    onnx.save(to_proto(graph), path)
    check_file(path)
    return Model(OnnxRuntimeEngine(path))


def _metadata(job: Job, precision: str) -> ModelMetadata:
    conversion = job.conversion
    return ModelMetadata(
        name=conversion.name,
        architecture=conversion.architecture,
        precision=precision,
        depth_range_m=(MIN_DEPTH_M, MAX_DEPTH_M),
        focal_px=conversion.focal_px or canonical_focal_px(conversion.architecture, job.checkpoint),
        resize=job.architecture.resize,
        licence=conversion.licence or job.architecture.network.licence,
        source_sha256=file_sha256(job.checkpoint),
        producer=f"footprints-edge {__version__}",
        training=conversion.training or _trained_on(job.checkpoint),
        outputs=conversion.outputs,
    )


def _trained_on(checkpoint: Path) -> str:
    credits = stated_credits(read_checkpoint(checkpoint), str(checkpoint))
    return f"works by licence: {summary(credits)}" if credits else "unstated"


def _apply_passes(graph: ir.Model, stage: PassStage, job: Job) -> None:
    apply_passes(graph, stage, PASSES)
    if job.target.plain_padding:
        pad_as_slices(graph)


def _verification_images(artifact: Artifact) -> list[NDArray[np.uint8]]:
    """Photos that nothing was calibrated on; our own if there are none.

    On pictures without ground, and on noise, masks hang by a thread: no rounding keeps them.
    """
    return network_inputs(artifact.job.held_out or [EXAMPLE_PHOTO], artifact.fp32)


def _file_facts(output: Path, model: Model) -> dict[str, object]:
    return {"file": output.name, "bytes": model.path.stat().st_size, "sha256": model.sha256}


def _facts(difference: Difference | None) -> dict[str, object] | None:
    return None if difference is None else difference.as_dict()
