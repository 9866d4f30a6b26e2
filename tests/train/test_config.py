"""Presets survive JSON; another version's are refused."""

import json
from dataclasses import replace

import pytest

from mobius.control.bodies import BODIES, body_of
from mobius.control.clock import Gait
from mobius.errors import InvalidInput
from mobius.train.config import as_plain, gait_as_plain, preset_from
from mobius.train.presets import PRESETS, EnvConfig


@pytest.mark.parametrize("key", PRESETS, ids="-".join)
def test_every_preset_comes_back_the_same(key):
    plain = json.loads(json.dumps(as_plain(PRESETS[key]), allow_nan=False))
    assert preset_from(plain) == PRESETS[key]


@pytest.mark.parametrize("lift", [None, 0.02])
@pytest.mark.parametrize("body", BODIES)
def test_a_gait_comes_back_the_same(body, lift):
    cfg = EnvConfig(body, lift=lift)
    plain = json.loads(json.dumps(gait_as_plain(cfg), allow_nan=False))
    gait = Gait(**plain)
    want = body_of(body).gait if lift is None else replace(body_of(body).gait, height=lift)
    assert replace(gait, offsets=tuple(gait.offsets), swing=tuple(gait.swing)) == want


def test_another_version_s_preset_is_refused():
    plain = as_plain(PRESETS["crawl", "fast"])
    plain["env"]["randomisation"]["warp"] = 9
    with pytest.raises(InvalidInput, match=r"preset\.env\.randomisation .*warp"):
        preset_from(plain)
    del plain["env"]
    with pytest.raises(InvalidInput, match="another version"):
        preset_from(plain)
