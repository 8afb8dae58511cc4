"""The tasks of one `fp-infer` run: which files to write for which picture."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from footprints_edge.cli.sources import InputImage, expand, left_out
from footprints_edge.errors import FootprintsError, OutputError
from footprints_edge.foundation.real_path import real_path
from footprints_edge.outputs.writers import Encoder, output_paths, refuse_overwriting


@dataclass(frozen=True)
class Task:
    """One picture, and the files to write for it."""

    source: InputImage
    targets: Mapping[Path, Encoder]


@dataclass
class Batch:
    """The tasks of a run, and their outcome.

    Attributes:
        tasks: The tasks, in order.
        total: Number of pictures and videos given, including finished ones.
        kept: Existing outputs that are kept.
        failures: One message for each picture or video that failed.
        notes: What the user should know, though nothing failed.
        model_failures: Number of pictures that failed because of the model.
    """

    tasks: list[Task] = field(default_factory=list)
    total: int = 0
    kept: list[Path] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    model_failures: int = 0

    def failed(self, name: str, error: Exception) -> None:
        """Adds why a video or bag failed, in a message that names it."""
        if isinstance(error, (FootprintsError, OSError)):
            self.failures.append(str(error) if name in str(error) else f"{name}: {error}")
        else:
            reason = f"{type(error).__name__}: {error}"
            self.failures.append(f"{name} cannot be processed: {reason}")


def plan(
    named: Sequence[str],
    formats: Sequence[str],
    output: Path | None,
    *,
    recursive: bool,
    overwrite: bool,
    extra: Mapping[str, Encoder] | None = None,
) -> Batch:
    """Lists all tasks before any is run.

    Outputs go to `output`, which mirrors the sub-folders of a given folder, or beside each picture.
    `extra` adds more files per picture: suffixes and their encoders.

    Raises:
        OutputError: If a format is unknown.
    """
    output_paths(Path(), "any", formats)  # reports an unknown format once
    batch = Batch()
    distinct: dict[tuple[Path | None, Path], InputImage] = {}
    for name in named:
        try:
            batch.notes += filter(None, [left_out(name, recursive=recursive)])
            for source in expand(name, recursive=recursive):
                path = real_path(source.path) if source.path else None
                distinct.setdefault((path, real_path(_folder(source, output))), source)
        except (FootprintsError, OSError) as error:
            batch.total += 1
            batch.failures.append(str(error))
    batch.total += len(distinct)
    pictures = {path for path, _ in distinct if path}
    made_from: dict[Path, InputImage] = {}
    for source in distinct.values():
        folder = _folder(source, output)
        targets = dict(output_paths(folder, source.name, formats))
        targets |= {folder / (source.name + end): encode for end, encode in (extra or {}).items()}
        try:
            refuse_overwriting(targets, pictures)
            _refuse_sharing(targets, made_from)
            kept = [path for path in targets if path.exists() and not overwrite]
            if kept and source.path is None:  # it may belong to another picture
                raise OutputError(f"its result {kept[0]} already exists; --overwrite replaces it")
        except (OutputError, OSError) as error:
            batch.failures.append(f"{source.label}: {error}")
            continue
        made_from |= dict.fromkeys(targets, source)
        batch.kept += kept
        if len(kept) < len(targets):
            missing = {path: targets[path] for path in targets if path not in kept}
            batch.tasks.append(Task(source, missing))
    return batch


def _folder(source: InputImage, output: Path | None) -> Path:
    if output is not None:
        return output / source.subfolder
    return source.path.parent if source.path else Path()


def _refuse_sharing(targets: Iterable[Path], made_from: Mapping[Path, InputImage]) -> None:
    for path in targets:
        if path in made_from:
            raise OutputError(
                f"its result {path} is that of {made_from[path].label} as well; "
                "run the two with different -o folders"
            )
