"""All passes, in order, each with its stage of a conversion. To add one, add its row."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import onnx_ir as ir

from footprints_edge_export.passes.elu_as_exponential import elu_as_exponential
from footprints_edge_export.passes.elu_on_bytes import elu_on_bytes
from footprints_edge_export.passes.few_outputs_by_blocks import few_outputs_by_blocks
from footprints_edge_export.passes.pad_and_resize_on_bytes import pad_and_resize_on_bytes
from footprints_edge_export.passes.upsample_by_expanding import upsample_by_expanding
from footprints_edge_export.passes.upsample_rows_in_convolution import upsample_rows_in_convolution


class PassStage(StrEnum):
    """Stage of a conversion.

    Attributes:
        FLOAT: the exported graph, from which both the float and the int8 file are made.
        FP32: the graph of the float file.
        INT8: the QDQ graph of the int8 file.
    """

    FLOAT = "float"
    FP32 = "fp32"
    INT8 = "int8"


@dataclass(frozen=True)
class Pass:
    """A rewrite and the stage it belongs to."""

    rewrite: Callable[[ir.Model], None]
    stage: PassStage

    @property
    def name(self) -> str:
        """Name of its function and of its file."""
        return self.rewrite.__name__


PASSES = (
    Pass(few_outputs_by_blocks, PassStage.FLOAT),
    Pass(upsample_rows_in_convolution, PassStage.FP32),
    Pass(elu_as_exponential, PassStage.FP32),
    Pass(pad_and_resize_on_bytes, PassStage.INT8),
    Pass(elu_on_bytes, PassStage.INT8),
    Pass(upsample_by_expanding, PassStage.INT8),
)


def apply_passes(model: ir.Model, stage: PassStage, passes: Sequence[Pass] = PASSES) -> None:
    """Apply the passes of a stage, in order and in place."""
    for each in passes:
        if each.stage == stage:
            each.rewrite(model)
