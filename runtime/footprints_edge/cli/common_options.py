"""What every command has: its settings, and --version."""

from typing import Annotated

import typer

HELP = {"help_option_names": ["-h", "--help"]}
"""Settings of every command."""


def show_version(wanted: bool) -> None:
    """Callback of --version: prints the version and ends the command."""
    if wanted:
        from footprints_edge.foundation.version import __version__

        typer.echo(f"footprints-edge {__version__}")
        raise typer.Exit


VersionOption = Annotated[
    bool,
    typer.Option("--version", callback=show_version, is_eager=True, help="Show the version."),
]
