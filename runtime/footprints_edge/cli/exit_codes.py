"""Exit codes of the commands, and messages instead of tracebacks.

Without typer, which usual runs of `fp-infer` do not load.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

from footprints_edge.errors import FootprintsError, ModelError

SOME_FAILED = 1
USAGE = 2
MODEL_PROBLEM = 3
INTERRUPTED = 130  # as shells report SIGINT
_BROKEN_PIPE = 141  # as shells report SIGPIPE


class OptionError(ValueError):
    """Options that do not go together, or a value that one cannot have; typer explains it."""


@contextmanager
def explained(extra: str | None = None) -> Iterator[None]:
    """Turns an exception that ends a command into a message on stderr and an exit code.

    Args:
        extra: The extra that the command needs; a missing module is taken for one of its packages.
    """
    try:
        yield
    except ModelError as error:
        complain(f"Error: {error}")
        raise SystemExit(MODEL_PROBLEM) from None
    except FootprintsError as error:
        complain(f"Error: {error}")
        raise SystemExit(USAGE) from None
    except ModuleNotFoundError as error:
        if extra is None:
            raise
        from footprints_edge.foundation.install_hint import install_hint

        complain(f"Error: this needs the package {error.name}; {install_hint(extra)}")
        raise SystemExit(USAGE) from None
    except ImportError as error:
        if not (error.path or "").endswith(tuple(EXTENSION_SUFFIXES)):
            raise
        complain(f"Error: a library cannot be loaded: {error}")  # such as for want of memory
        raise SystemExit(SOME_FAILED) from None
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None
    except MemoryError:
        complain("Error: there is not enough memory; give fewer threads or smaller inputs")
        raise SystemExit(SOME_FAILED) from None
    except BrokenPipeError:  # the reader, such as `head`, has closed the pipe
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(_BROKEN_PIPE) from None
    except OSError as error:  # such as a folder that cannot be created, or a full disk
        complain(f"Error: {error}")
        raise SystemExit(USAGE) from None


def complain(message: str) -> None:
    """Writes a message to stderr."""
    sys.stderr.write(f"{message}\n")
    sys.stderr.flush()


def name_file(path: Path) -> None:
    """Prints a file that was written; see `start.prepare_streams` for odd names."""
    sys.stdout.write(f"{path}\n")
    sys.stdout.flush()
