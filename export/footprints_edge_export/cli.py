"""``fp-export``: convert checkpoints, compare model files, write and check test vectors."""

import json
import logging
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.common_options import HELP, VersionOption
from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge.foundation.size_text import parse_size
from footprints_edge.foundation.types import Size

app = typer.Typer(
    name="fp-export",
    help="Turn a trained network into a verified model file.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=HELP,
)


@app.callback()
def _root(_version: VersionOption = False) -> None:
    """Turn a trained network into a verified model file."""


class ArchitectureName(StrEnum):
    """Networks that can be exported."""

    EDGE = "edge"
    REFERENCE = "reference"


class FilePrecision(StrEnum):
    """Precision of a file: fp16 applies to weights only, int8 keeps the last layer float."""

    FP32 = "fp32"
    FP16 = "fp16"
    INT8 = "int8"


class OutputMaps(StrEnum):
    """Maps that a file has."""

    ALL = "all"
    MASKS = "masks"
    DEPTHS = "depths"


class TargetName(StrEnum):
    """Kinds of processors and runtimes that a file can be made for."""

    X86_VNNI = "x86-vnni"
    X86_AVX2 = "x86-avx2"
    ARM64 = "arm64"
    WEB = "web"
    MOBILE = "mobile"


def _size(text: str | None) -> Size | None:
    if text is None or text == "dynamic":
        return None
    try:
        return parse_size(text)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--size") from error


@app.command("convert")
def convert_command(
    checkpoint: Annotated[Path, typer.Argument(help="PyTorch state dict, such as model.pth.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Model file to write.")],
    arch: Annotated[ArchitectureName, typer.Option(help="Network of the checkpoint.")],
    size: Annotated[
        str | None, typer.Option(metavar="HxW", help="Fix the input size.  [default: any]")
    ] = None,
    precision: Annotated[
        FilePrecision, typer.Option(help="Precision of weights and activations.")
    ] = FilePrecision.FP32,
    calibration: Annotated[
        list[Path] | None,
        typer.Option(help="Folder of photos to calibrate int8 on; may be repeated."),
    ] = None,
    target: Annotated[
        TargetName, typer.Option(help="Processor or runtime to make the file for.")
    ] = TargetName.X86_VNNI,
    name: Annotated[str | None, typer.Option(help="Name of the model.  [default: OUT]")] = None,
    licence: Annotated[str | None, typer.Option(help="Licence of the weights.")] = None,
    training: Annotated[
        str | None,
        typer.Option(help="Training data of the weights.  [default: as their credits say]"),
    ] = None,
    outputs: Annotated[OutputMaps, typer.Option(help="Maps that the file has.")] = OutputMaps.ALL,
    scale: Annotated[
        int,
        typer.Option(help="Decoder scale: 1, or 2 or 4 for coarser, faster maps (reference only)."),
    ] = 1,
    focal_px: Annotated[
        float | None,
        typer.Option(
            min=1.0,
            help="Focal length, in input pixels, of the camera that the depths are for.  "
            "[default: as CHECKPOINT states; else edge 400, reference: depths as trained]",
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the output.")] = False,
) -> None:
    """Convert CHECKPOINT to a model file, verify it, and write a report beside it, OUT.onnx.json.

    Exit codes: 2 wrong usage, 3 problem with the checkpoint or with the result.
    """
    with explained("export"):
        from footprints_edge_export.architectures import ARCHITECTURES
        from footprints_edge_export.convert import convert
        from footprints_edge_export.report import Conversion

        if notice := ARCHITECTURES[arch].network.notice:
            complain(notice)
        conversion = Conversion(
            architecture=arch.value,
            size=_size(size),
            precision=precision.value,
            calibration=tuple(calibration or ()),
            target=target.value,
            name=name or output.stem,
            licence=licence,
            training=training,
            outputs=outputs.value,
            scale=scale,
            focal_px=focal_px,
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


@app.command("credits")
def credits_command(
    checkpoint: Annotated[Path, typer.Argument(help="Weights that fp-train wrote.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="File to write.  [default: print it]")
    ] = None,
) -> None:
    """Write the credits section of a model card: whom to name for what WEIGHTS were trained on.

    Markdown, with title, author, licence and source of every data set and asset, by licence. Exit
    codes: 2 wrong usage, 3 the weights state no credits.
    """
    with explained("export"):
        from footprints_edge.errors import ModelError
        from footprints_edge.foundation.atomic_write import write_atomically
        from footprints_edge_export.credits_section import credits_section
        from footprints_edge_models.networks.checkpoint import read_checkpoint
        from footprints_edge_models.training.weight_credits import stated_credits

        found = stated_credits(read_checkpoint(checkpoint), str(checkpoint))
        if not found:
            raise ModelError(
                f"{checkpoint}: states no credits; the run's credits.json, if there is one, does"
            )
        section = credits_section(found)
        if output is None:
            typer.echo(section)
        else:
            write_atomically(output, section.encode())
            typer.echo(output)


@app.command()
def verify(
    model_a: Annotated[Path, typer.Argument(metavar="A", help="Model file to compare against.")],
    model_b: Annotated[Path, typer.Argument(metavar="B", help="Model file to compare.")],
    images: Annotated[Path, typer.Option(help="Folder of photos to run both models on.")],
) -> None:
    """Print the differences between the maps of two model files, as JSON."""
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
        Path | None,
        typer.Option(help="Photo to cut the images from.  [default: a room in the package]"),
    ] = None,
) -> None:
    """Write test vectors of MODEL for ports to other languages, and print their paths."""
    with explained("export"):
        from footprints_edge.model import load
        from footprints_edge_export.verification.test_vectors import EXAMPLE_PHOTO, write_vectors

        for path in write_vectors(load(model), output, photo or EXAMPLE_PHOTO):
            typer.echo(path)


@app.command("check-vectors")
def check_vectors_command(
    vectors: Annotated[Path, typer.Argument(help="Folder that fp-export vectors wrote.")],
    outputs: Annotated[
        Path, typer.Argument(help="Folder that the port wrote, with the same layout.")
    ],
) -> None:
    """Compare the outputs of a port with test vectors and print one line per quantity.

    Exit codes: 1 if a quantity differs, 2 wrong usage.
    """
    with explained("export"):
        from footprints_edge_export.verification.check_vectors import check_vectors

        findings = check_vectors(vectors, outputs)
        for finding in findings:
            typer.echo(finding)
        differ = sum(not finding.holds for finding in findings)
        skipped = sum(not finding.checked for finding in findings)
        verdict = f"{differ} of {len(findings)} comparisons differ" if differ else "all hold"
        complain(f"{verdict}; {skipped} not checked" if skipped else verdict)
        if differ:
            raise typer.Exit(SOME_FAILED)


def main() -> None:
    """Entry point of ``fp-export``."""
    logging.basicConfig(level=logging.WARNING, format="%(message)s", stream=sys.stderr)
    logging.getLogger("footprints_edge_export").setLevel(logging.INFO)
    app()


if __name__ == "__main__":
    main()
