"""What one run of `fp-infer` has to do: which files to write for which picture."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from footprints_edge.cli.sources import Source, expand
from footprints_edge.errors import FootprintsError, OutputError
from footprints_edge.outputs.writers import Encoder, output_paths, refuse_overwriting


@dataclass(frozen=True)
class Task:
    """One picture, and the files to make of it."""

    source: Source
    targets: Mapping[Path, Encoder]


@dataclass
class Batch:
    """The tasks of a run, and what became of them.

    Attributes:
        tasks: What to do, in order.
        total: How many pictures were named, done already or not.
        kept: Outputs that are there already and stay.
        failures: Why pictures have no result, one message each.
    """

    tasks: list[Task] = field(default_factory=list)
    total: int = 0
    kept: list[Path] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)


def plan(
    named: Sequence[str],
    formats: Sequence[str],
    output: Path | None,
    *,
    recursive: bool,
    overwrite: bool,
    extra: Mapping[str, Encoder] | None = None,
) -> Batch:
    """Lists the work before any of it is done.

    Outputs go to `output`, keeping the sub-folders of a named folder, or beside each picture.
    `extra` are more files of this run: what is added to the picture's name, and what encodes it.

    Raises:
        OutputError: If a format is unknown.
    """
    output_paths(Path(), "any", formats)
    batch = Batch()
    distinct: dict[tuple[Path | None, Path], Source] = {}
    for name in named:
        try:
            for source in expand(name, recursive=recursive):
                place = source.path.resolve() if source.path else None
                distinct.setdefault((place, _folder(source, output).resolve()), source)
        except (FootprintsError, OSError) as error:
            batch.total += 1
            batch.failures.append(str(error))
    batch.total += len(distinct)
    pictures = {place for place, _ in distinct if place}
    made_from: dict[Path, Source] = {}
    for source in distinct.values():
        folder = _folder(source, output)
        targets = dict(output_paths(folder, source.name, formats))
        targets |= {folder / (source.name + suffix): make for suffix, make in (extra or {}).items()}
        try:
            refuse_overwriting(targets, pictures)
            _refuse_sharing(targets, made_from)
            kept = [path for path in targets if path.exists() and not overwrite]
            if kept and source.path is None:  # who knows which picture it was made from
                raise OutputError(f"its result {kept[0]} is there already; --overwrite replaces it")
        except (OutputError, OSError) as error:
            batch.failures.append(f"{source.label}: {error}")
            continue
        made_from |= dict.fromkeys(targets, source)
        batch.kept += kept
        if len(kept) < len(targets):
            missing = {path: targets[path] for path in targets if path not in kept}
            batch.tasks.append(Task(source, missing))
    return batch


def _folder(source: Source, output: Path | None) -> Path:
    if output is not None:
        return output / source.subfolder
    return source.path.parent if source.path else Path()


def _refuse_sharing(targets: Iterable[Path], made_from: Mapping[Path, Source]) -> None:
    for path in targets:
        if path in made_from:
            raise OutputError(
                f"its result {path} is that of {made_from[path].label} as well; "
                "run the two with different -o folders"
            )
