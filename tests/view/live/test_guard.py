"""Who may talk to the page."""

import math
import os
import shutil
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from mobius.errors import InvalidInput
from mobius.view.live.guard import Door, cookie_name, is_loopback, new_token
from mobius.view.live.pulse import SILENT, Pulse

TOKEN = "a-token-that-nobody-guesses"


class Headers(dict):
    def get_all(self, name):
        value = self.get(name, [])
        return [value] if isinstance(value, str) else value


def asked(door, path="/", **headers):
    given = Headers({name.replace("_", "-"): value for name, value in headers.items()})
    refusal = door.refuses("GET", path, given, 8080)
    return None if refusal is None else refusal[0]


def test_the_loopback_is_let_in_by_its_names_alone():
    door = Door()
    for host in ("localhost:8080", "127.0.0.1:8080", "[::1]:8080"):
        assert asked(door, Host=host) is None
    for host in ("evil.example:8080", "localhost:80", "localhost", "127.0.0.1.evil.example:8080"):
        assert asked(door, Host=host) == 403
    assert asked(door) == 403
    assert asked(door, Host=["localhost:8080", "evil.example"]) == 403


def test_a_page_from_elsewhere_is_refused_and_this_page_is_not():
    door = Door()
    here = "localhost:8080"
    assert asked(door, "/ui?sid=1", Host=here, Origin="http://localhost:8080") is None
    for origin in ("http://evil.example", "null", "http://localhost:9000", "http://127.0.0.1:8080"):
        assert asked(door, "/ui?sid=1", Host=here, Origin=origin) == 403
    assert asked(door, "/model", Host=here, Sec_Fetch_Site="cross-site") == 403
    assert asked(door, "/model", Host=here, Sec_Fetch_Site="same-origin") is None
    link = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate"}
    assert asked(door, "/", Host=here, **link) is None
    assert asked(door, "/model", Host=here, **link) == 403


def test_beyond_the_loopback_every_request_must_carry_the_token():
    door = Door("0.0.0.0", 8080, TOKEN)
    host = {"Host": "robot.lan:8080"}
    assert asked(door, "/", **host) == 401
    assert asked(door, "/?token=wrong-wrong-wrong-wrong", **host) == 401
    assert asked(door, f"/?token={TOKEN}", **host) is None
    for path in ("/model", "/ui?sid=1", "/state?sid=1", "/pulse?sid=1", "/drop"):
        assert asked(door, path, **host) == 401
        assert asked(door, path, Cookie=f"{cookie_name(8080)}={TOKEN}", **host) is None
        assert asked(door, path, Cookie=f"{cookie_name(8080)}=x; other=1", **host) == 401
    assert (
        asked(
            door, "/", Origin="http://evil.example", Cookie=f"{cookie_name(8080)}={TOKEN}", **host
        )
        == 403
    )


@pytest.mark.parametrize("token", ["", "short"])
def test_a_door_to_other_machines_without_a_good_token_is_not_opened(token):
    with pytest.raises(InvalidInput, match="at least 16"):
        Door("0.0.0.0", 8080, token)


def test_odd_cookies_of_others_and_bytes_that_are_no_text_neither_let_in_nor_keep_out():
    door = Door("0.0.0.0", 8080, TOKEN)
    ours = f"{cookie_name(8080)}={TOKEN}"
    for others in ('{"a": 1}; ', "x=[1,2]; y; ", f"{cookie_name(9000)}=another; "):
        assert asked(door, Host="robot:8080", Cookie=others + ours) is None
    assert asked(door, Host="robot:8080", Cookie=f"{cookie_name(9000)}={TOKEN}") == 401
    assert asked(door, "/?token=\udce9\udcff", Host="robot:8080") == 401


@pytest.mark.parametrize("token", ["sixteen letters; and a b", "line\r\nSet-Cookie: x=y-long"])
def test_a_token_that_would_have_to_be_quoted_is_refused(token):
    with pytest.raises(InvalidInput, match="--token"):
        Door("0.0.0.0", 8080, token)


