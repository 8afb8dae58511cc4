"""Whom to credit for what weights learned from, kept beside them."""

import json
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

import torch

from footprints_edge.errors import ModelError
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import ordered_credits
from footprints_edge_models.networks.checkpoint import CREDITS_KEY


def stated_credits(weights: Any, name: str) -> list[Credit]:  # noqa: ANN401 - of any checkpoint
    """The credits that a state dict states; none where it states none.

    Raises:
        ModelError: what is stated is no list of credits.
    """
    if not isinstance(weights, dict) or CREDITS_KEY not in weights:
        return []
    try:
        facts = json.loads(bytes(weights[CREDITS_KEY].to(torch.uint8).tolist()))
        return [Credit(**each) for each in facts]
    except (AttributeError, ValueError, TypeError, NotImplementedError) as error:
        raise ModelError(f"{name}: {CREDITS_KEY} is no list of credits ({error})") from error


def as_tensor(credits: Iterable[Credit]) -> torch.Tensor:
    """Credits as a state dict holds them, uint8 (N,)."""
    text = json.dumps([asdict(each) for each in ordered_credits(credits)])
    return torch.tensor(list(text.encode()), dtype=torch.uint8)
