"""Access to the page: browsers on this machine that have its address with the token."""

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import parse_qs

_Message = MutableMapping[str, Any]
_Send = Callable[[_Message], Awaitable[None]]

FOREIGN = "This page is served only to 127.0.0.1 and localhost."
NO_TOKEN = "Open the page with the whole address that `mixed-ehl app` printed: the token at its end belongs to it."


class Guard:
    """ASGI middleware that rejects requests from outside the page, on HTTP and websocket.

    A name that points to 127.0.0.1 (DNS rebinding) is rejected by the header Host, a page of another address by Origin,
    and another user or program of this machine by the token. The token is first in the address, then in a cookie
    that browsers send only from the page.

    app: the guarded application.
    port: port of the page.
    token: token of the address.
    """

    def __init__(self, app: Callable[..., Awaitable[None]], port: int, token: str) -> None:
        self._app = app
        self._hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost", "[::1]")}
        self._cookie = f"mixed-ehl-{port}"  # cookies are shared by all ports
        self._token = token

    async def __call__(self, scope: _Message, receive: Callable[[], Awaitable[_Message]], send: _Send) -> None:
        """Handle one request (ASGI)."""
        if scope["type"] not in ("http", "websocket"):  # start and end of the server
            await self._app(scope, receive, send)
            return
        in_address = self._is_token(parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[-1])
        reason = self._refusal(scope, in_address)
        if reason is None:
            await self._app(scope, receive, self._keeping_token(send) if in_address else send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": reason})
        else:
            head = [(b"content-type", b"text/plain; charset=utf-8"), (b"cache-control", b"no-store")]
            await send({"type": "http.response.start", "status": 403, "headers": head})
            await send({"type": "http.response.body", "body": reason.encode()})

    def _refusal(self, scope: _Message, in_address: bool) -> str | None:
        hosts, origins = _header(scope, b"host"), _header(scope, b"origin")
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            return FOREIGN
        if any(origin.lower() != f"http://{hosts[0].lower()}" for origin in origins):
            return FOREIGN
        # split by hand: other programs of this machine may have set cookies that a strict parser stops at
        parts = [part.strip().partition("=") for line in _header(scope, b"cookie") for part in line.split(";")]
        kept = [value for name, _, value in parts if name == self._cookie]
        return None if in_address or any(map(self._is_token, kept)) else NO_TOKEN

    def _is_token(self, text: str) -> bool:
        return secrets.compare_digest(text.encode(errors="replace"), self._token.encode())

    def _keeping_token(self, send: _Send) -> _Send:
        cookie = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"

        async def with_cookie(message: _Message) -> None:
            if message["type"] == "http.response.start":
                # the address holds the token: no link carries it elsewhere
                added = [(b"set-cookie", cookie.encode()), (b"referrer-policy", b"no-referrer")]
                message["headers"] = [*message.get("headers", ()), *added]
            await send(message)

        return with_cookie


def _header(scope: _Message, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == name]
