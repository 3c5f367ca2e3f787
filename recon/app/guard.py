"""The guard of the pages: only this machine and holders of the token are served."""

import hmac
import ipaddress
import socket
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK_NAMES = ("localhost", "127.0.0.1", "::1")


def is_loopback(host: str) -> bool:
    """True if a server on `host` is reachable from this machine only."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Guard:
    """Rejects requests from foreign pages and host names, and passes the others on.

    A foreign page could make its own name point here (DNS rebinding), so a host name is accepted
    only if it is this machine's; it could also open a websocket here, so the origin must be the
    requested host.

    Parameters
    ----------
    inner : ASGI application
    host : str
        The host that the server listens on.
    token : str, optional
        If given, required in the address once, then in a cookie.
    cookie : str
        Name of the cookie.
    """

    def __init__(self, inner: Application, host: str, token: str | None, cookie: str) -> None:
        self.inner = inner
        self.token = token
        self.cookie = cookie
        self.names = {host.lower(), *LOOPBACK_NAMES}
        self.is_open = not is_loopback(host)
        if self.is_open:
            self.names |= {socket.gethostname().lower(), socket.getfqdn().lower()}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check a request, then pass it on or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            return await self.inner(scope, receive, send)
        headers = {name.decode("latin-1"): value.decode("latin-1")
                   for name, value in scope["headers"]}  # fmt: skip
        fault = self.fault(headers, scope.get("query_string", b"").decode("latin-1"))
        if fault is not None:
            return await _refuse(scope, send, *fault)
        return await self.inner(scope, receive, self._with_cookie(scope, send))

    def fault(self, headers: dict[str, str], query: str) -> tuple[int, str] | None:
        """Status and reason of a refusal; None if the request is valid."""
        host = headers.get("host", "")
        if not self._knows(host):
            return 403, f"host {host!r} is not this machine"
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return 403, f"origin {origin!r} is another page"
        if self.token is not None and not self._has_token(headers, query):
            return 401, "the token of the printed address is missing"
        return None

    def _knows(self, host: str) -> bool:
        try:
            name = (urlsplit(f"//{host}").hostname or "").lower()
        except ValueError:
            return False
        if name in self.names:
            return True
        # A literal address cannot be rebound.
        return self.is_open and _is_address(name)

    def _has_token(self, headers: dict[str, str], query: str) -> bool:
        assert self.token is not None
        cookies = SimpleCookie()
        try:
            cookies.load(headers.get("cookie", ""))
        except Exception:
            cookies.clear()
        kept = cookies[self.cookie].value if self.cookie in cookies else ""
        given = parse_qs(query).get("token", [""])[0]
        return any(
            hmac.compare_digest(one.encode(), self.token.encode()) for one in (kept, given) if one
        )

    def _with_cookie(self, scope: Scope, send: Send) -> Send:
        """A send function that sets the token as a cookie for the page's further requests."""
        if self.token is None or scope["type"] != "http":
            return send
        cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"

        async def sending(message: MutableMapping[str, Any]) -> None:
            if message["type"] == "http.response.start":
                kept = list(message.get("headers", []))
                message["headers"] = [*kept, (b"set-cookie", cookie.encode("latin-1"))]
            await send(message)

        return sending


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


async def _refuse(scope: Scope, send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": reason[:120]})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"cache-control", b"no-store")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": f"{reason}\n".encode()})
