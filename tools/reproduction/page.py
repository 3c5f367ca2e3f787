"""The page: one HTML file with its images beside it, which needs no server and no network."""

import html
from pathlib import Path

from reproduction.entry import Entry, Result, Table

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 68rem; margin: 2rem auto; padding: 0 1rem;
  color: #1b1f24; background: #fff; }
h2 { border-top: 1px solid #d0d7de; padding-top: 1.5rem; margin-top: 2.5rem; }
img { max-width: 100%; height: auto; display: block; margin: .75rem 0; }
table { border-collapse: collapse; margin: .75rem 0; font-size: .92rem; }
th, td { border-bottom: 1px solid #d0d7de; padding: .25rem .75rem; text-align: left; }
dt { font-weight: 600; } dd { margin: 0 0 .4rem 1.5rem; } nav a { margin-right: .8rem; }
@media (prefers-color-scheme: dark) { body { color: #e6edf3; background: #0d1117; }
  img { background: #fff; } th, td, h2 { border-color: #30363d; } a { color: #6cb6ff; } }
"""


def write_page(results: list[tuple[Entry, Result | str, float]], folder: Path) -> Path:
    """Write the page of all entries; a text instead of a result gives the reason."""
    folder.mkdir(parents=True, exist_ok=True)
    links = "".join(f'<a href="#{e.slug}">{html.escape(e.name)}</a> ' for e, _, _ in results)
    body = "".join(_section(entry, result, s, folder) for entry, result, s in results)
    path = folder / "index.html"
    path.write_text(
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>The thesis beside recon'
        f"</title><style>{STYLE}</style></head><body><h1>The thesis beside recon</h1>"
        f"<nav>{links}</nav>{body}</body></html>\n",
        encoding="utf-8",
    )
    return path


def _section(entry: Entry, result: Result | str, seconds: float, folder: Path) -> str:
    title = f"{entry.name.capitalize()}: {entry.title}"
    shown = (
        f"<p><em>{html.escape(result)}</em></p>"
        if isinstance(result, str)
        else _images(entry, result, folder) + "".join(_table(one) for one in result.tables)
    )
    return (
        f'<h2 id="{entry.slug}">{html.escape(title)}</h2>{shown}<dl><dt>The thesis</dt>'
        f"<dd>{html.escape(entry.thesis)}</dd><dt>The difference</dt>"
        f"<dd>{html.escape(entry.difference)}</dd><dt>Time</dt><dd>{seconds:.1f} s</dd></dl>"
    )


def _images(entry: Entry, result: Result, folder: Path) -> str:
    names = []
    for index, figure in enumerate(result.figures):
        names.append(f"{entry.slug}_{index}.png")
        figure.savefig(folder / names[-1], metadata={"Software": None})
    for path in result.images:
        names.append(f"{entry.slug}_{path.name}")
        (folder / names[-1]).write_bytes(path.read_bytes())
    return "".join(f'<img src="{n}" alt="{html.escape(entry.title)}">' for n in names)


def _table(one: Table) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in one.head)
    rows = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
        for row in one.rows
    )
    return f"<table><tr>{head}</tr>{rows}</table>"
