"""The figure that notebooks show automatically."""

import io

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A matplotlib figure outside pyplot, which does not keep it alive; notebooks show it."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()
