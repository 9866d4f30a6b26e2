import numpy as np
import pytest
from PIL import Image

from mobius.drive.session import Session
from mobius.errors import MobiusError
from mobius.mission.prepare import plan_mission
from mobius.robot import TICK
from mobius.view.live.nouns import Beat, Keeping

WATCHING = Beat(page=True)


class AtOnce:
    """A planner without a process."""

    def __init__(self):
        self.answers = {}

    def ask(self, world, modes, start, body):
        number = len(self.answers) + 1
        try:
            self.answers[number] = plan_mission(world, modes, start=start, last_mode=body)
        except MobiusError as error:
            self.answers[number] = error
        return number

    def answer(self, number):
        return self.answers[number]


class Live:
    """A session turned in simulated time, with somebody at its controls."""

    def __init__(self, source="demo", **options):
        self.session = Session(source, AtOnce(), **options)
        self.now, self.last = 0.0, None

    def ask(self, request):
        self.session.take(request, self.now)

    def run(self, seconds, beat=WATCHING):
        """Turn for so long, with that beat at 60 Hz; None: nobody is there."""
        for _ in range(round(seconds / TICK)):
            sample = self.session.stack.turn(self.session.source(lambda: self.now))
            self.now += TICK
            if sample is not None:
                if beat is not None:
                    self.session.take(beat, self.now)
                self.session.watch(self.now)
                self.last = self.session.see(sample, self.session.look(), Keeping())
        return self.last


@pytest.fixture
def live():
    return Live(randomised=False)


@pytest.fixture
def live_on():
    return lambda source: Live(source, randomised=False)


@pytest.fixture
def open_floor(tmp_path):
    """A map of 8 m by 8 m with nothing in it but its walls."""
    pixels = np.full((160, 160), 254, np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = 0
    Image.fromarray(pixels).save(tmp_path / "open.pgm")
    file = tmp_path / "open.yaml"
    file.write_text(
        "image: open.pgm\nresolution: 0.05\norigin: [-4.0, -4.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\nmobius: {start: [0.0, 0.0]}\n"
    )
    return file
