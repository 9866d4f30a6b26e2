"""Who may talk to the page: the doors of Studio's web server.

MuJoCo Studio 4.0 binds its web server to all interfaces and asks nobody who they are. Here it is
bound to the loopback, or to an address that was asked for together with a token; every request,
WebSockets included, is checked before Studio sees it:

- its Host must be one of ours (a page elsewhere whose name resolves to this machine is refused),
- its Origin, where the browser names one, must be this very page, and a cross-site request for
  anything but the page itself is refused,
- with a token it must carry it, as ``?token=`` once and as a cookie from then on.

The same door serves :file:`pulse.js`, which the page runs beside Studio's client, and hears what
it says (:class:`mobius.view.live.pulse.Pulse`).
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import socket
import string
import threading
import urllib.parse
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

from mobius.errors import InvalidInput
from mobius.view.live.answers import answer, page, pulse_js
from mobius.view.live.pulse import Pulse

COOKIE = "mobius_token"
"""Name of the cookie, before the port: a browser sends cookies to all ports of a host."""
TOKEN_LETTERS = frozenset(string.ascii_letters + string.digits + "-_.~")
"""Those that neither an address nor a cookie has to quote."""


@dataclass(frozen=True)
class Door:
    """Where the server listens, and whom it lets in."""

    host: str = "127.0.0.1"
    port: int = 8080
    """0: any free port from 8080 on."""
    token: str = ""
    """Empty: none needed, on the loopback alone."""

    def __post_init__(self) -> None:
        if not is_loopback(self.host) and len(self.token) < 16:
            raise InvalidInput(
                f"--host {self.host} lets other machines in: expected a token of at least 16"
                " characters, or none on 127.0.0.1"
            )
        if not set(self.token) <= TOKEN_LETTERS:
            raise InvalidInput(
                "--token or MOBIUS_TOKEN: expected letters, digits, '-', '_', '.' and '~' alone"
            )
        if not 0 <= self.port < 65536:
            raise InvalidInput(f"--port: expected 0 to 65535, got {self.port}")

    def refuses(self, method: str, path: str, headers: Any, port: int) -> tuple[int, str] | None:
        """Status and reason of a refusal; None lets the request in.

        Args:
            method: Of HTTP.
            path: With its query.
            headers: Offers ``get_all(name)``.
            port: On which the server listens.
        """
        del method
        host = _one(headers, "Host")
        if host is None or not self._ours(host, port):
            return 403, f"refused: open http://{self.address(port)}/ instead"
        origin = _one(headers, "Origin")
        if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
            return 403, "refused: a page from elsewhere"
        bare = path.partition("?")[0]
        far = _one(headers, "Sec-Fetch-Site") in ("cross-site", "same-site")
        if far and not (bare == "/" and _one(headers, "Sec-Fetch-Mode") == "navigate"):
            return 403, "refused: a request from elsewhere"
        if self.token and not self._known(path, headers, port):
            return 401, "refused: open the address with its token, as it was printed"
        return None

    def address(self, port: int) -> str:
        """Host and port to type into a browser."""
        host = self.host
        if host == "127.0.0.1":
            host = "localhost"
        elif host in ("0.0.0.0", "::"):  # all of this machine's addresses
            host = socket.gethostname()
        return f"{_bracketed(host)}:{port}"

    def check(self) -> None:
        """Whether this machine has the address.

        Raises:
            InvalidInput: It has not.
        """
        family = socket.AF_INET6 if ":" in self.host else socket.AF_INET
        try:
            if not self.host:  # to sockets it means all addresses
                raise OSError("it is empty")
            with socket.socket(family, socket.SOCK_STREAM) as probe:
                probe.bind((self.host, 0))
        except (OSError, UnicodeError) as error:
            why = getattr(error, "strerror", None) or error
            raise InvalidInput(
                f"--host {self.host}: expected an address of this machine, such as 127.0.0.1 or"
                f" 0.0.0.0 ({why})"
            ) from None

    def _ours(self, host: str, port: int) -> bool:
        """Whether a Host header names us; with a token any name may, for tunnels and DNS."""
        names = ("localhost", "127.0.0.1", "[::1]", _bracketed(self.host))
        return bool(self.token) or host in {f"{name}:{port}" for name in names}

    def _known(self, path: str, headers: Any, port: int) -> bool:
        query = urllib.parse.parse_qs(path.partition("?")[2])
        given = query.get("token", [])
        for line in headers.get_all("Cookie"):
            for cookie in line.split(";"):  # what others set on this host may be odd
                name, _, value = cookie.strip().partition("=")
                if name == cookie_name(port):
                    given.append(value)
        token = self.token.encode()
        return any(hmac.compare_digest(v.encode(errors="replace"), token) for v in given)


def cookie_name(port: int) -> str:
    """Of the page on a port, so that two pages of a machine do not take each other's."""
    return f"{COOKIE}_{port}"


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host


