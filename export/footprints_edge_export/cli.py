"""``fp-export``: checkpoints to model files, and how far two model files are apart."""

import json
import logging
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.endings import complain, explained

app = typer.Typer(
    name="fp-export",
    help="Turn a trained network into a verified model file.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    add_completion=False,
)


class Arch(StrEnum):
    """Networks that can be exported."""

    EDGE = "edge"
    REFERENCE = "reference"


class Precision(StrEnum):
    """Of weights and activations; the last layer is float in both."""

    FP32 = "fp32"
    INT8 = "int8"


class Target(StrEnum):
    """Kind of CPU that int8 is for."""

    X86_VNNI = "x86-vnni"
    X86_AVX2 = "x86-avx2"
    ARM64 = "arm64"


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None or text == "dynamic":
        return None
    try:
        height, width = (int(side) for side in text.lower().split("x"))
    except ValueError as error:
        raise typer.BadParameter(
            f"{text!r} is not HxW, such as 256x448", param_hint="--size"
        ) from error
    return height, width


@app.command("convert")
def convert_command(
    checkpoint: Annotated[Path, typer.Argument(help="PyTorch state dict, such as model.pth.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Model file to write.")],
    arch: Annotated[Arch, typer.Option(help="Network of the checkpoint.")],
    size: Annotated[
        str | None, typer.Option(metavar="HxW", help="Fix the input size.  [default: any]")
    ] = None,
    precision: Annotated[Precision, typer.Option()] = Precision.FP32,
    calibration: Annotated[
        list[Path] | None,
        typer.Option(help="Folder of photos that int8 is calibrated on; may be repeated."),
    ] = None,
    target: Annotated[Target, typer.Option(help="CPU that int8 is for.")] = Target.X86_VNNI,
    name: Annotated[str | None, typer.Option(help="Name in the file.  [default: OUT]")] = None,
    licence: Annotated[str | None, typer.Option(help="Licence of the weights.")] = None,
    training: Annotated[str, typer.Option(help="On what they were trained.")] = "unstated",
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the output.")] = False,
) -> None:
    """Convert CHECKPOINT to a model file, verify it, and write a report beside it, OUT.onnx.json.

    Exit codes: 2 wrong usage, 3 problem with the checkpoint or with what came of it.
    """
    with explained("export"):
        from .architectures import ARCHITECTURES
        from .convert import Conversion, convert

        if notice := ARCHITECTURES[arch].notice:
            complain(notice)
        conversion = Conversion(
            arch.value,
            _size(size),
            precision.value,
            tuple(calibration or ()),
            target.value,
            name or output.stem,
            licence,
            training,
        )
        report = convert(checkpoint, output, conversion, overwrite=overwrite)
        if report.fp32_to_int8 is not None:
            complain("int8 against fp32 on held-out photos:")
            for key, value in report.fp32_to_int8.items():
                complain(f"  {key}: {value}")
        typer.echo(output)


@app.command()
def verify(
    model_a: Annotated[Path, typer.Argument(metavar="A", help="Model file to compare with.")],
    model_b: Annotated[Path, typer.Argument(metavar="B", help="Model file that is compared.")],
    images: Annotated[Path, typer.Option(help="Folder of photos.")],
) -> None:
    """Print how far two model files' maps are apart, as JSON."""
    with explained("export"):
        from footprints_edge.model import load

        from .compare import compare_models
        from .errors import ExportError
        from .photos import list_photos, network_inputs, spread

        a, b = load(model_a), load(model_b)
        fixed = [model for model in (a, b) if model.session.input_size]
        sizes = sorted({size for model in fixed if (size := model.session.input_size)})
        if len(sizes) > 1:
            raise ExportError(f"the two models are fixed to different sizes: {sizes}")
        paths = spread(list_photos(images, at_least=1), 200)
        difference = compare_models(a, b, network_inputs(paths, next(iter(fixed), a)))
        typer.echo(json.dumps(difference.as_dict(), indent=2))


def main() -> None:
    """Entry point of ``fp-export``."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    logging.getLogger("footprints_edge_export").setLevel(logging.INFO)
    app()


if __name__ == "__main__":
    main()
