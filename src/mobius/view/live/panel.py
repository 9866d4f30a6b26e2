"""The Drive panel: who drives, which body, how fast, stop, push, policy, and how it goes."""

from __future__ import annotations

import math

from mujoco.studio.dear_imgui import dear_imgui as imgui

from mobius.view.live.cockpit import Cockpit
from mobius.view.live.nouns import (
    MODE_KEYS,
    Halt,
    Push,
    Record,
    Release,
    Reset,
    Snapshot,
    SpeedLimit,
    UsePolicy,
    WantMode,
)

RED, GREEN, AMBER = (0.82, 0.16, 0.16, 1.0), (0.10, 0.55, 0.25, 1.0), (0.80, 0.50, 0.05, 1.0)
_CODES = tuple(
    (code, getattr(imgui.Key, name))
    for code, name in (
        *((f"Arrow{way}", f"{way}Arrow") for way in ("Up", "Down", "Left", "Right")),
        *((f"Key{letter}", letter) for letter in "QER"),
        *((f"Digit{digit}", f"N{digit}") for digit, _ in MODE_KEYS),
        ("Space", "Space"),
    )
)
"""Drive keys by the name that a browser gives them, and as Dear ImGui knows them."""
WHITE = (1.0, 1.0, 1.0, 1.0)
POLICIES = ("flat", "rough", "zero", "random")
TOWARDS = (("forward", 0.0), ("left", math.pi / 2), ("back", math.pi), ("right", -math.pi / 2))
KEY_CARD = (
    ("Up / Down", "forward / back"),
    ("Left / Right", "turn left / right"),
    ("Q / E", "step left / right"),
    ("1 2 3 4", "crawl, biped, roll, push-ups"),
    ("Space", "EMERGENCY STOP"),
    ("R", "release the stop"),
)


