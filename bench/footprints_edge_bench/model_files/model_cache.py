"""The model files that are measured: bundled, or made on the spot and kept in a folder."""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.preprocessing import preprocess
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge.model_files.registry import resolve
from footprints_edge_bench.model_files.random_weights import with_lively_weights
from footprints_edge_bench.model_files.stock_files import write_stock
from footprints_edge_bench.model_files.synthetic_photos import made_photo

if TYPE_CHECKING:
    from torch import nn

CALIBRATION_PHOTOS = 10
EDGE, REFERENCE = "edge", "reference"
STOCK = "-stock"
PARTS = {
    "-masks": ("masks", 1),
    "-depths": ("depths", 1),
    "-scale2": ("all", 2),
    "-scale4": ("all", 4),
}
"""What may stand behind a precision: the outputs and the scale that a file is converted with."""


class NetworkFilesError(FootprintsError):
    """A model file that can be neither found nor made."""


@dataclass(frozen=True)
class NetworkFiles:
    """Where model files come from.

    ``edge`` is the bundled model; its float file is made from the checkpoint that it came from.
    ``reference`` is the paper's network with random weights: latency does not depend on them.
    Any other network is the path of a model file, which is taken as it is.

    Attributes:
        folder: what was made is kept here, by everything that it depends on.
        edge_checkpoint: weights of the edge network.
    """

    folder: Path
    edge_checkpoint: Path = Path("models/weights/edge.pt")

    def onnx(self, network: str, size: Size, precision: str) -> Path:
        """A model file of ours.

        Args:
            network: ``edge``, ``reference``, or a path.
            size: (H, W) of its input; the edge network takes any.
            precision: ``fp32`` or ``int8``; with ``-stock`` behind it, without our rewrites, with
                a key of ``PARTS``, only that part.

        Raises:
            NetworkFilesError: it can be neither found nor made.
        """
        if network not in (EDGE, REFERENCE):
            return resolve(network)
        if (network, precision) == (EDGE, "int8"):
            return resolve()
        fixed = None if network == EDGE else size
        text = "any" if fixed is None else f"{size[0]}x{size[1]}"
        made = self.kept(
            f"{network}-{text}-{precision}",
            {"weights": self.weights_sha256(network), "exporter": _exporter_sha256()},
            lambda folder: self._convert(folder, network, fixed, precision),
        )
        return made / "model.onnx"

    def network(self, network: str) -> "nn.Module":
        """A network in torch, with the weights that its files are made from.

        Raises:
            NetworkFilesError: it is neither ``edge`` nor ``reference``.
        """
        from footprints_edge_export.architectures import ARCHITECTURES, trained

        if network not in ARCHITECTURES:
            raise NetworkFilesError(f"{network} is a model file; only its graph is known")
        return trained(network, self._checkpoint(network))

    def weights_sha256(self, network: str) -> str:
        """SHA-256 of the checkpoint of ``edge`` or ``reference``."""
        return self.sha256(self._checkpoint(network))

    def calibration_images(self, size: Size) -> list[Rgb]:
        """The pictures that int8 is calibrated on, as the network sees them."""
        return [preprocess(photo, size) for photo in _calibration_photos()]

    @staticmethod
    def sha256(path: Path) -> str:
        """Of a file."""
        return hashlib.sha256(path.read_bytes()).hexdigest()

    def kept(self, name: str, settings: Mapping[str, Any], make: Callable[[Path], None]) -> Path:
        """A folder that is made once for each name and settings.

        Args:
            name: what it begins with.
            settings: everything that its content depends on, plain values.
            make: fills a folder.
        """
        text = json.dumps({"name": name, **settings}, sort_keys=True)
        kept = self.folder / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:12]}"
        if not kept.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            made = Path(tempfile.mkdtemp(dir=self.folder, prefix=".unfinished-"))
            try:
                make(made)
                made.replace(kept)
            finally:
                shutil.rmtree(made, ignore_errors=True)
        return kept

    def _checkpoint(self, network: str) -> Path:
        if network == EDGE:
            if not self.edge_checkpoint.is_file():
                raise NetworkFilesError(
                    f"{self.edge_checkpoint}: no such checkpoint of the edge network; name it with "
                    "--edge-checkpoint, in a checkout it is models/weights/edge.pt"
                )
            return self.edge_checkpoint
        if network != REFERENCE:
            raise NetworkFilesError(f"{network} is a model file; there is no checkpoint of it")
        return self.kept(
            "reference-weights", {"sources": _exporter_sha256()}, _random_reference
        ) / ("weights.pt")

    def _convert(self, folder: Path, network: str, size: Size | None, precision: str) -> None:
        from footprints_edge_export.convert import convert
        from footprints_edge_export.report import Conversion

        if precision.endswith(STOCK):
            self._write_stock(folder, network, size, precision.removesuffix(STOCK))
            return
        part = part_of(precision)
        outputs, scale = PARTS.get(part, ("all", 1))
        precision = precision.removesuffix(part)
        photos = folder / "photos"
        photos.mkdir()
        for index, photo in enumerate(_calibration_photos()):
            Image.fromarray(photo).save(photos / f"{index:02}.png")
        conversion = Conversion(
            architecture=network,
            size=size,
            precision=precision,
            calibration=(photos,),
            target="x86-vnni",
            name=network,
            licence=None,
            training="for its speed only",
            outputs=outputs,
            scale=scale,
        )
        convert(self._checkpoint(network), folder / "model.onnx", conversion, overwrite=False)
        shutil.rmtree(photos)

    def _write_stock(self, folder: Path, network: str, size: Size | None, precision: str) -> None:
        from footprints_edge_export.architectures import ARCHITECTURES
        from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M

        architecture = ARCHITECTURES[network]
        metadata = ModelMetadata(
            network,
            network,
            precision,
            (MIN_DEPTH_M, MAX_DEPTH_M),
            architecture.focal_px,
            "lanczos",
            architecture.licence,
            self.weights_sha256(network),
            "stock tools",
            "for its speed only",
        )
        images = self.calibration_images(size or (256, 448)) if precision == "int8" else []
        write_stock(self.network(network), metadata, size, images, folder / "model.onnx")


