"""What a pass gains: rounds are compared, not minutes of a busy machine."""

from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from footprints_edge_bench.cli import app
from footprints_edge_bench.passes import gains as passes
from footprints_edge_bench.passes.gains import (
    AS_EXPORTED,
    gains_as_markdown,
    measure_gains,
    summarise,
)


def test_ratios_are_of_the_same_round():
    busy = [1, 1, 10, 1, 1]  # the third round met another program
    gains = summarise(
        {
            AS_EXPORTED: [100 * b for b in busy],
            "one": [50 * b for b in busy],
            "two": [40 * b for b in busy],
        }
    )
    assert [gain.name for gain in gains] == [AS_EXPORTED, "one", "two"]
    assert [gain.of_before for gain in gains] == pytest.approx([1, 0.5, 0.8])
    assert [gain.of_first for gain in gains] == pytest.approx([1, 0.5, 0.4])
    assert [gain.min_ms for gain in gains] == [100, 50, 40]
    assert "| two | 40.0 | 40.0 | 0.80 | 0.40 |" in gains_as_markdown(gains)


@pytest.mark.parametrize(
    ("precision", "applied"),
    [
        (
            "fp32",
            ["few_outputs_by_blocks", "upsample_rows_in_convolution", "elu_as_exponential"],
        ),
        (
            "int8",
            [
                "few_outputs_by_blocks",
                "pad_and_resize_on_bytes",
                "elu_on_bytes",
                "upsample_by_expanding",
            ],
        ),
    ],
)
def test_each_pass_of_a_precision_has_its_row(monkeypatch, precision, applied):
    """The edge network: small, and each of its files runs."""
    times_ms = {}

    def once(runs, trials):
        assert trials == 3
        for name, run in runs.items():
            (maps,) = run()
            assert maps.shape == (1, 4, 64, 96)
            times_ms[name] = [1.0] * trials
        return times_ms

    monkeypatch.setattr(passes, "interleaved_ms", once)
    gains = measure_gains("edge", precision, (64, 96), threads=1, trials=3)
    assert [gain.name for gain in gains] == [AS_EXPORTED, *applied]


@pytest.mark.usefixtures("exact_int8")
def test_what_changes_in_the_maps_of_trained_weights(tmp_path):
    """The bundled weights: int8 is near float32, and the passes are nearer to int8 than that."""
    weights = Path(__file__).parents[3] / "models" / "weights" / "edge.pt"
    photo = Image.open(Path(__file__).parents[3] / "examples" / "room.jpg")
    for i in range(10):
        left = 40 * i
        photo.crop((left, 0, left + 800, 500)).resize((240, 150)).save(tmp_path / f"{i}.png")
    command = ["passes", "--network", "edge", "--size", "128x192", "--threads", "1"]
    command += ["--checkpoint", str(weights), "--photos", str(tmp_path)]
    found = CliRunner().invoke(app, command)
    assert found.exit_code == 0, found.output
    header, _, *lines = found.stdout.splitlines()
    assert header.startswith("| 2 photos |")  # of ten, one in five is judged by
    cells = {line.split("|")[1].strip(): line.split("|")[2:-1] for line in lines}
    assert list(cells) == [
        "int8, as exported against float32",
        "int8, all passes against float32",
        "int8, all passes against int8, as exported",
    ]
    ious = {name: min(map(float, values[:2])) for name, values in cells.items()}
    assert ious["int8, all passes against int8, as exported"] > 0.998
    assert 0.7 < ious["int8, all passes against float32"] < 0.998

    found = CliRunner().invoke(app, command[:-2])
    assert found.exit_code == 2 and "--photos" in found.stderr
