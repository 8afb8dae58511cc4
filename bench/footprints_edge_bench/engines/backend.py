"""What a contender is asked to run, and what it is once it runs."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Floats, Rgb, Size
from footprints_edge_bench.model_files.model_cache import ModelCache


class EngineError(FootprintsError):
    """An engine that cannot run what it is asked to."""


class Spinning(StrEnum):
    """What onnxruntime's threads do while they wait; other engines have no such choice.

    ``SHIPPED`` is what the runtime package does: they spin within a frame, and sleep after it.
    """

    SHIPPED = "shipped"
    ON = "on"
    OFF = "off"


@dataclass(frozen=True)
class Backend:
    """One row: a network at a size, in an engine, at a precision.

    Attributes:
        network: ``edge``, ``reference``, or the path of a model file.
        size: (H, W) of the network's input.
        engine: key of ``ENGINES``.
        precision: what the engine is asked for; ``Running.precision`` says what it does.
    """

    network: str
    size: Size
    engine: str
    precision: str

    @property
    def name(self) -> str:
        """Such as ``reference 192x640 openvino bf16``."""
        return f"{self.network} {self.size[0]}x{self.size[1]} {self.engine} {self.precision}"


@dataclass(frozen=True)
class BackendSetting:
    """How contenders are run.

    Attributes:
        files: where their model files come from.
        threads: of one frame.
        spinning: of onnxruntime's threads.
    """

    files: ModelCache
    threads: int
    spinning: Spinning = Spinning.SHIPPED


@dataclass(frozen=True)
class LoadedBackend:
    """A contender that is loaded.

    Attributes:
        run: uint8 (1, H, W, 3) to maps float32 (1, 4, H, W), as a model file of ours does.
        precision: read back from the engine: what its convolutions compute in, and how many.
        file_bytes: size of its model files; None where it has none of its own.
    """

    run: Callable[[Rgb], Floats]
    precision: str
    file_bytes: int | None


def counted(kinds: dict[str, int]) -> str:
    """Convolutions by precision, most first: ``int8 (52 convolutions; float32 4)``."""
    (first, most), *others = sorted(kinds.items(), key=lambda item: -item[1]) or [("unknown", 0)]
    rest = "".join(f"; {kind} {count}" for kind, count in others)
    return f"{first} ({most} convolutions{rest})"
