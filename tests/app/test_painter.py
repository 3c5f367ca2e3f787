"""Drawing in the background, with a page that only takes notes."""

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from recon.app import painter as module
from recon.app.painter import COMPILING, Painter


class Client:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass


@pytest.fixture
def shown(monkeypatch):
    """The notifications shown and dismissed, in their order."""
    steps = []

    def notification(text, **_):
        steps.append(text)
        return SimpleNamespace(dismiss=lambda: steps.append("dismissed"))

    ui = SimpleNamespace(context=SimpleNamespace(client=Client()), notification=notification)
    tasks = SimpleNamespace(background_tasks=SimpleNamespace(create=asyncio.create_task))
    monkeypatch.setattr(module, "nicegui", lambda: ui)
    monkeypatch.setattr(module, "load_extra", lambda *_: tasks)
    return steps


def compile_something():
    event = pytest.importorskip("numba.core.event")
    for _ in range(2):
        with event.trigger_event("numba:compile"):
            pass


def compile_elsewhere():
    thread = threading.Thread(target=compile_something)
    thread.start()
    thread.join()


def fail():
    compile_something()
    raise ValueError("no such thing")


def painted(draw):
    """What a painter draws and says until it rests."""
    drawn, said = [], []

    async def paint():
        Painter(draw, drawn.append, said.append).ask()
        await asyncio.gather(*asyncio.all_tasks() - {asyncio.current_task()})

    # The browser's event loop runs in this thread.
    with ThreadPoolExecutor(1) as pool:
        pool.submit(lambda: asyncio.run(paint())).result()
    return drawn, said


@pytest.mark.parametrize(
    ("compiles", "notified"),
    [
        (compile_something, [COMPILING, "dismissed"]),
        (compile_elsewhere, []),
        (lambda: None, []),
    ],
)
def test_compiling_is_notified_and_leaves_messages_alone(shown, compiles, notified):
    drawn, said = painted(lambda: compiles() or "a view")
    assert drawn == ["a view"]
    assert said == []
    assert shown == notified


def test_notification_goes_when_drawing_fails(shown):
    drawn, said = painted(fail)
    assert drawn == []
    assert said == ["ValueError: no such thing"]
    assert shown == [COMPILING, "dismissed"]
