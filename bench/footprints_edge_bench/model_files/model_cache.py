"""The model files that are measured: the bundled one, or converted ones kept in a cache folder."""

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.parts import part_folder
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.preprocessing import FILTER, preprocess
from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge.model_files.registry import resolve
from footprints_edge_bench.foundation.fingerprint import sha256_of_bytes, sha256_of_file
from footprints_edge_bench.model_files.random_weights import with_calibrated_random_weights
from footprints_edge_bench.model_files.stock_files import write_stock
from footprints_edge_bench.model_files.synthetic_photos import synthetic_photo

if TYPE_CHECKING:
    from torch import nn

CALIBRATION_PHOTOS = 10
EDGE, REFERENCE = "edge", "reference"
STOCK = "-stock"
_TRAINING = "for its speed only"
PARTS = {
    "-masks": ("masks", 1),
    "-depths": ("depths", 1),
    "-scale2": ("all", 2),
    "-scale4": ("all", 4),
}
"""Suffixes of a precision, with the outputs and the decoder scale of the converted file."""


class ModelCacheError(FootprintsError):
    """A model file can be neither found nor converted."""


@dataclass(frozen=True)
class ModelCache:
    """Finds model files, or converts them once and keeps them.

    ``edge`` is the bundled model; its float32 file is converted from its checkpoint.
    ``reference`` is the paper's network with calibrated random weights: latency does not depend on
    weights. Any other network is the path of a model file, which is used as it is.

    Attributes:
        folder: where converted files are kept, by a hash of everything they depend on.
        edge_checkpoint: checkpoint of the edge network.
    """

    folder: Path
    edge_checkpoint: Path = Path("models/weights/edge.pt")

    def onnx(self, network: str, size: Size, precision: str) -> Path:
        """An ONNX file of a network.

        Args:
            network: ``edge``, ``reference``, or a path.
            size: (H, W) of its input; files of the edge network take any size.
            precision: ``fp32`` or ``int8``. The suffix ``-stock`` leaves out our graph passes; a
                suffix of ``PARTS`` computes only that part.

        Raises:
            ModelCacheError: the file can be neither found nor converted.
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
        """A network in PyTorch, with the weights that its files are converted from.

        Raises:
            ModelCacheError: the network is neither ``edge`` nor ``reference``.
        """
        from footprints_edge_export.architectures import ARCHITECTURES, trained

        if network not in ARCHITECTURES:
            raise ModelCacheError(
                f"{network} is a model file, which PyTorch cannot run; name edge or reference"
            )
        return trained(network, self._checkpoint(network))

    def weights_sha256(self, network: str) -> str:
        """SHA-256 of the checkpoint of ``edge`` or ``reference``."""
        return sha256_of_file(self._checkpoint(network))

    def calibration_images(self, size: Size) -> list[Rgb]:
        """The images that int8 is calibrated on, at the size (H, W) of the network."""
        return [preprocess(photo, size) for photo in _calibration_photos()]

    def kept(self, name: str, settings: Mapping[str, Any], make: Callable[[Path], None]) -> Path:
        """A folder that is filled once for each name and settings.

        Args:
            name: beginning of the folder's name.
            settings: everything that the content depends on, as plain values.
            make: fills a folder; if it fails, nothing is kept.
        """
        text = json.dumps({"name": name, **settings}, sort_keys=True)
        kept = self.folder / f"{name}-{sha256_of_bytes(text.encode())[:12]}"
        if not kept.is_dir():
            self.folder.mkdir(parents=True, exist_ok=True)
            with part_folder(self.folder) as made:
                make(made)
                made.replace(kept)
        return kept

    def _checkpoint(self, network: str) -> Path:
        if network == EDGE:
            if not self.edge_checkpoint.is_file():
                raise ModelCacheError(
                    f"{self.edge_checkpoint}: no such checkpoint of the edge network; give it with "
                    "--edge-checkpoint; in a checkout it is models/weights/edge.pt"
                )
            return self.edge_checkpoint
        if network != REFERENCE:
            raise ModelCacheError(
                f"{network} is a model file without a checkpoint; name edge or reference"
            )
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
            training=_TRAINING,
            outputs=outputs,
            scale=scale,
        )
        convert(self._checkpoint(network), folder / "model.onnx", conversion, overwrite=False)
        shutil.rmtree(photos)

    def _write_stock(self, folder: Path, network: str, size: Size | None, precision: str) -> None:
        from footprints_edge_export.architectures import ARCHITECTURES, canonical_focal_px
        from footprints_edge_models.networks.channels import MAX_DEPTH_M, MIN_DEPTH_M

        architecture = ARCHITECTURES[network]
        metadata = ModelMetadata(
            name=network,
            architecture=network,
            precision=precision,
            depth_range_m=(MIN_DEPTH_M, MAX_DEPTH_M),
            focal_px=canonical_focal_px(network, self._checkpoint(network)),
            resize=FILTER,
            licence=architecture.network.licence,
            source_sha256=self.weights_sha256(network),
            producer="stock tools",
            training=_TRAINING,
        )
        images = self.calibration_images(size or (256, 448)) if precision == "int8" else []
        whole = architecture.part(self.network(network), "all", 1).eval()
        write_stock(whole, metadata, size, images, folder / "model.onnx")


def part_of(precision: str) -> str:
    """The key of ``PARTS`` that a precision ends with, or an empty string."""
    return next((part for part in PARTS if precision.endswith(part)), "")


def outputs_of(precision: str) -> str:
    """The maps of a file: a key of ``footprints_edge.model_files.metadata.OUTPUTS``."""
    return PARTS[part][0] if (part := part_of(precision)) else "all"


def default_folder() -> Path:
    """Default folder for converted files, in the user's cache."""
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "footprints-edge" / "bench"


def _calibration_photos() -> list[Rgb]:
    return [synthetic_photo((480, 640), seed) for seed in range(CALIBRATION_PHOTOS)]


def _random_reference(folder: Path) -> None:
    import torch

    from footprints_edge_models.networks.reference import ReferenceNetwork

    photos = [preprocess(synthetic_photo((96, 128), seed), (96, 128)) for seed in range(4)]
    network = with_calibrated_random_weights(ReferenceNetwork(), photos)
    torch.save(network.state_dict(), folder / "weights.pt")


@cache
def _exporter_sha256() -> str:
    """SHA-256 of the source files that decide the result of a conversion."""
    import footprints_edge_export
    from footprints_edge_models.networks import channels, edge, efficientnet_lite0, reference

    exporter = Path(footprints_edge_export.__path__[0])
    networks = [
        Path(str(module.__file__)) for module in (edge, efficientnet_lite0, channels, reference)
    ]
    digest = hashlib.sha256()
    for path in (*sorted(exporter.rglob("*.py")), *networks):
        digest.update(path.read_bytes())
    return digest.hexdigest()
