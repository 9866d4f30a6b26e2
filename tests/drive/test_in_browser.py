"""The whole way: a page in Chromium, a person's keys and clicks, the robot in physics.

Chromium draws without a graphics card here, about one frame a second; keys and the dead man's
switch do not wait for its frames, clicks do.
"""

import shutil
import threading
import time

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGS = [
    "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
]  # fmt: skip
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed here")


class Person:
    """Somebody in front of the page, who can also look at the robot's truth."""

    def __init__(self, page):
        self.page, self.cockpit, self.rows = page, None, []

    def sees(self, cockpit):
        self.cockpit = cockpit
        s = cockpit.snapshot
        if s is not None and (not self.rows or self.rows[-1][1].number != s.number):
            self.rows.append((time.monotonic(), s))

    @property
    def now(self):
        return self.rows[-1][1]

    def wait(self, until, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end and not until():
            time.sleep(0.05)
        return until()

    def click(self, name, done):
        """Click a button until what it does is done."""
        assert self.wait(lambda: self.cockpit is not None and name in self.cockpit.places, 60)
        for hold in (2.0, 4.0, 8.0):
            self.page.mouse.move(*self.cockpit.places[name])
            time.sleep(hold)
            self.page.mouse.down()
            time.sleep(hold)
            self.page.mouse.up()
            if self.wait(done, 12.0):
                return
        pytest.fail(f"the button '{name}' does nothing")

    def stopped_after(self, moment):
        """Time [s] from a moment until the true trunk stood."""
        assert self.wait(lambda: self.rows[-1][0] > moment + 1.0, 10)
        for at, s in self.rows:
            if at > moment and np.linalg.norm(s.twist[2, :2]) < 0.1:
                return at - moment
        return np.inf


def act(person):
    """Everything that acceptance asks of the page, in one visit: loading it takes longest."""
    page = person.page
    assert person.wait(lambda: person.cockpit is not None and person.cockpit.places, 60)
    before = page.screenshot()
    person.click("drive", lambda: person.cockpit.driving)

    x = person.now.true_pose[0]
    page.keyboard.down("ArrowUp")
    time.sleep(3.0)
    released = time.monotonic()
    page.keyboard.up("ArrowUp")
    took = time.monotonic() - released  # Chromium may be busy drawing
    assert person.stopped_after(released + took) < 0.5
    assert person.now.true_pose[0] - x > 0.5 and person.now.mode == "crawl"
    assert page.screenshot() != before

    person.click("biped", lambda: person.now.wanted == "biped")
    assert person.wait(lambda: person.now.mode == "biped", 20)
    assert person.now.true_pose[2] > 0.4
    person.click("crawl", lambda: person.now.wanted == "crawl")
    assert person.wait(lambda: person.now.mode == "crawl", 20)

    person.click("go", lambda: person.now.following)
    assert person.wait(lambda: person.now.arrived, 90), person.now.message
    goal = np.array(person.cockpit.way.goal)
    assert np.linalg.norm(person.now.true_pose[:2] - goal) < 0.35

    page.keyboard.down("ArrowLeft")
    assert person.wait(lambda: abs(person.now.twist[0, 2]) > 0.5, 5)
    page.keyboard.press("Space")
    assert person.wait(lambda: person.now.stopped, 3)
    page.keyboard.up("ArrowLeft")
    page.keyboard.press("KeyR")
    assert person.wait(lambda: person.now.mode == "crawl", 15)

    page.keyboard.down("ArrowUp")
    assert person.wait(lambda: person.now.twist[0, 0] > 0.5, 5)
    page.close()
    assert person.stopped_after(time.monotonic()) < 0.5
    assert person.wait(lambda: person.now.stopped, 2) and "page is gone" in person.now.message


def test_a_person_drives_stands_up_goes_to_a_goal_stops_and_leaves():
    pytest.importorskip("playwright")
    from playwright.sync_api import sync_playwright

    from mobius.drive.run import drive
    from mobius.view.live.guard import Door

    person, failed, over = Person(None), [], threading.Event()

    def visit(address):
        try:
            with sync_playwright() as play:
                browser = play.chromium.launch(executable_path=CHROMIUM, args=ARGS)
                person.page = browser.new_page(viewport={"width": 900, "height": 640})
                person.page.goto(address)
                act(person)
                browser.close()
        except BaseException as error:
            failed.append(error)
        finally:
            over.set()

    def seen(cockpit):
        person.sees(cockpit)
        if over.is_set():
            raise KeyboardInterrupt

    def ready(address):
        if address.startswith("http"):
            threading.Thread(target=visit, args=(address,), daemon=True).start()

    with pytest.raises(KeyboardInterrupt):
        drive("demo", door=Door(port=0), seconds=400, shadows=False, ready=ready, seen=seen)
    if failed:
        raise failed[0]