@pytest.mark.parametrize("host", ["no.such.host.invalid", "192.0.2.77", "", "x" * 300])
def test_a_host_that_is_no_address_of_this_machine_is_not_taken_for_a_port_in_use(host):
    with pytest.raises(InvalidInput, match="--host"):
        Door(host, 8080, TOKEN).check()


def test_the_address_to_open_is_one_on_which_the_page_listens():
    assert Door().address(8080) == "localhost:8080"
    assert Door("127.0.0.2").address(8080) == "127.0.0.2:8080"
    assert Door("::1").address(8080) == "[::1]:8080"
    assert Door("0.0.0.0", 8080, TOKEN).address(8080) == f"{socket.gethostname()}:8080"
    assert asked(Door("127.0.0.2"), Host="127.0.0.2:8080") is None
    Door("127.0.0.2").check()


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_is_a_port(port):
    with pytest.raises(InvalidInput, match="--port"):
        Door(port=port)


def test_loopback_and_tokens():
    assert all(map(is_loopback, ("localhost", "127.0.0.1", "::1", "127.9.9.9")))
    assert not any(map(is_loopback, ("0.0.0.0", "::", "192.168.1.1", "robot.lan", "")))
    assert len(new_token()) >= 32 and new_token() != new_token()


# -- the pulse ---------------------------------------------------------------------------


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


def said(focus="true", keys='["ArrowUp"]', **more):
    extra = "".join(f', "{k}": {v}' for k, v in more.items())
    return f'{{"focus": {focus}, "keys": {keys}{extra}}}'


def test_only_the_page_with_the_controls_is_heard():
    pulse = Pulse(Clock())
    pulse.hear("a", said())
    assert not pulse.there and not pulse.keys
    pulse.enter("a")
    pulse.enter("b")
    pulse.hear("b", said())
    assert not pulse.there
    pulse.hear("a", said())
    assert pulse.there and pulse.keys == {"ArrowUp"}
    pulse.leave("b")
    assert pulse.there
    pulse.leave("a")
    assert not pulse.there and not pulse.keys


def test_a_page_that_hangs_up_is_gone_at_once_and_may_come_back():
    pulse = Pulse(Clock())
    pulse.enter("a")
    pulse.hear("a", said())
    pulse.hang_up("b")
    assert pulse.there
    pulse.hang_up("a")
    assert not pulse.there and not pulse.keys
    pulse.hear("a", said())
    assert pulse.there


def test_a_page_that_comes_back_before_its_old_connection_ends_keeps_the_controls():
    pulse = Pulse(Clock())
    pulse.enter("a")
    pulse.enter("a")
    pulse.hear("a", said())
    pulse.leave("a")
    assert pulse.there
    pulse.leave("a")
    assert not pulse.there


def test_keys_grow_old_before_the_page_does():
    clock = Clock()
    pulse = Pulse(clock)
    pulse.enter("a")
    pulse.hear("a", said(age=0.1))
    clock.now += 0.2
    assert pulse.hands
    clock.now += 0.1
    assert pulse.there and not pulse.hands
    clock.now += SILENT
    assert not pulse.there


def test_a_page_that_is_held_up_has_no_hands():
    pulse = Pulse(Clock())
    pulse.enter("a")
    pulse.hear("a", said(age=2.0))
    assert pulse.there and not pulse.hands
    pulse.hear("a", said(age=20.0))
    assert not pulse.there


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "null", "7", '{"focus": true}', said(keys="3"), said(age='"x"'), said(age="-1"),
     said(pad='{"axes": [NaN]}'), said(pad='{"axes": "x"}'), "[" * 5000, "\x00" * 100],
)  # fmt: skip
def test_garbage_counts_for_nothing(text):
    pulse = Pulse(Clock())
    pulse.enter("a")
    pulse.hear("a", text)
    assert not pulse.there and not pulse.keys and not pulse.axes


