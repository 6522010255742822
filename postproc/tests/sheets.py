"""Small reference pictures of reports, plots, movies and pictures, and how they are compared.

    python sheets.py NEW KEPT       exit code 1 if what is in NEW (png, gif, html) is not what KEPT shows;
                                    with MFEC_NEW_PICTURES=1 KEPT is written instead
"""
import base64
import io
import os
import re
import sys

import numpy as np
from PIL import Image

MEAN, FAR, SHARE = 2.0, 60.0, 0.01
"""Most of the mean difference; a pixel is wrong beyond FAR; most of the wrong pixels."""


def frames(path):
    """The pictures of a file: itself, three frames of a movie, or all of a report."""
    if path.endswith('.html'):
        with open(path, encoding='utf-8') as stream:
            found = re.findall(r'src="data:image/png;base64,([^"]*)"', stream.read())
        return [Image.open(io.BytesIO(base64.b64decode(item))).convert('RGB') for item in found]
    film = Image.open(path)
    count = getattr(film, 'n_frames', 1)
    pictures = []
    for k in sorted({0, count // 2, count - 1}):
        film.seek(k)
        pictures.append(film.convert('RGB'))
    return pictures


def sheet(path, width=300):
    """All pictures of a file beside each other, three in a row, each so wide."""
    small = [p.resize((width, round(p.height * width / p.width)), Image.Resampling.BOX)
             for p in frames(path)]
    lines = [small[k:k + 3] for k in range(0, len(small), 3)]
    heights = [max(p.height for p in line) for line in lines]
    page = Image.new('RGB', (width * min(3, len(small)), sum(heights)), 'white')
    for row, line in enumerate(lines):
        for column, picture in enumerate(line):
            page.paste(picture, (width * column, sum(heights[:row])))
    return page


def difference(new, old):
    """What tells two pictures apart, '' if nothing does."""
    a, b = (np.asarray(p.convert('RGB'), dtype=float) for p in (new, old))
    if a.shape != b.shape:
        return f'size {a.shape[:2]}, wanted {b.shape[:2]}'
    mean, share = np.abs(a - b).mean(), np.mean(np.abs(a - b).max(axis=2) > FAR)
    if mean < MEAN and share < SHARE:
        return ''
    return f'mean difference {mean:.2f}, {100 * share:.2f} % of the pixels are wrong'


def main():
    """Command line."""
    new, kept = sys.argv[1:3]
    if os.environ.get('MFEC_NEW_PICTURES'):
        sheet(new).quantize(256).save(kept, optimize=True)
        return 0
    found = difference(sheet(new), Image.open(kept))
    if found:
        print(f'{kept}: {found}')
    return 1 if found else 0


if __name__ == '__main__':
    sys.exit(main())