def is_loopback(host: str) -> bool:
    """Whether an address or name is this machine alone."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def new_token() -> str:
    """A token nobody can guess."""
    return secrets.token_urlsafe(24)


@dataclass
class Opened:
    """How far the server is."""

    port: int = 0
    """On which it listens."""
    serving: threading.Event = field(default_factory=threading.Event)
    """Set once it answers."""


@contextmanager
def guarded(door: Door, pulse: Pulse) -> Iterator[Opened]:
    """Web viewers of Studio that are started inside the block stand behind the door.

    Stay in the block until :attr:`Opened.serving` is set.

    Raises:
        RuntimeError: Studio is not as it is known here; nothing has been opened.
    """
    from mujoco.studio import web_viewer
    from mujoco.studio.web import web_server

    bind, serve = (
        getattr(web_server, "bind_public_socket", None),
        getattr(web_server, "serve", None),
    )
    if bind is None or serve is None:
        raise RuntimeError(
            "MuJoCo Studio has changed: its web server has no bind_public_socket or serve; it"
            " cannot be bound to the loopback, so it is not started"
        )

    opened = Opened()

    def bind_here(host: str, port: int = 0) -> socket.socket:
        del host  # Studio's own: all interfaces
        sock: socket.socket = bind("127.0.0.1" if door.host == "localhost" else door.host, port)
        opened.port = sock.getsockname()[1]
        return sock

    web_server.bind_public_socket = bind_here
    web_server.serve = _serving(serve, door, pulse, opened)
    web_viewer._print_url_banner = lambda *_: None  # it says that nobody is asked who they are
    try:
        yield opened
    finally:
        web_server.bind_public_socket, web_server.serve = bind, serve


def _serving(serve: Any, door: Door, pulse: Pulse, opened: Opened) -> Any:
    """``websockets.serve`` with the door before its requests."""

    def served(handler: Callable[[Any], Awaitable[None]], **options: Any) -> Any:
        studio, studios = options["process_request"], options["process_response"]
        port = options["sock"].getsockname()[1]

        def process_request(connection: Any, request: Any) -> Any:
            refusal = door.refuses("GET", request.path, request.headers, port)
            if refusal is not None:
                return answer(*refusal)
            path = request.path.partition("?")[0]
            if path == "/pulse":
                return None
            if path == "/pulse.js":
                return answer(200, pulse_js(), "text/javascript")
            response = studio(connection, request)
            if (
                path in ("/", "/index.html")
                and response is not None
                and response.status_code == 200
            ):
                return page(response, _cookie(door, port))
            return response

        def process_response(connection: Any, request: Any, response: Any) -> Any:
            response = studios(connection, request, response) or response
            for name in ("Access-Control-Allow-Origin", "Cross-Origin-Resource-Policy"):
                if name in response.headers:  # Studio: everybody
                    del response.headers[name]
            response.headers["Cross-Origin-Resource-Policy"] = "same-origin"
            return response

        async def handle(ws: Any) -> None:
            match _path(ws):
                case "/pulse":
                    await _listen(ws, pulse)
                case "/ui":
                    session = _session(ws)
                    pulse.enter(session)
                    try:
                        await handler(ws)
                    finally:
                        pulse.leave(session)
                case _:
                    await handler(ws)

        options["process_request"] = process_request
        options["process_response"] = process_response
        opened.serving.set()
        return serve(handle, **options)

    return served


async def _listen(ws: Any, pulse: Pulse) -> None:
    """Hear one page until it goes."""
    from websockets.exceptions import ConnectionClosed

    with suppress(ConnectionClosed):
        async for message in ws:
            if isinstance(message, str):
                pulse.hear(_session(ws), message)
    pulse.hang_up(_session(ws))


def _path(ws: Any) -> str:
    return "" if ws.request is None else str(ws.request.path.partition("?")[0])


def _session(ws: Any) -> str:
    """The session that a page names in the address, as Studio's client does."""
    query = urllib.parse.parse_qs("" if ws.request is None else ws.request.path.partition("?")[2])
    return query.get("sid", [""])[0]


def _cookie(door: Door, port: int) -> str:
    """What carries the token from the first page on; empty where there is none."""
    return f"{cookie_name(port)}={door.token}" if door.token else ""


def _one(headers: Any, name: str) -> str | None:
    """The only value of a header; a header given twice counts as a strange one."""
    values = headers.get_all(name)
    return None if not values else values[0] if len(values) == 1 else ", ".join(values)
