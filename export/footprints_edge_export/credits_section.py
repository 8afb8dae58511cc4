"""The credits of a model card: whom to name for what weights were trained on."""

import re
from collections import Counter
from collections.abc import Iterable
from itertools import groupby

from footprints_edge_models.asset_files.asset import Credit

_CREATIVE_COMMONS = re.compile(r"CC-(BY(?:-NC)?(?:-SA|-ND)?)-(\d\.\d)")


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


def _linked(licence: str) -> str:
    """A licence with a link to its text, where it has a known address."""
    if match := _CREATIVE_COMMONS.fullmatch(licence):
        terms, version = match[1].lower(), match[2]
        return f"[{licence}](https://creativecommons.org/licenses/{terms}/{version}/)"
    if licence.startswith("CC0"):
        return f"[{licence}](https://creativecommons.org/publicdomain/zero/1.0/)"
    if licence in {"MIT", "Apache-2.0"} or licence.startswith("BSD-"):
        return f"[{licence}](https://spdx.org/licenses/{licence}.html)"
    return licence
