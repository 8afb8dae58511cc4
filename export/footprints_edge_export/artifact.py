"""A conversion under way: what each step of the chain in ``convert.py`` takes and returns."""

from dataclasses import dataclass
from pathlib import Path

import onnx_ir as ir
from torch import nn

from footprints_edge.model import Model
from footprints_edge_export.graph.uint8_input import Normalisation
from footprints_edge_export.job import Job
from footprints_edge_export.verification.compare import Difference


@dataclass(frozen=True, kw_only=True)
class ExportedGraph:
    """A network as torch exports it, before it is a file.

    Attributes:
        job: the conversion that this is part of.
        folder: where files are made until all of them are verified.
        network: the torch network with its weights; RGB float32 (1, 3, H, W) in [0, 1] to maps.
        graph: the float32 graph behind the normalisation of the image.
        normalisation: the normalisation that was cut off the graph.
    """

    job: Job
    folder: Path
    network: nn.Module
    graph: ir.Model
    normalisation: Normalisation


@dataclass(frozen=True, kw_only=True)
class Artifact:
    """A model file in the making, and what was measured on it.

    Attributes:
        exported: the graph that it was made from.
        graph: the graph of ``fp32``.
        fp32: the float32 file, loaded; it equals torch.
        torch_to_fp32: largest difference of each map between torch and ``fp32``.
        model: the file of the wanted precision, loaded.
        difference: ``model`` against ``fp32``; None where they are the same file.
        calibration_photos: number of photos that ``model`` was calibrated on.
        ort: the file in onnxruntime's format, loaded; None if there is none.
        ort_difference: ``ort`` against ``model``; None if there is no ``ort``.
    """

    exported: ExportedGraph
    graph: ir.Model
    fp32: Model
    torch_to_fp32: dict[str, float]
    model: Model
    difference: Difference | None = None
    calibration_photos: int = 0
    ort: Model | None = None
    ort_difference: Difference | None = None

    @property
    def job(self) -> Job:
        """The conversion that this is part of."""
        return self.exported.job
