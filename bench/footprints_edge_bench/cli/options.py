"""Options that several commands share."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from footprints_edge.foundation.types import Size

EDGE_CHECKPOINT = Path("models/weights/edge.pt")

Models = Annotated[
    list[str] | None,
    typer.Option(
        "--model",
        help="Model file, or a name from fp-models list; repeatable.  [default: the bundled model]",
    ),
]
OneModel = Annotated[
    str | None,
    typer.Option(
        "--model", help="Model file, or a name from fp-models list.  [default: the bundled model]"
    ),
]
ExactData = Annotated[
    list[Path],
    typer.Argument(
        help="Folders with ground truth of all four maps: synthetic scenes, RGB-D clips."
    ),
]
Frames = Annotated[
    str,
    typer.Option(metavar="A:B", help="Part of each dataset, such as 0.8:1 for the last fifth."),
]
Every = Annotated[int, typer.Option(min=1, metavar="N", help="Use every Nth image.")]
HeldOut = Annotated[
    bool,
    typer.Option(
        "--held-out", help="Use only images that fp-train edge holds out of datasets it knows."
    ),
]
Threads = Annotated[
    int | None,
    typer.Option(min=1, max=256, help="Threads for one frame.  [default: all usable cores]"),
]
JsonFile = Annotated[
    Path | None, typer.Option("-o", "--output", help="Also write the results as JSON to this file.")
]
EdgeCheckpoint = Annotated[
    Path, typer.Option(help="Checkpoint of the edge network, for its float32 rows.")
]
CacheFolder = Annotated[
    Path | None,
    typer.Option(
        "--cache", help="Folder that keeps converted models.  [default: the user's cache]"
    ),
]
Only = Annotated[
    list[str] | None,
    typer.Option(metavar="TEXT", help="Run only rows whose name contains this text; repeatable."),
]
FurtherModels = Annotated[
    list[str] | None,
    typer.Option("--model", help="Also run this model file, in onnxruntime; repeatable."),
]
ReferenceSizes = Annotated[
    list[str] | None,
    typer.Option(
        "--size",
        metavar="HxW",
        help="Input size of the reference network; repeatable.  [default: the paper's presets]",
    ),
]


def network_size(text: str) -> "Size":
    """Input size (H, W) of a network from text such as ``192x640``.

    Raises:
        typer.BadParameter: the text is not a size, or a network cannot have it.
    """
    from footprints_edge.foundation.size_text import parse_size

    try:
        height, width = parse_size(text)
    except ValueError as error:
        raise typer.BadParameter(f"--size: {error}") from None
    if min(height, width) < 64 or height % 32 or width % 32:
        raise typer.BadParameter(
            f"--size {text}: give a height and a width that are multiples of 32, at least 64"
        )
    return height, width


def class_ids(text: str, option: str) -> tuple[int, ...]:
    """Class ids from text such as ``3,4``.

    Raises:
        typer.BadParameter: the text holds something else.
    """
    try:
        return tuple(int(part) for part in text.replace(",", " ").split())
    except ValueError:
        raise typer.BadParameter(f"{option} {text!r}: give class ids, such as 3,4") from None