def part_of(precision: str) -> str:
    """The key of ``PARTS`` that a precision ends in, or nothing."""
    return next((part for part in PARTS if precision.endswith(part)), "")


def outputs_of(precision: str) -> str:
    """Which maps a file has, a key of ``footprints_edge.metadata.OUTPUTS``."""
    return PARTS[part][0] if (part := part_of(precision)) else "all"


def default_folder() -> Path:
    """Where made files are kept if nothing else is said: the user's cache."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "footprints-edge" / "bench"


def _calibration_photos() -> list[Rgb]:
    return [made_photo((480, 640), seed) for seed in range(CALIBRATION_PHOTOS)]


def _random_reference(folder: Path) -> None:
    import torch

    from footprints_edge_models.networks.reference import ReferenceNetwork

    photos = [preprocess(made_photo((96, 128), seed), (96, 128)) for seed in range(4)]
    network = with_lively_weights(ReferenceNetwork(), photos)
    torch.save(network.state_dict(), folder / "weights.pt")


@cache
def _exporter_sha256() -> str:
    """Of the sources that decide what a conversion gives."""
    import footprints_edge_export
    from footprints_edge_models.networks import channels as maps
    from footprints_edge_models.networks import edge, reference
    from footprints_edge_models.networks import efficientnet_lite0 as lite0

    exporter = Path(footprints_edge_export.__path__[0])
    networks = [Path(str(module.__file__)) for module in (edge, lite0, maps, reference)]
    digest = hashlib.sha256()
    for path in (*sorted(exporter.rglob("*.py")), *networks):
        digest.update(path.read_bytes())
    return digest.hexdigest()
