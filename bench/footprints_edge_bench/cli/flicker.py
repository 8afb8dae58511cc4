"""``fp-bench flicker``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import Every, Frames, OneModel


def flicker_command(
    clips: Annotated[list[Path], typer.Argument(help="Folders of RGB-D clips with poses.")],
    *,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Also write the Markdown to this file.")
    ] = None,
    model: OneModel = None,
    frames: Frames = "0:1",
    every: Every = 1,
) -> None:
    """Measure how much maps flicker on RGB-D clips.

    Compares frame-by-frame prediction with smoothing, also in accuracy. Prints tables as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.model import load
        from footprints_edge_bench.ground_truth.datasets import Subset
        from footprints_edge_bench.temporal.flicker import SMOOTHINGS, as_markdown, measure

        loaded, subset = load(model), Subset.parse(frames, every)
        scores = {clip.resolve().name: measure(clip, subset, loaded, SMOOTHINGS) for clip in clips}
        markdown = as_markdown(scores)
        if output is not None:
            output.write_text(markdown, encoding="utf-8")
        typer.echo(markdown, nl=False)
