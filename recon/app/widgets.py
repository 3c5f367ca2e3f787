"""Building blocks of both pages; those used by tests have a `data-testid`."""

from collections.abc import Callable, Sequence
from typing import Any

from recon.app.marks import text
from recon.libraries import load_extra

HEAD = """
<style>
  body { font-feature-settings: "tnum"; }
  .body--dark { --q-primary: #56b4e9 !important; }
  .w-full { width: 100%; } .gap-0 { gap: 0; } .gap-2 { gap: 8px; } .gap-3 { gap: 12px; }
  .recon-line { display: flex; align-items: flex-end; gap: 10px; width: 100%; }
  .recon-line > :first-child { flex: 1 1 0; min-width: 0; }
  .recon-buttons { display: flex; flex-wrap: wrap; align-items: center; gap: 8px; }
  .recon-page .q-btn--outline { padding: 2px 12px; font-size: 13px; flex: none; }
  .recon-page .q-table th, .recon-page .q-table td { padding: 2px 5px; }
  .recon-word { fill: #16191d; stroke: #fff; paint-order: stroke; font-family: sans-serif;
                pointer-events: none; }
  .body--dark .recon-word, .recon-seen .recon-word { fill: #fff; stroke: #16191d; }
  .nicegui-content { padding: 0; gap: 0; }
  .recon-head { display: flex; flex-wrap: nowrap; align-items: center; gap: 14px; width: 100%;
                height: 40px; padding: 0 12px; box-sizing: border-box; }
  .recon-page { display: flex; flex-wrap: nowrap; width: 100%; gap: 10px;
                height: calc(100vh - 40px); padding: 4px 10px 8px; box-sizing: border-box; }
  .recon-side { flex: 0 0 430px; overflow-y: auto; padding-right: 4px; }
  .recon-columns { columns: 1; column-gap: 10px; }
  .recon-columns > .recon-card { break-inside: avoid; }
  .recon-main { flex: 1 1 auto; min-width: 0; overflow-y: auto; }
  .recon-panes { display: grid; grid-template-columns: 1fr 1fr; gap: 8px; }
  .recon-card { padding: 8px 12px; width: 100%; gap: 4px; margin-bottom: 8px; box-shadow: none;
                border: 1px solid rgba(128, 128, 128, .35); border-radius: 6px; }
  .recon-title { font-size: 13px; font-weight: 600; }
  .recon-note { font-size: 12px; opacity: .8; white-space: pre-line; overflow-wrap: anywhere; }
  .recon-told { columns: 180px auto; width: 100%; }
  .recon-settings textarea { font: 12px monospace; height: 300px; resize: vertical; }
  .recon-fields { display: grid; grid-template-columns: repeat(3, 1fr); width: 100%;
                  gap: 2px 10px; }
  .recon-main > .recon-pane { max-width: calc((100vh - 190px) * 4 / 3); margin: 0 auto; }
  .recon-stack { display: grid; gap: 8px;
                 grid-template-columns: repeat(auto-fit, minmax(300px, 1fr)); }
  .recon-stack .recon-pane { min-height: 60px; }
  .recon-four { max-width: calc(100vh - 90px); margin: 0 auto; }
  .recon-cell { display: flex; flex-direction: column; gap: 8px; min-width: 0; }
  .recon-rest { flex: 1 1 130px; position: relative; }
  .recon-rest > .recon-card { position: absolute; inset: 0; margin: 0; overflow-y: auto;
                              flex-wrap: nowrap; }
  .recon-range { width: 100%; accent-color: #0072b2; }
  .recon-pane { border: 1px solid rgba(128, 128, 128, .35); border-radius: 4px; overflow: hidden;
                touch-action: none; user-select: none; outline-offset: -2px; }
  .recon-message { min-height: 20px; font-size: 13px; color: #d55e00; overflow-wrap: anywhere; }
  .recon-wait { pointer-events: none; }
  .recon-bar { height: 10px; width: 100%; border-radius: 3px; }
  @media (min-width: 1800px) { .recon-wide { flex-basis: 850px; }
                               .recon-wide > .recon-columns { columns: 2; } }
  @media (max-width: 1000px) { .recon-page { flex-wrap: wrap; height: auto; }
                               .recon-side { flex: 1 0 100%; } }
</style>
"""


