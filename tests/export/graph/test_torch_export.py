"""Graphs of free size: traced at one size, right at all."""

from dataclasses import replace

import pytest
import torch

from footprints_edge_export.architectures import ARCHITECTURES
from footprints_edge_export.convert import convert
from footprints_edge_export.errors import VerificationError


class KnowsItsSize(torch.nn.Module):
    """Darker, the higher the image."""

    def __init__(self, _network, outputs, scale):
        super().__init__()
        self.outputs, self.scale, self.head = outputs, scale, torch.nn.Conv2d(3, 4, 1)

    def forward(self, image):
        return torch.sigmoid(self.head(image)) * (64 / image.shape[2])


def test_a_network_that_knows_its_size_is_refused_where_the_size_is_free(
    edge_checkpoint, conversion, tmp_path, monkeypatch
):
    monkeypatch.setitem(ARCHITECTURES, "edge", replace(ARCHITECTURES["edge"], part=KnowsItsSize))
    convert(edge_checkpoint, tmp_path / "a.onnx", conversion(size=(64, 96)), overwrite=False)
    with pytest.raises(VerificationError, match="differs from torch"):
        convert(edge_checkpoint, tmp_path / "b.onnx", conversion(), overwrite=False)
    assert not (tmp_path / "b.onnx").exists()
