"""Scores on disk, image by image as they are computed, so that a stopped run can go on.

A file of JSON lines: the settings that the scores are for, then one line an image.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from footprints_edge.errors import FootprintsError
from footprints_edge_bench.accuracy.scoring import MethodScores

ImageScores: TypeAlias = dict[str, MethodScores]
"""Scores on one image by the row's name."""


class ResultsError(FootprintsError):
    """Results of an earlier run are in the way."""


class Results:
    """The scores of a run.

    Attributes:
        path: the file.
        images: scores of each image that is done.
    """

    def __init__(self, path: Path, settings: Mapping[str, Any], *, fresh: bool = False) -> None:
        """Opens the file, or begins it.

        Args:
            path: of the file.
            settings: what the scores depend on, plain values.
            fresh: whether earlier results are thrown away.

        Raises:
            ResultsError: the file holds results of other settings, or something else.
        """
        self.path = path
        self.images: dict[str, ImageScores] = {}
        header = json.dumps({"settings": settings}, sort_keys=True)
        lines = [] if fresh or not path.exists() else path.read_text(encoding="utf-8").split("\n")
        whole = lines[:-1]  # a line that does not end was being written when the run was stopped
        if whole:
            if whole[0] != header:
                raise ResultsError(
                    f"{path} holds results of other settings ({_differences(whole[0], settings)}); "
                    "--fresh throws them away, or choose another folder with -o"
                )
            for line in whole[1:]:
                self._take(line)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join([*(whole or [header]), ""]), encoding="utf-8")

    def add(self, name: str, scores: ImageScores) -> None:
        """Keeps the scores of an image, in memory and on disk."""
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
                f"{self.path} is damaged ({error}); --fresh throws it away"
            ) from error


def _differences(header: str, settings: Mapping[str, Any]) -> str:
    try:
        earlier = json.loads(header)["settings"]
        keys = sorted(set(earlier) | set(settings))
        return ", ".join(key for key in keys if earlier.get(key) != settings.get(key))
    except (ValueError, KeyError, TypeError, AttributeError):
        return "the file is not of this program"
