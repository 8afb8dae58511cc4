"""The credits of a model card: whom to name for what weights were trained on."""

import re
from collections import Counter
from collections.abc import Iterable
from itertools import groupby

from footprints_edge_models.asset_files.asset import Credit

_KNOWN = re.compile(
    r"\bCC-(?P<terms>BY(?:-NC)?(?:-SA|-ND)?)-(?P<version>\d\.\d)\b|\bCC0(?:-1\.0)?\b"
    r"|\b(?:MIT-0|MIT|Apache-2\.0|BSD-\d-Clause(?:-Clear)?)(?![\w-])"
)


def credits_section(credits: Iterable[Credit]) -> str:
    """A section in Markdown with name, title, licence and link of everything, by licence.

    CC BY asks for these four; what has no author and no licence stated is named, too.
    """
    lines = ["## Credits", "", "Trained on works of these authors, changed as training needs:", ""]
    ordered = sorted(credits, key=lambda each: (each.licence, each.author, each.source))
    for licence, of_licence in groupby(ordered, lambda each: each.licence):
        lines += [f"### {_linked(licence)}", ""]
        for (author, source), works in groupby(of_licence, lambda each: (each.author, each.source)):
            titles = ", ".join(sorted({f"“{each.title}”" for each in works}))
            lines.append(f"- {titles} by {author}{f' ({source})' if source else ''}")
        lines.append("")
    return "\n".join(lines)


def summary(credits: Iterable[Credit]) -> str:
    """What weights were trained on, in a line: how many works under each licence."""
    count = Counter(each.licence for each in credits)
    return ", ".join(f"{licence}: {number}" for licence, number in sorted(count.items()))


def _linked(licences: str) -> str:
    """A licence, or several in words, each with a link to its text if it has a known address."""
    return _KNOWN.sub(lambda found: f"[{found[0]}]({_address(found)})", licences)


def _address(licence: re.Match[str]) -> str:
    if licence["terms"]:
        terms, version = licence["terms"].lower(), licence["version"]
        return f"https://creativecommons.org/licenses/{terms}/{version}/"
    if licence[0].startswith("CC0"):
        return "https://creativecommons.org/publicdomain/zero/1.0/"
    return f"https://spdx.org/licenses/{licence[0]}.html"
