"""``fp-train assets``: 3D models, worlds, textures and panoramas in one file."""

import json
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import complain, explained


def assets(
    folders: Annotated[
        list[Path],
        typer.Argument(
            exists=True,
            file_okay=False,
            help="Folders with Sweet Home 3D catalogues (.sh3f), GLB objects and worlds, textures "
            "and panoramas.",
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="The pack, a .zip file.")],
    triangles: Annotated[
        int, typer.Option(min=100, help="Models with more triangles are simplified to about these.")
    ] = 4000,
    texture_px: Annotated[
        int,
        typer.Option(
            min=16, max=512, help="Longest side of the textures of models, and of worlds if < 256."
        ),
    ] = 256,
    quiet: Annotated[
        bool, typer.Option("-q", "--quiet", help="Do not list the assets that were skipped.")
    ] = False,
) -> None:
    """Read all assets below folders and pack them into one file; print a summary as JSON."""
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge_models.asset_files.pack import pack_assets

        with tqdm(unit="asset", disable=None) as bar:
            report = pack_assets(
                folders,
                output,
                lambda _: bar.update(),
                most_triangles=triangles,
                texture_px=texture_px,
            )
        if not quiet:
            for reason in report.skipped:
                complain(f"skipped: {reason}")
        summary = {
            "assets": str(output),
            **{f"{kind}s": count for kind, count in sorted(report.counts.items())},
            "skipped": len(report.skipped),
            "bytes": output.stat().st_size,
        }
        typer.echo(json.dumps(summary))
