"""Scores on disk, added image by image, so that an interrupted run can be resumed.

The file holds JSON lines: first the settings that the scores depend on, then one line per image.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from footprints_edge.errors import FootprintsError
from footprints_edge_bench.accuracy.scoring import MethodScores

ImageScores: TypeAlias = dict[str, MethodScores]
"""Scores on one image, by the name of the row."""


class ResultsError(FootprintsError):
    """Results of an earlier run cannot be used."""


class Results:
    """The scores of a run.

    Attributes:
        path: the file of results.
        images: scores by image name, of the images that are done.
    """

    def __init__(self, path: Path, settings: Mapping[str, Any], *, fresh: bool = False) -> None:
        """Opens the file, or starts a new one.

        Args:
            path: the file of results.
            settings: everything that the scores depend on, as plain values.
            fresh: whether to discard earlier results.

        Raises:
            ResultsError: the file holds results of other settings, or is damaged.
        """
        self.path = path
        self.images: dict[str, ImageScores] = {}
        header = json.dumps({"settings": settings}, sort_keys=True)
        lines = [] if fresh or not path.exists() else path.read_text(encoding="utf-8").split("\n")
        whole = lines[:-1]  # an unfinished last line is dropped: the run was stopped there
        if whole:
            if whole[0] != header:
                raise ResultsError(
                    f"{path} holds results of other settings ({_differences(whole[0], settings)}); "
                    "discard them with --fresh, or choose another folder with -o"
                )
            for line in whole[1:]:
                self._take(line)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join([*(whole or [header]), ""]), encoding="utf-8")

    def add(self, name: str, scores: ImageScores) -> None:
        """Adds the scores of an image, in memory and on disk."""
        self.images[name] = scores
        values = {row: each.as_json() for row, each in scores.items()}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"image": name, "scores": values}) + "\n")

    def _take(self, line: str) -> None:
        try:
            entry = json.loads(line)
            self.images[entry["image"]] = {
                row: MethodScores.from_json(values) for row, values in entry["scores"].items()
            }
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise ResultsError(
                f"{self.path} is damaged ({error}); discard it with --fresh"
            ) from error


def _differences(header: str, settings: Mapping[str, Any]) -> str:
    try:
        earlier = json.loads(header)["settings"]
        keys = sorted(set(earlier) | set(settings))
        return ", ".join(key for key in keys if earlier.get(key) != settings.get(key))
    except (ValueError, KeyError, TypeError, AttributeError):
        return "the file is not from this program"
