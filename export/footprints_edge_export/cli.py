"""``fp-export``: checkpoints to model files, how far two of them are apart, and test vectors."""

import json
import logging
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained

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
    """Of weights and activations; fp16 is of weights only, and int8 keeps the last layer float."""

    FP32 = "fp32"
    FP16 = "fp16"
    INT8 = "int8"


class Outputs(StrEnum):
    """Maps that a file has."""

    ALL = "all"
    MASKS = "masks"
    DEPTHS = "depths"


class Target(StrEnum):
    """What the file is for."""

    X86_VNNI = "x86-vnni"
    X86_AVX2 = "x86-avx2"
    ARM64 = "arm64"
    WEB = "web"
    MOBILE = "mobile"


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
    target: Annotated[Target, typer.Option(help="What the file is for.")] = Target.X86_VNNI,
    name: Annotated[str | None, typer.Option(help="Name in the file.  [default: OUT]")] = None,
    licence: Annotated[str | None, typer.Option(help="Licence of the weights.")] = None,
    training: Annotated[str, typer.Option(help="On what they were trained.")] = "unstated",
    outputs: Annotated[Outputs, typer.Option(help="Maps that the file has.")] = Outputs.ALL,
    scale: Annotated[
        int, typer.Option(help="Of the head: 2 or 4 for reference's coarser, faster ones.")
    ] = 1,
    focal_px: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            help="Focal length, pixels of the input, of the camera that its depths are for.  "
            "[default: edge 400; reference: depths as trained]",
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the output.")] = False,
) -> None:
    """Convert CHECKPOINT to a model file, verify it, and write a report beside it, OUT.onnx.json.

    Exit codes: 2 wrong usage, 3 problem with the checkpoint or with what came of it.
    """
    with explained("export"):
        from footprints_edge_export.architectures import ARCHITECTURES
        from footprints_edge_export.convert import Conversion, convert

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
            outputs.value,
            scale,
            focal_px,
        )
        report = convert(checkpoint, output, conversion, overwrite=overwrite)
        compared = {
            "fp16 against fp32": report.fp32_to_fp16,
            "int8 against fp32": report.fp32_to_int8,
            ".ort against .onnx": report.model_to_ort,
        }
        for kind, difference in compared.items():
            if difference is not None:
                complain(f"{kind}:")
                for key, value in difference.items():
                    complain(f"  {key}: {value}")
        for file in filter(None, (report.model, report.ort)):
            complain(f"{file['file']}: {file['bytes']} bytes")
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
        from footprints_edge_export.errors import ExportError
        from footprints_edge_export.quantization.calibration import (
            list_photos,
            network_inputs,
            spread,
        )
        from footprints_edge_export.verification.compare import compare_models

        a, b = load(model_a), load(model_b)
        fixed = [model for model in (a, b) if model.engine.input_size]
        sizes = sorted({size for model in fixed if (size := model.engine.input_size)})
        if len(sizes) > 1:
            raise ExportError(f"the two models are fixed to different sizes: {sizes}")
        paths = spread(list_photos(images, at_least=1), 200)
        difference = compare_models(a, b, network_inputs(paths, next(iter(fixed), a)))
        typer.echo(json.dumps(difference.as_dict(), indent=2))


@app.command("vectors")
def vectors_command(
    model: Annotated[str, typer.Argument(help="Model file, or a name that fp-models list shows.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the vectors.")],
    photo: Annotated[
        Path | None, typer.Option(help="Photo to cut them from.  [default: examples/room.jpg]")
    ] = None,
) -> None:
    """Write test vectors of MODEL, for ports to other languages, and print the files."""
    with explained("export"):
        from footprints_edge.model import load
        from footprints_edge_export.verification.test_vectors import EXAMPLE_PHOTO, write_vectors

        for path in write_vectors(load(model), output, photo or EXAMPLE_PHOTO):
            typer.echo(path)


@app.command("check-vectors")
def check_vectors_command(
    vectors: Annotated[Path, typer.Argument(help="Folder that fp-export vectors wrote.")],
    outputs: Annotated[Path, typer.Argument(help="Folder that a port wrote, the same way.")],
) -> None:
    """Hold what a port wrote against test vectors, a line a quantity.

    Exit codes: 1 if one differs, 2 wrong usage.
    """
    with explained("export"):
        from footprints_edge_export.verification.check_vectors import check_vectors

        findings = check_vectors(vectors, outputs)
        for finding in findings:
            typer.echo(finding)
        differ = sum(not finding.holds for finding in findings)
        complain(f"{differ} of {len(findings)} comparisons differ" if differ else "all hold")
        if differ:
            raise typer.Exit(SOME_FAILED)


def main() -> None:
    """Entry point of ``fp-export``."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    logging.getLogger("footprints_edge_export").setLevel(logging.INFO)
    app()


if __name__ == "__main__":
    main()
