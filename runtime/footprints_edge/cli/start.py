"""Entry points of the commands: what must hold before the rest of a command is imported.

A second passes until everything is imported, and Ctrl-C in that second is Ctrl-C, too.
"""

import atexit
import codecs
import gc
import os
import signal
import sys
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper
from types import FrameType
from typing import Any

_INTERRUPTED = 130  # as `exit_codes.INTERRUPTED`, whose module imports more

_interrupted = False


def start(module: str) -> None:
    """Runs the function `main` of a command's module; ends with 130 when it is interrupted."""
    for name in ("SIGINT", "SIGTERM"):  # a stopped service ends as with Ctrl-C on a terminal
        number = getattr(signal, name)
        if signal.getsignal(number) in {signal.SIG_DFL, signal.default_int_handler}:
            signal.signal(number, _interrupt)
    # What modules are made of lives to the end: to look for garbage in it, while it is imported or
    # when the process ends, would be a fifth of `--help`.
    gc.disable()
    atexit.register(gc.freeze)
    try:
        prepare_streams()
        main = _imported(module).main
        gc.freeze()
        gc.enable()
        main()
    except BaseException:
        # whatever it has become on its way: C extensions make an ImportError of it
        if _interrupted:
            raise SystemExit(_INTERRUPTED) from None
        raise


def _imported(module: str) -> Any:  # noqa: ANN401 - a module
    """The module, which is not imported a second time where `python -m` runs it already."""
    running = sys.modules["__main__"]
    spec = getattr(running, "__spec__", None)
    return running if spec and spec.name == module else import_module(module)


def _interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001 - a signal handler
    global _interrupted  # noqa: PLW0603 - there is one process to end
    _interrupted = True
    raise KeyboardInterrupt


def prepare_streams() -> None:
    """Makes the standard streams safe to use, and able to print any file name.

    Where one is closed, as in a service or a program without a window, the next file that is opened
    would take its place, and messages would be written into it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            with suppress(OSError):
                os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
    codecs.register_error("file-name", _as_the_system_spells_it)
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="file-name")


def _as_the_system_spells_it(error: UnicodeError) -> tuple[bytes, int]:
    """Bytes of a file name that the stream's encoding lacks: names need not be valid text."""
    assert isinstance(error, UnicodeEncodeError)
    part = error.object[error.start : error.end]
    return part.encode("utf-8", "surrogateescape"), error.end


def infer() -> None:
    """Entry point of `fp-infer`."""
    start("footprints_edge.cli.infer_command")


def models() -> None:
    """Entry point of `fp-models`."""
    start("footprints_edge.cli.models")


def export() -> None:
    """Entry point of `fp-export`."""
    start("footprints_edge_export.cli")


def train() -> None:
    """Entry point of `fp-train`."""
    start("footprints_edge_models.cli")


def bench() -> None:
    """Entry point of `fp-bench`."""
    start("footprints_edge_bench.cli")
