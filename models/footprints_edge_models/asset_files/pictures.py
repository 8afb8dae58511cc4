"""Textures and panoramas: pictures that an `index.json` describes."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from footprints_edge_models.asset_files.asset import AssetError, Credit, free_licence

HELD_OUT_PANORAMAS = frozenset({"city", "hall", "lobby", "lythwood_room_1k", "venice", "workshop"})
"""By name: no network is trained on them, neither as pictures nor behind synthetic scenes."""


@dataclass(frozen=True)
class PictureFile:
    """A JPEG with its facts.

    Attributes:
        kind: What it is.
        key: Unique name, its path in the folder without the suffix.
        name: What it shows.
        category: Class of a texture, such as `woodfloor`; setting of a panorama, such as `indoor`.
        credit: Whom to credit.
        jpeg: The file's bytes.
    """

    kind: Literal["texture", "panorama"]
    key: str
    name: str
    category: str
    credit: Credit
    jpeg: bytes = field(repr=False)


def texture_files(index: Path) -> Iterator[PictureFile | AssetError]:
    """The textures of a folder; in place of one that cannot be used, why."""
    for facts in json.loads(index.read_text(encoding="utf-8")):
        yield _picture(index, "texture", facts, name_key="cls", category_key="cls")


def panorama_files(index: Path) -> Iterator[PictureFile | AssetError]:
    """The panoramas of a folder; in place of one that cannot be used, why."""
    for facts in json.loads(index.read_text(encoding="utf-8")):
        yield _picture(index, "panorama", facts, name_key="shows", category_key="setting")


def _picture(
    index: Path,
    kind: Literal["texture", "panorama"],
    facts: Mapping[str, Any],
    *,
    name_key: str,
    category_key: str,
) -> PictureFile | AssetError:
    try:
        path = index.parent / facts["file"]
        credit = Credit(
            path.stem,
            str(facts["author"]),
            free_licence(str(facts["licence"])),
            str(facts["source"]),
        )
        return PictureFile(
            kind,
            Path(facts["file"]).with_suffix("").as_posix(),
            str(facts[name_key]),
            str(facts[category_key]),
            credit,
            path.read_bytes(),
        )
    except AssetError as error:
        return AssetError(f"{index}: {facts['file']}: {error}")
    except (OSError, KeyError, TypeError) as error:
        return AssetError(f"{index}: {error!r}")
