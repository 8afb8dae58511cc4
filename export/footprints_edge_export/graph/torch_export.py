"""A torch network to a float32 ONNX graph."""

import contextlib
import copy
import io
import logging
import warnings

import onnx_ir as ir
import torch
from onnx_ir.passes.common import ClearMetadataAndDocStringPass
from torch import nn

OPSET = 18
EXAMPLE_SIZE = (64, 96)
"""(H, W) of the image that is traced where the size is free."""


class _Clamp6(nn.Module):
    """What ReLU6 does, as one of the operators that torch's exporter takes as they are."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.clamp(x, 0.0, 6.0)


def to_graph(network: nn.Module, size: tuple[int, int] | None) -> ir.Model:
    """Export with batch norms folded.

    Args:
        network: RGB float32 (1, 3, H, W) in [0, 1] to maps (1, C, H, W).
        size: (H, W) to fix the input to; None leaves both free.

    Returns:
        A model with input ``image`` float32 [1, 3, H, W] in [0, 1] and output ``maps`` float32
        [1, C, H, W].
    """
    model = traced(network, size or EXAMPLE_SIZE)
    if size is None:
        _free_size(model)
    return model


def traced(network: nn.Module, size: tuple[int, int]) -> ir.Model:
    """The graph of :func:`to_graph` for one size (H, W)."""
    exporter_log = logging.getLogger("torch.onnx")
    level = exporter_log.level
    exporter_log.setLevel(logging.ERROR)  # it warns of packages that we do not need
    try:
        with (
            warnings.catch_warnings(),
            contextlib.redirect_stdout(io.StringIO()),
            torch.no_grad(),
        ):
            warnings.simplefilter("ignore")
            program = torch.onnx.export(
                _without_relu6(network).eval(),
                (torch.zeros(1, 3, *size),),
                dynamo=True,
                opset_version=OPSET,
                input_names=["image"],
                output_names=["maps"],
                verbose=False,
            )
    finally:
        exporter_log.setLevel(level)
    if program is None:
        raise RuntimeError("torch.onnx.export returned no program")
    model: ir.Model = program.model
    ClearMetadataAndDocStringPass()(model)  # stack traces with paths of this machine
    for value in (*model.graph.inputs, *model.graph.outputs):
        value.metadata_props.clear()
    return model


def _free_size(model: ir.Model) -> None:
    """Let a graph take any size, in place.

    Our networks only pad, convolve, pool and scale by factors, so no node knows the size. Tracing
    with symbols in its place gives the same nodes in 2.4 times the time. A network that does know
    it is refused by a conversion, which compares its maps with torch's at other sizes.
    """
    for value in (*model.graph.inputs, *model.graph.outputs):
        assert value.shape is not None
        value.shape = ir.Shape([*value.shape[:2], None, None])
    for node in model.graph:
        for value in node.outputs:
            if not value.is_graph_output():
                value.shape = None


def _without_relu6(network: nn.Module) -> nn.Module:
    """A copy that computes the same: taking ReLU6 apart would be a fifth of an export's time."""
    network = copy.deepcopy(network)
    for parent in list(network.modules()):
        for name, child in parent.named_children():
            if isinstance(child, nn.ReLU6):
                setattr(parent, name, _Clamp6())
    return network
