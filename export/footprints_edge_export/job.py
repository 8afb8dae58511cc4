"""One conversion job: its checkpoint, photos and files, checked before any work begins."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from footprints_edge.foundation.types import Size
from footprints_edge_export.architectures import ARCHITECTURES, Architecture
from footprints_edge_export.errors import ExportError
from footprints_edge_export.graph.ort_format import operators_path
from footprints_edge_export.quantization.calibration import split_photos
from footprints_edge_export.report import Conversion, report_path
from footprints_edge_export.targets import TARGETS, ExportTarget

_FREE_SIZES: list[Size] = [(96, 128), (160, 96), (256, 448)]
"""Image sizes that a file of free input size is verified on."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A conversion that can be done.

    Attributes:
        checkpoint: file of a PyTorch state dict.
        conversion: what to make of it; its size is the target's where the caller named none.
        output: path of the model file.
        ort: path of the file in onnxruntime's format; None if the target or precision has none.
        calibration: photos that int8 is calibrated on.
        held_out: photos that the result is judged on.
    """

    checkpoint: Path
    conversion: Conversion
    output: Path
    ort: Path | None
    calibration: tuple[Path, ...]
    held_out: tuple[Path, ...]

    @classmethod
    def checked(
        cls, checkpoint: Path, output: Path, conversion: Conversion, *, overwrite: bool
    ) -> Self:
        """Check the options, the paths and the photos.

        Raises:
            ExportError: bad options, too few photos, or an output exists and ``overwrite`` is
                false.
            ImageError: a folder has no image.
        """
        target = TARGETS[conversion.target]
        conversion = replace(conversion, size=conversion.size or target.size)
        _check_options(conversion)
        if output.suffix != ".onnx":
            raise ExportError(f"{output}: a model file ends in .onnx")
        if not output.parent.is_dir():
            raise ExportError(f"{output.parent}: no such folder to write to")
        # The format's converter folds the casts of half precision: the result would be the fp32
        # file again.
        has_ort = target.ort_format and conversion.precision != "fp16"
        ort = output.with_suffix(".ort") if has_ort else None
        files = [output, report_path(output), *([] if ort is None else [ort, operators_path(ort)])]
        for path in files:
            if path.resolve() == checkpoint.resolve():
                raise ExportError(f"{path} is the checkpoint itself; name another output")
            if path.exists() and not overwrite:
                raise ExportError(f"{path} exists; --overwrite replaces it")
        folders = conversion.calibration if conversion.precision != "fp32" else ()
        calibration, held_out = split_photos(folders)
        return cls(
            checkpoint=checkpoint,
            conversion=conversion,
            output=output,
            ort=ort,
            calibration=tuple(calibration),
            held_out=tuple(held_out),
        )

    @property
    def architecture(self) -> Architecture:
        """The network's row in ``ARCHITECTURES``."""
        return ARCHITECTURES[self.conversion.architecture]

    @property
    def target(self) -> ExportTarget:
        """What the file is made for."""
        return TARGETS[self.conversion.target]

    @property
    def test_sizes(self) -> list[Size]:
        """(H, W) of the images that the files are verified on."""
        return [self.conversion.size] if self.conversion.size else _FREE_SIZES


def _check_options(conversion: Conversion) -> None:
    if conversion.precision == "int8" and not conversion.calibration:
        raise ExportError("int8 needs photos to calibrate on, 100 or more: --calibration DIR")
    scales = ARCHITECTURES[conversion.architecture].scales
    if conversion.scale not in scales:
        raise ExportError(
            f"scale {conversion.scale}: {conversion.architecture} has trained heads of scale "
            f"{', '.join(map(str, scales))} only"
        )
    size = conversion.size
    if size and (min(size) < 64 or any(side % 32 for side in size)):
        raise ExportError(f"size {size}: both sides must be multiples of 32, from 64 on")
