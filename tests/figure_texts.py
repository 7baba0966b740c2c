# SPDX-License-Identifier: MIT
"""Texts of a matplotlib figure: which lie on each other, are cut off, or say a quantity without its unit."""

import contextlib

from matplotlib.text import Text

from dolfinx_impact.io import plots

TOUCH = 2.0  # overlaps below it are those of boxes, which are larger than the letters in them [pixels]


def _boxes(figure):
    """Name and box of every text and legend that is drawn; texts of a legend belong to it."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    legends = [legend for axes in figure.axes if (legend := axes.get_legend())] + list(figure.legends)
    inside = {id(text) for legend in legends for text in legend.findobj(Text)}
    hidden = {id(t) for axes in figure.axes if not axes.axison for t in axes.findobj(Text)} - inside
    # Ticks beyond the limits are not drawn, but have texts all the same.
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            shown = [tick for tick in axis._update_ticks() if low <= tick.get_loc() <= high]
            hidden |= {id(label) for tick in axis.majorTicks + axis.minorTicks for label in (tick.label1, tick.label2)}
            hidden -= {id(label) for tick in shown for label in (tick.label1, tick.label2)}
    found = [
        (text.get_text(), text.get_window_extent(renderer))
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text().strip() and id(text) not in inside | hidden
    ]
    return found + [("legend", legend.get_window_extent(renderer)) for legend in legends]


def overlaps(figure):
    """Pairs of texts or legends that lie on each other, and texts that the figure's rim cuts off."""
    boxes, pairs = _boxes(figure), []
    width, height = figure.canvas.get_width_height()
    for k, (name, box) in enumerate(boxes):
        if box.x0 < -TOUCH or box.y0 < -TOUCH or box.x1 > width + TOUCH or box.y1 > height + TOUCH:
            pairs.append((name, "the rim"))
        for other, second in boxes[:k]:
            if min(box.x1, second.x1) - max(box.x0, second.x0) > TOUCH:
                if min(box.y1, second.y1) - max(box.y0, second.y0) > TOUCH:
                    pairs.append((name, other))
    return pairs


def without_unit(figure):
    """Labels of axes that have neither a unit in brackets nor what the quantity is taken over."""
    labels = [label for axes in figure.axes if axes.axison for label in (axes.get_xlabel(), axes.get_ylabel())]
    counts = ("passage", "unknowns")
    return [t for t in labels if t and not any(s in t for s in ("[", " / ", " over ")) and t not in counts]


@contextlib.contextmanager
def figures():
    """List of the figures that are saved inside, still open; they are closed at the end."""
    drawn, save = [], plots.save
    plots.save = lambda figure, path, *args, **options: drawn.append(figure)
    try:
        yield drawn
    finally:
        plots.save = save
        for figure in drawn:
            plots.pyplot().close(figure)