class DrivePanel:
    """Draws the panel and reads the keys, once a frame."""

    def __init__(self, cockpit: Cockpit) -> None:
        self._cockpit = cockpit
        self._limit, self._push, self._towards = 1.0, 0.3, 0
        self._policy, self._scene = dict[str, str](), 0

    def keys(self) -> None:
        """Take the keyboard from Studio while Drive is on; call once a frame."""
        cockpit = self._cockpit
        cockpit.typing = imgui.IsAnyItemActive() and not imgui.IsAnyMouseDown()
        if cockpit.driving:
            imgui.SetNextFrameWantCaptureKeyboard(True)
        cockpit.press(frozenset(code for code, key in _CODES if imgui.IsKeyDown(key)))

    def draw(self) -> None:
        """The panel's inside."""
        cockpit, s = self._cockpit, self._cockpit.snapshot
        self._drive_and_stop(s)
        if s is None:
            imgui.TextDisabled("waiting for the robot")
            return
        self._modes(s)
        self._state(s)
        imgui.SeparatorText("Speed and push")
        changed, self._limit = imgui.SliderFloat("speed limit", self._limit, 0.1, 1.0, "%.2f")
        if changed:
            cockpit.ask(SpeedLimit(float(self._limit)))
        _, self._push = imgui.SliderFloat("push [m/s]", self._push, 0.05, 1.0, "%.2f")
        for i, (name, bearing) in enumerate(TOWARDS):
            if i:
                imgui.SameLine()
            if imgui.Button(f"{name}##push"):
                cockpit.ask(Push(float(self._push), bearing))
        imgui.SeparatorText("Run")
        if imgui.Button("Reset"):
            cockpit.ask(Reset())
        imgui.SameLine()
        changed, on = imgui.Checkbox("record", bool(s.recording))
        if changed:
            cockpit.ask(Record(on))
        self._policies()
        self._key_card()

    def _place(self, name: str) -> None:
        """Note where the button just drawn is."""
        low, high = imgui.GetItemRectMin(), imgui.GetItemRectMax()
        self._cockpit.places[name] = (0.5 * (low.x + high.x), 0.5 * (low.y + high.y))

    def _drive_and_stop(self, s: Snapshot | None) -> None:
        cockpit = self._cockpit
        colour = GREEN if cockpit.driving else None
        _coloured(colour)
        label = "Drive: ON (keys move the robot)" if cockpit.driving else "Drive: off"
        if imgui.Button(label, imgui.Vec2(-1.0, 30.0)):
            cockpit.driving = not cockpit.driving
        self._place("drive")
        _plain(colour)
        if s is not None and s.stopped:
            _coloured(AMBER)
            if imgui.Button("Release the stop (R)", imgui.Vec2(-1.0, 34.0)):
                cockpit.ask(Release())
            self._place("release")
            _plain(AMBER)
        else:
            _coloured(RED)
            if imgui.Button("EMERGENCY STOP (Space)", imgui.Vec2(-1.0, 34.0)):
                cockpit.ask(Halt("emergency stop (button)"))
            self._place("stop")
            _plain(RED)

    def _modes(self, s: Snapshot) -> None:
        imgui.SeparatorText("Body")
        for i, (digit, mode) in enumerate(MODE_KEYS):
            if i:
                imgui.SameLine()
            on = s.mode == mode
            _coloured(GREEN if on else None)
            if imgui.Button(f"{digit} {mode.replace('_', '-')}"):
                self._cockpit.ask(WantMode(mode))
            self._place(mode)
            _plain(GREEN if on else None)
        wanted = "" if s.wanted == s.mode else f", wanted: {s.wanted}"
        imgui.Text(f"now: {s.mode}{wanted}")
        # two lines are kept for what explains a refusal, so that nothing below them jumps
        imgui.BeginChild("##notice", imgui.Vec2(0.0, 3.2 * imgui.GetTextLineHeight()))
        if s.notice:
            imgui.TextWrapped(s.notice)
        if s.message and s.message != s.notice:
            imgui.TextWrapped(s.message)
        imgui.EndChild()

    def _state(self, s: Snapshot) -> None:
        if not imgui.BeginTable("##state", 4):
            return
        rows = [
            ("", "vx m/s", "vy m/s", "wz rad/s"),
            *(
                (name, *(f"{v:+.2f}" for v in row))
                for name, row in zip(("command", "belief", "truth"), s.twist, strict=True)
            ),
        ]
        for row in rows:
            imgui.TableNextRow()
            for cell in row:
                imgui.TableNextColumn()
                imgui.Text(cell)
        imgui.EndTable()
        off = math.dist(s.true_pose[:2], s.believed_pose[:2])
        imgui.Text(f"t {s.t:.1f} s   power {s.power:.0f} W   belief off {off:.2f} m")
        keeping = s.keeping
        bad = keeping.factor < 0.98 or keeping.misses > 0.005
        text = (
            f"real time x {keeping.factor:.3f}, 300 Hz deadlines missed"
            f" {100 * keeping.misses:.2f} %"
        )
        if bad:
            imgui.TextColored(imgui.Vec4(*AMBER), text)
        else:
            imgui.Text(text)
        if keeping.dropped_s > 0.0:
            imgui.Text(f"given up {keeping.dropped_s:.2f} s: this machine was too slow")

    def _policies(self) -> None:
        scene = self._cockpit.scene
        if scene is not None and scene.number != self._scene:
            self._scene, self._policy = scene.number, dict(scene.policies)
        for body, now in self._policy.items():
            imgui.SetNextItemWidth(110.0)
            names = [*POLICIES] if now in POLICIES else [now, *POLICIES]
            changed, k = imgui.Combo(f"policy of {body}", names.index(now), names)
            if changed:
                self._policy[body] = names[k]
                self._cockpit.ask(UsePolicy(body, names[k]))

    def _key_card(self) -> None:
        imgui.SeparatorText("Keys (while Drive is on)")
        if imgui.BeginTable("##keys", 2):
            for key, what in KEY_CARD:
                imgui.TableNextRow()
                imgui.TableNextColumn()
                imgui.Text(key)
                imgui.TableNextColumn()
                imgui.Text(what)
            imgui.EndTable()
        imgui.TextWrapped("Let go: it stops. Gamepad: hold the left shoulder button.")


def _coloured(colour: tuple[float, ...] | None) -> None:
    """Begin a coloured button with white text."""
    if colour is not None:
        for part in (imgui.Col.Button, imgui.Col.ButtonHovered, imgui.Col.ButtonActive):
            imgui.PushStyleColor(int(part), imgui.Vec4(*colour))
        imgui.PushStyleColor(int(imgui.Col.Text), imgui.Vec4(*WHITE))


def _plain(colour: tuple[float, ...] | None) -> None:
    """End it."""
    if colour is not None:
        imgui.PopStyleColor(4)
