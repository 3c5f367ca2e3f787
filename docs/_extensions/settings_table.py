"""The directive `settings-table`: every setting of recon, made from the code."""

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from recon.settings.reference import reference


class SettingsTable(SphinxDirective):
    """One table per stage: name, type, default, the thesis's value, meaning."""

    def run(self) -> list[nodes.Node]:
        """Write the tables as Markdown, and have them parsed."""
        lines: list[str] = []
        stage = ""
        for one in reference():
            if one.name.partition(".")[0] != stage:
                stage = one.name.partition(".")[0]
                lines += ["", f"## {stage}", "", "| setting | type | default | thesis | meaning |"]
                lines += ["|---|---|---|---|---|"]
            thesis = "" if one.thesis == one.default else f"`{one.thesis}`"
            type_ = one.type.replace("|", "or")
            lines.append(f"| `{one.name}` | {type_} | `{one.default}` | {thesis} | {one.meaning} |")
        return self.parse_text_to_nodes(StringList(lines, "settings"), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("settings-table", SettingsTable)
    return {"parallel_read_safe": True}
