#!/usr/bin/env python3
"""The manuals as HTML pages that need no network: formulas as MathML, pictures where they lie.

    doc/pages.py [FOLDER]        build/html without it (make html)
"""
import html
import os
import re
import sys

import formulas

STYLE = """body { max-width: 60em; margin: 2em auto; padding: 0 1em; font: 16px/1.5 sans-serif; color: #222 }
table { border-collapse: collapse; display: block; overflow-x: auto } td, th { border: 1px solid #ccc; padding: 2px 8px }
pre { background: #f5f5f5; padding: 8px; overflow-x: auto } code { font-size: 90% }
img { max-width: 100% } math[display=block] { margin: 0.6em 0 }"""
# Anything that Markdown leaves alone.
MARK = 'formula%dhere'


def slug(text, _=None):
    """The anchor of a heading, as GitHub makes it."""
    return re.sub(r'[^\w -]', '', text.lower()).replace(' ', '-')


def with_marks(text):
    """The text with a mark in place of each formula; and the formulas as MathML."""
    drawn = []

    def block(match):
        drawn.append(formulas.drawn(match.group(1).strip(), 'block'))
        return '\n' + MARK % (len(drawn) - 1) + '\n'

    def inline(match):
        drawn.append(formulas.drawn(match.group(1)))
        return MARK % (len(drawn) - 1)

    text = re.sub(r'(?ms)^```math\n(.*?)^```', block, text)
    return re.sub(r'\$`([^`]*)`\$', inline, text), drawn


def page(path, folder):
    """One document as a page that lies in a folder."""
    import markdown
    text, drawn = with_marks(formulas.read(path))
    body = markdown.markdown(text, extensions=['tables', 'fenced_code', 'toc', 'sane_lists'],
                             extension_configs={'toc': {'slugify': slug}})
    for k, formula in enumerate(drawn):
        body = body.replace(MARK % k, formula, 1)

    def local(match):
        word, target = match.groups()
        if re.match(r'[a-z]+:|#', target):
            return match.group(0)
        name, hash_, anchor = target.partition('#')
        there = os.path.normpath(os.path.join(os.path.dirname(path), name))
        name = name_of(there) if there in formulas.documents() else os.path.relpath(there, folder)
        return f'{word}="{name}{hash_}{anchor}"'

    body = re.sub(r'\b(href|src)="([^"]*)"', local, body)
    title = re.search(r'<h1[^>]*>(.*?)</h1>', body)
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>'
            + html.escape(title.group(1) if title else os.path.basename(path))
            + f'</title><style>{STYLE}</style></head>\n<body>\n{body}\n</body></html>\n')


def name_of(path):
    """The name of the page of a document."""
    return os.path.splitext(os.path.relpath(path, formulas.TOP))[0].replace('/', '_') + '.html'


def write(folder):
    """All pages; their names."""
    os.makedirs(folder, exist_ok=True)
    names = []
    for path in formulas.documents():
        names.append(os.path.join(folder, name_of(path)))
        with open(names[-1], 'w', encoding='utf-8') as stream:
            stream.write(page(path, folder))
    return names


if __name__ == '__main__':
    target = sys.argv[1] if len(sys.argv) > 1 else os.path.join(formulas.TOP, 'build', 'html')
    print('\n'.join(write(os.path.abspath(target))))