def test_sticks_are_bounded():
    pulse = Pulse(Clock())
    pulse.enter("a")
    pulse.hear("a", said(pad='{"axes": [9, -9, 0.5], "buttons": [0, 1]}'))
    assert pulse.axes == (1.0, -1.0, 0.5) and pulse.buttons == (0, 1)


# -- the sockets themselves -----------------------------------------------------------------


SERVE = """
import sys, time
import mujoco
from mujoco.studio import launch_web, viewer_protocol
from mobius.view.live.guard import Door, guarded
from mobius.view.live.pulse import Pulse
host, token = sys.argv[1:]
with guarded(Door(host, 0, token), Pulse()) as opened:
    handle = launch_web.launch(viewer_protocol.ViewerConfig(gfx="web"))
    assert opened.serving.wait(90)
handle.set_model(mujoco.MjModel.from_xml_string("<mujoco><worldbody/></mujoco>"))
print("port", opened.port, flush=True)
while handle.is_running():
    handle.sync()
    time.sleep(0.05)
"""


@pytest.fixture(scope="module")
def served():
    """The page of a plain model behind each door, a process each: [(port, pid)]."""
    processes, found = [], []
    try:
        for host, token in (("127.0.0.1", ""), ("0.0.0.0", TOKEN)):
            command = [sys.executable, "-c", SERVE, host, token]
            process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
            processes.append(process)
            port = next(int(line.split()[1]) for line in process.stdout if line.startswith("port"))
            threading.Thread(target=process.stdout.read, daemon=True).start()
            found.append((port, process.pid))
        yield found
        assert all(process.poll() is None for process in processes)
    finally:
        for process in processes:
            process.kill()
            process.wait()


def fetch(url, **headers):
    given = {k.replace("_", "-"): v for k, v in headers.items()}
    try:
        with urllib.request.urlopen(urllib.request.Request(url, headers=given), timeout=10) as r:
            return r.status, r.read(), dict(r.headers)
    except urllib.error.HTTPError as error:
        return error.code, error.read(), dict(error.headers)


def listening(pid):
    """Addresses on which a process listens, from the kernel's tables."""
    inodes = set()
    for fd in os.listdir(f"/proc/{pid}/fd"):
        try:
            target = os.readlink(f"/proc/{pid}/fd/{fd}")
        except OSError:
            continue
        if target.startswith("socket:["):
            inodes.add(target[8:-1])
    found = []
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{table}").read_text().splitlines()[1:]:
            field = line.split()
            if field[3] == "0A" and field[9] in inodes:
                address, port = field[1].split(":")
                raw = bytes.fromhex(address)
                if table == "tcp":
                    host = socket.inet_ntoa(raw[::-1])
                else:
                    words = struct.unpack("<4I", raw)
                    host = socket.inet_ntop(socket.AF_INET6, struct.pack(">4I", *words))
                found.append((host, int(port, 16)))
    return found


def test_every_listening_socket_is_on_the_loopback_but_the_one_that_was_asked_for(served):
    (loopback, pid), (beyond, other) = served
    here, there = listening(pid), listening(other)
    assert ("127.0.0.1", loopback) in here and all(is_loopback(host) for host, _ in here)
    assert ("0.0.0.0", beyond) in there
    assert all(is_loopback(host) for host, port in there if port != beyond)


def test_the_page_is_served_with_our_script_and_the_model_without_an_open_door(served):
    status, body, headers = fetch(f"http://127.0.0.1:{served[0][0]}/")
    assert status == 200 and b'<script src="/pulse.js"></script></head>' in body
    assert headers["X-Frame-Options"] == "DENY"
    status, body, headers = fetch(f"http://localhost:{served[0][0]}/pulse.js")
    assert status == 200 and b"/pulse?sid=" in body
    status, _, headers = fetch(f"http://localhost:{served[0][0]}/model")
    assert status == 200 and "Access-Control-Allow-Origin" not in headers


