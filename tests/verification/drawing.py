"""Draws the figures of the studies (matplotlib), and keeps what they were made from."""
import ast
import glob
import hashlib
import os

HERE = os.path.dirname(os.path.abspath(__file__))


def study_of(name):
    """The text of the procedure that fills a figure, '' if there is none."""
    for path in sorted(glob.glob(os.path.join(HERE, '*_studies.py'))):
        with open(path, encoding='utf-8') as stream:
            text = stream.read()
        for part in ast.parse(text).body:
            source = ast.get_source_segment(text, part)
            if isinstance(part, ast.FunctionDef) and f"picture('{name}'" in source:
                return source
    return ''


def digest(name):
    """What a figure is as old as: the procedure that fills it."""
    return hashlib.sha256(study_of(name).encode()).hexdigest()[:16]


def note_digests(folder, names):
    """Writes the digests of figures beside them."""
    path, kept = os.path.join(folder, 'made_from.txt'), {}
    if os.path.exists(path):
        with open(path, encoding='ascii') as stream:
            kept = dict(line.split() for line in stream)
    kept.update({name: digest(name) for name in names})
    with open(path, 'w', encoding='ascii') as stream:
        stream.writelines(f'{name} {value}\n' for name, value in sorted(kept.items()))


def draw(figures, folder):
    """One file NAME.svg for each figure; the names drawn."""
    import matplotlib
    matplotlib.use('Agg')
    from matplotlib import pyplot
    pyplot.rcParams.update({'svg.fonttype': 'none', 'svg.hashsalt': 'mfec'})
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
        figure.savefig(os.path.join(folder, name + '.svg'), metadata={'Date': None})
        pyplot.close(figure)
    note_digests(folder, [name for name, *_ in figures])
