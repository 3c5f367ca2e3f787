"""The guard answers this machine's names, its own pages, and holders of the token."""

from contextlib import suppress

import pytest

from recon.app.guard import Guard, is_loopback
from recon.app.serving import listen
from recon.errors import InputError


async def inner(scope, receive, send):
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"page"})


def ask(guard, kind="http", query="", **headers):
    """Return status and headers of a response; a rejected socket is closed with 1008."""
    sent = []

    async def send(message):
        sent.append(message)

    async def receive():
        return {"type": "http.request"}

    scope = {
        "type": kind, "query_string": query.encode(),
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
    }  # fmt: skip
    # Nothing is awaited: no event loop is needed, and another test may run one.
    with suppress(StopIteration):
        guard(scope, receive, send).send(None)
    first = sent[0]
    return first.get("status", first.get("code")), dict(first.get("headers", []))


@pytest.fixture
def local():
    return Guard(inner, "127.0.0.1", None, "cookie")


@pytest.fixture
def far():
    return Guard(inner, "0.0.0.0", "secret", "cookie")


@pytest.mark.parametrize("host", ["127.0.0.1:80", "localhost", "localhost:9", "[::1]:80"])
def test_requests_for_this_machine_are_answered(local, host):
    assert ask(local, host=host)[0] == 200
    assert ask(local, host=host, origin=f"http://{host}")[0] == 200


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "", "localhost.evil", "[", "10.0.0.1"]
)
def test_foreign_host_is_rejected(local, host):
    assert ask(local, host=host)[0] == 403
    assert ask(local, kind="websocket", host=host)[0] == 1008


def test_missing_host_header_is_rejected(local):
    assert ask(local)[0] == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:2"])
def test_foreign_origin_is_rejected(local, origin):
    assert ask(local, host="localhost:1", origin=origin)[0] == 403
    assert ask(local, kind="websocket", host="localhost:1", origin=origin)[0] == 1008


def test_token_is_required_and_then_kept_in_a_cookie(far):
    assert ask(far, host="10.0.0.1:80")[0] == 401
    assert ask(far, host="10.0.0.1:80", query="token=wrong")[0] == 401
    assert ask(far, host="10.0.0.1:80", cookie="cookie=wrong")[0] == 401
    status, headers = ask(far, host="10.0.0.1:80", query="token=secret")
    assert status == 200
    assert b"HttpOnly" in headers[b"set-cookie"]
    assert ask(far, host="10.0.0.1:80", cookie="cookie=secret")[0] == 200
    assert ask(far, kind="websocket", host="10.0.0.1:80")[0] == 1008
    assert ask(far, host="evil.example", query="token=secret")[0] == 403


def test_only_loopback_needs_no_token():
    assert is_loopback("127.0.0.1")
    assert is_loopback("localhost")
    assert is_loopback("::1")
    for host in ("0.0.0.0", "10.0.0.1", "example.org", ""):
        assert not is_loopback(host)
    here, everywhere = listen("127.0.0.1", 0), listen("0.0.0.0", 0)
    assert here.token is None
    assert "token=" not in here.url
    assert f"?token={everywhere.token}" in everywhere.url
    for address in (here, everywhere):
        address.listener.close()


def test_port_in_use_is_named_in_the_error():
    first = listen("127.0.0.1", 0)
    with pytest.raises(InputError, match=f"--port {first.port}"):
        listen("127.0.0.1", first.port)
    first.listener.close()
    with pytest.raises(InputError, match=r"--host 203\.0\.113\.7"):
        listen("203.0.113.7", 0)
    with pytest.raises(InputError, match=r"--host 203\.0\.113\.7: "):
        listen("203.0.113.7", None)
