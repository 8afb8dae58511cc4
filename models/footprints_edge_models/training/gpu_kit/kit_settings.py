"""What a kit says about itself: ``kit.json``."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from footprints_edge_models.data.errors import DatasetError

SETTINGS, INITIAL_WEIGHTS, SHARD, ASSETS = "kit.json", "initial.pt", "views.zip", "assets.zip"
"""Files of an unpacked kit; ``assets.zip`` may be missing."""


@dataclass(frozen=True)
class KitSettings:
    """What a run with a kit does, besides its length.

    Attributes:
        size: (h, w) of a batch of landscape views.
        shares: How often each data set is drawn, relative to the others.
        seed: Of scenes and training.
        recipe: Further fields of ``Recipe``, such as the weights of its losses.
    """

    size: tuple[int, int]
    shares: dict[str, float]
    seed: int
    recipe: dict[str, Any]

    def to_json(self) -> str:
        """For :func:`read_kit_settings`."""
        return json.dumps(asdict(self), indent=1) + "\n"


def read_kit_settings(kit: Path) -> KitSettings:
    """The settings of an unpacked kit.

    Raises:
        DatasetError: it is none.
    """
    path = kit / SETTINGS
    try:
        facts: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        height, width = facts["size"]
        return KitSettings(**facts | {"size": (height, width)})
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DatasetError(f"{path}: not of a kit ({error}); make one: fp-train gpu-kit") from error
