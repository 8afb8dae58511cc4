"""Static int8 quantization in QDQ form, calibrated on real photos, with bias correction.

Convolutions and what lies between them run in int8. The last convolutions and all that follows
stay float: a uint8 disparity can only say 100, 20.3, 11.3, 7.8, 6.0 metres.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import onnx
import onnx_ir as ir
from numpy.typing import NDArray
from onnxruntime.quantization import (
    CalibrationDataReader,
    CalibrationMethod,
    QuantFormat,
    QuantType,
    quantize_static,
)
from onnxruntime.quantization.quant_utils import add_pre_process_metadata

from footprints_edge_export.errors import ExportError
from footprints_edge_export.graph.editing import to_proto
from footprints_edge_export.graph.uint8_input import NORMALISED, Normalisation
from footprints_edge_export.quantization.bias_correction import correct_biases, mean_inputs
from footprints_edge_export.quantization.exact_add_scales import make_sums_exact
from footprints_edge_export.targets import TARGETS

_QUANTIZED_OPS = ["Conv", "Add", "Concat", "Resize", "Relu", "Clip", "MaxPool", "Pad"]


def _feeds(
    images: list[NDArray[np.uint8]], normalisation: Normalisation
) -> Iterator[dict[str, NDArray[np.float32]]]:
    for image in images:
        # What the int8 graph will see: the zero byte is a whole one there.
        x = (image.astype(np.float32) - normalisation.zero_point) * normalisation.scale
        yield {NORMALISED: x.transpose(0, 3, 1, 2).astype(np.float32)}


class _Photos(CalibrationDataReader):  # type: ignore[misc]
    def __init__(self, feeds: Iterator[dict[str, NDArray[np.float32]]]) -> None:
        self._feeds = feeds

    def get_next(self) -> dict[str, NDArray[np.float32]] | None:
        return next(self._feeds, None)


def quantize(
    model: ir.Model,
    normalisation: Normalisation,
    images: list[NDArray[np.uint8]],
    target: str,
) -> ir.Model:
    """Quantize a float graph that begins with ``image_normalised``.

    Args:
        model: float32, from :func:`uint8_input.split_normalisation`.
        normalisation: the normalisation that was cut off.
        images: calibration photos, uint8 (1, H, W, 3) each.
        target: key of ``targets.TARGETS``.

    Returns:
        A QDQ graph with the same input and per-channel int8 weights.
    """
    if not 0 <= normalisation.zero_point <= 255:
        raise ExportError(
            f"the network's zero is byte {normalisation.zero_byte:g}; int8 needs one from 0 to 255"
        )
    settings = TARGETS[target]
    is_signed = settings.activations == QuantType.QInt8
    zero_dtype = np.int8 if is_signed else np.uint8
    image_quantization = {
        "quant_type": settings.activations,
        "scale": np.array(normalisation.scale, np.float32),
        "zero_point": np.array(normalisation.zero_point - 128 * is_signed, zero_dtype),
    }
    with tempfile.TemporaryDirectory() as folder:
        source, quantized = Path(folder, "float.onnx"), Path(folder, "int8.onnx")
        shaped = onnx.shape_inference.infer_shapes(to_proto(model))
        add_pre_process_metadata(shaped)  # the exporter folded all that its pre-processing would
        onnx.save(shaped, source)
        quantize_static(
            source,
            quantized,
            _Photos(_feeds(images, normalisation)),
            quant_format=QuantFormat.QDQ,
            op_types_to_quantize=_QUANTIZED_OPS,
            per_channel=True,
            reduce_range=settings.reduce_range,
            activation_type=settings.activations,
            weight_type=QuantType.QInt8,
            nodes_to_exclude=float_tail(model.graph),
            calibrate_method=CalibrationMethod.MinMax,
            extra_options={
                "TensorQuantOverrides": {NORMALISED: [image_quantization]},
                "CalibTensorRangeSymmetric": False,
                # Ranges are means over the photos: one photo's outlier coarsens no other.
                "CalibMovingAverage": True,
            },
        )
        result = ir.load(quantized)
    make_sums_exact(result)
    correct_biases(result, model, mean_inputs(model, _feeds(images, normalisation)))
    return result


def float_tail(graph: ir.Graph) -> list[str]:
    """Names of the last convolutions and of every node after them."""
    tail, waiting = [], [graph.outputs[0].producer()]
    while waiting:
        node = waiting.pop()
        if node is None:
            continue
        tail.append(str(node.name))
        if node.op_type != "Conv":
            waiting += node.predecessors()
    return tail
