"""The list of credits in a folder of what was made from assets."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.asset_files.asset import AssetError, Credit

CREDITS = "credits.json"


def write_credits_file(folder: Path, credits: Iterable[Credit]) -> list[Credit]:
    """Writes `credits.json`: title, author, licence and source of every asset, each once.

    Returns:
        The credits, by licence, author and title.
    """
    ordered = ordered_credits(credits)
    facts = [asdict(each) for each in ordered]
    write_atomically(folder / CREDITS, (json.dumps(facts, indent=1) + "\n").encode())
    return ordered


def ordered_credits(credits: Iterable[Credit]) -> list[Credit]:
    """Each once, by licence, author, title and source."""
    return sorted(
        set(credits), key=lambda each: (each.licence, each.author, each.title, each.source)
    )


def read_credits_file(path: Path) -> list[Credit]:
    """The credits that :func:`write_credits_file` wrote.

    Raises:
        AssetError: It is damaged.
    """
    try:
        return [Credit(**facts) for facts in json.loads(path.read_text(encoding="utf-8"))]
    except (OSError, ValueError, TypeError) as error:
        raise AssetError(f"{path}: no readable credits ({error})") from error
