"""The command `fp-models`: lists, describes and checks models, and checks this machine."""

from typing import Annotated

import typer

from footprints_edge.cli.common_options import HELP, VersionOption
from footprints_edge.cli.exit_codes import MODEL_PROBLEM, complain, explained

app = typer.Typer(
    context_settings=HELP,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
)
ModelArgument = Annotated[
    str | None, typer.Argument(help="Name or file. Default: the bundled one.")
]


@app.callback()
def models(
    _version: VersionOption = False,
) -> None:
    """Show and check the models that fp-infer runs."""


@app.command("list")
def list_models() -> None:
    """List the models that come with the package."""
    with explained():
        from footprints_edge.model_files.registry import bundled_models

        entries = bundled_models()
        for entry in entries:
            mark = " (default)" if entry.default else ""
            size_mb = entry.bytes / 1e6
            typer.echo(
                f"{entry.name}{mark}\t{size_mb:.1f} MB\t{entry.licence}\t{entry.description}"
            )
        if not entries:
            complain("This installation bundles no model.")


@app.command()
def info(model: ModelArgument = None) -> None:
    """Show the metadata of a model file."""
    with explained():
        from footprints_edge.model import load

        loaded = load(model)
        size = loaded.engine.input_size
        near_m, far_m = loaded.metadata.depth_range_m
        focal_px = loaded.metadata.focal_px
        facts = {
            "name": loaded.name,
            "file": loaded.path,
            "bytes": loaded.path.stat().st_size,
            "sha256": loaded.sha256,
            "architecture": loaded.metadata.architecture,
            "precision": loaded.metadata.precision,
            "input": f"{size[0]} x {size[1]} (H x W)" if size else "follows the picture",
            "depths": f"{near_m:g} to {far_m:g} m",
            "camera": f"focal length {focal_px:g} px" if focal_px else "as trained",
            "licence": loaded.metadata.licence,
            "training": loaded.metadata.training,
            "source sha256": loaded.metadata.source_sha256,
            "producer": loaded.metadata.producer,
            "format": loaded.metadata.format,
        }
        for key, value in facts.items():
            typer.echo(f"{key}: {value}")


@app.command()
def verify(
    names: Annotated[
        list[str] | None, typer.Argument(help="Names or files. Default: all bundled models.")
    ] = None,
) -> None:
    """Check that model files are intact and load. Exit code 3 if one fails."""
    with explained():
        from footprints_edge.errors import ModelError
        from footprints_edge.model import load
        from footprints_edge.model_files.registry import bundled_models

        wanted = names or [entry.name for entry in bundled_models()]
        if not wanted:
            raise ModelError("this installation bundles no model; give a file to verify")
        damaged = 0
        for name in wanted:
            try:
                model = load(name)
            except ModelError as error:
                damaged += 1
                complain(f"{name}: {error}")
            else:
                typer.echo(f"{name}: whole, sha256 {model.sha256}")
        if damaged:
            raise typer.Exit(MODEL_PROBLEM)


@app.command()
def doctor(model: ModelArgument = None) -> None:
    """Check this machine: versions, processor, cores, providers, and timing of a model."""
    with explained():
        from footprints_edge.cli.doctor import advice, machine_facts, time_model
        from footprints_edge.model import load

        facts = machine_facts()
        for key, value in facts.items():
            typer.echo(f"{key}: {value}")
        loaded = load(model)
        timing = time_model(loaded)
        typer.echo(f"model: {loaded.name} ({loaded.metadata.precision}), {loaded.path}")
        typer.echo(f"network: {timing}")
        for line in advice(loaded.metadata.precision):
            typer.echo(f"advice: {line}")


def main() -> None:
    """Runs `fp-models`; see `start`."""
    app()


if __name__ == "__main__":
    from footprints_edge.cli.start import start

    start("footprints_edge.cli.models")
