"""The interface of engines, which run model files, and the checks that they share."""

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol, SupportsIndex

from footprints_edge.errors import ModelError
from footprints_edge.foundation.cores import usable_cores
from footprints_edge.foundation.types import Floats, Rgb, Size

_MOST_THREADS = 256

MAX_SIDE_PX = 4096
"""Longest side of a fixed input size."""

MAX_PX = 2**22
"""Most pixels of a fixed input size: forty times as many as the usual one."""

_TOLERANCE = 1e-6
"""Values this far beyond 0 and 1 are rounding."""


class Engine(Protocol):
    """A loaded model file. `run` keeps no state, so many threads may share one engine.

    Attributes:
        path: The model file.
        sha256: SHA-256 of the bytes that were loaded.
        props: The file's `metadata_props`.
        input_size: Fixed (H, W) of the input, None if it takes any multiples of 32.
        threads: Threads that one `run` uses.
        providers: Devices or execution providers, by the engine's own names.
        runtime: Name and version of the engine.
    """

    path: Path
    sha256: str
    props: dict[str, str]
    input_size: Size | None
    threads: int
    providers: tuple[str, ...]
    runtime: str

    def run(self, image: Rgb) -> Floats:
        """One forward pass.

        Args:
            image: uint8 (1, H, W, 3), RGB; H and W are multiples of 32.

        Returns:
            float32 (1, 4, H, W): probabilities of visible ground and of ground, then the sigmoid
            disparities of the visible surface and of the ground (the paper's S, S*, D and D*); or
            two of these, see `metadata.OUTPUTS`.

        Raises:
            ModelError: If the pass fails, for example because memory runs out.
        """


def checked_threads(threads: int | None) -> int:
    """The number of threads; None means all cores that this process may use.

    Raises:
        ModelError: If the number is not between 1 and 256.
    """
    if threads is not None and not (
        isinstance(threads, SupportsIndex) and 1 <= threads <= _MOST_THREADS
    ):
        raise ModelError(f"threads is {threads!r}; give 1 to {_MOST_THREADS}, or leave it out")
    return threads or usable_cores()


def checked_input_size(
    path: Path, found: Sequence[tuple[str, str, Sequence[object]]]
) -> Size | None:
    """The fixed input size (H, W) of a graph, None if it is dynamic.

    Args:
        path: The model file, for the message.
        found: Name, type and shape of the inputs and outputs, in onnxruntime's terms; dynamic
            sides are anything but integers.

    Raises:
        ModelError: If the input or the output breaks the file contract.
    """
    match [(name, kind, list(shape)) for name, kind, shape in found]:
        case [
            ("image", "tensor(uint8)", [1, height, width, 3]),
            ("maps", "tensor(float)", [_, channels, _, _]),
        ] if channels in {2, 4} or not isinstance(channels, int):  # 2: see `metadata.OUTPUTS`
            pass
        case _:
            raise ModelError(
                f"{path} is an ONNX model with {_signature(found)}; expected image uint8 "
                "[1, H, W, 3] in and maps float32 [1, 4, H, W] out; convert one with: "
                "fp-export convert CHECKPOINT -o OUT.onnx --arch edge"
            )
    if not (isinstance(height, int) and isinstance(width, int)):
        return None
    sides = (height, width)
    if min(sides) < 1 or max(sides) > MAX_SIDE_PX or height * width > MAX_PX:
        raise ModelError(
            f"{path} has the fixed input size {sides}; sides up to {MAX_SIDE_PX} and {MAX_PX} "
            "pixels in all are possible; convert it again"
        )
    return sides


def checked_maps(path: Path, maps: Floats, size: Size) -> Floats:
    """What a network has given: maps of its input's size, from 0 to 1.

    Two reductions, some ten microseconds a map.

    Args:
        path: The model file, for the message.
        maps: What came out.
        size: (H, W) of the input.

    Raises:
        ModelError: If they are anything else.
    """
    if maps.ndim != 4 or maps.shape[0] != 1 or maps.shape[2:] != size:
        raise ModelError(
            f"{path} gives maps of the shape {maps.shape} for an input of {size}; expected "
            f"(1, 4, {size[0]}, {size[1]}); it is damaged, or no model of footprints-edge"
        )
    least, most = (maps.min(), maps.max()) if maps.size else (0.0, 0.0)
    if not (least >= -_TOLERANCE and most <= 1 + _TOLERANCE):  # NaN is neither
        raise ModelError(
            f"{path} gives values from {least:g} to {most:g}; maps are from 0 to 1: its weights "
            "are damaged"
        )
    return maps if least >= 0 and most <= 1 else maps.clip(0, 1)


def _signature(nodes: Sequence[tuple[str, str, Sequence[object]]]) -> str:
    return ", ".join(f"{name} {kind} {list(shape)}" for name, kind, shape in nodes)
