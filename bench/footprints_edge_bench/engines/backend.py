"""Backends: a network in an engine, as requested and as loaded."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge_bench.model_files.model_cache import ModelCache


class BackendError(FootprintsError):
    """An engine cannot run what it is asked to."""


class Spinning(StrEnum):
    """What onnxruntime's threads do while they wait; other engines ignore it.

    ``SHIPPED`` is the setting of the runtime package: threads spin within a frame and sleep after
    it.
    """

    SHIPPED = "shipped"
    ON = "on"
    OFF = "off"


@dataclass(frozen=True)
class Backend:
    """One row of a table: a network at an input size, in an engine, at a precision.

    Attributes:
        network: ``edge``, ``reference``, or the path of a model file.
        size: (H, W) of the network's input.
        engine: key of ``ENGINES``.
        precision: the requested precision; ``LoadedBackend.precision`` is the one in use.
    """

    network: str
    size: Size
    engine: str
    precision: str

    @property
    def name(self) -> str:
        """Name of the row, such as ``reference 192x640 openvino bf16``."""
        return f"{self.network} {self.size[0]}x{self.size[1]} {self.engine} {self.precision}"


@dataclass(frozen=True)
class BackendSetting:
    """How backends are run.

    Attributes:
        cache: supplies their model files.
        threads: threads for one frame.
        spinning: what onnxruntime's threads do while they wait.
    """

    cache: ModelCache
    threads: int
    spinning: Spinning = Spinning.SHIPPED


@dataclass(frozen=True)
class LoadedBackend:
    """A backend that is ready to run.

    Attributes:
        run: maps an image, uint8 (1, H, W, 3), to maps, float32 (1, 4, H, W), as model files do.
        precision: the precision of its convolutions and their number, read back from the engine.
        file_bytes: size of its model files; None where it has none of its own.
    """

    run: Callable[[Rgb], Floats]
    precision: str
    file_bytes: int | None


def describe_precisions(convolutions: dict[str, int]) -> str:
    """Convolutions by precision, most frequent first: ``int8 (52 convolutions; float32 4)``."""
    ranked = sorted(convolutions.items(), key=lambda item: -item[1]) or [("unknown", 0)]
    (first, most), *others = ranked
    rest = "".join(f"; {precision} {count}" for precision, count in others)
    return f"{first} ({most} convolutions{rest})"