def test_over_the_wire_token_host_and_origin_are_asked_for(served):
    (loopback, _), (beyond, _) = served
    assert fetch(f"http://127.0.0.1:{beyond}/")[0] == 401
    assert fetch(f"http://127.0.0.1:{beyond}/model", Cookie=f"{cookie_name(beyond)}=no")[0] == 401
    status, _, headers = fetch(f"http://127.0.0.1:{beyond}/?token={TOKEN}")
    assert status == 200 and "HttpOnly" in headers["Set-Cookie"]
    assert "SameSite=Strict" in headers["Set-Cookie"]
    carried = f"{cookie_name(beyond)}={TOKEN}"
    assert fetch(f"http://127.0.0.1:{beyond}/model", Cookie=carried)[0] == 200
    assert fetch(f"http://127.0.0.1:{loopback}/", Host="evil.example")[0] == 403
    assert fetch(f"http://127.0.0.1:{loopback}/model", Origin="http://evil.example")[0] == 403


@pytest.mark.parametrize("path", ["/ui", "/state", "/pulse", "/drop"])
def test_websockets_of_other_pages_are_refused(served, path):
    from websockets.exceptions import InvalidStatus
    from websockets.sync.client import connect

    (loopback, _), (beyond, _) = served
    for port, origin, status in (
        (loopback, "http://evil.example", 403),
        (beyond, f"http://127.0.0.1:{beyond}", 401),
    ):
        with pytest.raises(InvalidStatus) as refused:
            connect(f"ws://127.0.0.1:{port}{path}?sid=x", origin=origin, close_timeout=1)
        assert refused.value.response.status_code == status


def test_a_hundred_frames_of_garbage_on_every_socket_do_not_end_the_program(served):
    from websockets.exceptions import WebSocketException
    from websockets.sync.client import connect

    rng = np.random.default_rng(0)
    port, pid = served[0]
    for _, there in listening(pid):
        for _ in range(25):
            with socket.create_connection(("127.0.0.1", there), timeout=5) as raw:
                raw.sendall(rng.bytes(int(rng.integers(1, 400))))
    for path in ("/ui", "/state", "/pulse", "/drop"):
        for _ in range(25):
            try:
                with connect(f"ws://127.0.0.1:{port}{path}?sid=g", close_timeout=0.2) as ws:
                    ws.send(rng.bytes(int(rng.integers(0, 200))))
                    ws.send("".join(map(chr, rng.integers(32, 1000, 50))))
            except (WebSocketException, OSError):
                pass
    time.sleep(0.5)
    assert fetch(f"http://127.0.0.1:{port}/")[0] == 200


@pytest.mark.skipif(shutil.which("ip") is None, reason="no iproute2 is installed here")
def test_another_host_reaches_the_token_door_alone(served):
    """A network namespace stands for a machine on the same network; needs root."""
    name = f"mobius{threading.get_ident() % 10000}"
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True)
    if made.returncode:
        pytest.skip("network namespaces cannot be made here")
    try:
        link = f"mv{math.floor(time.time()) % 10**6}"
        for command in (
            f"ip link add {link} type veth peer name far netns {name}",
            f"ip addr add 10.177.1.1/24 dev {link}",
            f"ip link set {link} up",
            f"ip netns exec {name} ip addr add 10.177.1.2/24 dev far",
            f"ip netns exec {name} ip link set far up",
        ):
            subprocess.run(command.split(), check=True, capture_output=True)
        (loopback, _), (beyond, _) = served

        def from_there(port, path="/"):
            code = (
                "import urllib.request, urllib.error\n"
                f"try: print(urllib.request.urlopen('http://10.177.1.1:{port}{path}',"
                " timeout=5).status)\n"
                "except urllib.error.HTTPError as e: print(e.code)\n"
                "except OSError: print('closed')"
            )
            run = ["ip", "netns", "exec", name, "python3", "-c", code]
            return subprocess.run(run, capture_output=True, text=True).stdout.strip()

        assert from_there(loopback) == "closed"
        assert from_there(beyond) == "401"
        assert from_there(beyond, f"/?token={TOKEN}") == "200"
    finally:
        subprocess.run(["ip", "netns", "del", name], capture_output=True)
