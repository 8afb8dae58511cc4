"""Fills pages of the documentation site while MkDocs builds it.

Two comments stand for text that has its home elsewhere:

    <!-- include: ../CHANGELOG.md -->                      the page is that file
    <!-- commands: fp-infer footprints_edge.cli.infer -->  help of every command of that program

Links are written for readers of the repository, so a page may link to `../CONTRIBUTING.md`. Here
such a link becomes one to the page that includes the file; a link to any other file outside of
`docs/` keeps its text only.
"""

import importlib
import logging
import re
from os.path import relpath
from pathlib import Path
from typing import Any

_LOG = logging.getLogger("mkdocs.hooks.site_pages")  # a warning fails a strict build

_INCLUDE = re.compile(r"<!-- include: (\S+) -->")
_COMMANDS = re.compile(r"<!-- commands: (\S+) (\S+) -->")
_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]*)(#[^)\s]*)?\)")


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:  # noqa: ANN401
    """Puts in what the page's comments stand for (an event of MkDocs)."""
    docs = Path(config["docs_dir"])
    source = docs / page.file.src_uri
    included = _INCLUDE.search(markdown)
    if included:
        source = (source.parent / included[1]).resolve()
        markdown = source.read_text(encoding="utf-8")
    markdown = _COMMANDS.sub(lambda found: describe_program(found[1], found[2]), markdown)
    homes = {docs / file.src_uri for file in files}
    pages_of = _pages_of_included_files(docs)

    def rewrite(link: re.Match[str]) -> str:
        image, text, target, anchor = link[1], link[2], link[3], link[4] or ""
        if not target or re.match(r"[a-z]+:", target):
            return link[0]
        home = (source.parent / target).resolve()
        home = pages_of.get(home, home)
        if not home.exists():
            _LOG.warning("%s links to %s, which is not there", source, target)
        if home not in homes:
            return text
        return f"{image}[{text}]({relpath(home, (docs / page.file.src_uri).parent)}{anchor})"

    return _LINK.sub(rewrite, markdown)


def describe_program(program: str, module: str) -> str:
    """Markdown about every command of a typer application.

    Args:
        program: Name that users type, such as `fp-infer`.
        module: Module whose `app` it is.
    """
    import typer

    command = typer.main.get_command(importlib.import_module(module).app)
    if not hasattr(command, "commands"):
        return _describe_command(command, program)
    parts = [_prose(command.help)]
    for name, child in command.commands.items():
        parts += [f"## {name}", _describe_command(child, f"{program} {name}")]
    return "\n\n".join(parts)


def _describe_command(command: Any, name: str) -> str:  # noqa: ANN401
    context = command.context_class(command, info_name=name)
    usage = command.get_usage(context).removeprefix("Usage: ")
    parts = [f"```\n{' '.join(usage.split())}\n```", _prose(command.help)]
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record is not None:
            names, text = record
            parts.append(f"`{_plain_types(names)}`\n:   {_escape(text) or '(no help)'}")
    return "\n\n".join(parts)


def _plain_types(names: str) -> str:
    """`--format <list[str]>` as `--format <str>`; `<int range>` as `<int>`."""
    return re.sub(r"<(?:list\[)?([\w|.-]+)\]?(?: range)?>", r"<\1>", names)


def _prose(text: str | None) -> str:
    return _escape(text or "")


def _escape(text: str) -> str:
    return text.replace("\\[", "[").replace("<", "&lt;").replace("*", "\\*").replace("_", "\\_")


def _pages_of_included_files(docs: Path) -> dict[Path, Path]:
    """Files outside of `docs`, and the page that includes each."""
    found = {}
    for page in docs.rglob("*.md"):
        included = _INCLUDE.search(page.read_text(encoding="utf-8"))
        if included:
            found[(page.parent / included[1]).resolve()] = page
    return found