def nicegui() -> Any:
    """NiceGUI's `ui`."""
    return load_extra("nicegui", "app").ui


def testid(element: Any, name: str) -> Any:
    """The element, marked for tests and scripts."""
    return element.props(f'data-testid="{name}"')


def card(title: str) -> Any:
    """A frame with a title, to be entered with `with`."""
    ui = nicegui()
    frame = ui.card().classes("recon-card")
    with frame:
        ui.label(title).classes("recon-title")
    return frame


def note(name: str = "", words: str = "", kind: str = "recon-note") -> Any:
    """A line of changeable text."""
    label = nicegui().label(words).classes(kind)
    return testid(label, name) if name else label


def number_field(name: str, label: str, value: float, change: Callable[[Any], Any]) -> Any:
    """A number field that is applied by Enter, or when it loses the focus."""
    field = nicegui().number(label, value=value, format="%.6g").props("dense step=any")
    testid(field, name)
    field.on("change", change)
    field.on("keydown.enter", change)
    return field


def line() -> Any:
    """A row of a field and its buttons, to be entered with `with`."""
    return nicegui().element("div").classes("recon-line")


def button(name: str, words: str, press: Callable[[], Any]) -> Any:
    """An outlined button."""
    made = nicegui().button(words, on_click=press).props("dense no-caps outline no-wrap")
    return testid(made, name)


def side() -> Any:
    """The cards beside the panes, in two columns on wide screens; to be entered with `with`."""
    ui = nicegui()
    with ui.element("div").classes("recon-side recon-wide"):
        return ui.element("div").classes("recon-columns")


def slider(name: str, ends: tuple[float, float, float], value: float, change: Any) -> Any:
    """The browser's native slider, for keyboard, mouse and screen readers; (low, high, step)."""
    low, high, step = ends
    element = nicegui().element("input").classes("recon-range")
    element.props(f"type=range min={low:g} max={high:g} step={step:g} value={value:g}")
    element.on("input", lambda event: change(float(event.args)), js_handler=_VALUE)
    return testid(element, name)


_VALUE = "(event) => emit(event.target.value)"


def chooser(name: str, label: str, options: Sequence[str], value: str, change: Any) -> Any:
    """A selection of one option."""
    with testid(nicegui().element("div").classes("w-full"), name):
        return nicegui().select(
            list(options), value=value, label=label, on_change=lambda event: change(event.value)
        ).props("dense options-dense").classes("w-full")  # fmt: skip


def header(title: str, subtitle: str) -> Any:
    """The header of a page: name, subtitle, dark or light; returns the dark mode."""
    ui = nicegui()
    ui.add_head_html(HEAD)
    ui.colors(primary="#0072b2")
    dark = ui.dark_mode(True)
    with ui.element("div").classes("recon-head"):
        ui.label(title).style("font-weight: 700")
        ui.label(subtitle).classes("recon-note")
        ui.space()
        testid(ui.button("dark / light").props("flat dense no-caps"), "theme").on_click(
            lambda: dark.set_value(not dark.value)
        )
    return dark


def pane(name: str, size: tuple[int, int], on_mouse: Any, events: Sequence[str]) -> Any:
    """An image drawn by the server, with overlays."""
    image = nicegui().interactive_image(
        size=size, on_mouse=on_mouse, events=list(events), sanitize=False
    )
    image.classes("recon-pane w-full").props("tabindex=0")
    image.set_content(text(size[0] / 2.0, size[1] / 2.0, "drawing ...", 0.03 * size[0]))
    return testid(image, name)
