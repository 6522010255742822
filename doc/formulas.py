#!/usr/bin/env python3
"""Formulas of the manuals in the two forms that GitHub's Markdown leaves alone: $`...`$ and fenced
math blocks. Between plain dollar signs it eats backslashes.

    doc/formulas.py            names what is written otherwise
    doc/formulas.py --fix      rewrites it

With latex2mathml (it is in build/venv) each formula is also handed to a renderer.
"""
import glob
import os
import re
import sys
import xml.etree.ElementTree as tree

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FENCE = re.compile(r'(^```.*?^```[^\n]*$)', re.S | re.M)
KEPT = re.compile(r'(\$`[^`]*`\$|`[^`\n]*`)')
PLAIN = re.compile(r'(?<![\\$])\$(?![$`])((?:[^$\\\n]|\\.|\n(?!\n))+?)(?<!`)\$(?!\$)')


def documents():
    """All manuals."""
    return [os.path.join(TOP, name) for name in ('README.md', 'CONTRIBUTING.md', 'CHANGELOG.md')] + \
        sorted(glob.glob(os.path.join(TOP, 'doc', '**', '*.md'), recursive=True))


def fixed(text):
    """The text with all formulas in the safe forms."""
    def block(match):
        lines = match.group(1).strip('\n').split('\n')
        return '```math\n' + '\n'.join(line.strip() for line in lines) + '\n```'

    parts = FENCE.split(text)
    for i in range(0, len(parts), 2):
        parts[i] = re.sub(r'^\$\$[ \t]*\n?(.*?)\n?\$\$[ \t]*$', block, parts[i],
                          flags=re.S | re.M)
    parts = FENCE.split(''.join(parts))
    for i in range(0, len(parts), 2):
        pieces = KEPT.split(parts[i])
        for k in range(0, len(pieces), 2):
            pieces[k] = PLAIN.sub(lambda m: '$`' + m.group(1) + '`$', pieces[k])
        parts[i] = ''.join(pieces)
    return ''.join(parts)


def formulas(text):
    """All formulas of a text in the safe forms."""
    return re.findall(r'\$`([^`]*)`\$', text) + re.findall(r'^```math\n(.*?)^```', text,
                                                          re.S | re.M)


def drawn(formula, display='inline'):
    """A formula as MathML, its number beside it. The renderer knows `aligned` by the name `align*`
    alone."""
    from latex2mathml.converter import convert
    formula = re.sub(r'\\tag\{(.*?)\}', r'\\qquad\\text{(\1)}', formula)
    return convert(formula.replace('{aligned}', '{align*}'), display=display)


def fault(formula):
    """What a renderer says of a formula, '' if it draws all of it."""
    bare = re.sub(r'\\[{}]', '', formula)
    if bare.count('{') != bare.count('}'):
        return f'braces do not match: {formula}'
    try:
        mathml = drawn(formula)
        tree.fromstring(mathml)
    except Exception as problem:  # the renderer has many
        return f'{type(problem).__name__}: {formula}'
    unknown = re.findall(r'<m[io]>(\\[a-zA-Z]+)</m[io]>', mathml)
    return f'unknown {" ".join(unknown)}: {formula}' if unknown else ''


def read(path):
    """A document."""
    with open(path, encoding='utf-8') as stream:
        return stream.read()


def main():
    """Exit code 1 if something is to be rewritten, or cannot be drawn."""
    status = 0
    for path in documents():
        text = read(path)
        new = fixed(text)
        if new != text and '--fix' in sys.argv[1:]:
            with open(path, 'w', encoding='utf-8') as stream:
                stream.write(new)
        elif new != text:
            print(f'{path}: formulas between plain dollar signs; doc/formulas.py --fix')
            status = 1
    return status


if __name__ == '__main__':
    sys.exit(main())
