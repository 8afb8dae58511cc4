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

from footprints_edge_models.networks.channels import raw_to_maps

OPSET = 18


class _WithMaps(nn.Module):
    """RGB float32 (1, 3, H, W) in [0, 1] to the maps of the file contract."""

    def __init__(self, network: nn.Module) -> None:
        super().__init__()
        self.network = network

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return raw_to_maps(self.network(image))


class _Clamp6(nn.Module):
    """What ReLU6 does, as one of the operators that torch's exporter takes as they are."""

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.clamp(x, 0.0, 6.0)


def to_graph(
    network: nn.Module, size: tuple[int, int] | None, *, gives_maps: bool = False
) -> ir.Model:
    """Export with batch norms folded.

    Args:
        network: as :data:`footprints_edge_models.networks.registry.Network` says.
        size: (H, W) to fix the input to; None leaves both free.
        gives_maps: whether it gives maps, not raw channels.

    Returns:
        A model with input ``image`` float32 [1, 3, H, W] in [0, 1] and output ``maps`` float32
        [1, 4, H, W], or fewer channels where the network gives fewer.
    """
    height, width = size or (64, 96)
    sides = [32 * torch.export.Dim(name, min=2, max=512) for name in ("h", "w")]
    shapes = {"image": {2: sides[0], 3: sides[1]}} if size is None else None
    example = torch.zeros(1, 3, height, width)
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
                _without_relu6(network if gives_maps else _WithMaps(network)).eval(),
                (example,),
                dynamo=True,
                opset_version=OPSET,
                input_names=["image"],
                output_names=["maps"],
                dynamic_shapes=shapes,
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


def _without_relu6(network: nn.Module) -> nn.Module:
    """A copy that computes the same: taking ReLU6 apart would be a fifth of an export's time."""
    network = copy.deepcopy(network)
    for parent in list(network.modules()):
        for name, child in parent.named_children():
            if isinstance(child, nn.ReLU6):
                setattr(parent, name, _Clamp6())
    return network
