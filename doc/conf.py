"""Sphinx makes the manuals into HTML pages that need no network (make html): MyST reads the Markdown as
it lies, formulas become MathML here, links are resolved or named as dead."""
import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import formulas  # noqa: E402

project = 'mfec'
extensions = ['myst_parser']
include_patterns = [os.path.relpath(path, formulas.TOP) for path in formulas.documents()] + ['postproc/README.md']
exclude_patterns = ['build', '.git']
root_doc = 'README'
html_theme = 'furo'
html_title = 'mfec'
html_copy_source = html_show_sourcelink = html_show_sphinx = False
html_theme_options = {'navigation_with_keys': False}
pygments_style = 'tango'
myst_enable_extensions = ['dollarmath']
myst_fence_as_directive = ['math']
myst_heading_anchors = 4
# A Markdown file of GitHub may link to files and folders of the tree, and start with any level of heading.
suppress_warnings = ['myst.header', 'misc.highlighting_failure']
CONTENTS = [('Manuals', ['doc/manual', 'doc/keywords', 'doc/tutorials', 'doc/gallery', 'postproc/README']),
            ('Method', ['doc/theory', 'doc/terms', 'doc/heuristics', 'doc/history']),
            ('Evidence', ['doc/verification', 'doc/benchmark']),
            ('Project', ['doc/developer', 'CONTRIBUTING', 'doc/releases', 'CHANGELOG'])]
BELOW = {'doc/keywords': 'doc/keywords/', 'doc/tutorials': 'doc/tutorials/', 'doc/verification': 'doc/verification/'}


def toctree(names, caption=''):
    """A list of pages that shows in the contents alone."""
    head = '\n\n```{toctree}\n:hidden:\n' + (f':caption: {caption}\n' if caption else '')
    return head + '\n' + '\n'.join(f'/{name}' for name in names) + '\n```\n'


def add_contents(_, name, source):
    """The pages below a page, for GitHub knows no contents."""
    if name == root_doc:
        source[0] += ''.join(toctree(names, caption) for caption, names in CONTENTS)
    if name in BELOW:
        pages = sorted(os.path.splitext(path)[0] for path in include_patterns if path.startswith(BELOW[name]))
        source[0] += toctree(pages)


def as_formula(self, node, display):
    """A formula as MathML; GitHub's marks have backticks within the dollar signs."""
    text = re.sub(r'^`|`$', '', node.astext().strip())
    self.body.append(formulas.drawn(text, display))


def inline(self, node):
    """A formula in a line."""
    as_formula(self, node, 'inline')
    from docutils import nodes
    raise nodes.SkipNode


def block(self, node):
    """A formula of its own."""
    as_formula(self, node, 'block')
    from docutils import nodes
    raise nodes.SkipNode


def setup(app):
    """What Sphinx calls first."""
    app.connect('source-read', add_contents)
    app.add_html_math_renderer('mathml', inline_renderers=(inline, None), block_renderers=(block, None))


html_math_renderer = 'mathml'
