"""``fp-bench``: how accurate the models are, and how fast."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.endings import SOME_FAILED, complain, explained

app = typer.Typer(
    name="fp-bench",
    help="Measure the models of footprints-edge.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
)


@app.callback()
def _root() -> None:
    """Measure the models of footprints-edge."""


@app.command()
def accuracy(
    data: Annotated[
        list[Path],
        typer.Argument(
            help="Folders: RGB-D clips, KITTI or Matterport truth, labelled photos; see "
            "docs/accuracy.md."
        ),
    ],
    *,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", help="Folder of the results; an unfinished run goes on."),
    ] = Path("accuracy"),
    model: Annotated[
        list[str] | None,
        typer.Option(help="Model file, or a name that fp-models list shows; repeat for more."),
    ] = None,
    images: Annotated[
        Path | None,
        typer.Option(help="Where KITTI's or Matterport's pictures are: a folder, or KITTI's list."),
    ] = None,
    walkable: Annotated[
        str, typer.Option(metavar="ID,…", help="Class ids of ground in labelled photos.")
    ] = "",
    void: Annotated[str, typer.Option(metavar="ID,…", help="Class ids that are not scored.")] = "",
    frames: Annotated[
        str, typer.Option(metavar="A:B", help="Part of each dataset; 0.8:1 is the last fifth.")
    ] = "0:1",
    every: Annotated[int, typer.Option(min=1, help="Score every so manieth image only.")] = 1,
    boxes: Annotated[
        Path | None, typer.Option(help="JSON of oriented boxes, for the box baseline.")
    ] = None,
    voxels: Annotated[
        Path | None, typer.Option(help="Folder of voxel grids, for the voxel baselines.")
    ] = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Throw away the results that are there already.")
    ] = False,
) -> None:
    """Score models and the paper's baselines; prints the tables as Markdown.

    Exit codes: 0 all done, 1 some images failed, 2 wrong usage, 3 problem with the model.
    """
    with explained("bench"):
        from tqdm import tqdm

        from footprints_edge.model import load
        from footprints_edge_bench.accuracy import (
            Benchmark,
            Extras,
            evaluate,
            name_models,
            write_reports,
        )
        from footprints_edge_bench.boxes import read_boxes
        from footprints_edge_bench.datasets import Part, Reading, open_datasets
        from footprints_edge_bench.results import Results

        reading = Reading(images, _ids(walkable, "--walkable"), _ids(void, "--void"))
        if voxels is not None and not voxels.is_dir():
            raise typer.BadParameter(f"--voxels {voxels} is no folder")
        benchmark = Benchmark(
            open_datasets(data, reading, Part.parse(frames, every)),
            name_models([load(name) for name in model] if model else [load()]),
            Extras({} if boxes is None else read_boxes(boxes), boxes, voxels),
            {
                "frames": frames,
                "every": every,
                "walkable": list(reading.walkable),
                "void": list(reading.void),
            },
        )
        results = Results(output / "results.jsonl", benchmark.settings(), fresh=fresh)
        with tqdm(total=len(benchmark.items()), unit="image", disable=None) as bar:

            def progress(name: str) -> None:
                bar.set_postfix_str(name, refresh=False)
                bar.update()

            failures = evaluate(benchmark, results, progress)
        typer.echo(write_reports(benchmark, results, failures, output), nl=False)
        for name, reason in failures.items():
            complain(f"Skipped {name}: {reason}")
        if failures:
            complain(f"{len(failures)} of {len(benchmark.items())} images failed.")
            raise typer.Exit(SOME_FAILED)


def main() -> None:
    """Entry point of ``fp-bench``."""
    app()


def _ids(text: str, option: str) -> tuple[int, ...]:
    """Class ids from text such as ``3,4``."""
    try:
        return tuple(int(part) for part in text.replace(",", " ").split())
    except ValueError:
        raise typer.BadParameter(f"{option} {text!r}: give class ids, such as 3,4") from None


if __name__ == "__main__":
    main()
