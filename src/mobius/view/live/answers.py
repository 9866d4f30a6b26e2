"""What the door answers itself: refusals, the page with our script in it, the script."""

from __future__ import annotations

from importlib.resources import files
from typing import Any


def answer(status: int, text: str, kind: str = "text/plain") -> Any:
    """A whole response: a refusal, or a script."""
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    body = text.encode()
    headers = Headers()
    headers["Content-Type"] = f"{kind}; charset=utf-8"
    headers["Content-Length"] = str(len(body))
    headers["Cache-Control"] = "no-store"
    headers["Cross-Origin-Resource-Policy"] = "same-origin"
    reason = {200: "OK", 401: "Unauthorized", 403: "Forbidden"}[status]
    return Response(status, reason, headers, body)


def page(response: Any, cookie: str) -> Any:
    """Studio's page with our script in it; it may stand in no frame of another page.

    Args:
        response: Studio's.
        cookie: ``name=value`` to give it; none where empty.
    """
    body = response.body.replace(b"</head>", b'<script src="/pulse.js"></script></head>', 1)
    headers = response.headers
    for name, value in (
        ("Content-Length", str(len(body))),
        ("X-Frame-Options", "DENY"),
        ("Referrer-Policy", "no-referrer"),
    ):
        if name in headers:
            del headers[name]
        headers[name] = value
    if cookie:
        headers["Set-Cookie"] = f"{cookie}; HttpOnly; SameSite=Strict; Path=/"
    return type(response)(response.status_code, response.reason_phrase, headers, body)


def pulse_js() -> str:
    """The script that the page runs."""
    return files("mobius.view.live").joinpath("pulse.js").read_text(encoding="utf-8")
