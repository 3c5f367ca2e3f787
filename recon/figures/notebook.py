"""The figure that notebooks show without being told to."""

import io

from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A matplotlib figure outside pyplot: nothing keeps it alive, and notebooks show it."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()
