"""Draws the figures of the studies (matplotlib)."""
import os


def draw(figures, folder):
    """One file NAME.png for each figure; the names drawn."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    os.makedirs(folder, exist_ok=True)
    for name, (x_text, y_text, title), curves, logarithmic in figures:
        figure, axes = pyplot.subplots(figsize=(6.0, 4.2))
        for label, style, xs, ys in curves:
            axes.plot(xs, ys, style, label=label, markersize=4, linewidth=1, markerfacecolor='none')
        if logarithmic:
            axes.set_xscale('log')
            axes.set_yscale('log')
        axes.set(xlabel=x_text, ylabel=y_text, title=title)
        axes.grid(True, which='both', linewidth=0.3)
        axes.legend(fontsize=8)
        figure.tight_layout()
        figure.savefig(os.path.join(folder, name + '.png'), dpi=110)
        pyplot.close(figure)
