"""All passes, in order, and where in a conversion each belongs. To add one, add its row."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import onnx

from footprints_edge_export.passes.elu_as_exponential import elu_as_exponential
from footprints_edge_export.passes.elu_on_bytes import elu_on_bytes
from footprints_edge_export.passes.few_outputs_by_blocks import few_outputs_by_blocks
from footprints_edge_export.passes.pad_and_resize_on_bytes import pad_and_resize_on_bytes
from footprints_edge_export.passes.upsample_by_expanding import upsample_by_expanding
from footprints_edge_export.passes.upsample_rows_in_convolution import upsample_rows_in_convolution


class Stage(StrEnum):
    """Of a conversion.

    Attributes:
        FLOAT: the exported graph, of which both the float and the int8 file are made.
        FP32: the float file.
        INT8: the QDQ file.
    """

    FLOAT = "float"
    FP32 = "fp32"
    INT8 = "int8"


@dataclass(frozen=True)
class Pass:
    """A rewrite and where it belongs."""

    rewrite: Callable[[onnx.ModelProto], onnx.ModelProto]
    stage: Stage

    @property
    def name(self) -> str:
        """Of its function and its file."""
        return self.rewrite.__name__


PASSES = (
    Pass(few_outputs_by_blocks, Stage.FLOAT),
    Pass(upsample_rows_in_convolution, Stage.FP32),
    Pass(elu_as_exponential, Stage.FP32),
    Pass(pad_and_resize_on_bytes, Stage.INT8),
    Pass(elu_on_bytes, Stage.INT8),
    Pass(upsample_by_expanding, Stage.INT8),
)


def apply_passes(
    model: onnx.ModelProto, stage: Stage, passes: Sequence[Pass] = PASSES
) -> onnx.ModelProto:
    """Apply those passes that belong to a stage, in order.

    Returns:
        A new model, or ``model`` itself where none does.
    """
    for each in passes:
        if each.stage == stage:
            model = each.rewrite(model)
    return model
