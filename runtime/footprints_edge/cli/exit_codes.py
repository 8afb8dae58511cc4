"""How commands end: exit codes, and messages instead of tracebacks."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from footprints_edge.errors import FootprintsError, ModelError

SOME_FAILED = 1
USAGE = 2
MODEL_PROBLEM = 3
INTERRUPTED = 130  # what shells report for SIGINT
_BROKEN_PIPE = 141  # and for SIGPIPE


@contextmanager
def explained(extra: str | None = None) -> Iterator[None]:
    """Turns what stops a command into a message on stderr and an exit code.

    Args:
        extra: The optional part of the package that the command needs; a module that is missing
            is then one of its.
    """
    try:
        yield
    except ModelError as error:
        complain(f"Error: {error}")
        raise typer.Exit(MODEL_PROBLEM) from None
    except FootprintsError as error:
        complain(f"Error: {error}")
        raise typer.Exit(USAGE) from None
    except ModuleNotFoundError as error:
        if extra is None:
            raise
        install = f"pip install 'footprints-edge[{extra}]'"
        complain(f"Error: this needs the package {error.name}; install it with: {install}")
        raise typer.Exit(USAGE) from None
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(_BROKEN_PIPE) from None
    except OSError as error:  # a folder that cannot be made, a disk that is full
        complain(f"Error: {error}")
        raise typer.Exit(USAGE) from None


def complain(message: str) -> None:
    """Writes a message to stderr."""
    typer.echo(message, err=True)


def show_version(wanted: bool) -> None:
    """Prints the version and ends the command, if asked to."""
    if wanted:
        from footprints_edge.foundation.version import __version__

        typer.echo(f"footprints-edge {__version__}")
        raise typer.Exit
