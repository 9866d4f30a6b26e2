"""A number that is not finite stops training and leaves a file that shows it again."""

from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from rsl_rl.algorithms import PPO  # noqa: E402

from mobius.cli import main  # noqa: E402
from mobius.errors import InvalidInput, MobiusError  # noqa: E402
from mobius.train.checkpoint import read_tree, write_tree  # noqa: E402
from mobius.train.guard import TrainingStopped, replay  # noqa: E402
from mobius.train.learn import load_checkpoint, train  # noqa: E402
from mobius.train.ppo import LeanPPO  # noqa: E402
from mobius.train.presets import preset_of  # noqa: E402

BATCH = 16 * 24
TINY = replace(preset_of("crawl", "smoke"), num_envs=16, steps=2 * BATCH)


@pytest.fixture
def poisoned(tmp_path, monkeypatch):
    """A run whose learner asks robots 5 and 9 for nan in the 30th policy step."""
    act, calls = LeanPPO.act, [0]

    def poison(self, obs):
        action = act(self, obs)
        calls[0] += 1
        if calls[0] == 30:
            action[5, 1] = action[9] = torch.nan
        return action

    monkeypatch.setattr(LeanPPO, "act", poison)
    with pytest.raises(TrainingStopped) as caught:
        train(TINY, tmp_path / "run", seed=2, threads=1, save_every=1)
    monkeypatch.undo()
    return tmp_path / "run", str(caught.value)


def test_a_poisoned_action_stops_the_run_and_can_be_replayed(poisoned, capsys):
    run, message = poisoned
    (dump,) = (run / "nan").iterdir()
    assert f"after {BATCH} steps" in message and str(dump) in message and "\n" not in message
    assert issubclass(TrainingStopped, MobiusError)
    tree = read_tree(dump)
    assert tree["robots"].tolist() == [5, 9]
    assert np.isnan(tree["action"][5, 1]) and np.isfinite(tree["action"][5, 2])
    assert np.isfinite(tree["env"]["sim"]["state"]).all()  # it is the state before
    again = replay(dump)
    assert (again.kind, again.seen) == ("step", "action of robot 5, 9")
    assert again.seen == again.recorded
    assert load_checkpoint(run)["steps"] == BATCH  # and not later
    assert main(["train", "--replay", str(dump)]) == 1
    assert "action of robot 5, 9" in capsys.readouterr().out


def test_a_replay_of_what_is_finite_says_so(poisoned, capsys):
    run, _ = poisoned
    (dump,) = (run / "nan").iterdir()
    tree = read_tree(dump)
    write_tree(dump, {**tree, "action": np.nan_to_num(tree["action"])})
    assert replay(dump).seen is None
    assert main(["train", "--replay", str(dump)]) == 0
    assert "finite" in capsys.readouterr().out


def test_an_update_that_goes_wrong_can_be_replayed(tmp_path, monkeypatch):
    returns = PPO.compute_returns

    def poison(self, obs):
        returns(self, obs)
        self.storage.advantages[3, 7] = torch.inf

    monkeypatch.setattr(PPO, "compute_returns", poison)
    with pytest.raises(TrainingStopped, match="weights"):
        train(TINY, tmp_path, seed=2, threads=1)
    monkeypatch.undo()
    (dump,) = (tmp_path / "nan").iterdir()
    again = replay(dump)
    assert again.kind == "update" and again.seen == again.recorded and "weights" in again.seen


def test_only_dumps_are_replayed(tmp_path):
    write_tree(tmp_path / "other.safetensors", {"steps": 3})
    with pytest.raises(InvalidInput, match="dump"):
        replay(tmp_path / "other.safetensors")
