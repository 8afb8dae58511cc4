"""Runs `fp-infer` with a tiny model."""

import pytest
from typer.testing import CliRunner

from footprints_edge.cli.infer import app as infer_app


@pytest.fixture
def infer(tiny_path):
    """Runs `fp-infer` with the tiny model in this process."""

    def invoke(*arguments, **options):
        return CliRunner().invoke(
            infer_app,
            [*map(str, arguments), "--model", str(tiny_path), "--threads", "1"],
            **options,
        )

    return invoke
